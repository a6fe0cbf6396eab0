//! What a solver needs to know of a material.

/// A brittle, isotropic solid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// Young's modulus E \[Pa\].
    pub young: f64,
    /// Poisson's ratio ν \[1\].
    pub poisson: f64,
    /// Rankine threshold σ_f \[Pa\].
    pub failure_stress: f64,
    /// Mode I fracture energy G_f \[J/m²\].
    pub fracture_energy: f64,
}

impl Material {
    /// Lamé's first parameter λ = Eν/((1+ν)(1−2ν)) \[Pa\].
    #[must_use]
    pub fn lame(&self) -> f64 {
        self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// Shear modulus μ = E/(2(1+ν)) \[Pa\].
    #[must_use]
    pub fn shear(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// Speed of pressure waves c_d = √((λ+2μ)/ρ) \[m/s\].
    #[must_use]
    pub fn pressure_speed(&self) -> f64 {
        ((self.lame() + 2.0 * self.shear()) / self.density).sqrt()
    }

    /// Speed of shear waves c_s = √(μ/ρ) \[m/s\].
    #[must_use]
    pub fn shear_speed(&self) -> f64 {
        (self.shear() / self.density).sqrt()
    }

    /// Speed of Rayleigh waves, c_s (0.862 + 1.14ν)/(1 + ν) within 0.3 %  [accuracy 1.0] \[m/s\].
    #[must_use]
    pub fn rayleigh_speed(&self) -> f64 {
        self.shear_speed() * (0.862 + 1.14 * self.poisson) / (1.0 + self.poisson)
    }

    /// Mean size of the fragments of a solid that is stretched at `rate` \[1/s\] until it breaks:
    /// s = 4.5 s₀/(1 + 0.77 r^¼ + 5.4 r^¾) with s₀ = EG_f/σ_f² and r = rate E²G_f/cσ_f³, c = √(E/ρ)
    /// [Zhou, Molinari and Ramesh 2006; G1] \[m\].
    ///
    /// At low rates it is the energy stored at σ_f that pays for the cracks, and the size has a
    /// bound; Grady's (24G_f/ρε̇²)^⅓ knows only the energy of motion and has none.
    #[must_use]
    pub fn fragment_size(&self, rate: f64) -> f64 {
        let (young, strength) = (self.young, self.failure_stress);
        let size = young * self.fracture_energy / (strength * strength);
        let speed = (young / self.density).sqrt();
        let ratio = rate * young * size / (speed * strength);
        let quarter = ratio.sqrt().sqrt();
        4.5 * size / (1.0 + 0.77 * quarter + 5.4 * quarter.powi(3))
    }
}

#[cfg(test)]
mod tests {
    use crate::Material;

    #[test]
    fn wave_speeds_of_soda_lime_glass() {
        let glass = Material {
            density: 2440.0,
            young: 72e9,
            poisson: 0.22,
            failure_stress: 50e6,
            fracture_energy: 8.0,
        };
        assert!((glass.pressure_speed() - 5804.0).abs() < 1.0);
        assert!((glass.shear_speed() - 3478.0).abs() < 1.0);
        assert!((glass.rayleigh_speed() / 3180.0 - 1.0).abs() < 3e-3);
    }

    /// G1: fragments of a ceramic bar of 50 mm.
    #[test]
    fn a_ceramic_bar_breaks_into_as_many_as_the_catalogue_says() {
        let ceramic = Material {
            density: 2750.0,
            young: 275e9,
            poisson: 0.0,
            failure_stress: 300e6,
            fracture_energy: 100.0,
        };
        for (rate, count) in [(1e3, 61.0), (1e4, 132.0), (1e5, 498.0), (1e6, 2490.0)] {
            let found = 0.05 / ceramic.fragment_size(rate);
            assert!((found / count - 1.0_f64).abs() < 0.01, "{found} at {rate} /s, not {count}");
        }
    }
}
