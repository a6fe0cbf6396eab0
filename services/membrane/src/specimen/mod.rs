//! Specimens by the membrane family: flat sheets as a
//! [`Discretisation`](cullet_specimen::Discretisation).
//!
//! A specimen is given as a solid, and a sheet is its middle plane with one layer of points. A
//! place at height z over the plane moves by u + z(a₃ − A₃), a₃ being the normal. A support holds
//! the points in its part; one that has none, as a side of the body, holds the row of points along
//! it. A clamp that holds a slope must be three spacings deep, for a point has no slope of its own.
//!
//! Near what holds a sheet in its plane nothing breaks, as near the grips of a scene's sheets.

mod body;
mod build;
mod hold;
mod outline;
mod push;
mod read;
#[cfg(test)]
mod tests;

use cullet_model::PointPrecision;
use cullet_specimen::{Feature, PointField, SpecimenFamily};

/// The row of the family.
pub const FAMILY: SpecimenFamily =
    SpecimenFamily { name: crate::family::NAME, features: FEATURES, build: body::discrete };

const FEATURES: &[Feature] = &[
    Feature::Field(PointField::Displacement),
    Feature::Field(PointField::Velocity),
    Feature::Field(PointField::Stress),
    Feature::Field(PointField::Strain),
    Feature::Field(PointField::Damage),
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
];
