//! Bodies that meet each other within a step (F42).
//!
//! The engine sees contacts where a step begins. Afterwards all bodies are swept from where they
//! were to where they are, the first meeting first. Two that the engine does not have in contact
//! go on together from where they meet, with the velocity that their momentum gives them: only
//! places change, so the next step begins with the two in contact, and the engine takes the whole
//! closing speed as one hit. Two that the engine has in contact lose what closes along their normal
//! and nothing else: the rest of their ways, and the ways of all others, go on. So a body that lies
//! on the ground and is pushed along it slides, and what pushes it is not stopped by the ground.
//! Nobody turns on after a meeting.
//!
//! As long as bodies in contact follow their velocities they are the solver's, which leaves a
//! little of the speed at which they close: they meet where that sinks their cores into each other.
//! These lose what closes from their velocities, too: nothing else would ever take it out, and a
//! body whose place is held while its velocity runs on hangs in the air. That impulse counts with
//! those of the contact. Of bodies that turn farther in a step than it can show, what closes
//! between the middles is taken out likewise.
//!
//! It may be that the engine never gets a contact: another body pushes one that has met the ground
//! farther from it than the engine looks, and a step later it is there again, as fast. So a body
//! that did not follow its velocity over the last step, and has it still, is caught: all that it
//! meets takes out of both velocities what closes where they touch and between the middles.
//!
//! The engine's own sweeps are off: they know one of two moving bodies, and no order.

use super::relax::{Touch, Touches};
use super::sweep::{Pair, SweepContext, SweepHit, SweptBody, facing, slack};
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d_f64::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d_f64::prelude::{RigidBody, RigidBodyHandle};
use std::collections::{BTreeMap, BTreeSet};

/// An impulse between two bodies whose cores met.
pub(super) struct Push {
    /// Their ids.
    pub(super) ids: (u32, u32),
    /// Where they touch \[m\].
    pub(super) point: Vector,
    /// From the centre of each to there \[m\].
    pub(super) arms: (Vector, Vector),
    /// Unit, from the first to the second.
    pub(super) normal: Vector,
    /// \[N·s\]
    pub(super) impulse: f64,
}

/// What became of a crowd.
#[derive(Default)]
pub(super) struct Met {
    /// Where those end that met others.
    pub(super) ends: Vec<(RigidBodyHandle, Pose)>,
    /// Velocities and spins that have changed.
    pub(super) motions: Vec<(RigidBodyHandle, Vector, Vector)>,
    pub(super) pushes: Vec<Push>,
}

/// Continuous collision detection over one step; bodies in the order of their ids.
pub(super) struct CcdSolver<'a> {
    bodies: Vec<SweptBody<'a>>,
    touches: Touches,
    /// Parts that have met.
    met: BTreeSet<Pair>,
    /// Which two meet when, and how: shares are not negative, so their bits are in their order.
    events: BTreeMap<Event, SweepHit>,
    of: Vec<Vec<Event>>,
    /// Bounding volumes of the spans.
    index: Bvh,
    /// Velocities and spins that have changed.
    motions: BTreeMap<usize, (Vector, Vector)>,
    pushes: Vec<Push>,
}

type Event = (u64, usize, usize);

impl<'a> CcdSolver<'a> {
    pub(super) fn new(bodies: Vec<SweptBody<'a>>) -> Self {
        let of = vec![Vec::new(); bodies.len()];
        Self {
            touches: Touches::new(bodies.len()),
            bodies,
            met: BTreeSet::new(),
            events: BTreeMap::new(),
            of,
            index: Bvh::new(),
            motions: BTreeMap::new(),
            pushes: Vec::new(),
        }
    }

    /// Handles all meetings, the first in time first.
    pub(super) fn solve(mut self, context: &SweepContext<'_>) -> Met {
        self.find_pairs(context);
        while let Some(((_, a, b), meeting)) = self.events.pop_first() {
            self.join(a, b, meeting, context);
        }
        let motions = self.motions.iter().map(|(&k, &(v, w))| (self.bodies[k].handle, v, w));
        Met {
            ends: self.bodies.iter().filter_map(|body| Some((body.handle, body.end()?))).collect(),
            motions: motions.collect(),
            pushes: self.pushes,
        }
    }

    /// Finds the pairs that would meet, at least one of them far, if none met another before.
    fn find_pairs(&mut self, context: &SweepContext<'_>) {
        let far: Vec<bool> = self.bodies.iter().map(SweptBody::far).collect();
        if !far.contains(&true) {
            return;
        }
        let spans: Vec<Aabb> = self.bodies.iter().map(|body| body.span).collect();
        self.index = Bvh::from_leaves(BvhBuildStrategy::Binned, &spans);
        for a in (0..self.bodies.len()).filter(|&a| far[a]) {
            // Two that both are far are looked at once.
            for b in self.around(a, context).into_iter().filter(|&b| b > a || !far[b]) {
                self.meet(a.min(b), a.max(b), 0.0, context);
            }
        }
    }

