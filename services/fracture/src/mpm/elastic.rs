//! Compressible neo-Hookean solid in the displacement gradient H = F − I, in the frame before the
//! hit.

use cullet_geometry::Mat3;
use cullet_geometry::symmetric::Sym3;
use cullet_model::Material;

/// Volume ratio J below which a point counts as crushed (F07).
pub const CRUSHED: f64 = 0.2;

/// J² at which a broken point bears nothing from then on: its crack is as wide as half the point,
/// and what its nodes do on either side is no strain. It would be pressed in one direction for
/// being torn in the others, and make energy.
pub const LOOSE: f64 = 2.25;

/// Lamé parameters \[Pa\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LameParameters {
    /// λ \[Pa\].
    pub lame: f64,
    /// μ \[Pa\].
    pub shear: f64,
}

impl LameParameters {
    /// The elasticity of `material`.
    #[must_use]
    pub fn new(material: &Material) -> Self {
        Self { lame: material.lame(), shear: material.shear() }
    }

    /// Second Piola–Kirchhoff stress S \[Pa\] and J² − 1 \[1\]; exact for small strain, objective
    /// for any. P = (I + H) S.
    ///
    /// Ψ = μ/2 (tr C − 3) − μ ln J + λ/4 (J² − 1 − 2 ln J), so S = μ(I − C⁻¹) + λ/2 (J² − 1) C⁻¹,
    /// with C⁻¹ = adj C/J² and J² − 1 from the minors of E: no logarithm, no cancellation at small
    /// strain. Below J = [`CRUSHED`] the division stops growing (F07).
    #[must_use]
    #[inline]
    pub fn second_piola(&self, h: &Mat3) -> (Sym3, f64) {
        self.stress(&green_strain(h))
    }

    /// The same of Green's strain E.
    #[must_use]
    #[inline]
    pub fn stress(&self, e: &Sym3) -> (Sym3, f64) {
        let (trace, adjoint) = (e[0] + e[1] + e[2], adjugate(e));
        let det = e[0] * adjoint[0] + e[3] * adjoint[3] + e[5] * adjoint[5];
        let d = 2.0 * trace + 4.0 * (adjoint[0] + adjoint[1] + adjoint[2]) + 8.0 * det;
        let share = 1.0 / (1.0 + d).max(CRUSHED * CRUSHED);
        let (mu, bulk) = (self.shear * share, 0.5 * self.lame * d * share);
        let part = |k: usize| {
            let unit = if k < 3 { 1.0 } else { 0.0 };
            // adj C − I = 2(tr E I − E) + 4 adj E
            let rest = 2.0 * (trace * unit - e[k]) + 4.0 * adjoint[k];
            mu * (d * unit - rest) + bulk * (unit + rest)
        };
        ([part(0), part(1), part(2), part(3), part(4), part(5)], d)
    }

    /// Poisson's ratio \[1\].
    #[must_use]
    pub fn poisson(&self) -> f64 {
        0.5 * self.lame / (self.lame + self.shear)
    }

    /// Ψ of Green's strain E of the undamaged solid \[J/m³\].
    #[must_use]
    pub fn energy_density(&self, e: &Sym3) -> f64 {
        let (trace, adjoint) = (e[0] + e[1] + e[2], adjugate(e));
        let det = e[0] * adjoint[0] + e[3] * adjoint[3] + e[5] * adjoint[5];
        let minors = adjoint[0] + adjoint[1] + adjoint[2];
        let d = 2.0 * trace + 4.0 * minors + 8.0 * det;
        // μ/2 (tr C − 3 − ln J²) + λ/4 (J² − 1 − ln J²), and tr C − 3 = d less the minors of C.
        let rest = 4.0 * minors + 8.0 * det;
        0.5 * self.shear * (excess(d) - rest) + 0.25 * self.lame * excess(d)
    }

