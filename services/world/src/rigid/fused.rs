//! Bodies that rigid joints hold to each other move as one.
//!
//! The engine's joints give: a row of glued bricks sags, rings at some thirty hertz, and carries
//! nearly twice its weight when it is let go. So after each of its steps every group takes the
//! rigid motion with the momentum and the angular momentum that the engine left it, which is the
//! one nearest to its motion: energy is never made. A group that something holds which never moves
//! stays where it is, and one that a driven body holds goes with that; what this takes is the load
//! of the joints that hold it. A group that is held in two ways which disagree is left to the
//! engine.
//!
//! The engine's joints lose some angular momentum, too. A group that touches nothing turns as a
//! free rigid body does.

use super::Rigid;
use super::convert::{engine_pose, vec3, vector};
use super::engine_joints::{FusedGroup, Holder};
use crate::body::{invert, shifted};
use crate::motion::Motion;
use cullet_geometry::{Mat3, Pose, Quat, Vec3};
use rapier3d_f64::prelude::Collider;
use std::collections::{BTreeMap, BTreeSet};

/// One of a group: before the step, and where the engine has it.
struct Member {
    id: u32,
    mass: f64,
    inertia: Mat3,
    before: Motion,
    after: Motion,
}

/// A group that is still is left where the engine has it every so many steps: putting it in its
/// place would wake it.
const TRIAL_EVERY: u64 = 60;

/// A group in free flight turns in so many parts of a step.
const SUBSTEPS: u32 = 8;
/// Corrections of the turn of a group until it fits.
const TURNS: usize = 4;

impl Rigid {
    /// The groups that rigid joints make.
    fn fuse(&mut self) -> Vec<FusedGroup> {
        if let Some(groups) = self.joints.fused.take() {
            return groups;
        }
        let mut root: BTreeMap<u32, u32> = BTreeMap::new();
        let find = |root: &BTreeMap<u32, u32>, mut id: u32| {
            while let Some(&next) = root.get(&id).filter(|&&next| next != id) {
                id = next;
            }
            id
        };
        let holder = |id: Option<u32>| match id.and_then(|id| Some((id, self.slots.get(&id)?))) {
            Some((id, slot)) if slot.driven.is_some() => Holder::Driven(id),
            Some((_, slot)) if !slot.fixed => Holder::Nothing,
            _ => Holder::Still,
        };
        let mut held: Vec<(u32, Holder)> = Vec::new();
        for &(a, b) in self.joints.welds.values() {
            let ends = [Some(a), b];
            let free = ends.map(|end| end.filter(|_| holder(end) == Holder::Nothing));
            for id in free.into_iter().flatten() {
                root.entry(id).or_insert(id);
            }
            match free {
                [Some(a), Some(b)] => {
                    let (x, y) = (find(&root, a), find(&root, b));
                    root.insert(x.max(y), x.min(y));
                }
                [Some(a), None] => held.push((a, holder(b))),
                [None, Some(b)] => held.push((b, holder(Some(a)))),
                [None, None] => {}
            }
        }
        let mut groups: BTreeMap<u32, FusedGroup> = BTreeMap::new();
        for &id in root.keys() {
            let none = || FusedGroup { members: Vec::new(), holder: Holder::Nothing };
            groups.entry(find(&root, id)).or_insert_with(none).members.push(id);
        }
        for (id, holder) in held {
            if let Some(group) = groups.get_mut(&find(&root, id)) {
                group.holder = group.holder.and(holder);
            }
        }
        self.suppressed.fused = root.keys().map(|&id| (id, find(&root, id))).collect();
        groups.into_values().collect()
    }

    /// Finds out which bodies are one before the engine looks for contacts between them.
    pub(super) fn prepare_fused(&mut self) {
        if self.joints.fused.is_none() {
            let groups = self.fuse();
            self.joints.fused = Some(groups);
        }
    }

