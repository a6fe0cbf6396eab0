//! What the world needs to know of a material.

use cullet_model::Material;

/// A material as the rigid world meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMaterial {
    /// Density, elasticity and strength.
    pub solid: Material,
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

impl ContactMaterial {
    /// The first field outside the range in which the contact formulas hold.
    pub(crate) fn fault(&self) -> Option<Bound> {
        let solid = &self.solid;
        let rows = [
            ("density [kg/m³]", solid.density, 1e-2, 1e6),
            ("young [Pa]", solid.young, 1.0, 1e13),
            ("poisson [1]", solid.poisson, -0.99, 0.4999),
            ("failure_stress [Pa]", solid.failure_stress, 1e-6, 1e13),
            ("fracture_energy [J/m²]", solid.fracture_energy, 0.0, 1e12),
            ("restitution [1]", self.restitution, 0.0, 1.0),
            ("friction [1]", self.friction, 0.0, 10.0),
        ];
        rows.into_iter()
            .map(|(what, value, low, high)| Bound { what, value, low, high })
            .find(|b| !(b.low..=b.high).contains(&b.value))
    }
}
