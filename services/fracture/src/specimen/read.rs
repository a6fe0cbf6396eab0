//! What is read off material points on a grid.

use crate::mpm::Domain;
use crate::mpm::domain::PointMotion;
use crate::mpm::elastic::green_strain;
use cullet_geometry::Mat3;
use cullet_specimen::{FieldValues, LocalVector, PointField, PointFields};
use std::collections::BTreeMap;

/// What the points carry, in the order of the arrays.
pub(super) fn points(domain: &Domain, fields: &[PointField]) -> PointFields {
    let particles = &domain.particles;
    let moves = |field: &PointField| {
        use PointField::{Damage, PlasticStrain, Stress};
        !matches!(field, Damage | Stress | PlasticStrain)
    };
    let motions = if fields.iter().any(moves) { domain.motions() } else { Vec::new() };
    let vectors = |one: fn(&PointMotion) -> LocalVector| {
        FieldValues::Vectors(motions.iter().map(one).collect())
    };
    let values = |field| match field {
        PointField::Displacement => vectors(|motion| LocalVector {
            value: motion.displacement,
            gradient: motion.displacement_gradient,
        }),
        PointField::Velocity => vectors(|motion| LocalVector {
            value: motion.velocity,
            gradient: motion.velocity_gradient,
        }),
        PointField::Stress => FieldValues::Tensors(domain.stresses()),
        PointField::Strain => {
            let strain = |motion: &PointMotion| green_strain(&motion.displacement_gradient);
            FieldValues::Tensors(motions.iter().map(strain).collect())
        }
        PointField::Damage => FieldValues::Numbers(particles.damage.clone()),
        PointField::PlasticStrain => {
            let strain = |p: usize| particles.flow.get(p).map_or(0.0, |it| it.history.strain);
            FieldValues::Numbers((0..particles.len()).map(strain).collect())
        }
        PointField::VolumeRatio => {
            let ratio = |motion: &PointMotion| {
                (Mat3::identity() + motion.displacement_gradient).determinant()
            };
            FieldValues::Numbers(motions.iter().map(ratio).collect())
        }
    };
    PointFields {
        places: particles.reference.clone(),
        numbers: particles.id.clone(),
        volumes: particles.volume.clone(),
        fields: fields.iter().map(|&field| (field, values(field))).collect(),
    }
}

/// Shares of the body's mass that its pieces have, by their whole points, the largest first.
pub(super) fn shares(domain: &Domain) -> Vec<f64> {
    let particles = &domain.particles;
    let mut sizes: BTreeMap<u32, f64> = BTreeMap::new();
    for (id, piece) in domain.pieces().into_iter().enumerate() {
        if let Some(piece) = piece {
            *sizes.entry(piece).or_default() += particles.mass(domain.slot(id as u32));
        }
    }
    let all: f64 = (0..particles.volume.len()).map(|p| particles.mass(p)).sum();
    let mut shares: Vec<f64> = sizes.into_values().map(|size| size / all).collect();
    shares.sort_unstable_by(|a, b| b.total_cmp(a));
    shares
}
