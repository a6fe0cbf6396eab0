//! The law of soft walls: neo-Hookean in plane stress at any strain, or linear in elastic Green
//! strains with plastic ones where they yield; and cracks in either.
//!
//! The neo-Hookean energy ½μ(tr C − 3) − μ ln J + ¼λ(J² − 1 − 2 ln J) with σ₃₃ = 0 has the closed
//! form C₃₃ = (λ + 2μ)/(λD + 2μ) for D = det C of the layer, and S = μ(1 − C₃₃ C⁻¹). Below a ratio
//! of areas of [`LEAST_AREA`] the part that goes by D alone is continued by its parabola: still a
//! potential, but one that a wall which is folded flat cannot make infinitely stiff.

use crate::kernel::PlaneStress;

/// (da/dA)² below which the energy is continued by its parabola \[1\].
pub(crate) const LEAST_AREA: f64 = 0.05;

/// λ² of a strip below which its energy is continued by its tangent \[1\].
const LEAST_STRETCH: f64 = 0.05;

/// Neo-Hookean elasticity, by Lamé's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// λ \[Pa\].
    pub lambda: f64,
    /// μ \[Pa\].
    pub mu: f64,
}

/// How a soft wall is elastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SoftElasticity {
    /// At any strain.
    NeoHookean(NeoHookean),
    /// Linear in Green's strain: of what yields, good to elastic strains of 5 %.
    Linear(PlaneStress),
}

/// What a section needs to know of a soft wall beside its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftSection {
    /// How it is elastic.
    pub elastic: SoftElasticity,
    /// Heights of stations over those of the real thickness: above 1 where a softer material is to
    /// bend like the real one \[1\].
    pub bend: f64,
    /// Viscosity over the step: what damping adds is elasticity of this times the strain since the
    /// last step \[1\].
    pub viscosity: f64,
}

impl NeoHookean {
    /// Of Young's modulus E \[Pa\] and Poisson's ratio ν.
    #[must_use]
    pub fn new(young: f64, poisson: f64) -> Self {
        let mu = 0.5 * young / (1.0 + poisson);
        Self { lambda: 2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu }
    }

    /// −2∂W/∂D at fixed tr C, as it is for D: μC₃₃/D \[Pa\].
    fn area_stress(&self, d: f64) -> f64 {
        let Self { lambda, mu } = *self;
        mu * (lambda + 2.0 * mu) / ((lambda * d + 2.0 * mu) * d)
    }

    /// μC₃₃/D at the least ratio of areas, and by how much it rises for each unit that D is less
    /// \[Pa\].
    pub(crate) fn continued(&self) -> (f64, f64) {
        let Self { lambda, mu } = *self;
        let both = (lambda * LEAST_AREA + 2.0 * mu) * LEAST_AREA;
        let rises =
            mu * (lambda + 2.0 * mu) * (2.0 * lambda * LEAST_AREA + 2.0 * mu) / (both * both);
        (self.area_stress(LEAST_AREA), rises)
    }

    /// Ŝ of Green's strain: 11, 22, 12 \[Pa\].
    #[must_use]
    pub fn stress(&self, e: &[f64; 3]) -> [f64; 3] {
        let (c11, c22, c12) = (1.0 + 2.0 * e[0], 1.0 + 2.0 * e[1], 2.0 * e[2]);
        let d = c11 * c22 - c12 * c12;
        let by_area = match d < LEAST_AREA {
            true => {
                let (at, rises) = self.continued();
                at + rises * (LEAST_AREA - d)
            }
            false => self.area_stress(d),
        };
        [self.mu - by_area * c22, self.mu - by_area * c11, by_area * c12]
    }

