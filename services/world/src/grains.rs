//! Debris: grains too small to be bodies. They fly as gravity lets them, come to rest where they
//! meet a body that never moves, and touch nothing else. Their mass and momentum stay in the books.

use crate::cluster::Part;
use crate::id::BodyId;
use crate::rigid::Rigid;
use crate::world::World;
use cullet_geometry::{Mat3, Vec3};
use cullet_model::Grain;

/// A grain in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebrisParticle {
    /// Its number among grains: increasing, never reused.
    pub id: u64,
    /// The body that it broke from.
    pub parent: BodyId,
    /// Mass \[kg\].
    pub mass: f64,
    /// Diameter \[m\].
    pub size: f64,
    /// Where \[m\].
    pub position: Vec3,
    /// Velocity \[m/s\].
    pub velocity: Vec3,
    /// Lies where it fell.
    pub resting: bool,
}

/// Grains that fly at once: more lie where they broke off.
const MOST_FLYING: usize = 20_000;

impl DebrisParticle {
    pub(crate) fn part(&self) -> Part {
        let (centre, velocity, mass) = (self.position, self.velocity, self.mass);
        Part { mass, inertia: Mat3::zeros(), centre, velocity, spin: Vec3::zeros() }
    }

    /// Semi-implicit Euler, as the bodies move.
    fn fly(&mut self, gravity: &Vec3, dt: f64, rigid: &Rigid) {
        self.velocity += gravity * dt;
        let way = self.velocity * dt;
        let stop = rigid.fixed_on_the_way(&self.position, &way);
        self.position += way * stop.unwrap_or(1.0);
        if stop.is_some() {
            self.velocity = Vec3::zeros();
            self.resting = true;
        }
    }
}

impl World {
    /// All grains, oldest first.
    #[must_use]
    pub fn grains(&self) -> &[DebrisParticle] {
        &self.grains
    }

    pub(crate) fn fly(&mut self) {
        let (gravity, dt) = (self.settings.gravity, self.settings.step);
        for grain in self.grains.iter_mut().filter(|grain| !grain.resting) {
            grain.fly(&gravity, dt, &self.rigid);
        }
    }

    /// Lets grains go that move as `parts` say; hands back the numbers they got.
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
