//! Joints in the engine.

use super::Rigid;
use super::convert::{rotation, vector};
use crate::jointed::{JointLink, Jointed};
use cullet_geometry::{Quat, Vec3};
use rapier3d_f64::dynamics::JointAxesMask;
use rapier3d_f64::math::{Pose as EnginePose, Vector};
use rapier3d_f64::prelude::{
    GenericJoint, GenericJointBuilder, RigidBodyBuilder, RigidBodyHandle, RopeJoint,
};
use std::collections::BTreeMap;

/// Solver iterations of groups of joined bodies beside the world's: five bricks of steel that are
/// joined end to end give by 0.4 mm instead of 2.3 mm before they are taken as one.
const MORE_ITERATIONS: usize = 8;

impl Rigid {
    /// Joins two bodies; nothing happens where one of them is not there.
    pub(crate) fn join(&mut self, id: u32, joint: &Jointed) {
        let Some(a) = self.slots.get(&joint.a).map(|slot| slot.handle) else { return };
        let b = match joint.b {
            Some(b) => self.slots.get(&b).map(|slot| slot.handle),
            None => Some(self.ground()),
        };
        let Some(b) = b else { return };
        for handle in [a, b] {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.set_additional_solver_iterations(MORE_ITERATIONS);
            }
        }
        let handle = self.world.insert_impulse_joint(a, b, engine_joint(joint));
        let pair = joint.b.map(|b| (joint.a.min(b), joint.a.max(b))).filter(|_| !joint.collide);
        if let Some(pair) = pair {
            *self.suppressed.joined.entry(pair).or_insert(0) += 1;
        }
        self.joints.handles.insert(id, (handle, pair));
        for body in [Some(joint.a), joint.b].into_iter().flatten() {
            *self.joints.counts.entry(body).or_insert(0) += 1;
        }
        match joint.link {
            JointLink::Rope { .. } => self.joints.ropes.insert(id, (joint.a, joint.b)),
            _ => self.joints.ends.insert(id, (joint.a, joint.b)),
        };
        if joint.link == JointLink::Rigid {
            self.joints.welds.insert(id, (joint.a, joint.b));
        }
        self.joints.fused = None;
    }

    /// Takes a joint out, and wakes what it held.
    pub(crate) fn unjoin(&mut self, id: u32) {
        let Some((handle, pair)) = self.joints.handles.remove(&id) else { return };
        let ends = self.joints.ends.remove(&id).or(self.joints.ropes.remove(&id));
        if let Some((a, b)) = ends {
            [Some(a), b].into_iter().flatten().for_each(|body| self.count_less(body));
        }
        self.joints.welds.remove(&id);
        self.joints.fused = None;
        self.world.remove_impulse_joint(handle);
        let Some(pair) = pair else { return };
        if let Some(count) = self.suppressed.joined.get_mut(&pair) {
            *count -= 1;
            if *count == 0 {
                self.suppressed.joined.remove(&pair);
            }
        }
    }

    /// A body has one joint less; without any it is as it was before it had some.
    fn count_less(&mut self, body: u32) {
        let Some(count) = self.joints.counts.get_mut(&body) else { return };
        *count -= 1;
        if *count > 0 {
            return;
        }
        self.joints.counts.remove(&body);
        let handle = self.slots.get(&body).map(|slot| slot.handle);
        if let Some(body) = handle.and_then(|handle| self.world.bodies.get_mut(handle)) {
            body.set_additional_solver_iterations(0);
        }
    }

    /// Accelerations that bodies have over the next step beside gravity \[m/s²\]. One that has the
    /// same as in the step before is not woken.
    pub(crate) fn set_fields(&mut self, fields: &BTreeMap<u32, Vec3>, last: &BTreeMap<u32, Vec3>) {
        for id in last.keys().filter(|id| !fields.contains_key(id)) {
            if let Some(body) = self.slots.get(id).and_then(|s| self.world.bodies.get_mut(s.handle))
            {
                body.reset_forces(true);
            }
        }
        for (id, field) in fields {
            let wakes = last.get(id) != Some(field);
            if let Some(body) = self.slots.get(id).and_then(|s| self.world.bodies.get_mut(s.handle))
            {
                body.reset_forces(false);
                body.add_force(vector(field) * body.mass(), wakes);
            }
        }
    }

    /// Adds to the places where bodies end that met others those of all that are joined to them:
    /// a group that nothing else holds is set back as one, as far as the one of it that is set back
    /// farthest.
    pub(super) fn with_joined(
        &self,
        ends: Vec<(RigidBodyHandle, EnginePose)>,
    ) -> Vec<(RigidBodyHandle, EnginePose)> {
        if ends.is_empty() || self.joints.ends.is_empty() {
            return ends;
        }
        let moved = |(handle, pose): &(RigidBodyHandle, EnginePose)| {
            let body = self.world.bodies.get(*handle)?;
            Some((body.user_data as u32, pose.translation - body.position().translation))
        };
        let shifts: BTreeMap<u32, Vector> = ends.iter().filter_map(moved).collect();
        let mut all: BTreeMap<u32, (RigidBodyHandle, EnginePose)> =
            shifts.keys().copied().zip(ends).collect();
        for group in self.free_groups() {
            let own = group.iter().filter_map(|id| shifts.get(id).copied());
            let farthest =
                own.reduce(
                    |far, shift| {
                        if shift.length_squared() > far.length_squared() { shift } else { far }
                    },
                );
            let Some(shift) = farthest else { continue };
            for id in group {
                let Some(slot) = self.slots.get(&id) else { continue };
                let Some(body) = self.world.bodies.get(slot.handle) else { continue };
                let (place, turn) = (body.position().translation, body.position().rotation);
                all.insert(id, (slot.handle, EnginePose::from_parts(place + shift, turn)));
            }
        }
        all.into_values().collect()
    }

    /// Bodies that joints hold together, and that neither the world nor a body that nothing moves
    /// holds; ropes apart.
    fn free_groups(&self) -> Vec<Vec<u32>> {
        let mut root: BTreeMap<u32, u32> = BTreeMap::new();
        let find = |root: &mut BTreeMap<u32, u32>, id: u32| {
            let mut top = id;
            while let Some(&next) = root.get(&top).filter(|&&next| next != top) {
                top = next;
            }
            root.insert(id, top);
            top
        };
        let free = |id: u32| self.slots.get(&id).is_some_and(|s| !s.fixed && s.driven.is_none());
        let mut held = Vec::new();
        for &(a, b) in self.joints.ends.values() {
            match b.filter(|_| free(a)) {
                Some(b) if free(b) => {
                    let (x, y) = (find(&mut root, a), find(&mut root, b));
                    root.insert(x.max(y), x.min(y));
                }
                _ => held.extend([Some(a), b].into_iter().flatten().filter(|&id| free(id))),
            }
        }
        for id in &mut held {
            *id = find(&mut root, *id);
        }
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let ids: Vec<u32> = root.keys().copied().collect();
        for id in ids {
            let top = find(&mut root, id);
            if !held.contains(&top) {
                groups.entry(top).or_default().push(id);
            }
        }
        groups.into_values().collect()
    }

    /// The most substeps that a body may take in a step.
    pub(super) fn substeps(&self) -> usize {
        self.world.integration_parameters.num_solver_iterations + MORE_ITERATIONS
    }

    fn ground(&mut self) -> RigidBodyHandle {
        let ground = self.joints.ground;
        ground.unwrap_or_else(|| {
            let body = RigidBodyBuilder::fixed().user_data(u128::from(u32::MAX)).build();
            let ground = self.world.insert_body(body);
            self.joints.ground = Some(ground);
            ground
        })
    }
}