    /// Who may be met on what is left of a way, and who is on it.
    fn around(&self, k: usize, context: &SweepContext<'_>) -> Vec<usize> {
        let span = self.bodies[k].span.loosened(context.slop);
        self.index.intersect_aabb(&span).map(|other| other as usize).collect()
    }

    /// Notes when the two meet, if they do after `from`.
    fn meet(&mut self, a: usize, b: usize, from: f64, context: &SweepContext<'_>) {
        let (one, two) = (&self.bodies[a], &self.bodies[b]);
        if context.may_meet(one, two)
            && let Some(meeting) = context.meeting((a, one), (b, two), from, &self.met)
        {
            let event = (meeting.share.to_bits(), a, b);
            self.events.insert(event, meeting);
            self.of[a].push(event);
            self.of[b].push(event);
        }
    }

    /// Two meet: they and those that they are pushed against go other ways from there.
    fn join(&mut self, a: usize, b: usize, meeting: SweepHit, context: &SweepContext<'_>) {
        let SweepHit { share, parts: (p, q), held, core } = meeting;
        self.met.insert((a, b, p, q));
        let (one, two) = (&self.bodies[a], &self.bodies[b]);
        let (p, q) = (&one.parts[p], &two.parts[q]);
        let poses = [one.at(share), two.at(share)];
        let Some((point, normal)) = facing([p, q], [&poses[0], &poses[1]]) else {
            return;
        };
        // The engine had its chance to take out what closes.
        let caught = one.caught || two.caught;
        let touch = Touch { a, b, normal, together: !held && !caught, slack: slack(p, q) };
        if core || caught {
            let arms = (point - poses[0].translation, point - poses[1].translation);
            self.push((a, b), point, arms, normal);
        }
        // Who whirls may seem to roll along what is in its way: where they touch nothing closes,
        // but the middle runs into it.
        let whirl = [a, b].into_iter().any(|k| context.whirls(&self.bodies[k]));
        if whirl || caught {
            self.push((a, b), point, (Vector::ZERO, Vector::ZERO), normal);
        }
        let turned = self.touches.meet(touch, &self.bodies, share);
        for (&k, &way) in &turned {
            self.bodies[k].bend(share, way);
            self.index.insert(self.bodies[k].span, k as u32);
            for event in std::mem::take(&mut self.of[k]) {
                self.events.remove(&event);
            }
        }
        for &k in turned.keys() {
            for other in self.around(k, context) {
                if other > k || !turned.contains_key(&other) {
                    self.meet(k.min(other), k.max(other), share, context);
                }
            }
        }
    }

    /// Takes out of the velocities of two bodies what closes where they touch, as an impulse that
    /// leaves them no faster than they were.
    fn push(
        &mut self,
        (a, b): (usize, usize),
        point: Vector,
        arms: (Vector, Vector),
        normal: Vector,
    ) {
        let (one, two) = (&self.bodies[a], &self.bodies[b]);
        let of = |k: usize, swept: &SweptBody<'_>| {
            let own = (swept.body.linvel(), swept.body.angvel());
            self.motions.get(&k).copied().unwrap_or(own)
        };
        let ((v, spin_v), (w, spin_w)) = (of(a, one), of(b, two));
        let closing = (v + spin_v.cross(arms.0) - w - spin_w.cross(arms.1)).dot(normal);
        let turns =
            [(one, arms.0), (two, arms.1)].map(|(swept, arm)| turn(swept, arm.cross(normal)));
        let give = |arm: Vector, turn: Vector| turn.cross(arm).dot(normal);
        let eased = one.ease + two.ease + give(arms.0, turns[0]) + give(arms.1, turns[1]);
        let impulse = closing / eased;
        if closing <= 0.0 || !impulse.is_finite() {
            return;
        }
        let ids = (one.id, two.id);
        let after = [
            (a, (v - normal * (impulse * one.ease), spin_v - turns[0] * impulse)),
            (b, (w + normal * (impulse * two.ease), spin_w + turns[1] * impulse)),
        ];
        let free = after.into_iter().filter(|&(k, _)| self.bodies[k].ease > 0.0);
        self.motions.extend(free.collect::<Vec<_>>());
        self.pushes.push(Push { ids, point, arms, normal, impulse });
    }
}

/// The spin that a torque impulse gives a body.
fn turn(swept: &SweptBody<'_>, torque: Vector) -> Vector {
    if swept.ease == 0.0 {
        return Vector::ZERO;
    }
    let local = swept.body.mass_properties().local_mprops;
    local.world_inv_inertia(&swept.body.position().rotation) * torque
}

/// Sets a body back. Its velocity stays; its spin is the one with the same angular momentum there.
pub(super) fn set_back(body: &mut RigidBody, pose: Pose) {
    let local = body.mass_properties().local_mprops;
    let (inertia, inverse) = (local.principal_inertia(), local.inv_principal_inertia);
    let frame = |pose: &Pose| pose.rotation * local.principal_inertia_local_frame;
    let (then, now) = (frame(body.position()), frame(&pose));
    let angular = then * (inertia * (then.inverse() * body.angvel()));
    let spin = now * (inverse * (now.inverse() * angular));
    body.set_position(pose, false);
    body.set_angvel(spin, false);
}
