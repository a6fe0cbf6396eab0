//! Specimens by the brittle and the ductile family: material points on a grid as a
//! [`Discretisation`](cullet_specimen::Discretisation).

mod body;
mod build;
mod hold;
mod push;
mod read;
#[cfg(test)]
mod tests;

use cullet_model::PointPrecision;
use cullet_specimen::{Feature, PointField, SpecimenFamily};

/// The row of the brittle family.
pub const FAMILY: SpecimenFamily =
    SpecimenFamily { name: "brittle", features: FEATURES, build: body::discrete };

/// The row of the ductile family.
pub const DUCTILE: SpecimenFamily =
    SpecimenFamily { name: "ductile", features: DUCTILE_FEATURES, build: body::discrete };

const DUCTILE_FEATURES: &[Feature] = &[
    Feature::Field(PointField::Displacement),
    Feature::Field(PointField::Velocity),
    Feature::Field(PointField::Stress),
    Feature::Field(PointField::Strain),
    Feature::Field(PointField::Damage),
    Feature::Field(PointField::PlasticStrain),
    Feature::Field(PointField::VolumeRatio),
    Feature::Precision(PointPrecision::Single),
    Feature::Precision(PointPrecision::Double),
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
    Feature::Flow,
    Feature::Bodies,
    Feature::Turn,
];

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
    Feature::Symmetry,
    Feature::Damping,
    Feature::Stretch,
    Feature::Start,
    Feature::Notch,
    Feature::Breaking,
    Feature::Zone,
    Feature::Patch,
    Feature::Bodies,
    Feature::Turn,
];
