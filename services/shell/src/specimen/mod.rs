//! Specimens by the shell family: thin flat plates as a
//! [`Discretisation`](cullet_specimen::Discretisation).
//!
//! A specimen is given as a solid, and a plate is what its midsurface and its normal make of it: a
//! place at height z over the midsurface moves by u + z(a₃ − A₃). So what holds both faces along
//! an axis of the plane holds the slope, what holds a line through the thickness does not, and
//! points are read at the five stations through the thickness.

mod body;
mod build;
mod hold;
mod push;
mod read;
#[cfg(test)]
mod tests;

use cullet_model::PointPrecision;
use cullet_specimen::{Feature, PointField, SpecimenFamily};

/// The row of the shell family.
pub const FAMILY: SpecimenFamily =
    SpecimenFamily { name: "shell", features: FEATURES, build: body::discrete };

const FEATURES: &[Feature] = &[
    Feature::Field(PointField::Displacement),
    Feature::Field(PointField::Velocity),
    Feature::Field(PointField::Stress),
    Feature::Field(PointField::Strain),
    Feature::Field(PointField::Damage),
    Feature::Precision(PointPrecision::Single),
    Feature::Precision(PointPrecision::Double),
    Feature::Traction,
    Feature::Pressure,
    Feature::Force,
    Feature::Acceleration,
    Feature::Support,
    Feature::Damping,
    Feature::Stretch,
    Feature::Start,
    Feature::Notch,
    Feature::Breaking,
    Feature::Patch,
];
