//! Compressible neo-Hookean solid in the displacement gradient H = F − I.

use super::symmetric::Sym3;
use crate::material::Material;
use cullet_geometry::Mat3;

/// Volume ratio J below which a point counts as crushed (F07).
pub const CRUSHED: f64 = 0.2;

/// Lamé parameters \[Pa\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// λ \[Pa\].
    pub lame: f64,
    /// μ \[Pa\].
    pub shear: f64,
}

impl Elastic {
    /// The elasticity of `material`.
    #[must_use]
    pub fn new(material: &Material) -> Self {
        Self { lame: material.lame(), shear: material.shear() }
    }

    /// Kirchhoff stress τ \[Pa\]; exact for small strain, objective for any.
    ///
    /// Ψ = μ/2 (tr b − 3) − μ ln J + λ/4 (J² − 1 − 2 ln J), so τ = μ(b − I) + λ/2 (J² − 1) I: the
    /// form without a logarithm, which stays finite down to J = 0 (F07).
    #[must_use]
    #[inline]
    pub fn kirchhoff(&self, h: &Mat3) -> Sym3 {
        let b = left_strain(h);
        let j = volume_change(h);
        let pressure = 0.5 * self.lame * j * (j + 2.0);
        [
            self.shear * b[0] + pressure,
            self.shear * b[1] + pressure,
            self.shear * b[2] + pressure,
            self.shear * b[3],
            self.shear * b[4],
            self.shear * b[5],
        ]
    }
}

/// b − I = H + Hᵀ + HHᵀ: no cancellation at small strain \[1\].
#[must_use]
#[inline]
pub fn left_strain(h: &Mat3) -> Sym3 {
    let dot =
        |i: usize, j: usize| h[(i, 0)] * h[(j, 0)] + h[(i, 1)] * h[(j, 1)] + h[(i, 2)] * h[(j, 2)];
    [
        2.0 * h[(0, 0)] + dot(0, 0),
        2.0 * h[(1, 1)] + dot(1, 1),
        2.0 * h[(2, 2)] + dot(2, 2),
        h[(0, 1)] + h[(1, 0)] + dot(0, 1),
        h[(1, 2)] + h[(2, 1)] + dot(1, 2),
        h[(2, 0)] + h[(0, 2)] + dot(2, 0),
    ]
}

/// J − 1 from the minors of H: tr H + Σ principal 2×2 minors + det H \[1\].
#[must_use]
#[inline]
pub fn volume_change(h: &Mat3) -> f64 {
    let minor = |i: usize, j: usize| h[(i, i)] * h[(j, j)] - h[(i, j)] * h[(j, i)];
    h.trace() + minor(0, 1) + minor(1, 2) + minor(2, 0) + h.determinant()
}

#[cfg(test)]
mod tests {
    use super::{Elastic, volume_change};
    use cullet_geometry::{Mat3, Quat, Vec3};

    const STEEL: Elastic = Elastic { lame: 115e9, shear: 77e9 };

    /// E1 at a point: Hooke's law to second order in the strain.
    #[test]
    fn small_strain_is_hooke() {
        let m = Mat3::new(0.3, -0.7, 0.2, 1.1, 0.5, -0.4, 0.6, 0.9, -0.8);
        for scale in [1e-4, 1e-8, 1e-12] {
            let h = m * scale;
            let e = (h + h.transpose()) * 0.5;
            let hooke = Mat3::identity() * (STEEL.lame * e.trace()) + e * (2.0 * STEEL.shear);
            let tau = STEEL.kirchhoff(&h);
            let size = STEEL.shear * scale;
            for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].iter().enumerate() {
                let error = (tau[k] - hooke[(*i, *j)]).abs() / size;
                assert!(error < 10.0 * scale + 1e-14, "scale {scale}: {error}");
            }
        }
    }

    /// E2 at a point: a rotation carries no stress, and turns the stress of a strained point.
    #[test]
    fn rotation_is_not_strain() {
        let turn =
            Quat::from_scaled_axis(Vec3::new(0.3, -0.4, 0.5).normalize() * 37f64.to_radians());
        let r = turn.to_rotation_matrix().into_inner();
        let idle = STEEL.kirchhoff(&(r - Mat3::identity()));
        assert!(idle.iter().all(|s| s.abs() < 1e-14 * STEEL.shear * 10.0), "{idle:?}");
        let stretch = Mat3::new(1e-2, 2e-3, 0.0, 2e-3, -4e-3, 1e-3, 0.0, 1e-3, 3e-3);
        let still = full(&STEEL.kirchhoff(&stretch));
        let f = r * (Mat3::identity() + stretch);
        let turned = full(&STEEL.kirchhoff(&(f - Mat3::identity())));
        assert!((turned - r * still * r.transpose()).norm() < 1e-12 * still.norm());
    }

    #[test]
    fn volume_change_is_the_determinant_less_one() {
        let h = Mat3::new(0.3, -0.2, 0.1, 0.15, -0.25, 0.05, 0.4, 0.2, 0.1);
        let det = (Mat3::identity() + h).determinant();
        assert!((volume_change(&h) - (det - 1.0)).abs() < 1e-15);
        assert!((volume_change(&(Mat3::identity() * 1e-20)) - 3e-20).abs() < 1e-34);
    }

    fn full(s: &[f64; 6]) -> Mat3 {
        Mat3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
    }
}
