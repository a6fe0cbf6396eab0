//! Debris: grains too small to be bodies. They fly as gravity lets them, come to rest where they
//! meet a body that never moves, and touch nothing else. Their mass and momentum stay in the books.

use crate::cluster::Part;
use crate::debris::DebrisParticle;
use crate::id::BodyId;
use crate::rigid::Rigid;
use cullet_geometry::Vec3;
use cullet_model::Grain;

/// Grains that fly at once: more lie where they broke off.
const MOST_FLYING: usize = 20_000;

/// All grains, oldest first.
#[derive(Default)]
pub(crate) struct Debris {
    pub(crate) grains: Vec<DebrisParticle>,
}

impl Debris {
    /// Moves the grains that fly by one step of `dt` \[s\].
    pub(crate) fn advance(&mut self, gravity: &Vec3, dt: f64, rigid: &Rigid) {
        for grain in self.grains.iter_mut().filter(|grain| !grain.resting) {
            grain.fly(gravity, dt, rigid);
        }
    }

    /// Adds grains that move as `parts` say; returns the numbers they got.
    pub(crate) fn scatter(&mut self, parent: u32, grains: &[Grain], parts: &[Part]) -> Vec<u64> {
        let flying = self.grains.iter().filter(|grain| !grain.resting).count();
        let room = MOST_FLYING.saturating_sub(flying);
        let mut ids = Vec::with_capacity(grains.len());
        for (k, (grain, part)) in grains.iter().zip(parts).enumerate() {
            let id = self.grains.last().map_or(0, |last| last.id + 1);
            self.grains.push(DebrisParticle {
                id,
                parent: BodyId(parent),
                mass: part.mass,
                size: grain.size,
                position: part.centre,
                velocity: part.velocity,
                resting: k >= room,
            });
            ids.push(id);
        }
        ids
    }
}
