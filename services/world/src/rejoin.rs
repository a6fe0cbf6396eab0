//! The joints of a body that breaks go over to its fragments.

use crate::body::Body;
use crate::curvature::nearest;
use crate::glue::{GlueLimit, glued};
use crate::joint::{JointLimit, JointLimits};
use crate::jointed::Jointed;
use crate::joints::put;
use crate::state::WorldState;
use cullet_geometry::inside::Inside;
use cullet_geometry::{Pose, Vec3};

/// How many joints of a broken body its fragments got, and how many nothing holds any more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rejoined {
    pub(crate) kept: usize,
    pub(crate) lost: usize,
}

/// Gives joints that held a body to its fragments, which lie at `offsets` in its frame \[m\]: those
/// of glue to all that share the old face, with limits by their share of its area; others to the
/// fragment that has the anchor in it, or is nearest to it. What glue held to the world or a body
/// that is gone is lost.
pub(crate) fn rejoin(
    world: &mut WorldState,
    held: Vec<Jointed>,
    body: u32,
    fragments: &[(u32, Vec3)],
) -> Rejoined {
    let mut count = Rejoined::default();
    for joint in held {
        let new = match joint.face.normal {
            Some(_) => glue_again(world, &joint, body, fragments),
            None => hold_again(world, &joint, body, fragments).into_iter().collect(),
        };
        if new.is_empty() {
            count.lost += 1;
        }
        count.kept += new.len();
        for joint in new {
            put(world, joint);
        }
    }
    count
}

/// Glue between the fragments and the other body, as the two were joined.
fn glue_again(
    world: &WorldState,
    joint: &Jointed,
    body: u32,
    fragments: &[(u32, Vec3)],
) -> Vec<Jointed> {
    let Some(other) = (if joint.a == body { joint.b } else { Some(joint.a) }) else {
        return Vec::new();
    };
    let Some(its) = world.bodies.get(&other) else { return Vec::new() };
    // From the frame of `b` to that of `a`.
    let back = joint.turn.inverse();
    let place = Pose::from_parts((joint.ends[0] - back * joint.ends[1]).into(), back);
    let limit = match joint.limit {
        JointLimit::Stress { tensile, shear } => GlueLimit::Stress { tensile, shear },
        JointLimit::Whole(limits) | JointLimit::Pull(limits) => {
            GlueLimit::EachPair { force: limits.force, torque: limits.torque }
        }
    };
    let again = |&(id, offset): &(u32, Vec3)| {
        let fragment = world.bodies.get(&id)?;
        let mut new = if joint.a == body {
            let place = Pose::from_parts((place.translation.vector - offset).into(), back);
            glued((id, fragment), (other, its), &place, limit, joint.gap)?
        } else {
            let shift = place.translation.vector + back * offset;
            let place = Pose::from_parts(shift.into(), back);
            glued((other, its), (id, fragment), &place, limit, joint.gap)?
        };
        new.limit = scaled(new.limit, new.face.area / joint.face.area);
        Some(new)
    };
    fragments.iter().filter_map(again).collect()
}

/// A limit of a share of the area.
fn scaled(limit: JointLimit, share: f64) -> JointLimit {
    match limit {
        JointLimit::Stress { .. } => limit,
        JointLimit::Whole(limits) | JointLimit::Pull(limits) => {
            let less = |value: Option<f64>| value.map(|value| value * share);
            let limits = JointLimits { force: less(limits.force), torque: less(limits.torque) };
            JointLimit::Pull(limits)
        }
    }
}

/// The joint on the fragment that it holds.
fn hold_again(
    world: &WorldState,
    joint: &Jointed,
    body: u32,
    fragments: &[(u32, Vec3)],
) -> Option<Jointed> {
    let side = usize::from(joint.a != body);
    let anchor = joint.ends[side];
    let distance = |fragment: &Body, offset: &Vec3| {
        let point = anchor - offset;
        let mesh = &fragment.solid.mesh;
        if Inside::new(mesh).contains(point) { 0.0 } else { (nearest(mesh, &point) - point).norm() }
    };
    let far =
        |&(id, offset): &(u32, Vec3)| Some((distance(world.bodies.get(&id)?, &offset), id, offset));
    let holds = fragments.iter().filter_map(far).min_by(|x, y| x.0.total_cmp(&y.0))?;
    let mut new = joint.clone();
    new.ends[side] = anchor - holds.2;
    if side == 0 {
        new.a = holds.1;
    } else {
        new.b = Some(holds.1);
    }
    Some(new)
}