    /// Elastic energy a volume \[J/m³\].
    #[must_use]
    pub fn energy(&self, e: &[f64; 3]) -> f64 {
        let (c11, c22, c12) = (1.0 + 2.0 * e[0], 1.0 + 2.0 * e[1], 2.0 * e[2]);
        let d = c11 * c22 - c12 * c12;
        let Self { lambda, mu } = *self;
        let at = d.max(LEAST_AREA);
        let c33 = (lambda + 2.0 * mu) / (lambda * at + 2.0 * mu);
        let square = at * c33;
        let whole = 0.5 * mu * (c11 + c22 + c33 - 3.0) + 0.25 * lambda * (square - 1.0)
            - (0.5 * mu + 0.25 * lambda) * libm::log(square);
        let less = at - d;
        let (slope, rises) = self.continued();
        whole + 0.5 * less * (slope + 0.5 * rises * less)
    }

    /// Energy a volume \[J/m³\] of a strip that is pulled along alone, and its stress \[Pa\], by
    /// its strain.
    #[must_use]
    pub fn strip(&self, strain: f64) -> (f64, f64) {
        let Self { lambda, mu } = *self;
        let real = 1.0 + 2.0 * strain;
        let c = real.max(LEAST_STRETCH);
        // C across: ½λc q² + μq = μ + ½λ.
        let both = mu + 0.5 * lambda;
        let q = 2.0 * both / (mu + (mu * mu + 2.0 * lambda * c * both).sqrt());
        let energy = 0.5 * mu * (c + 2.0 * q - 3.0) + 0.25 * lambda * (c * q * q - 1.0)
            - 0.5 * both * libm::log(c * q * q);
        let stress = mu + 0.5 * lambda * q * q - both / c;
        (energy + 0.5 * stress * (real - c), stress)
    }

    /// Stiffness of the layer along its most pressed direction, ∂P/∂λ, over E/(1 − ν²) \[1\].
    #[must_use]
    pub fn stiffening(&self, e: &[f64; 3]) -> f64 {
        let Self { lambda, mu } = *self;
        let (mean, half) = (1.0 + e[0] + e[1], e[0] - e[1]);
        let radius = (half * half + 4.0 * e[2] * e[2]).sqrt();
        let (low, high) = (mean - radius, mean + radius);
        let d = (low * high).max(LEAST_AREA);
        let high = high.max(LEAST_AREA);
        let low = d / high;
        let c33 = (lambda + 2.0 * mu) / (lambda * d + 2.0 * mu);
        let stress = mu * (1.0 - c33 / low);
        let rises = mu * c33 / low * (1.0 / low + lambda * high / (lambda * d + 2.0 * mu));
        let first = 4.0 * mu * (lambda + mu) / (lambda + 2.0 * mu);
        (stress + 2.0 * low * rises) / first
    }
}

impl SoftElasticity {
    /// Ŝ of the elastic strain: 11, 22, 12 \[Pa\].
    #[must_use]
    pub fn stress(&self, e: &[f64; 3]) -> [f64; 3] {
        match self {
            Self::NeoHookean(law) => law.stress(e),
            Self::Linear(law) => law.stress(e),
        }
    }

    /// Elastic energy a volume \[J/m³\].
    #[must_use]
    pub fn energy(&self, e: &[f64; 3]) -> f64 {
        match self {
            Self::NeoHookean(law) => law.energy(e),
            Self::Linear(law) => law.energy(e),
        }
    }

    /// Energy a volume \[J/m³\] of a strip that is pulled along alone, and its stress \[Pa\], by
    /// its strain.
    #[must_use]
    pub fn strip(&self, strain: f64) -> (f64, f64) {
        match self {
            Self::NeoHookean(law) => law.strip(strain),
            Self::Linear(law) => {
                let young = law.modulus * (1.0 - law.poisson * law.poisson);
                (0.5 * young * strain * strain, young * strain)
            }
        }
    }

    /// What a station still bears of a strain in the frame of its crack (nn, tt, nt) when nothing
    /// holds it together any more: energy \[J/m³\] and stress \[Pa\]. Pulled apart it is a strip
    /// along the crack; pressed together it slides.
    pub(super) fn parted(&self, e: &[f64; 3]) -> (f64, [f64; 3]) {
        let straight = [e[0], e[1], 0.0];
        let stress = self.stress(&straight);
        if stress[0] <= 0.0 {
            return (self.energy(&straight), stress);
        }
        let (energy, along) = self.strip(e[1]);
        (energy, [0.0, along, 0.0])
    }
}

