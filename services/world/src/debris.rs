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

    pub(crate) fn fly(&mut self, gravity: &Vec3, dt: f64, rigid: &Rigid) {
        let free = FreeFlight { faster: gravity * dt, step: dt };
        let (position, velocity) = free.after(self.position, self.velocity);
        let way = velocity * dt;
        match rigid.fixed_on_the_way(&self.position, &way) {
            None => (self.position, self.velocity) = (position, velocity),
            Some(stop) => {
                self.position += way * stop;
                self.velocity = Vec3::zeros();
                self.resting = true;
            }
        }
    }
}

/// How a grain moves in a step in which it meets nothing: semi-implicit Euler, as the bodies move.
/// Recordings rely on it to the last bit.
#[derive(Clone, Copy, Debug)]
pub struct FreeFlight {
    /// Gravity times the step \[m/s\].
    pub faster: Vec3,
    /// The step \[s\].
    pub step: f64,
}

impl FreeFlight {
    /// Position \[m\] and velocity \[m/s\] a step later.
    #[must_use]
    pub fn after(&self, position: Vec3, velocity: Vec3) -> (Vec3, Vec3) {
        let velocity = velocity + self.faster;
        (position + velocity * self.step, velocity)
    }
}
