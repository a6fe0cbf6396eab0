//! What the contacts of the last step did to each pair of bodies.

use super::Patch;
use super::Rigid;
use super::ccd::Push;
use super::convert::vec3;
use super::suppressed::depth;
use crate::motion::Motion;
use cullet_geometry::Vec3;
use rapier3d_f64::prelude::{
    ColliderHandle, ContactManifold, ContactPair, RigidBody, SolverContact,
};
use std::collections::BTreeMap;

/// All contact points of one pair of bodies over one step, taken together (F39).
#[derive(Clone, Debug)]
pub(crate) struct Contact {
    /// Lower id of the pair.
    pub(crate) a: u32,
    /// Higher id.
    pub(crate) b: u32,
    /// Σ of the normal impulses' sizes \[N·s\].
    pub(crate) impulse: f64,
    /// Σ of the normal impulses on `b`; `a` got the opposite \[N·s\].
    pub(crate) on_b: Vec3,
    /// Torque impulse of the same on `a` about its centre \[N·m·s\].
    pub(crate) torque_a: Vec3,
    /// Torque impulse on `b` about its centre \[N·m·s\].
    pub(crate) torque_b: Vec3,
    /// Σ impulse · point \[N·s·m\].
    pub(crate) moment: Vec3,
    /// Σ impulse · closing speed before the step \[N·m\].
    pub(crate) closing: f64,
    /// Σ impulse · closing speed after the step \[N·m\].
    pub(crate) closing_after: f64,
    /// Friction on `b`, as the engine's last substep had it, over the whole step: an estimate
    /// \[N·s\].
    pub(crate) rub: Vec3,
    /// Impulse times the gap before the step.
    gap: f64,
}

impl Contact {
    fn new(a: u32, b: u32) -> Self {
        let zero = Vec3::zeros();
        Self {
            a,
            b,
            impulse: 0.0,
            on_b: zero,
            torque_a: zero,
            torque_b: zero,
            moment: zero,
            closing: 0.0,
            closing_after: 0.0,
            rub: zero,
            gap: 0.0,
        }
    }

    /// Takes in an impulse between two whose cores met in the step (F42).
    fn push(&mut self, push: &Push, one: &(Motion, Motion), two: &(Motion, Motion)) {
        let (arms, normal) = ((vec3(push.arms.0), vec3(push.arms.1)), vec3(push.normal));
        let on_b = normal * push.impulse;
        let closing = |a: &Motion, b: &Motion| {
            let at_a = a.velocity + a.spin.cross(&arms.0);
            (at_a - b.velocity - b.spin.cross(&arms.1)).dot(&normal)
        };
        self.impulse += push.impulse;
        self.on_b += on_b;
        self.torque_a -= arms.0.cross(&on_b);
        self.torque_b += arms.1.cross(&on_b);
        self.moment += vec3(push.point) * push.impulse;
        self.closing += push.impulse * closing(&one.0, &two.0);
        self.closing_after += push.impulse * closing(&one.1, &two.1);
    }

    /// Closing speed before the step \[m/s\].
    pub(crate) fn closing_speed(&self) -> f64 {
        self.closing / self.impulse
    }

    /// Gap between the surfaces before the step \[m\].
    pub(crate) fn gap(&self) -> f64 {
        (self.gap / self.impulse).max(0.0)
    }

    /// Closing speed after the step \[m/s\].
    pub(crate) fn closing_speed_after(&self) -> f64 {
        self.closing_after / self.impulse
    }
}

impl Rigid {
    /// Where a body touches others, a patch each normal, also where nothing pushes.
    pub(crate) fn patches(&self, id: u32) -> Vec<Patch> {
        let mut pairs: Vec<&ContactPair> =
            self.world.contact_pairs().filter(|pair| pair.has_any_active_contact()).collect();
        let key = |c: ColliderHandle| c.into_raw_parts();
        pairs.sort_unstable_by_key(|pair| (key(pair.collider1), key(pair.collider2)));
        let mut patches = Vec::new();
        for pair in pairs {
            let (Some(one), Some(two)) = (self.side(pair.collider1), self.side(pair.collider2))
            else {
                continue;
            };
            if (one.id == id) == (two.id == id) {
                continue;
            }
            for manifold in pair.solver_manifolds() {
                let normal = vec3(manifold.data.normal);
                let contacts = manifold.data.solver_contacts.iter();
                let points: Vec<Vec3> =
                    contacts.map(|contact| world_point(contact, manifold, &one, &two)).collect();
                if points.is_empty() {
                    continue;
                }
                let (other, normal) =
                    if one.id == id { (two.id, -normal) } else { (one.id, normal) };
                patches.push(Patch { other, points, normal });
            }
        }
        patches
    }
}

/// A body on one side of a contact, before and after the step.
struct Side {
    id: u32,
    before: Motion,
    after: Motion,
}

impl Rigid {
    /// What the last step's contacts did, in the order of the pairs' ids.
    pub(crate) fn contacts(&self) -> Vec<Contact> {
        let substeps = self.substeps() as f64;
        let mut pairs: Vec<&ContactPair> =
            self.world.contact_pairs().filter(|pair| pair.has_any_active_contact()).collect();
        let key = |c: ColliderHandle| c.into_raw_parts();
        pairs.sort_unstable_by_key(|pair| (key(pair.collider1), key(pair.collider2)));
        let mut sums: BTreeMap<(u32, u32), Contact> = BTreeMap::new();
        for pair in pairs {
            let (Some(one), Some(two)) = (self.side(pair.collider1), self.side(pair.collider2))
            else {
                continue;
            };
            if one.id == two.id {
                continue;
            }
            let ids = (one.id.min(two.id), one.id.max(two.id));
            let sum = sums.entry(ids).or_insert_with(|| Contact::new(ids.0, ids.1));
            for manifold in pair.solver_manifolds() {
                add(sum, manifold, &one, &two);
                add_friction(sum, manifold, one.id > two.id, substeps);
            }
        }
        for push in &self.pushes {
            let (a, b) = push.ids;
            let sides = [a, b].map(|id| Some((*self.before(id)?, self.motion(id)?)));
            if let [Some(one), Some(two)] = sides {
                sums.entry((a, b)).or_insert_with(|| Contact::new(a, b)).push(push, &one, &two);
            }
        }
        sums.into_values().filter(|sum| sum.impulse > 0.0).collect()
    }