#[cfg(test)]
mod tests {
    use super::{NeoHookean, SoftElasticity};
    use cullet_geometry::math::unit;

    fn states() -> impl Iterator<Item = [f64; 3]> {
        let number = |k: u64, n: u64| unit(7, k, n);
        (0..200).map(move |n| {
            // Stretches of 0.2 to 2.5, turned.
            let [a, b] = [0, 1].map(|k| 0.2 + 2.3 * number(k, n));
            let (s, c) = libm::sincos(6.0 * number(2, n));
            let (a, b) = (a * a, b * b);
            let c11 = a * c * c + b * s * s;
            let c22 = a * s * s + b * c * c;
            [0.5 * (c11 - 1.0), 0.5 * (c22 - 1.0), 0.5 * (a - b) * s * c]
        })
    }

    /// S11: the closed form is what a search for σ₃₃ = 0 finds.
    #[test]
    fn s11_plane_stress_is_exact() {
        let law = NeoHookean::new(1.0, 0.3);
        let NeoHookean { lambda, mu } = law;
        for e in states() {
            let (c11, c22, c12) = (1.0 + 2.0 * e[0], 1.0 + 2.0 * e[1], 2.0 * e[2]);
            let d = c11 * c22 - c12 * c12;
            if d < super::LEAST_AREA {
                continue;
            }
            // S33 = μ(1 − 1/C33) + ½λ(J² − 1)/C33.
            let across = |c: f64| mu * (1.0 - 1.0 / c) + 0.5 * lambda * (d * c - 1.0) / c;
            let (mut low, mut high) = (1e-6_f64, 1e6_f64);
            for _ in 0..200 {
                let middle = (low * high).sqrt();
                *(if across(middle) > 0.0 { &mut high } else { &mut low }) = middle;
            }
            let squared = d * low;
            let pressure = -mu + 0.5 * lambda * (squared - 1.0);
            let wanted = [mu + pressure * c22 / d, mu + pressure * c11 / d, -pressure * c12 / d];
            let found = law.stress(&e);
            let size = wanted.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
            (0..3).for_each(|k| assert!((found[k] - wanted[k]).abs() < 4e-12 * size, "{e:?}"));
        }
    }

    /// The stress is the slope of the energy, where it is continued too, and of small strains that
    /// of linear elasticity.
    #[test]
    fn stress_is_the_slope_of_the_energy() {
        let law = SoftElasticity::NeoHookean(NeoHookean::new(2.0, 0.4));
        let pressed = [[-0.45, -0.3, 0.1], [-0.6, 0.1, 0.0], [-0.49, -0.49, 0.0]];
        for e in states().chain(pressed) {
            let s = law.stress(&e);
            let size = s.iter().fold(1.0_f64, |most, s| most.max(s.abs()));
            for k in 0..3 {
                let step = 1e-6;
                let at = |sign: f64| {
                    let mut e = e;
                    e[k] += sign * step;
                    law.energy(&e)
                };
                let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
                let wanted = if k == 2 { 2.0 * s[k] } else { s[k] };
                assert!((slope - wanted).abs() < 1e-6 * size, "{e:?} {k}: {slope} {wanted}");
            }
            let (energy, stress) = law.strip(e[0]);
            let slope = (law.strip(e[0] + 1e-6).0 - law.strip(e[0] - 1e-6).0) / 2e-6;
            assert!((slope - stress).abs() < 1e-6 * (1.0 + stress.abs()), "{slope} {stress}");
            assert!(energy <= law.energy(&[e[0], e[1], 0.0]) + 1e-12, "the strip is no least");
        }
        let linear = crate::kernel::PlaneStress::new(2.0, 0.4);
        let e = [1e-7, -2e-7, 0.5e-7];
        let (a, b) = (law.stress(&e), linear.stress(&e));
        (0..3).for_each(|k| assert!((a[k] - b[k]).abs() < 1e-12, "{a:?} {b:?}"));
    }
}
