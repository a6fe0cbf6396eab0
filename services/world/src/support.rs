//! What a body rests on when it is hit: what is under it holds it while the solver breaks it, and
//! what the engine let that do meanwhile is taken back.
//!
//! A support that can move keeps a share of what it gets as motion of its own, and passes the rest
//! on. The engine has already worked out how much that is, with everything behind it: the share is
//! read off its exchanges. What went on to the ground is taken back from the ground; where nothing
//! under the support is fixed, the support is taken to keep all of it.

use crate::body::Body;
use crate::exchange::Exchange;
use crate::id::BodyId;
use crate::impact::Hit;
use crate::motion::Motion;
use crate::rigid::Patch;
use crate::state::WorldState;
use cullet_geometry::Vec3;
use cullet_model::Support;
use std::collections::BTreeSet;

/// Where a body rests on another, and what the engine let that do.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldContact {
    /// The body that supports it.
    pub other: BodyId,
    /// The disc that holds the body, in its own frame. Its mobility is the velocity against the
    /// normal that an impulse spread over all discs of `other` gives it there, over that on this
    /// disc \[1/kg\].
    pub held: Support,
    /// Share of what `other` gets that it keeps as its own motion \[1\]; the rest goes to the
    /// ground.
    pub kept: f64,
    /// From the centre of `other` to the disc when it held, world frame \[m\].
    pub lever: Vec3,
    /// What the engine put into the body on behalf of `other` since the hit began, beside what it
    /// carries at rest; in the first support by that body, zero in the others.
    pub exchanged: Exchange,
    /// What it put into `other` on behalf of the body; likewise.
    pub exchanged_other: Exchange,
    /// Kinetic energy that this took out of both \[J\]; likewise.
    pub dissipated: f64,
}

/// A support, and the impulse that the solver says it gave along its normal \[N·s\].
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// The support that gave it.
    pub support: HeldContact,
    /// The impulse that it gave \[N·s\].
    pub impulse: f64,
}

/// Most discs of one patch.
const MOST_DISCS: usize = 16;
/// Least radius of a disc, as a share of the body's reach: a corner carries too.
const LEAST_RADIUS: f64 = 0.02;

/// [`crate::World::supports`].
pub(crate) fn find_supports(world: &WorldState, body: BodyId, hits: &[Hit]) -> Vec<HeldContact> {
    let (Some(own), Some(motion)) = (world.bodies.get(&body.0), world.rigid.before(body.0)) else {
        return Vec::new();
    };
    let began = hits.iter().map(|hit| hit.time).fold(f64::INFINITY, f64::min);
    let step = (began / world.settings.step).round().min(world.steps as f64) as u64;
    let back = motion.pose.inverse();
    let mut supports: Vec<HeldContact> = Vec::new();
    for patch in world.rigid.patches(body.0) {
        let other = BodyId(patch.other);
        let (Some(under), Some(its)) =
            (world.bodies.get(&patch.other), world.rigid.before(patch.other))
        else {
            continue;
        };
        let (Some(received), Some(received_other)) = (
            world.resting.since(body.0, patch.other, step),
            world.resting.since(patch.other, body.0, step),
        ) else {
            continue;
        };
        if hits.iter().any(|hit| hit.other == other) {
            continue;
        }
        let kept = kept_share(world, patch.other, body.0, &patch.normal, step);
        for (point, radius) in discs(&patch, LEAST_RADIUS * own.reach) {
            let known = supports.iter().any(|support| support.other == other);
            let share = if known { 0.0 } else { 1.0 };
            let held = Support {
                point: (back * nalgebra::Point3::from(point)).coords,
                normal: back.rotation * patch.normal,
                radius,
                mobility: kept * mobility(under, its, &point, &patch.normal),
            };
            supports.push(HeldContact {
                other,
                held,
                kept,
                lever: if under.immovable() { Vec3::zeros() } else { point - its.centre() },
                exchanged: received.exchange.scaled(share),
                exchanged_other: received_other.exchange.scaled(share),
                dissipated: (received.taken + received_other.taken) * share,
            });
        }
    }
    // Discs of one body yield together.
    let count = |other| supports.iter().filter(|s| s.other == other).count() as f64;
    let counts: Vec<f64> = supports.iter().map(|support| count(support.other)).collect();
    supports.iter_mut().zip(counts).for_each(|(support, count)| support.held.mobility *= count);
    supports
}

/// Share of what `support` got from `body` since `step`, against `normal`, that it did not pass
/// on to the ground \[1\].
fn kept_share(world: &WorldState, support: u32, body: u32, normal: &Vec3, step: u64) -> f64 {
    if world.bodies.get(&support).is_none_or(Body::immovable) {
        return 0.0;
    }
    let got = |from: u32| {
        let received = world.resting.since(support, from, step);
        received.map_or(0.0, |received| -received.exchange.linear.dot(normal))
    };
    let (own, whole) = (got(body), world.resting.partners(support).map(got).sum::<f64>());
    if own <= 0.0 || !is_grounded(world, support, body) {
        return 1.0;
    }
    (whole / own).clamp(0.0, 1.0)
}

/// Does a body rest on something fixed, directly or through others, but for `body`?
fn is_grounded(world: &WorldState, support: u32, body: u32) -> bool {
    let mut seen = BTreeSet::from([support, body]);
    let mut open = vec![support];
    while let Some(id) = open.pop() {
        for other in world.resting.partners(id) {
            if seen.insert(other) {
                if world.bodies.get(&other).is_some_and(Body::immovable) {
                    return true;
                }
                open.push(other);
            }
        }
    }
    false
}

/// Velocity along `normal` that a unit impulse along it gives a free body at a point \[1/kg\].
fn mobility(body: &Body, motion: &Motion, point: &Vec3, normal: &Vec3) -> f64 {
    if body.immovable() { 0.0 } else { body.mobility(motion, point, normal) }
}

/// Discs in a row along the longer side of the patch, as wide as its shorter one: middle and radius
/// \[m\].
fn discs(patch: &Patch, least: f64) -> Vec<(Vec3, f64)> {
    let points = &patch.points;
    let pairs = points.iter().flat_map(|a| points.iter().map(move |b| b - a));
    let longest = pairs.fold(Vec3::zeros(), |longest, d| {
        if d.norm_squared() > longest.norm_squared() { d } else { longest }
    });
    let level = longest - patch.normal * longest.dot(&patch.normal);
    let along = level.try_normalize(1e-9).unwrap_or_else(|| patch.normal.yzx());
    let across = patch.normal.cross(&along);
    let range = |axis: Vec3| {
        let values = points.iter().map(|p| p.dot(&axis));
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ((low, high), (near, far)) = (range(along), range(across));
    let half = ((far - near) / 2.0).max(least);
    let count = ((high - low) / (2.0 * half)).ceil().clamp(1.0, MOST_DISCS as f64);
    let step = (high - low) / count;
    let radius = (half * half + step * step / 4.0).sqrt();
    let height = points.iter().map(|p| p.dot(&patch.normal)).sum::<f64>() / points.len() as f64;
    let middle = patch.normal * height + across * ((near + far) / 2.0);
    (0..count as u32)
        .map(|k| (middle + along * (low + step * (f64::from(k) + 0.5)), radius))
        .collect()
}
