//! Specimens as points and bonds: a [`Discretisation`](cullet_specimen::Discretisation).
//!
//! Points are a spacing apart, each of a spacing cubed of volume, scattered or in rows, and bonds
//! reach as far as the specimen's `horizon` times that. What is at a face of the body:
//!
//! - Behind a side of the body that a support or a plane of symmetry lies on is the body's image
//!   (`mirror`). Other supports hold the points in their part.
//! - What loads press is the point nearest to each piece of the surface.
//!
//! A crack between two rows takes two fifths of the bonds of the points beside it, not all. So the
//! damage that is shown is a point's share of lost bonds over that which such a crack takes,
//! without what notches took (`read`).

mod body;
mod build;
mod hold;
mod mirror;
mod push;
mod read;
#[cfg(test)]
mod tests;

pub use build::HORIZON;

use cullet_model::PointPrecision;
use cullet_specimen::{Feature, PointField, SpecimenFamily};

/// The row of the family.
pub const FAMILY: SpecimenFamily =
    SpecimenFamily { name: "peridynamics", features: FEATURES, build: body::discrete };

const FEATURES: &[Feature] = &[
    Feature::Field(PointField::Displacement),
    Feature::Field(PointField::Velocity),
    Feature::Field(PointField::Stress),
    Feature::Field(PointField::Strain),
    Feature::Field(PointField::Damage),
    Feature::Field(PointField::PlasticStrain),
    Feature::Field(PointField::VolumeRatio),
    Feature::Precision(PointPrecision::Single),
    Feature::Traction,
    Feature::Pressure,
    Feature::Force,
    Feature::Acceleration,
    Feature::Support,
    Feature::Symmetry,
    Feature::Damping,
    Feature::Stretch,
    Feature::Start,
    Feature::Notch,
    Feature::Breaking,
    Feature::Flow,
    Feature::Patch,
    Feature::Turn,
];
