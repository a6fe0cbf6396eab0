//! Weights of bonds that have the moments of a continuum at each point, at edges too.
//!
//! Each bond of a point is multiplied by r(n) = r₀ + λ·b(n), b being even polynomials of its
//! direction and λ such that Σ r w b is what it should be. A bond takes the mean of what its two
//! ends ask for, so that it is the same from both; six sweeps bring the moments back.

use nalgebra::{SMatrix, SVector};

/// Sweeps over all points. More do not bring the moments closer: what is left is at edges.
const SWEEPS: usize = 6;

/// What is asked of the weights of a point's bonds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MomentTarget<const N: usize> {
    /// Σ w b.
    pub(crate) moments: [f64; N],
    /// Σ w.
    pub(crate) sum: f64,
}

/// Least and greatest factor of a bond over the mean factor of its point \[1\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FactorBounds {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// Bonds by point, each from both ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BondRows<'a> {
    /// First bond of each point, then their number.
    pub(crate) starts: &'a [u32],
    /// Each bond as its other end has it.
    pub(crate) twins: &'a [u32],
}

impl BondRows<'_> {
    /// The bonds of a point.
    pub(crate) fn of(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }
}

/// Brings positive weights to the moments that `target` asks of each point. `basis` has b of each
/// bond.
pub(crate) fn fit<const N: usize>(
    rows: BondRows<'_>,
    weights: &mut [f64],
    basis: impl Fn(usize) -> [f64; N],
    target: impl Fn(usize) -> MomentTarget<N>,
    bounds: FactorBounds,
) {
    let mut factors = vec![1.0; weights.len()];
    for _ in 0..SWEEPS {
        for i in 0..rows.starts.len() - 1 {
            let own = rows.of(i);
            let sum: f64 = weights[own.clone()].iter().sum();
            if sum <= 0.0 {
                continue;
            }
            let target = target(i);
            let mean = target.sum / sum;
            let lambda = multipliers(own.clone(), weights, &basis, &target, mean);
            let mut share = 1.0_f64;
            for bond in own.clone() {
                let off = lambda.dot(&SVector::from(basis(bond)));
                let room = if off < 0.0 { bounds.low - 1.0 } else { bounds.high - 1.0 };
                if off * share / (room * mean) > 1.0 {
                    share = room * mean / off;
                }
            }
            for bond in own {
                factors[bond] = mean + share * lambda.dot(&SVector::from(basis(bond)));
            }
        }
        for (bond, weight) in weights.iter_mut().enumerate() {
            *weight *= 0.5 * (factors[bond] + factors[rows.twins[bond] as usize]);
        }
    }
}

/// λ of a point; zero where its bonds do not determine it.
fn multipliers<const N: usize>(
    own: std::ops::Range<usize>,
    weights: &[f64],
    basis: &impl Fn(usize) -> [f64; N],
    target: &MomentTarget<N>,
    mean: f64,
) -> SVector<f64, N> {
    let mut matrix = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::from(target.moments);
    for bond in own {
        let b = SVector::from(basis(bond));
        matrix += b * b.transpose() * weights[bond];
        right -= b * (mean * weights[bond]);
    }
    cholesky(matrix, right).unwrap_or_else(SVector::zeros)
}

/// The solution of a symmetric positive system, where it is far enough from singular.
pub(crate) fn cholesky<const N: usize>(
    mut a: SMatrix<f64, N, N>,
    mut b: SVector<f64, N>,
) -> Option<SVector<f64, N>> {
    let scale = a.trace() / N as f64;
    for k in 0..N {
        for m in 0..k {
            let known: f64 = (0..m).map(|c| a[(k, c)] * a[(m, c)]).sum();
            a[(k, m)] = (a[(k, m)] - known) / a[(m, m)];
        }
        let known: f64 = (0..k).map(|c| a[(k, c)] * a[(k, c)]).sum();
        let pivot = a[(k, k)] - known;
        if pivot.is_nan() || pivot <= 1e-9 * scale {
            return None;
        }
        a[(k, k)] = pivot.sqrt();
    }
    for k in 0..N {
        let known: f64 = (0..k).map(|c| a[(k, c)] * b[c]).sum();
        b[k] = (b[k] - known) / a[(k, k)];
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|c| a[(c, k)] * b[c]).sum();
        b[k] = (b[k] - known) / a[(k, k)];
    }
    Some(b)
}
