//! Symmetric 3×3 tensors: a bound on the eigenvalues without computing them, and the eigenvalues.

/// Components xx, yy, zz, xy, yz, zx.
pub type Sym3 = [f64; 6];

/// Sweeps of Jacobi's method: the third is exact to rounding for 3×3, one more for bad cases.
const SWEEPS: usize = 5;

/// Off-diagonal size, relative to the largest entry, below which a rotation changes nothing.
const NEGLIGIBLE: f64 = 1e-17;

/// Whether every eigenvalue lies below `limit`: `limit·I − s` is positive definite (3 minors).
#[must_use]
#[inline]
pub fn below(s: &Sym3, limit: f64) -> bool {
    let (a, b, c) = (limit - s[0], limit - s[1], limit - s[2]);
    let (d, e, f) = (s[3], s[4], s[5]);
    let minor = a * b - d * d;
    let det = c * minor - 2.0 * d * e * f - a * e * e - b * f * f;
    a > 0.0 && minor > 0.0 && det > 0.0
}

/// Eigenvalues in no order, and the unit eigenvector of each (cyclic Jacobi).
#[must_use]
#[inline]
pub fn eigen(s: &Sym3) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut a = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let scale = s.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let small = NEGLIGIBLE * scale;
    for _ in 0..SWEEPS {
        if a[0][1].abs() <= small && a[0][2].abs() <= small && a[1][2].abs() <= small {
            break;
        }
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            if a[p][q].abs() > small {
                rotate(&mut a, &mut v, [p, q, r]);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], v)
}

/// One Jacobi rotation that zeroes entry (p, q); rows of `v` are the eigenvectors.
#[inline]
fn rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], [p, q, r]: [usize; 3]) {
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let sign = if theta < 0.0 { -1.0 } else { 1.0 };
    let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    let off = a[p][q];
    a[p][p] -= t * off;
    a[q][q] += t * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let (x, y) = (a[r][p], a[r][q]);
    (a[r][p], a[r][q]) = (c * x - s * y, s * x + c * y);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    let (first, second) = (v[p], v[q]);
    v[p] = std::array::from_fn(|k| c * first[k] - s * second[k]);
    v[q] = std::array::from_fn(|k| s * first[k] + c * second[k]);
}

#[cfg(test)]
mod tests {
    use super::{Sym3, below, eigen};
    use crate::math::unit;

    fn random(index: u64) -> Sym3 {
        let mut s = [0.0; 6];
        for (k, x) in s.iter_mut().enumerate() {
            *x = 2.0 * unit(11, k as u64, index) - 1.0;
        }
        if index.is_multiple_of(5) {
            (s[3], s[4]) = (1e-9 * s[3], 0.0);
        }
        s
    }

    #[test]
    fn eigenpairs_rebuild_the_tensor() {
        for index in 0..500 {
            let s = random(index);
            let (values, v) = eigen(&s);
            for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].iter().enumerate() {
                let sum: f64 = (0..3).map(|n| values[n] * v[n][*i] * v[n][*j]).sum();
                assert!((sum - s[k]).abs() < 1e-13, "case {index}: {sum} for {}", s[k]);
            }
        }
    }

    #[test]
    fn the_bound_agrees_with_the_eigenvalues() {
        for index in 0..2000 {
            let s = random(index);
            let (values, _) = eigen(&s);
            let largest = values.iter().fold(f64::NEG_INFINITY, |m, &x| m.max(x));
            assert!(below(&s, largest + 1e-9), "case {index}");
            assert!(!below(&s, largest - 1e-9), "case {index}");
        }
    }
}
