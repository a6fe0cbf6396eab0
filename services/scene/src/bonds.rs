//! What a scene makes of the bonds of a material, and what `peridynamics` cannot do.

use super::direction::direction;
use super::format::{self, SolverChoice};
use super::material::SceneMaterial;
use super::sourced::Fault;
use cullet_model::{BondGrain, BondProperty, BondedSolid, BoundedNumber, DuctileFailure};
use cullet_plan::family;

impl From<&format::BondNumbers> for BondedSolid {
    /// How it yields is another key.
    fn from(written: &format::BondNumbers) -> Self {
        let none = Self::default();
        let grain = |grain: format::BondAxis| {
            let axis = direction(grain.axis).unwrap_or(grain.axis).into();
            BondGrain { axis, strength: grain.strength, stretch: grain.softness.unwrap_or(1.0) }
        };
        let failure =
            |[one, two, three]: [f64; 3]| DuctileFailure { d: [one, two, three, 0.0, 0.0] };
        Self {
            hardening: None,
            breaks: written.breaks.unwrap_or(none.breaks),
            dust: written.dust.unwrap_or(none.dust),
            failure: written.failure.map(failure),
            max_plastic_stretch: written.max_plastic_stretch,
            grain: written.grain.map(grain),
            friction: written.friction.unwrap_or(none.friction),
            bond_damping: written.damping.unwrap_or(none.bond_damping),
            air_damping: written.air.unwrap_or(none.air_damping),
            horizon: written.horizon.unwrap_or(none.horizon),
        }
    }
}

/// What is wrong with the bonds of a material, by the key below `peridynamics`.
pub(super) fn faults(written: &format::BondNumbers) -> Vec<Fault> {
    let axis = written.grain.map(|grain| direction(grain.axis));
    if let Some(Err(why)) = axis {
        return vec![("grain", format!("`axis` {why}"))];
    }
    let bonds = BondedSolid::from(written);
    let fault = |number: BoundedNumber| {
        let (what, value, low, high) = number.bound;
        let message = format!("{what} is {value:.3e}; it must lie in [{low:.3e}, {high:.3e}]");
        (!(low..=high).contains(&value)).then_some((key_of(number.of)?, message))
    };
    bonds.numbers().into_iter().filter_map(fault).collect()
}

/// The key below `peridynamics` that a property of bonds is written at. How they yield is another
/// key of the material.
fn key_of(property: BondProperty) -> Option<&'static str> {
    match property {
        BondProperty::Dust => Some("dust"),
        BondProperty::Friction => Some("friction"),
        BondProperty::BondDamping => Some("damping"),
        BondProperty::AirDamping => Some("air"),
        BondProperty::Horizon => Some("horizon"),
        BondProperty::Hardening => None,
        BondProperty::MaxPlasticStretch => Some("max_plastic_stretch"),
        BondProperty::Grain => Some("grain"),
        BondProperty::Failure => Some("failure"),
    }
}

/// Why `peridynamics` cannot solve a body of a material, by the key at fault.
pub(super) fn unfit(
    material: &SceneMaterial,
    painted: bool,
    solver: &SolverChoice,
) -> Option<Fault> {
    let name = solver.name().filter(|name| *name == family::PERIDYNAMICS)?;
    let why = |what: &str| format!("`{name}` knows no {what}: `{}` does", family::DEFAULT);
    if material.weak_plane.is_some() {
        return Some(("material", why("weak plane, but the `grain` of its bonds")));
    }
    if material.layers.is_some() {
        return Some(("material", why("layers")));
    }
    painted.then(|| ("paint", why("painted strength")))
}
