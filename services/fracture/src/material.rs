//! What a solver needs to know of a material.

/// A brittle, isotropic solid.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

#[cfg(test)]
mod tests {
    use super::Material;

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
}
