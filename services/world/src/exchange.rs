//! What one body of a pair received over a contact episode.

use crate::body::Motion;
use crate::rigid::Contact;
use cullet_geometry::{Mat3, Vec3};
use std::collections::BTreeMap;

/// What the engine has put into a body on behalf of one contact partner: normal impulses and the
/// pair's share of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// Impulse \[N·s\].
    pub linear: Vec3,
    /// Torque impulse about the body's centre of mass \[N·m·s\].
    pub torque: Vec3,
}

impl Exchange {
    /// Nothing.
    pub(crate) fn zero() -> Self {
        Self { linear: Vec3::zeros(), torque: Vec3::zeros() }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.linear += other.linear;
        self.torque += other.torque;
    }

    pub(crate) fn scaled(&self, share: f64) -> Self {
        Self { linear: self.linear * share, torque: self.torque * share }
    }

    /// What it does to the kinetic energy of a body of that mean velocity and spin \[J\].
    fn work(&self, velocity: &Vec3, spin: &Vec3) -> f64 {
        self.linear.dot(velocity) + self.torque.dot(spin)
    }
}

/// What one contact did to one body in one step.
#[derive(Clone, Copy)]
pub(crate) struct Received {
    pub(crate) exchange: Exchange,
    /// Kinetic energy that it took out of the body \[J\].
    pub(crate) taken: f64,
}

/// Friction and all else that the contacts of a body did beside their normal impulses, to be shared
/// out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest {
    rest: Exchange,
    /// Kinetic energy gained beside the work of gravity and of all exchanges \[J\]: the turning of
    /// the inertia.
    energy: f64,
    impulse: f64,
    velocity: Vec3,
    spin: Vec3,
}

impl Rest {
    /// All that belongs to a contact of that many \[N·s\] and of that normal exchange.
    pub(crate) fn share(&self, impulse: f64, normal: Exchange) -> Received {
        let part = impulse / self.impulse;
        let mut exchange = normal;
        exchange.add(&self.rest.scaled(part));
        let taken = -exchange.work(&self.velocity, &self.spin) - self.energy * part;
        Received { exchange, taken }
    }
}

/// A body's mass, inertia in the world frame, and motion before and after a step.
pub(crate) struct Stepped {
    pub(crate) mass: f64,
    pub(crate) inertia: Mat3,
    pub(crate) inertia_after: Mat3,
    pub(crate) before: Motion,
    pub(crate) after: Motion,
}

impl Stepped {
    /// Kinetic energy gained over the step \[J\].
    fn gained(&self) -> f64 {
        let energy = |motion: &Motion, inertia: &Mat3| {
            let (v, w) = (motion.velocity, motion.spin);
            0.5 * (self.mass * v.norm_squared() + w.dot(&(inertia * w)))
        };
        energy(&self.after, &self.inertia_after) - energy(&self.before, &self.inertia)
    }
}

/// What each body's contacts did in sum: lower and higher side of each pair.
pub(crate) fn sums(contacts: &[Contact]) -> BTreeMap<u32, (Exchange, f64)> {
    let mut sums: BTreeMap<u32, (Exchange, f64)> = BTreeMap::new();
    for c in contacts {
        for (id, sign, torque) in [(c.a, -1.0, c.torque_a), (c.b, 1.0, c.torque_b)] {
            let entry = sums.entry(id).or_insert((Exchange::zero(), 0.0));
            entry.0.add(&Exchange { linear: c.on_b * sign, torque });
            entry.1 += c.impulse;
        }
    }
    sums
}

/// The balance of a body over a step: change of motion − gravity − free turning − normal impulses.
pub(crate) fn rest(body: &Stepped, gravity: &Vec3, dt: f64, normal: &(Exchange, f64)) -> Rest {
    let spin = body.before.spin;
    let free = -spin.cross(&(body.inertia * spin)) * dt;
    let linear = (body.after.velocity - body.before.velocity - gravity * dt) * body.mass;
    let torque = body.inertia * (body.after.spin - spin) - free;
    let velocity = (body.before.velocity + body.after.velocity) / 2.0;
    let mean_spin = (spin + body.after.spin) / 2.0;
    let weight = Exchange { linear: gravity * (dt * body.mass), torque: Vec3::zeros() };
    let done = weight.work(&velocity, &mean_spin)
        + Exchange { linear, torque }.work(&velocity, &mean_spin);
    Rest {
        rest: Exchange { linear: linear - normal.0.linear, torque: torque - normal.0.torque },
        energy: body.gained() - done,
        impulse: normal.1,
        velocity,
        spin: mean_spin,
    }
}
