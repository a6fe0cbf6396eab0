//! Weights of a point's bonds, fitted to fourth moments.

use crate::anisotropy::{self, QUARTIC};
use cullet_geometry::Vec3;
use nalgebra::{SMatrix, SVector};

/// A weight is no less than this share of what it was before the fit.
const LEAST_SHARE: f64 = 0.2;

/// Share of the mean of the diagonal that is added to it, at first, by which it grows where weights
/// would be too small, and at which there is no fit.
const FIRST: f64 = 1e-12;
const GROWTH: f64 = 10.0;
const LAST: f64 = 1e6;

/// Greatest miss of a moment with which bonds still count as fitted.
const TIGHT: f64 = 1e-6;

/// n_a n_b n_c n_d.
fn components(n: &Vec3) -> SVector<f64, QUARTIC> {
    SVector::from(anisotropy::components(n))
}

/// Weights of bonds ξ to points of the volumes V, Σw = 1: l₀V times a quartic form in n = ξ/l₀ that
/// makes Σw n⊗n⊗n⊗n the `target`. Where some would be too small the form is held back; whether it
/// was not.
pub(super) fn fitted(bonds: &[(Vec3, f64)], target: &[f64; QUARTIC]) -> (Vec<f64>, bool) {
    let target = SVector::from(*target);
    let plain: Vec<f64> = bonds.iter().map(|(xi, volume)| xi.norm() * volume).collect();
    let sum: f64 = plain.iter().sum();
    let plain: Vec<f64> = plain.into_iter().map(|w| w / sum).collect();
    let forms: Vec<_> = bonds.iter().map(|(xi, _)| components(&(xi / xi.norm()))).collect();
    let mut matrix = SMatrix::<f64, QUARTIC, QUARTIC>::zeros();
    let mut missing = target;
    for (w, form) in plain.iter().zip(&forms) {
        for row in 0..QUARTIC {
            for column in 0..QUARTIC {
                matrix[(row, column)] += w * form[row] * form[column];
            }
        }
        missing -= form * *w;
    }
    let mean = matrix.trace() / QUARTIC as f64;
    let mut held = FIRST;
    while held < LAST {
        let solved = (matrix + SMatrix::identity() * (held * mean)).cholesky();
        if let Some(form) = solved.map(|solved| solved.solve(&missing)) {
            let share: Vec<f64> = forms.iter().map(|other| 1.0 + form.dot(other)).collect();
            if share.iter().all(|&s| s >= LEAST_SHARE) {
                let weights: Vec<f64> = plain.iter().zip(&share).map(|(w, s)| w * s).collect();
                let sum: f64 = weights.iter().sum();
                let weights: Vec<f64> = weights.into_iter().map(|w| w / sum).collect();
                let found = weights.iter().zip(&forms).map(|(w, form)| form * *w);
                let miss = (target - found.sum::<SVector<f64, QUARTIC>>()).amax();
                return (weights, miss <= TIGHT);
            }
        }
        held *= GROWTH;
    }
    (plain, false)
}

#[cfg(test)]
mod tests {
    use super::components;
    use crate::anisotropy;
    use cullet_geometry::Vec3;

    fn fitted(bonds: &[(Vec3, f64)]) -> (Vec<f64>, bool) {
        super::fitted(bonds, &anisotropy::isotropic())
    }

    /// Bonds of a point of a lattice within `horizon`, in front of a plane.
    fn bonds(horizon: f64, front: impl Fn(&Vec3) -> bool) -> Vec<(Vec3, f64)> {
        let at = |k: i32| Vec3::new(f64::from(k % 9 - 4), f64::from(k / 9 % 9 - 4), 0.0);
        let all = (0..729).map(|k| at(k) + Vec3::z() * f64::from(k / 81 - 4));
        let near = all.filter(|x| x.norm() > 0.5 && x.norm() <= horizon && front(x));
        near.map(|x| (x, 1.0)).collect()
    }

    /// Greatest miss of a fourth moment.
    fn miss(bonds: &[(Vec3, f64)], weights: &[f64]) -> f64 {
        let mut sum = -nalgebra::SVector::from(anisotropy::isotropic());
        for ((xi, _), w) in bonds.iter().zip(weights) {
            sum += components(&(xi / xi.norm())) * *w;
        }
        sum.amax()
    }

    /// Bonds of a layer one point thick have no extent across it: no weights do.
    #[test]
    fn a_layer_of_points_is_not_isotropic() {
        let layer = bonds(3.015, |x| x.z == 0.0);
        assert!(!fitted(&layer).1);
        // Nor of so few at an edge, though a solution of least squares has positive ones.
        assert!(!fitted(&bonds(1.5, |x| x.x >= 0.0 && x.y >= 0.0)).1);
    }

    #[test]
    fn moments_are_isotropic_inside_and_at_faces() {
        for horizon in [2.04, 3.015, 4.0] {
            for (what, some) in
                [("inside", bonds(horizon, |_| true)), ("face", { bonds(horizon, |x| x.z >= 0.0) })]
            {
                let (weights, fits) = fitted(&some);
                assert!(fits && weights.iter().all(|&w| w > 0.0), "{what}, {horizon}");
                assert!(miss(&some, &weights) < 1e-8, "{what}, {horizon}");
                let even = vec![1.0 / some.len() as f64; some.len()];
                assert!(miss(&some, &even) > 1e-4, "{what}, {horizon}: nothing to fit");
            }
        }
    }

    /// At a corner no positive weights do; those found are positive, and better than none fitted.
    #[test]
    fn corners_keep_positive_weights() {
        let some = bonds(3.015, |x| x.iter().all(|&c| c >= 0.0));
        let (weights, fits) = fitted(&some);
        assert!(!fits && weights.iter().all(|&w| w > 0.0));
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let sum: f64 = some.iter().map(|(xi, _)| xi.norm()).sum();
        let plain: Vec<f64> = some.iter().map(|(xi, _)| xi.norm() / sum).collect();
        let (after, before) = (miss(&some, &weights), miss(&some, &plain));
        assert!(after < before, "{after}, {before} without a fit");
    }
}
