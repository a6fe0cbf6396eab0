//! A grain of debris in the world.

use crate::cluster::Part;
use crate::id::BodyId;
use crate::rigid::Rigid;
use cullet_geometry::{Mat3, Vec3};

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

impl DebrisParticle {
    pub(crate) fn part(&self) -> Part {
        let (centre, velocity, mass) = (self.position, self.velocity, self.mass);
        Part { mass, inertia: Mat3::zeros(), centre, velocity, spin: Vec3::zeros() }
    }

    /// Semi-implicit Euler, as the bodies move.
    pub(crate) fn fly(&mut self, gravity: &Vec3, dt: f64, rigid: &Rigid) {
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