fn engine_joint(joint: &Jointed) -> GenericJoint {
    let frame = |end: &Vec3, turn: &Quat| EnginePose::from_parts(vector(end), rotation(turn));
    let [one, two] = &joint.ends;
    let (locked, own) = match joint.link {
        JointLink::Rope { length } => {
            let mut rope = RopeJoint::new(length);
            rope.set_local_anchor1(vector(one)).set_local_anchor2(vector(two));
            return rope.into();
        }
        JointLink::Rigid => (JointAxesMask::LOCKED_FIXED_AXES, Quat::identity()),
        JointLink::Ball => (JointAxesMask::LOCKED_SPHERICAL_AXES, Quat::identity()),
        JointLink::Hinge { axis } => (JointAxesMask::LOCKED_REVOLUTE_AXES, onto(&axis)),
    };
    GenericJointBuilder::new(locked)
        .local_frame1(frame(one, &own))
        .local_frame2(frame(two, &(joint.turn * own)))
        .build()
}

/// A turn of the x axis onto a unit vector.
fn onto(axis: &Vec3) -> Quat {
    let x = Vec3::x();
    // Half way between the two; where they are opposite, about y.
    let half = (x + axis).try_normalize(1e-6).unwrap_or_else(Vec3::z);
    let (w, v) =
        if (x + axis).norm() < 1e-6 { (0.0, Vec3::y()) } else { (x.dot(&half), x.cross(&half)) };
    Quat::new_normalize(nalgebra::Quaternion::new(w, v.x, v.y, v.z))
}
