//! What the world needs to know of a material.

use cullet_model::{Material, SurfaceLaw};

/// A material as the rigid world meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMaterial {
    /// Density, elasticity and strength.
    pub solid: Material,
    /// Coefficient of restitution of a bounce \[1\]; a pair takes the mean.
    pub restitution: f64,
    /// Coulomb friction coefficient \[1\]; a pair takes the mean.
    pub friction: f64,
    /// How its surface bears others.
    pub surface: SurfaceLaw,
    /// Whether its own solve makes it flow: a contact with it then yields in that solve.
    pub flows: bool,
}

/// One field, its value and the range it must lie in.
pub(crate) struct Bound {
    pub(crate) what: &'static str,
    pub(crate) value: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl ContactMaterial {
    /// Mean pressure at which the contact of a hit on this with `other` yields \[Pa\]: the hardness
    /// of the softer of the two. What flows in its own solve yields there, and its contact where
    /// the other does.
    pub(crate) fn crushing_pressure(&self, other: &Self) -> f64 {
        match self.flows {
            true => other.surface.hardness,
            false => self.surface.hardness.min(other.surface.hardness),
        }
    }

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
            ("hardness [Pa]", self.surface.hardness, 1e-3, 1e13),
            ("crack_friction [1]", self.surface.friction, 0.0, 10.0),
        ];
        rows.into_iter()
            .map(|(what, value, low, high)| Bound { what, value, low, high })
            .find(|b| !(b.low..=b.high).contains(&b.value))
    }
}
