//! The path of a body over a step, and when the paths of two bodies bring them into contact.

use super::hulls::Part;
use super::seams::{HeldBalls, is_at_side};
use super::suppressed::SuppressedPairs;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d_f64::parry::query;
use rapier3d_f64::parry::query::sweep_toi::{Sweep, ToiProxy, sweep_time_of_impact};
use rapier3d_f64::prelude::{ColliderHandle, ContactPair, NarrowPhase, RigidBody, RigidBodyHandle};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// A part's core is the part shrunk to this share of its size \[1\].
const CORE: f64 = 0.75;
/// Whether two parts that touch go on to close is seen after this share of their size \[1\].
const LITTLE: f64 = 0.05;
/// Two parts that touch may sink into each other by this share of their size within a step \[1\].
const SLACK: f64 = 0.02;
/// Two bodies are swept over no greater an angle at once than this \[rad\].
const TURN: f64 = 0.5;

/// A body that turns farther than this in a step whirls \[rad\].
const WHIRL: f64 = 1.0;

/// What a body meets.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum SweptKind {
    /// Nothing moves it.
    Fixed,
    /// It moves along its path, and nothing moves it.
    Driven,
    /// Meets what is fixed alone.
    Tiny,
    /// Meets all but what is tiny.
    Moving,
}

/// A body and its path over a step.
pub(super) struct SweptBody<'a> {
    pub(super) id: u32,
    pub(super) handle: RigidBodyHandle,
    pub(super) kind: SweptKind,
    pub(super) body: &'a RigidBody,
    pub(super) parts: &'a [Part],
    /// The way against another over which the two must be looked at \[m\].
    least: f64,
    sweep: Sweep,
    /// Greatest distance of a corner from the centre \[m\].
    reach: f64,
    /// One over the mass; zero where nothing moves it [1/kg].
    pub(super) ease: f64,
    /// In the last step it did not follow its velocity, and has it still.
    pub(super) caught: bool,
    /// From which share of the step on it no longer follows its velocity, where it was then, and
    /// its way from there over a whole step.
    bent: Option<(f64, Pose, Vector)>,
    /// Box around what is left of its way \[m\].
    pub(super) span: Aabb,
}

impl<'a> SweptBody<'a> {
    /// The way of `body` from where it was before the step.
    pub(super) fn new(
        (id, handle, body): (u32, RigidBodyHandle, &'a RigidBody),
        parts: &'a [Part],
        (kind, least): (SweptKind, f64),
        before: &Pose,
    ) -> Self {
        let reach = parts.iter().map(|part| part.centre.length() + part.reach).fold(0.0, f64::max);
        let sweep = Sweep::from_poses(before, body.position(), Vector::ZERO);
        let held = matches!(kind, SweptKind::Fixed | SweptKind::Driven);
        let ease = if held { 0.0 } else { 1.0 / body.mass() };
        let (bent, span) = (None, Aabb::new_invalid());
        let caught = false;
        let mut swept =
            Self { id, handle, kind, body, parts, least, sweep, reach, ease, caught, bent, span };
        swept.span = match kind {
            // A floor is much larger than what may meet it, and lower.
            SweptKind::Fixed => parts.iter().fold(Aabb::new_invalid(), |span, part| {
                span.merged(&part.shape.compute_aabb(body.position()))
            }),
            SweptKind::Tiny | SweptKind::Moving | SweptKind::Driven => swept.span_from(0.0),
        };
        swept
    }

    /// Did it move so far that it may have passed through something?
    pub(super) fn far(&self) -> bool {
        (self.sweep.c2 - self.sweep.c1).length() + arc(&self.sweep, self.reach) > self.least
    }

    /// Where it is after a share of the step.
    pub(super) fn at(&self, share: f64) -> Pose {
        match &self.bent {
            None => self.sweep.transform_at(share),
            Some((since, from, way)) => {
                Pose::from_parts(from.translation + *way * (share - since), from.rotation)
            }
        }
    }

    /// Its way over a whole step, as it is going now \[m\].
    pub(super) fn along(&self) -> Vector {
        self.bent.as_ref().map_or(self.sweep.c2 - self.sweep.c1, |(_, _, way)| *way)
    }

    /// Where it ends, if that is not where its velocity took it.
    pub(super) fn end(&self) -> Option<Pose> {
        self.bent.is_some().then(|| self.at(1.0))
    }

    fn span_from(&self, share: f64) -> Aabb {
        let (from, to) = (self.at(share).translation, self.at(1.0).translation);
        Aabb::new(from.min(to) - self.reach, from.max(to) + self.reach)
    }

    /// From now on it goes this way, without turning.
    pub(super) fn bend(&mut self, share: f64, way: Vector) {
        self.bent = Some((share, self.at(share), way));
        self.span = self.span_from(share);
    }

    /// Can the two meet?
    fn meets(&self, other: &Self) -> bool {
        match (self.kind, other.kind) {
            (SweptKind::Fixed | SweptKind::Driven, SweptKind::Fixed | SweptKind::Driven)
            | (SweptKind::Tiny, SweptKind::Tiny | SweptKind::Moving) => false,
            (one, SweptKind::Tiny) => matches!(one, SweptKind::Fixed | SweptKind::Driven),
            _ => true,
        }
    }
}

/// Two parts of two bodies: places of the bodies in their crowd, and of the parts in the bodies.
pub(super) type Pair = (usize, usize, usize, usize);

/// That two bodies meet, and how.
#[derive(Clone, Copy)]
pub(super) struct SweepHit {
    /// Share of the step at which they do \[1\].
    pub(super) share: f64,
    /// Which of their parts.
    pub(super) parts: (usize, usize),
    /// Did the solver have the two in contact in this step?
    pub(super) held: bool,
    /// Do their cores meet, although it had?
    pub(super) core: bool,
}

/// What the sweeps of one step share.
pub(super) struct SweepContext<'a> {
    pub(super) suppressed: &'a SuppressedPairs,
    pub(super) touching: &'a NarrowPhase,
    /// What held balls before it.
    pub(super) balls: &'a HeldBalls,
    /// Distance at which bodies touch \[m\].
    pub(super) slop: f64,
    /// Of seams \[m\].
    pub(super) room: f64,
    /// \[s\]
    pub(super) step: f64,
}

