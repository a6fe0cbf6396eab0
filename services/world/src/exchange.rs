//! What one body of a pair received over a contact episode.

use crate::motion::Motion;
use crate::rigid::Contact;
use cullet_geometry::{Mat3, Vec3};
use std::collections::{BTreeMap, BTreeSet};

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Received {
    pub(crate) exchange: Exchange,
    /// Kinetic energy that it took out of the body \[J\].
    pub(crate) taken: f64,
}

impl Received {
    /// Nothing.
    pub(crate) fn zero() -> Self {
        Self { exchange: Exchange::zero(), taken: 0.0 }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.exchange.add(&other.exchange);
        self.taken += other.taken;
    }

    pub(crate) fn scaled(&self, share: f64) -> Self {
        Self { exchange: self.exchange.scaled(share), taken: self.taken * share }
    }
}

/// Friction and all else that the contacts of a body did beside their normal impulses, to be shared
/// out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest {
    rest: Exchange,
    /// Kinetic energy gained beside the work of gravity and of all exchanges \[J\]: the turning of
    /// the inertia.
    energy: f64,
    /// Normal impulses of the contacts that it is still to be shared out to \[N·s\].
    impulse: f64,
    /// How many they are.
    contacts: u32,
    centre: Vec3,
    velocity: Vec3,
    spin: Vec3,
}

impl Rest {
    /// The impulse of all friction \[N·s\].
    pub(crate) fn linear(&self) -> Vec3 {
        self.rest.linear
    }

    /// What belongs to a contact of that many \[N·s\] by its share of the impulse.
    fn part(&self, impulse: f64) -> Exchange {
        self.rest.scaled(impulse / self.impulse)
    }

    /// Hands `rest` to a contact of that many \[N·s\] and of that normal exchange.
    fn hand(&mut self, impulse: f64, rest: Exchange, normal: Exchange) -> Received {
        let energy = self.energy * (impulse / self.impulse);
        self.rest.add(&rest.scaled(-1.0));
        self.energy -= energy;
        self.impulse -= impulse;
        self.contacts -= 1;
        let mut exchange = normal;
        exchange.add(&rest);
        let taken = -exchange.work(&self.velocity, &self.spin) - energy;
        Received { exchange, taken }
    }
}

/// What each contact did to both of its bodies over a step; `rests` has the bodies that move, and
/// `driven` the motions of those that are driven.
///
/// A body with one contact got all its friction there, and its partner the opposite at the contact
/// point, so the tree of contacts is peeled from its leaves; what is left over goes to the last
/// contact of a body. Around a ring each body's friction is shared out by the normal impulses.
pub(crate) fn received(
    contacts: &[Contact],
    mut rests: BTreeMap<u32, Rest>,
    driven: &BTreeMap<u32, Motion>,
) -> Vec<[Received; 2]> {
    let normal = |c: &Contact, side: usize| match side {
        0 => Exchange { linear: -c.on_b, torque: c.torque_a },
        _ => Exchange { linear: c.on_b, torque: c.torque_b },
    };
    let mut sides: Vec<[Option<Received>; 2]> = vec![[None; 2]; contacts.len()];
    let mut of: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (k, c) in contacts.iter().enumerate() {
        [c.a, c.b].into_iter().for_each(|id| of.entry(id).or_default().push(k));
    }
    let mut leaves: BTreeSet<u32> =
        rests.iter().filter(|(_, rest)| rest.contacts == 1).map(|(&id, _)| id).collect();
    while let Some(id) = leaves.pop_first() {
        let open = of.get(&id).into_iter().flatten().copied();
        let Some(k) = open.into_iter().find(|&k| sides[k] == [None; 2]) else {
            continue;
        };
        let c = &contacts[k];
        let (side, partner) = if c.a == id { (0, c.b) } else { (1, c.a) };
        let Some(own) = rests.get_mut(&id) else {
            continue;
        };
        let all = own.rest;
        sides[k][side] = Some(own.hand(c.impulse, all, normal(c, side)));
        let linear = -all.linear;
        sides[k][1 - side] = Some(match rests.get_mut(&partner) {
            Some(rest) => {
                let torque = (c.moment / c.impulse - rest.centre).cross(&linear);
                let last = rest.contacts == 1;
                let all = if last { rest.rest } else { Exchange { linear, torque } };
                let got = rest.hand(c.impulse, all, normal(c, 1 - side));
                if rest.contacts == 1 {
                    leaves.insert(partner);
                }
                got
            }
            None => from_driver(c, partner, normal(c, 1 - side), &linear, driven),
        });
    }
    let shared = |rests: &BTreeMap<u32, Rest>, c: &Contact, side: usize| {
        let mut rest = rests.get([&c.a, &c.b][side]).copied();
        let got =
            rest.as_mut().map(|rest| rest.hand(c.impulse, rest.part(c.impulse), normal(c, side)));
        let other = rests.get([&c.b, &c.a][side]).map(|rest| -rest.part(c.impulse).linear);
        let rub = other.unwrap_or_else(Vec3::zeros);
        got.unwrap_or_else(|| from_driver(c, [c.a, c.b][side], normal(c, side), &rub, driven))
    };
    let both = contacts.iter().zip(sides);
    both.map(|(c, [one, two])| {
        [one.unwrap_or_else(|| shared(&rests, c, 0)), two.unwrap_or_else(|| shared(&rests, c, 1))]
    })
    .collect()
}