    /// Lets each group move as one.
    pub(super) fn move_as_one(&mut self) {
        let groups = self.fuse();
        if groups.is_empty() {
            self.joints.fused = Some(groups);
            return;
        }
        let touched = self.touched();
        for group in &groups {
            let members: Option<Vec<Member>> =
                group.members.iter().map(|&id| self.member(id)).collect();
            let Some(members) = members else { continue };
            if members.iter().all(|member| self.sleeping(member.id)) {
                continue;
            }
            let stays = self.tries_to_sleep()
                && members
                    .iter()
                    .all(|m| self.slots.get(&m.id).is_some_and(|slot| slot.rest.rests));
            match group.holder {
                Holder::Nothing => {
                    let flies = group.members.iter().all(|id| !touched.contains(id));
                    self.move_freely(&members, flies, stays);
                }
                Holder::Still => {
                    for Member { id, before, .. } in &members {
                        let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
                        let motion = Motion { pose: before.pose, velocity, spin };
                        self.set_motion(*id, &motion, stays);
                    }
                }
                Holder::Driven(driver) => self.move_with(&members, driver),
                Holder::Several => {}
            }
        }
        self.joints.fused = Some(groups);
    }

    fn tries_to_sleep(&self) -> bool {
        self.steps.is_multiple_of(TRIAL_EVERY)
    }

    fn member(&self, id: u32) -> Option<Member> {
        let slot = self.slots.get(&id)?;
        let (before, after) = (*self.before(id)?, self.motion(id)?);
        // What the engine has lost is not to be found here.
        let sound = after.finite();
        sound.then_some(Member { id, mass: slot.mass, inertia: slot.inertia, before, after })
    }

    /// Gives a body a motion; its place only unless it `stays`.
    fn set_motion(&mut self, id: u32, motion: &Motion, stays: bool) {
        let handle = self.slots.get(&id).map(|slot| slot.handle);
        if let Some(body) = handle.and_then(|handle| self.world.bodies.get_mut(handle)) {
            if !stays {
                body.set_position(engine_pose(&motion.pose), false);
            }
            body.set_linvel(vector(&motion.velocity), false);
            body.set_angvel(vector(&motion.spin), false);
        }
    }

    /// Bodies that something acts on beside gravity, fields and rigid joints.
    fn touched(&self) -> BTreeSet<u32> {
        let joints = self.joints.ends.iter().filter(|(id, _)| !self.joints.welds.contains_key(id));
        let ends = joints.chain(&self.joints.ropes).flat_map(|(_, &(a, b))| [Some(a), b]);
        let of = |collider| {
            let parent = self.world.colliders.get(collider).and_then(Collider::parent)?;
            Some(self.world.bodies.get(parent)?.user_data as u32)
        };
        let pairs = self.world.contact_pairs().filter(|pair| pair.has_any_active_contact());
        let contacts = pairs.flat_map(|pair| [of(pair.collider1), of(pair.collider2)]);
        let pushes = self.pushes.iter().flat_map(|push| [push.ids.0, push.ids.1]);
        let all = ends.chain(contacts).flatten().chain(pushes);
        all.chain(self.set_back.iter().copied()).collect()
    }

    /// The turn of a group about its centre over the step, and its angular momentum after it, when
    /// nothing acts on it but gravity and fields.
    fn free_turn(&self, members: &[Member], from: &Vec3) -> (Quat, Vec3) {
        let dt = self.world.integration_parameters.dt;
        let (mut inertia, mut angular) = (Mat3::zeros(), Vec3::zeros());
        for m in members {
            let arm = m.before.centre() - from;
            let own = world_inertia(&m.inertia, &m.before.pose.rotation);
            let body = self.slots.get(&m.id).and_then(|slot| self.world.bodies.get(slot.handle));
            let force = body.map_or_else(Vec3::zeros, |body| vec3(body.user_force()));
            angular += arm.cross(&(m.before.velocity * m.mass + force * dt)) + own * m.before.spin;
            inertia += shifted(&own, m.mass, &arm);
        }
        let inverse = invert(&inertia);
        let spin_at = |turn: &Quat| turn * (inverse * (turn.inverse() * angular));
        let mut turn = Quat::identity();
        let h = dt / f64::from(SUBSTEPS);
        for _ in 0..SUBSTEPS {
            let middle = turned(&(spin_at(&turn) * (h / 2.0))) * turn;
            turn = turned(&(spin_at(&middle) * h)) * turn;
        }
        (turn, angular)
    }

