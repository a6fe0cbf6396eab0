//! Contact of points that have lost bonds.

use super::PeridynamicDomain;
use crate::bonds::neighbours::CellOrder;
use crate::law::PartedContact;
use cullet_geometry::Vec3;
use rayon::prelude::*;

/// Share of the spacing, and of a broken bond's length at rest, within which points push each other
/// apart, so that none does when a bond has just broken (Silling and Askari 2005).
pub(crate) const REACH: f64 = 0.9;

/// Stiffness over KΔx: about what the bonds bore that are gone.
pub(crate) const STIFFNESS: f64 = 0.5;

/// Share of a pair's relative speed across their line that friction takes in a step at most.
const MOST_SLOWED: f64 = 0.25;

/// What contact does to a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ContactPush {
    /// \[N\].
    pub(crate) force: Vec3,
    /// Its half of the energy that pairs hold \[J\].
    pub(crate) held: f64,
    /// Its half of what friction takes \[J\].
    pub(crate) friction: f64,
}

impl PeridynamicDomain {
    /// Adds the forces of contact after a step of `dt` \[s\]; what friction took \[J\].
    pub(super) fn push_apart(&mut self, contact: &PartedContact, dt: f64) -> f64 {
        let damaged = |p: &usize| self.states[*p].damage > 0.0;
        let parted: Vec<usize> = (0..self.places.len()).filter(damaged).collect();
        let places: Vec<Vec3> = parted.iter().map(|&p| self.places[p]).collect();
        self.contact = 0.0;
        if places.is_empty() || places.iter().any(|x| !x.iter().all(|c| c.is_finite())) {
            return 0.0;
        }
        let order = CellOrder::new(&places, REACH * libm::cbrt(self.mean_volume));
        let body = &*self;
        let push = |k: usize| {
            let near = order.of(k).into_iter().map(|q| parted[q as usize]);
            near.fold(ContactPush::default(), |sum, q| {
                body.pushed(sum, [parted[k], q], contact, dt)
            })
        };
        let found: Vec<ContactPush> = (0..parted.len()).into_par_iter().map(push).collect();
        let mut friction = 0.0;
        for (p, push) in parted.into_iter().zip(found) {
            self.forces[p] += push.force;
            self.contact += push.held;
            friction += push.friction;
        }
        friction
    }

    /// Adds what the second of two points does to the first. All but signs is the same for the
    /// other, so that momentum is kept.
    pub(crate) fn pushed(
        &self,
        mut sum: ContactPush,
        [p, q]: [usize; 2],
        contact: &PartedContact,
        dt: f64,
    ) -> ContactPush {
        let spacing = libm::cbrt(self.mean_volume);
        let mut reach = REACH * spacing;
        if let Some(bond) = self.bonds.find(p, q) {
            if self.left(bond) > 0.0 {
                return sum;
            }
            reach = reach.min(REACH * self.rest(p, bond));
        }
        let apart = self.places[p] - self.places[q];
        let distance = apart.norm();
        let depth = reach - distance;
        if depth <= 0.0 || distance == 0.0 {
            return sum;
        }
        let stiffness = STIFFNESS * self.law.bulk * spacing;
        let (n, push) = (apart / distance, stiffness * depth);
        let velocity = self.velocities[p] - self.velocities[q];
        let across = velocity - n * n.dot(&velocity);
        let speed = across.norm();
        sum.force += n * push;
        sum.held += 0.25 * stiffness * depth * depth;
        if speed > 0.0 && dt > 0.0 {
            let mass = 1.0 / (1.0 / self.mass(p) + 1.0 / self.mass(q));
            let drag = (contact.friction * push).min(MOST_SLOWED * mass * speed / dt);
            sum.force -= across * (drag / speed);
            sum.friction += 0.5 * drag * speed * dt;
        }
        sum
    }
}