/// What a body that nothing moves got: of a driven one with the friction, and with the work that it
/// did; of a fixed one the normal impulses alone.
fn from_driver(
    contact: &Contact,
    id: u32,
    normal: Exchange,
    rub: &Vec3,
    driven: &BTreeMap<u32, Motion>,
) -> Received {
    let Some(motion) = driven.get(&id) else {
        return Received { exchange: normal, taken: 0.0 };
    };
    let arm = contact.moment / contact.impulse - motion.centre();
    let mut exchange = normal;
    exchange.add(&Exchange { linear: *rub, torque: arm.cross(rub) });
    Received { exchange, taken: -exchange.work(&motion.velocity, &motion.spin) }
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

/// The normal impulses on one body in sum.
#[derive(Clone, Copy)]
pub(crate) struct Normals {
    exchange: Exchange,
    impulse: f64,
    contacts: u32,
}

/// What each body's contacts did in sum: lower and higher side of each pair.
pub(crate) fn sums(contacts: &[Contact]) -> BTreeMap<u32, Normals> {
    let none = Normals { exchange: Exchange::zero(), impulse: 0.0, contacts: 0 };
    let mut sums: BTreeMap<u32, Normals> = BTreeMap::new();
    for c in contacts {
        for (id, sign, torque) in [(c.a, -1.0, c.torque_a), (c.b, 1.0, c.torque_b)] {
            let entry = sums.entry(id).or_insert(none);
            entry.exchange.add(&Exchange { linear: c.on_b * sign, torque });
            entry.impulse += c.impulse;
            entry.contacts += 1;
        }
    }
    sums
}

impl Normals {
    /// Are they of one contact?
    pub(crate) fn single(&self) -> bool {
        self.contacts == 1
    }
}

/// The balance of a body over a step: change of motion − gravity (with fields) − free turning −
/// normal impulses − what its joints gave it.
pub(crate) fn rest(
    body: &Stepped,
    gravity: &Vec3,
    dt: f64,
    normal: &Normals,
    held: Option<&Exchange>,
) -> Rest {
    let held = held.copied().unwrap_or_else(Exchange::zero);
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
        rest: Exchange {
            linear: linear - normal.exchange.linear - held.linear,
            torque: torque - normal.exchange.torque - held.torque,
        },
        energy: body.gained() - done,
        impulse: normal.impulse,
        contacts: normal.contacts,
        centre: body.before.centre(),
        velocity,
        spin: mean_spin,
    }
}

/// What a replacement settled for the other body of an episode, should that break too.
#[derive(Clone, Debug)]
pub(crate) struct PendingExchange {
    /// What the other body holds from the episode, all told.
    pub(crate) mine: Exchange,
    /// What the fragments hold from it.
    pub(crate) theirs: Exchange,
    /// The fragments.
    pub(crate) others: Vec<u32>,
    /// What is left of the energy that the contact took \[J\].
    pub(crate) energy_budget: f64,
}
