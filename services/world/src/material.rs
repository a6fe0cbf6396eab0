//! What the world needs to know of a material.

/// A brittle, isotropic solid as the rigid world sees it.
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
    /// Coefficient of restitution of a bounce \[1\]; a pair takes the mean.
    pub restitution: f64,
    /// Coulomb friction coefficient \[1\]; a pair takes the mean.
    pub friction: f64,
}

/// One field, its value and the range it must lie in.
pub(crate) struct Bound {
    pub(crate) what: &'static str,
    pub(crate) value: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Material {
    /// Speed of pressure waves in the bulk \[m/s\].
    #[must_use]
    pub fn pressure_speed(&self) -> f64 {
        let (young, poisson) = (self.young, self.poisson);
        (young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson) * self.density)).sqrt()
    }

    /// Speed of shear waves \[m/s\].
    #[must_use]
    pub fn shear_speed(&self) -> f64 {
        (self.young / (2.0 * (1.0 + self.poisson) * self.density)).sqrt()
    }

    /// The first field outside the range in which the contact formulas hold.
    pub(crate) fn fault(&self) -> Option<Bound> {
        let rows = [
            ("density [kg/m³]", self.density, 1e-2, 1e6),
            ("young [Pa]", self.young, 1.0, 1e13),
            ("poisson [1]", self.poisson, -0.99, 0.4999),
            ("failure_stress [Pa]", self.failure_stress, 1e-6, 1e13),
            ("fracture_energy [J/m²]", self.fracture_energy, 0.0, 1e12),
            ("restitution [1]", self.restitution, 0.0, 1.0),
            ("friction [1]", self.friction, 0.0, 10.0),
        ];
        rows.into_iter()
            .map(|(what, value, low, high)| Bound { what, value, low, high })
            .find(|b| !(b.low..=b.high).contains(&b.value))
    }
}
