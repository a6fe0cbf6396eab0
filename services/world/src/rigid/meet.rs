//! Bodies that meet each other within a step (F42).
//!
//! Two that would meet go on together from where they touch, with the velocity that their momentum
//! gives them and without turning, the first that meet first; who meets those joins them. Only
//! places are set back, not velocities: the next step finds the bodies in contact. Those that are
//! in contact are the solver's, which leaves a little of the speed at which they close: they meet
//! where that sinks their cores into each other ([`CORE`]). The engine's own sweeps are off: they
//! know one of two moving bodies, and no order.

use super::hulls::Part;
use super::quiet::Quiet;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d_f64::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d_f64::parry::query;
use rapier3d_f64::parry::query::sweep_toi::{Sweep, ToiProxy, sweep_time_of_impact};
use rapier3d_f64::prelude::{ColliderHandle, ContactPair, NarrowPhase, RigidBody, RigidBodyHandle};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// A part's core is the part shrunk to this share of its size \[1\].
const CORE: f64 = 0.75;
/// Whether two parts that touch go on to close is seen after this share of their size \[1\].
const LITTLE: f64 = 0.05;
/// Two bodies are swept over no greater an angle at once than this \[rad\].
const TURN: f64 = 0.5;
/// Of more that go on together the velocity stays when others join them: the work of a step grows
/// no faster than that of a crowd's pairs.
const FEW: usize = 16;

/// What a body meets.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Nothing moves it.
    Fixed,
    /// Meets what is fixed alone.
    Tiny,
    /// Meets all but what is tiny.
    Moving,
}

/// The way of a body over a step.
pub(super) struct Way<'a> {
    id: u32,
    handle: RigidBodyHandle,
    kind: Kind,
    parts: &'a [Part],
    colliders: &'a [ColliderHandle],
    /// The way against another over which the two must be looked at \[m\].
    least: f64,
    sweep: Sweep,
    /// Greatest distance of a corner from the centre \[m\].
    reach: f64,
    mass: f64,
    /// Since when and where it goes on with others, and its way from there over a whole step.
    joined: Option<(f64, Pose, Vector)>,
    /// Box around what is left of its way \[m\].
    span: Aabb,
}

impl<'a> Way<'a> {
    /// The way of `body` from where it was before the step.
    pub(super) fn new(
        (id, handle, body): (u32, RigidBodyHandle, &'a RigidBody),
        parts: &'a [Part],
        (kind, least): (Kind, f64),
        before: &Pose,
    ) -> Self {
        let reach = parts.iter().map(|part| part.centre.length() + part.reach).fold(0.0, f64::max);
        let sweep = Sweep::from_poses(before, body.position(), Vector::ZERO);
        let mass = if kind == Kind::Fixed { f64::INFINITY } else { body.mass() };
        let (colliders, joined, span) = (body.colliders(), None, Aabb::new_invalid());
        let mut way =
            Self { id, handle, kind, parts, colliders, least, sweep, reach, mass, joined, span };
        way.span = way.span_from(0.0);
        way
    }

    /// Did it move so far that it may have passed through something?
    pub(super) fn far(&self) -> bool {
        (self.sweep.c2 - self.sweep.c1).length() + arc(&self.sweep, self.reach) > self.least
    }

    /// Where it is after a share of the step.
    fn at(&self, share: f64) -> Pose {
        match &self.joined {
            None => self.sweep.transform_at(share),
            Some((since, from, way)) => {
                Pose::from_parts(from.translation + *way * (share - since), from.rotation)
            }
        }
    }

    /// Where it ends, if it has met others.
    fn end(&self) -> Option<Pose> {
        self.joined.is_some().then(|| self.at(1.0))
    }

    fn span_from(&self, share: f64) -> Aabb {
        let (from, to) = (self.at(share).translation, self.at(1.0).translation);
        Aabb::new(from.min(to) - self.reach, from.max(to) + self.reach)
    }

    fn join(&mut self, share: f64, way: Vector) {
        self.joined = Some((share, self.at(share), way));
        self.span = self.span_from(share);
    }

    /// Can the two meet?
    fn meets(&self, other: &Self) -> bool {
        match (self.kind, other.kind) {
            (Kind::Fixed, Kind::Fixed) | (Kind::Tiny, Kind::Tiny | Kind::Moving) => false,
            (one, Kind::Tiny) => one == Kind::Fixed,
            _ => true,
        }
    }
}

/// What stands around the ways.
pub(super) struct Scene<'a> {
    pub(super) quiet: &'a Quiet,
    pub(super) touching: &'a NarrowPhase,
    /// Distance at which bodies touch \[m\].
    pub(super) slop: f64,
    /// Distance from one that has met another at which the next joins them, so that the engine has
    /// the two contacts one after the other \[m\].
    pub(super) room: f64,
}

/// Those that go on together.
struct Group {
    members: Vec<usize>,
    /// The way of a whole step \[m\].
    way: Vector,
    mass: f64,
}