    /// What principal `strains` (Green's, in any order) would bear if those directions that are
    /// pulled kept their stiffness while their cracks open \[Pa\]; of what is pulled the solid
    /// bears all but the share `taken`.
    ///
    /// The undamaged stress is Sᵢ = μ(1 − x/Cᵢ) with x = 1 − λ/2μ (J² − 1). Cracks across pulled
    /// directions, Cᵢ > x, leave a share of the stretch to the solid between them: J² is made of
    /// Cᵢ, and there of (1 − taken) Cᵢ + taken x. That J² is the least of its kind whichever
    /// directions are taken for pulled, so the right one gives the least root. At taken = 1 this
    /// is the solid that bears no tension, and with Cᵢ to the power 1 − taken in place of the mean
    /// it would have a potential at any strain; partly broken points are strained so little that
    /// it does not show.
    #[must_use]
    pub fn pulls(&self, strains: [f64; 3], taken: f64) -> [f64; 3] {
        let half = 0.5 * self.lame / self.shear;
        let mut u = strains.map(|e| 2.0 * e);
        let swell = half * swelling(u, half, taken);
        for u in &mut u {
            *u = self.shear * (*u + swell) / (1.0 + *u).max(CRUSHED * CRUSHED);
        }
        u
    }

    /// The energy of which that is the slope: Ψ of the solid between the cracks, and half the work
    /// of the pulls in opening them \[J/m³\].
    #[must_use]
    pub fn energy(&self, strains: [f64; 3], taken: f64) -> f64 {
        let half = 0.5 * self.lame / self.shear;
        let u = strains.map(|e| 2.0 * e);
        let swell = half * swelling(u, half, taken);
        let (mut energy, mut d) = (0.0, 0.0);
        for u in u {
            let open = taken * (u + swell).max(0.0);
            let solid = u - open;
            let pull = self.shear * (u + swell) / (1.0 + u).max(CRUSHED * CRUSHED);
            energy += 0.5 * self.shear * excess(solid) + 0.25 * (1.0 - taken) * pull * open;
            d += solid + d * solid;
        }
        energy + 0.25 * self.lame * excess(d)
    }
}

/// u − ln(1 + u), without cancellation; below J = [`CRUSHED`] the logarithm stops growing.
fn excess(u: f64) -> f64 {
    if u.abs() < 1e-4 {
        u * u * (0.5 - u * (1.0 / 3.0 - 0.25 * u))
    } else {
        u - libm::log1p(u.max(CRUSHED * CRUSHED - 1.0))
    }
}

/// J² − 1 of the solid between the cracks \[1\] at C = 1 + u; `half` is λ/2μ.
fn swelling(mut u: [f64; 3], half: f64, taken: f64) -> f64 {
    u.sort_unstable_by(|a, b| b.total_cmp(a));
    let left = 1.0 - taken;
    let ([v, w, z], give) = (u.map(|u| left * u), half * taken);
    // No direction is pulled; one; two.
    let rest = u[1] + u[2] + u[1] * u[2];
    let none = u[0] + rest * (1.0 + u[0]);
    let one = (rest + v * (1.0 + rest)) / (1.0 + give * (1.0 + rest));
    let share = 1.0 + u[2];
    let (sum, slope) = (u[2] + share * (v + w + v * w), 1.0 + give * share * (2.0 + v + w));
    let two =
        2.0 * sum / (slope + (slope * slope - 4.0 * give * give * share * sum).max(0.0).sqrt());
    // All three: the root for small strains, and a step of Newton's.
    let small = (v + w + z) / (1.0 + 3.0 * give);
    let [a, b, c] = [v, w, z].map(|v| v - give * small);
    let (pairs, sum) = (a * b + b * c + c * a, a + b + c);
    let slope = 1.0 + give * (3.0 + 2.0 * sum + pairs);
    let three = small - (small - (sum + pairs + a * b * c)) / slope;
    none.min(one).min(two).min(three)
}

/// E = (H + Hᵀ + HᵀH)/2 \[1\].
#[must_use]
#[inline]
pub fn green_strain(h: &Mat3) -> Sym3 {
    let dot =
        |i: usize, j: usize| h[(0, i)] * h[(0, j)] + h[(1, i)] * h[(1, j)] + h[(2, i)] * h[(2, j)];
    [
        h[(0, 0)] + 0.5 * dot(0, 0),
        h[(1, 1)] + 0.5 * dot(1, 1),
        h[(2, 2)] + 0.5 * dot(2, 2),
        0.5 * (h[(0, 1)] + h[(1, 0)] + dot(0, 1)),
        0.5 * (h[(1, 2)] + h[(2, 1)] + dot(1, 2)),
        0.5 * (h[(2, 0)] + h[(0, 2)] + dot(2, 0)),
    ]
}