impl SweepContext<'_> {
    /// Does a body turn so fast that the step does not show how it rolls?
    pub(super) fn whirls(&self, swept: &SweptBody<'_>) -> bool {
        swept.ease > 0.0 && swept.body.angvel().length() * self.step > WHIRL
    }

    pub(super) fn may_meet(&self, a: &SweptBody<'_>, b: &SweptBody<'_>) -> bool {
        a.span.loosened(self.slop).intersects(&b.span)
            && a.meets(b)
            && !self.suppressed.holds((a.id, b.id))
    }

    /// When two bodies touch, if they do after `from`, parts that have met in this step apart; of
    /// parts that the solver has in contact, and that both still follow their velocity, when their
    /// cores do.
    pub(super) fn meeting(
        &self,
        (i, a): (usize, &SweptBody<'_>),
        (j, b): (usize, &SweptBody<'_>),
        from: f64,
        met: &BTreeSet<Pair>,
    ) -> Option<SweepHit> {
        let rest = |swept: &SweptBody<'_>| {
            Sweep::from_poses(&swept.at(from), &swept.at(1.0), Vector::ZERO)
        };
        let (x, y) = (rest(a), rest(b));
        let way = (y.c2 - y.c1) - (x.c2 - x.c1);
        let between = y.c1 - x.c1;
        let along = -between.dot(way) / way.length_squared();
        let nearest = if along > 0.0 { between + way * along.min(1.0) } else { between };
        let whole = way.length() + arc(&x, a.reach) + arc(&y, b.reach);
        if whole <= a.least.min(b.least) || nearest.length() > a.reach + b.reach + self.slop {
            return None;
        }
        let free = a.bent.is_none() && b.bent.is_none();
        let (start_a, start_b) = (x.transform_at(0.0), y.transform_at(0.0));
        let mut first: Option<SweepHit> = None;
        for (k, (p, &collider_p)) in a.parts.iter().zip(a.body.colliders()).enumerate() {
            for (l, (q, &collider_q)) in b.parts.iter().zip(b.body.colliders()).enumerate() {
                let gap = (start_a * p.centre - start_b * q.centre).length() - p.reach - q.reach;
                let turned = arc(&x, p.centre.length()) + arc(&y, q.centre.length());
                if gap > self.slop + way.length() + turned || met.contains(&(i, j, k, l)) {
                    continue;
                }
                let held = self.held(collider_p, collider_q);
                let core = free && held;
                let most = first.map_or(1.0, |meeting| meeting.share);
                let at = self.touch([p, q], [&x, &y], most, core);
                // Those that touch already meet as well, unless they part.
                let meet = at < most && (at > 0.0 || closes([p, q], [&x, &y], whole));
                let poses = [x.transform_at(at), y.transform_at(at)];
                let colliders = [collider_p, collider_q];
                if meet && !self.is_seam(colliders, [p, q], [&poses[0], &poses[1]]) {
                    first = Some(SweepHit { share: at, parts: (k, l), held, core });
                }
            }
        }
        let late = |share: f64| from + share * (1.0 - from);
        first.map(|meeting| SweepHit { share: late(meeting.share), ..meeting })
    }

    /// Do two parts that touch there touch at a side or an edge past which one hardly reaches?
    fn is_seam(
        &self,
        colliders: [ColliderHandle; 2],
        [p, q]: [&Part; 2],
        [a, b]: [&Pose; 2],
    ) -> bool {
        let placed = [(p.shape.as_ref(), a), (q.shape.as_ref(), b)];
        facing([p, q], [a, b]).is_some_and(|(_, normal)| {
            is_at_side(placed, normal, self.room)
                || self.balls.is_at_edge(colliders, placed, normal, self.room)
        })
    }

    /// Does the solver have the two in contact?
    fn held(&self, one: ColliderHandle, two: ColliderHandle) -> bool {
        self.touching.contact_pair(one, two).is_some_and(ContactPair::has_any_active_contact)
    }

    /// Share of the sweeps, up to `most`, at which two parts or their cores touch; or `most`.
    fn touch(&self, [p, q]: [&Part; 2], sweeps: [&Sweep; 2], most: f64, cores: bool) -> f64 {
        if cores {
            let [p, q] = [core(p), core(q)];
            let cores = [&p, &q].map(|(points, round)| ToiProxy::from_points(points, *round));
            return touch(&cores, sweeps, most, self.slop);
        }
        match [p, q].map(|part| ToiProxy::from_shape(part.shape.as_ref())) {
            [Some(p), Some(q)] => touch(&[p, q], sweeps, most, self.slop),
            _ => most,
        }
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

/// By how much two parts may sink into each other within a step, so that those that slide are left
/// alone \[m\].
pub(super) fn slack(p: &Part, q: &Part) -> f64 {
    SLACK * p.reach.min(q.reach)
}

/// Would two parts that touch sink into each other on sweeps of this length, as they begin?
fn closes([p, q]: [&Part; 2], [x, y]: [&Sweep; 2], whole: f64) -> bool {
    let little = (LITTLE * p.reach.min(q.reach) / whole).min(1.0);
    let most = p.reach + q.reach;
    let gap = |share: f64| {
        let (a, b) = (x.transform_at(share), y.transform_at(share));
        let near = query::contact(&a, p.shape.as_ref(), &b, q.shape.as_ref(), most);
        near.ok().flatten().map_or(most, |contact| contact.dist)
    };
    (gap(0.0) - gap(little)) / little > slack(p, q)
}

/// Where two parts touch that are there, and the unit normal from the first to the second.
pub(super) fn facing([p, q]: [&Part; 2], [a, b]: [&Pose; 2]) -> Option<(Vector, Vector)> {
    let most = p.reach + q.reach;
    let near = query::contact(a, p.shape.as_ref(), b, q.shape.as_ref(), most).ok().flatten();
    let found = near.map(|contact| ((contact.point1 + contact.point2) * 0.5, contact.normal1));
    let sound = |(point, normal): &(Vector, Vector)| {
        point.is_finite() && (normal.length_squared() - 1.0).abs() < 1e-6
    };
    let (from, to) = (*a * p.centre, *b * q.centre);
    let middles = || Some(((from + to) * 0.5, (to - from).try_normalize()?));
    found.filter(sound).or_else(middles)
}

/// The corners of a part, shrunk towards its middle, and what is round about them; of a ball its
/// middle \[m\].
fn core(part: &Part) -> (Vec<Vector>, f64) {
    match part.shape.as_convex_polyhedron() {
        Some(hull) => {
            let shrunk = |&corner: &Vector| part.centre + CORE * (corner - part.centre);
            (hull.points().iter().map(shrunk).collect(), 0.0)
        }
        None => (vec![part.centre], CORE * part.reach),
    }
}

/// No less than the way of a place so far from the centre as the body turns \[m\].
fn arc(sweep: &Sweep, distance: f64) -> f64 {
    // The quaternions' distance is 2 sin(θ/4), the shorter way round.
    let [one, two] = [sweep.q1, sweep.q2];
    let chord = (one - two).length().min((one + two).length());
    PI * chord * distance
}