    fn move_with(&mut self, members: &[Member], driver: u32) {
        let (Some(&before), Some(after)) = (self.before(driver), self.motion(driver)) else {
            return;
        };
        let turn = after.pose.rotation * before.pose.rotation.inverse();
        let velocity_at =
            |place: &Vec3| before.velocity + before.spin.cross(&(place - after.centre()));
        for member in members {
            let place = after.centre() + turn * (member.before.centre() - before.centre());
            let pose = placed(&place, turn * member.before.pose.rotation);
            let motion = Motion { pose, velocity: velocity_at(&place), spin: before.spin };
            self.set_motion(member.id, &motion, false);
        }
    }

    fn move_freely(&mut self, members: &[Member], flies: bool, stays: bool) {
        let mass: f64 = members.iter().map(|m| m.mass).sum();
        let mean = |of: &dyn Fn(&Member) -> Vec3| {
            members.iter().map(|m| of(m) * m.mass).sum::<Vec3>() / mass
        };
        let (from, to) = (mean(&|m| m.before.centre()), mean(&|m| m.after.centre()));
        let (turn, angular) = if flies {
            self.free_turn(members, &from)
        } else {
            (turn_of(members, &from, &to), angular_momentum(members, &to))
        };
        let velocity = mean(&|m| m.after.velocity);
        let placed: Vec<Pose> = members
            .iter()
            .map(|m| {
                let place = to + turn * (m.before.centre() - from);
                placed(&place, turn * m.before.pose.rotation)
            })
            .collect();
        let arms = placed.iter().map(|pose| pose.translation.vector - to);
        let inertia: Mat3 = members
            .iter()
            .zip(&placed)
            .zip(arms)
            .map(|((m, pose), arm)| {
                shifted(&world_inertia(&m.inertia, &pose.rotation), m.mass, &arm)
            })
            .sum();
        let spin = invert(&inertia) * angular;
        for (member, pose) in members.iter().zip(placed) {
            let velocity = velocity + spin.cross(&(pose.translation.vector - to));
            self.set_motion(member.id, &Motion { pose, velocity, spin }, stays);
        }
    }
}

/// About a point, after the step \[N·m·s\].
fn angular_momentum(members: &[Member], about: &Vec3) -> Vec3 {
    let own = |m: &Member| {
        let turn = &m.after.pose.rotation;
        let arm = m.after.centre() - about;
        arm.cross(&m.after.velocity) * m.mass + world_inertia(&m.inertia, turn) * m.after.spin
    };
    members.iter().map(own).sum()
}

/// The turn about the common centre that is nearest to what the engine did with all, by mass and
/// inertia.
fn turn_of(members: &[Member], from: &Vec3, to: &Vec3) -> Quat {
    let mut turn = Quat::identity();
    let arm = |m: &Member, turn: &Quat| turn * (m.before.centre() - from);
    for _ in 0..TURNS {
        let (mut inertia, mut moment) = (Mat3::zeros(), Vec3::zeros());
        for m in members {
            let (arm, own) = (arm(m, &turn), world_inertia(&m.inertia, &m.after.pose.rotation));
            let rest = m.after.pose.rotation * (turn * m.before.pose.rotation).inverse();
            let sign = if rest.w < 0.0 { -2.0 } else { 2.0 };
            inertia += shifted(&own, m.mass, &arm);
            moment += arm.cross(&(m.after.centre() - to - arm)) * m.mass
                + own * Vec3::new(rest.i, rest.j, rest.k) * sign;
        }
        let more = invert(&inertia) * moment;
        // To first order; what that leaves is taken by the next.
        turn = turned(&more) * turn;
    }
    turn
}

/// A small turn about an axis, by its length \[rad\], good to the third order.
fn turned(by: &Vec3) -> Quat {
    let half = by / 2.0;
    let half = half * (1.0 + half.norm_squared() / 3.0);
    Quat::new_normalize(nalgebra::Quaternion::new(1.0, half.x, half.y, half.z))
}

fn world_inertia(inertia: &Mat3, turn: &Quat) -> Mat3 {
    let turn = turn.to_rotation_matrix();
    turn.matrix() * inertia * turn.matrix().transpose()
}

fn placed(place: &Vec3, turn: Quat) -> Pose {
    Pose::from_parts((*place).into(), Quat::new_normalize(turn.into_inner()))
}