/// The adjugate of a symmetric tensor.
#[must_use]
#[inline]
pub(super) fn adjugate(e: &Sym3) -> Sym3 {
    [
        e[1] * e[2] - e[4] * e[4],
        e[2] * e[0] - e[5] * e[5],
        e[0] * e[1] - e[3] * e[3],
        e[4] * e[5] - e[2] * e[3],
        e[5] * e[3] - e[0] * e[4],
        e[3] * e[4] - e[1] * e[5],
    ]
}

/// The tensor as a matrix.
#[must_use]
#[inline]
pub fn matrix(s: &Sym3) -> Mat3 {
    Mat3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
}

#[cfg(test)]
mod tests {
    use super::{LameParameters, matrix};
    use cullet_geometry::{Mat3, Quat, Vec3};

    const STEEL: LameParameters = LameParameters { lame: 115e9, shear: 77e9 };

    /// E1 at a point: Hooke's law to second order in the strain.
    #[test]
    fn small_strain_is_hooke() {
        let m = Mat3::new(0.3, -0.7, 0.2, 1.1, 0.5, -0.4, 0.6, 0.9, -0.8);
        for scale in [1e-4, 1e-8, 1e-12] {
            let h = m * scale;
            let e = (h + h.transpose()) * 0.5;
            let hooke = Mat3::identity() * (STEEL.lame * e.trace()) + e * (2.0 * STEEL.shear);
            let stress = matrix(&STEEL.second_piola(&h).0);
            let error = (stress - hooke).amax() / (STEEL.shear * scale);
            assert!(error < 20.0 * scale + 1e-14, "scale {scale}: {error}");
        }
    }

    /// E2 at a point: a rotation carries no stress and changes none.
    #[test]
    fn rotation_is_not_strain() {
        let turn =
            Quat::from_scaled_axis(Vec3::new(0.3, -0.4, 0.5).normalize() * 37f64.to_radians());
        let r = turn.to_rotation_matrix().into_inner();
        let (idle, _) = STEEL.second_piola(&(r - Mat3::identity()));
        assert!(idle.iter().all(|s| s.abs() < 1e-14 * STEEL.shear * 10.0), "{idle:?}");
        let stretch = Mat3::new(1e-2, 2e-3, 0.0, 2e-3, -4e-3, 1e-3, 0.0, 1e-3, 3e-3);
        let still = matrix(&STEEL.second_piola(&stretch).0);
        let f = r * (Mat3::identity() + stretch);
        let turned = matrix(&STEEL.second_piola(&(f - Mat3::identity())).0);
        assert!((turned - still).norm() < 1e-12 * still.norm());
    }

    /// The stress is the derivative of the energy, far from small strain too.
    #[test]
    fn stress_does_the_work_of_the_energy() {
        let energy = |h: &Mat3| {
            let f = Mat3::identity() + h;
            let (j, c) = (f.determinant(), f.transpose() * f);
            0.5 * STEEL.shear * (c.trace() - 3.0) - STEEL.shear * libm::log(j)
                + 0.25 * STEEL.lame * (j * j - 1.0 - 2.0 * libm::log(j))
        };
        let h = Mat3::new(-0.3, -0.2, 0.1, 0.15, -0.25, 0.05, 0.1, 0.2, 0.1);
        let (s, d) = STEEL.second_piola(&h);
        let j = (Mat3::identity() + h).determinant();
        assert!((d - (j * j - 1.0)).abs() < 1e-14);
        let first = (Mat3::identity() + h) * matrix(&s);
        let step = 1e-5;
        for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
            let mut unit = Mat3::zeros();
            unit[(i, k)] = step;
            let slope = (energy(&(h + unit)) - energy(&(h - unit))) / (2.0 * step);
            assert!((slope - first[(i, k)]).abs() < 1e-7 * STEEL.lame, "{i}{k}");
        }
    }
}