    /// The body of a collider; none where it sleeps (its contacts are then those of long ago).
    /// Bodies that overlap where they are, and how deep \[m\]; at least one of each pair can move.
    pub(crate) fn overlaps(&self) -> Vec<(u32, u32, f64)> {
        let fixed = |id: &u32| self.slots.get(id).is_none_or(|s| s.fixed || s.driven.is_some());
        let mut found = Vec::new();
        for &a in self.slots.keys() {
            let near = |b: &u32| *b > a && !(fixed(&a) && fixed(b)) && self.near(a, *b);
            for b in self.slots.keys().copied().filter(near) {
                if let (Some(pa), Some(pb)) = (self.placed(a), self.placed(b)) {
                    let overlap = depth(&pa, &pb);
                    found.extend((overlap > 0.0).then_some((a, b, overlap)));
                }
            }
        }
        found
    }

    /// Bodies that touch one, and how deep \[m\].
    pub(crate) fn depths(&self, id: u32) -> Vec<(u32, f64)> {
        let handle = self.slots.get(&id).map(|slot| slot.handle);
        let colliders = handle.and_then(|handle| self.world.bodies.get(handle));
        let colliders = colliders.map_or(&[][..], RigidBody::colliders);
        let mut depths: BTreeMap<u32, f64> = BTreeMap::new();
        for &collider in colliders {
            for pair in self.world.narrow_phase.contact_pairs_with(collider) {
                let other =
                    if pair.collider1 == collider { pair.collider2 } else { pair.collider1 };
                let Some(other) = self.side(other) else { continue };
                for manifold in pair.solver_manifolds() {
                    if manifold.data.solver_contacts.is_empty() {
                        continue;
                    }
                    let deepest = manifold.points.iter().map(|point| -point.dist);
                    let depth = depths.entry(other.id).or_default();
                    *depth = deepest.fold(*depth, f64::max);
                }
            }
        }
        depths.into_iter().collect()
    }

    fn side(&self, collider: ColliderHandle) -> Option<Side> {
        let parent = self.world.colliders.get(collider)?.parent()?;
        let body = self.world.bodies.get(parent)?;
        if body.is_dynamic() && body.is_sleeping() {
            return None;
        }
        let id = body.user_data as u32;
        Some(Side { id, before: *self.before(id)?, after: self.read(parent)? })
    }
}

fn add(sum: &mut Contact, manifold: &ContactManifold, one: &Side, two: &Side) {
    // Points from the first body to the second.
    let normal = vec3(manifold.data.normal);
    for contact in &manifold.data.solver_contacts {
        let index = contact.contact_indices()[0] as usize;
        let Some(impulse) = manifold.points.get(index).map(|point| point.data.impulse) else {
            continue;
        };
        if impulse <= 0.0 {
            continue;
        }
        let point = world_point(contact, manifold, one, two);
        let push = normal * impulse;
        let (a, b, on_b) = if one.id < two.id { (one, two, push) } else { (two, one, -push) };
        let closing =
            |x: &Motion, y: &Motion| (x.velocity_at(&point) - y.velocity_at(&point)).dot(&normal);
        sum.impulse += impulse;
        sum.on_b += on_b;
        sum.torque_a -= (point - a.before.centre()).cross(&on_b);
        sum.torque_b += (point - b.before.centre()).cross(&on_b);
        sum.moment += point * impulse;
        sum.gap += impulse * contact.dist;
        sum.closing += impulse * closing(&one.before, &two.before);
        sum.closing_after += impulse * closing(&one.after, &two.after);
    }
}

/// Adds what a manifold's friction did on the second of the pair, or on the first if `swapped`.
///
/// The engine has one friction a manifold, notes it at each point, and only that of its last
/// substep; the normal impulses of the step over those of that substep stand for how many there
/// were.
fn add_friction(sum: &mut Contact, manifold: &ContactManifold, swapped: bool, most: f64) {
    let active = manifold.data.solver_contacts.iter().filter_map(|contact| {
        manifold.points.get(contact.contact_indices()[0] as usize).map(|point| &point.data)
    });
    let (mut whole, mut last, mut friction) = (0.0, 0.0, None);
    for data in active {
        whole += data.impulse;
        last += data.warmstart_impulse;
        friction.get_or_insert(vec3(data.warmstart_tangent_world));
    }
    let Some(on_first) = friction.filter(|_| whole > 0.0) else { return };
    let times = if last > 0.0 { (whole / last).min(most) } else { 1.0 };
    sum.rub += on_first * if swapped { times } else { -times };
}

/// The middle between the two surfaces at a contact, where the bodies were before the step \[m\].
fn world_point(
    contact: &SolverContact,
    manifold: &ContactManifold,
    one: &Side,
    two: &Side,
) -> Vec3 {
    let place = |anchor: Vec3, side: &Side, fixed: bool| {
        if fixed { anchor } else { side.before.centre() + side.before.pose.rotation * anchor }
    };
    let dominance = manifold.data.relative_dominance;
    let first = place(vec3(contact.anchor1), one, dominance > 0);
    let second = place(vec3(contact.anchor2), two, dominance < 0);
    (first + second) / 2.0
}