impl Group {
    /// The two together, and which of them go on with another velocity than before.
    fn with(mut self, mut other: Self) -> (Self, Vec<usize>) {
        let fixed = |group: &Self| group.mass.is_infinite();
        let many = self.members.len() + other.members.len() > FEW;
        let size = |group: &Self| (fixed(group), group.members.len());
        if size(&self) < size(&other) {
            std::mem::swap(&mut self, &mut other);
        }
        let mass = self.mass + other.mass;
        let mut turned = other.members.clone();
        let mut way = self.way;
        if !fixed(&self) && !many {
            way = (self.way * self.mass + other.way * other.mass) / mass;
            turned.extend(&self.members);
        }
        self.members.append(&mut other.members);
        (Self { members: self.members, way, mass }, turned)
    }
}

/// Bodies, in the order of their ids, that meet each other.
pub(super) struct Crowd<'a> {
    ways: Vec<Way<'a>>,
    /// Who goes on with whom.
    groups: BTreeMap<usize, Group>,
    group: Vec<usize>,
    /// Which two meet when: shares are not negative, so their bits are in their order.
    events: BTreeSet<Event>,
    of: Vec<Vec<Event>>,
    /// Of the spans of the ways.
    index: Bvh,
}

type Event = (u64, usize, usize);

impl<'a> Crowd<'a> {
    pub(super) fn new(ways: Vec<Way<'a>>) -> Self {
        let group = |(k, way): (usize, &Way<'_>)| {
            let along = way.sweep.c2 - way.sweep.c1;
            (k, Group { members: vec![k], way: along, mass: way.mass })
        };
        let groups = ways.iter().enumerate().map(group).collect();
        let (group, of) = ((0..ways.len()).collect(), vec![Vec::new(); ways.len()]);
        let (events, index) = (BTreeSet::new(), Bvh::new());
        Self { ways, groups, group, events, of, index }
    }

    /// Who met others, and where it ends.
    pub(super) fn go(mut self, scene: &Scene<'_>) -> Vec<(RigidBodyHandle, Pose)> {
        self.look(scene);
        while let Some((at, a, b)) = self.events.pop_first() {
            if self.group[a] != self.group[b] {
                self.join(f64::from_bits(at), a, b, scene);
            }
        }
        self.ways.iter().filter_map(|way| Some((way.handle, way.end()?))).collect()
    }

    /// Finds who would meet whom, at least one of them far, if none met another before.
    fn look(&mut self, scene: &Scene<'_>) {
        let far: Vec<bool> = self.ways.iter().map(Way::far).collect();
        if !far.contains(&true) {
            return;
        }
        let spans: Vec<Aabb> = self.ways.iter().map(|way| way.span).collect();
        self.index = Bvh::from_leaves(BvhBuildStrategy::Binned, &spans);
        for a in (0..self.ways.len()).filter(|&a| far[a]) {
            // Two that both are far are looked at once.
            for b in self.around(a, scene).into_iter().filter(|&b| b > a || !far[b]) {
                self.meet(a.min(b), a.max(b), 0.0, scene);
            }
        }
    }

    /// Who may be met on what is left of a way, and who is on it.
    fn around(&self, k: usize, scene: &Scene<'_>) -> Vec<usize> {
        let span = self.ways[k].span.loosened(scene.room);
        self.index.intersect_aabb(&span).map(|other| other as usize).collect()
    }

    /// Notes when the two meet, if they do after `from`.
    fn meet(&mut self, a: usize, b: usize, from: f64, scene: &Scene<'_>) {
        let (one, two) = (&self.ways[a], &self.ways[b]);
        if scene.may_meet(one, two)
            && let Some(share) = scene.meeting(one, two, from)
        {
            let event = (share.to_bits(), a, b);
            self.events.insert(event);
            self.of[a].push(event);
            self.of[b].push(event);
        }
    }

    /// The two that meet, and those that each goes on with, go on together.
    fn join(&mut self, share: f64, a: usize, b: usize, scene: &Scene<'_>) {
        let (one, two) = (self.group[a], self.group[b]);
        let (Some(x), Some(y)) = (self.groups.remove(&one), self.groups.remove(&two)) else {
            return;
        };
        let (group, mut turned) = x.with(y);
        turned.retain(|&k| self.ways[k].kind != Kind::Fixed);
        turned.sort_unstable();
        for &k in &group.members {
            self.group[k] = one;
        }
        for &k in &turned {
            self.ways[k].join(share, group.way);
            self.index.insert(self.ways[k].span, k as u32);
            for event in std::mem::take(&mut self.of[k]) {
                self.events.remove(&event);
            }
        }
        self.groups.insert(one, group);
        for &k in &turned {
            for other in self.around(k, scene) {
                if self.group[other] != one {
                    self.meet(k.min(other), k.max(other), share, scene);
                }
            }
        }
    }
}

