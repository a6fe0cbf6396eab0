//! What a cut is told of the points, in the order in which they were sampled.

use super::Domain;
use cullet_fragment::crack::BROKEN;
use cullet_fragment::cut::DamageField;
use cullet_fragment::debris::{Mote, Motes};
use cullet_fragment::pieces::Pieces;
use cullet_geometry::Vec3;

/// Places and damage of the points.
#[derive(Clone, Debug)]
pub(crate) struct PointDamage {
    positions: Vec<Vec3>,
    /// Of each \[1\].
    pub(crate) damage: Vec<f64>,
    times: Vec<f64>,
    normals: Vec<Vec3>,
}

impl PointDamage {
    /// Of a body on its grid.
    pub(crate) fn of(domain: &Domain) -> Self {
        let particles = &domain.particles;
        let slots = (0..particles.len() as u32).map(|id| domain.slot(id));
        let slots: Vec<usize> = slots.collect();
        Self {
            positions: slots.iter().map(|&p| particles.reference[p]).collect(),
            damage: slots.iter().map(|&p| particles.damage[p]).collect(),
            times: slots.iter().map(|&p| particles.damage_time[p].max(0.0)).collect(),
            normals: slots.iter().map(|&p| particles.normal[p]).collect(),
        }
    }

    /// As a cut takes it; no crack runs faster than `top_speed` \[m/s\].
    pub(crate) fn field<'a>(
        &'a self,
        domain: &Domain,
        top_speed: f64,
        pieces: &'a Pieces,
    ) -> DamageField<'a> {
        DamageField {
            spacing: domain.grid.spacing.max(),
            positions: &self.positions,
            damage: &self.damage,
            damage_time: &self.times,
            time_step: domain.step,
            top_speed,
            scale: Vec3::repeat(1.0),
            normals: Some(&self.normals),
            pieces: Some(pieces),
            scored: &[],
        }
    }
}

/// The points that broke, where `place` says from their slots, and how they move.
pub(crate) fn motes(domain: &Domain, place: impl Fn(usize) -> Vec3) -> Motes {
    let particles = &domain.particles;
    let motions = domain.motions();
    let broken = (0..particles.len() as u32).map(|id| domain.slot(id));
    let broken = broken.filter(|&p| particles.damage[p] >= BROKEN);
    let mote = |p: usize| Mote { place: place(p), velocity: motions[p].velocity };
    Motes { all: broken.map(mote).collect(), reach: domain.grid.spacing.max() }
}