impl Scene<'_> {
    fn may_meet(&self, a: &Way<'_>, b: &Way<'_>) -> bool {
        a.span.loosened(self.room).intersects(&b.span)
            && a.meets(b)
            && !self.quiet.pairs.contains_key(&(a.id, b.id))
    }

    /// Share of the step at which two bodies touch, if they do after `from` \[1\]; of parts that
    /// were in contact, and have met no others since, the share at which their cores do.
    fn meeting(&self, a: &Way<'_>, b: &Way<'_>, from: f64) -> Option<f64> {
        let joined = a.joined.is_some() || b.joined.is_some();
        let rest = |way: &Way<'_>| Sweep::from_poses(&way.at(from), &way.at(1.0), Vector::ZERO);
        let (x, y) = (rest(a), rest(b));
        let way = (y.c2 - y.c1) - (x.c2 - x.c1);
        let between = y.c1 - x.c1;
        let along = -between.dot(way) / way.length_squared();
        let nearest = if along > 0.0 { between + way * along.min(1.0) } else { between };
        let room = if joined { self.room } else { self.slop };
        let whole = way.length() + arc(&x, a.reach) + arc(&y, b.reach);
        if whole <= a.least.min(b.least) || nearest.length() > a.reach + b.reach + room {
            return None;
        }
        let (start_a, start_b) = (x.transform_at(0.0), y.transform_at(0.0));
        let mut first = 1.0;
        for (p, &collider_p) in a.parts.iter().zip(a.colliders) {
            for (q, &collider_q) in b.parts.iter().zip(b.colliders) {
                let gap = (start_a * p.centre - start_b * q.centre).length() - p.reach - q.reach;
                let turned = arc(&x, p.centre.length()) + arc(&y, q.centre.length());
                if gap > room + way.length() + turned {
                    continue;
                }
                let pair = self.touching.contact_pair(collider_p, collider_q);
                let held = !joined && pair.is_some_and(ContactPair::has_any_active_contact);
                let at = if held {
                    let [p, q] = [core(p), core(q)];
                    let cores = [&p, &q].map(|points| ToiProxy::from_points(points, 0.0));
                    touch(&cores, [&x, &y], first, self.slop)
                } else {
                    let of = [p, q].map(|part| ToiProxy::from_shape(part.shape.as_ref()));
                    let [Some(p), Some(q)] = of else { continue };
                    touch(&[p, q], [&x, &y], first, room)
                };
                // Those that touch already meet as well, unless they part.
                if at < first && (at > 0.0 || closes([p, q], [&x, &y], whole)) {
                    first = at;
                }
            }
        }
        (first < 1.0).then_some(from + first * (1.0 - from))
    }
}

/// Share of the sweeps up to `most` after which two shapes are within `room` of each other, or
/// `most`.
fn touch([p, q]: &[ToiProxy<'_>; 2], [x, y]: [&Sweep; 2], most: f64, room: f64) -> f64 {
    // Axes between the two turn with them: over too great an angle they part what has met.
    let pieces = ((arc(x, 1.0) + arc(y, 1.0)) / TURN).ceil().max(1.0);
    let mut from = 0.0;
    for k in 1..=pieces as u32 {
        let to = f64::from(k) / pieces;
        let [x, y] = [x, y].map(|sweep| {
            let ends = [from, to].map(|share| sweep.transform_at(share));
            Sweep::from_poses(&ends[0], &ends[1], Vector::ZERO)
        });
        let at = sweep_time_of_impact(p, &x, q, &y, 1.0, room).fraction;
        if at < 1.0 || to >= most {
            return (from + at * (to - from)).min(most);
        }
        from = to;
    }
    most
}

/// Do two parts that touch sink into each other at the beginning of ways of this length?
fn closes([p, q]: [&Part; 2], [x, y]: [&Sweep; 2], whole: f64) -> bool {
    let little = (LITTLE * p.reach.min(q.reach) / whole).min(1.0);
    let most = p.reach + q.reach;
    let gap = |share: f64| {
        let (a, b) = (x.transform_at(share), y.transform_at(share));
        let near = query::contact(&a, p.shape.as_ref(), &b, q.shape.as_ref(), most);
        near.ok().flatten().map_or(most, |contact| contact.dist)
    };
    gap(little) < gap(0.0)
}

/// The corners of a part, shrunk towards its middle.
fn core(part: &Part) -> Vec<Vector> {
    let corners = part.shape.as_convex_polyhedron().map_or(&[][..], |hull| hull.points());
    corners.iter().map(|&corner| part.centre + CORE * (corner - part.centre)).collect()
}

/// No less than the way of a place so far from the centre as the body turns \[m\].
fn arc(sweep: &Sweep, distance: f64) -> f64 {
    // The quaternions' distance is 2 sin(θ/4), the shorter way round.
    let [one, two] = [sweep.q1, sweep.q2];
    let chord = (one - two).length().min((one + two).length());
    PI * chord * distance
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
