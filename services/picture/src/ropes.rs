//! Ropes: straight lines between where they are tied, of pieces that overlap where one is slack.

use super::track::{Actor, Mesh, Track};
use cullet_geometry::shapes::{Detail, cylinder};
use cullet_geometry::{Pose, Quat, Solid, Vec3};
use cullet_proto::recording::{BodyJoint, EventKind, JointType, Vector3};
use cullet_record::Recording;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pieces that a rope is drawn of.
const PIECES: u32 = 32;
/// How long a piece is over its share of the rope \[1\]: pieces of one that turns leave no gaps.
const OVERLAP: f64 = 1.1;
/// Radius over the length of the rope \[1\], and its bounds \[m\].
const SLIMNESS: f64 = 0.004;
const RADII: (f64, f64) = (5e-4, 0.03);
/// Corners around it.
const CORNERS: u32 = 8;
/// Most poses of pieces that are kept: of more, poses between are left out, and ropes lag.
const MOST_POSES: usize = 1 << 20;
/// Hemp.
const COLOUR: [f32; 3] = [0.45, 0.36, 0.24];

/// Where an end of a rope is tied: to the world, or to a body, in its own frame \[m\].
enum RopeEnd<'a> {
    World(Vec3),
    Body(&'a Actor, Vec3),
}

impl RopeEnd<'_> {
    fn at(&self, time: f64) -> Option<Vec3> {
        match self {
            Self::World(place) => Some(*place),
            Self::Body(actor, place) => {
                actor.at(time).map(|pose| pose.rotation * place + pose.translation.vector)
            }
        }
    }
}

impl Track {
    /// Ropes of a recording, as lines.
    pub(super) fn tie(&mut self, recording: &Recording, index: &BTreeMap<u64, usize>) {
        let is_rope = |joint: &&BodyJoint| joint.kind() == JointType::Rope && joint.length > 0.0;
        let ropes: Vec<&BodyJoint> = recording.joints.iter().filter(is_rope).collect();
        let stride = stride(ropes.len(), recording.poses.len());
        let times: Vec<f64> = recording.poses.iter().step_by(stride).map(|it| it.time).collect();
        let ends = ends(recording);
        let mut pieces = Vec::new();
        for joint in ropes {
            let end = ends.get(&joint.id).copied().unwrap_or(f64::INFINITY);
            let body = index.get(&joint.body).map(|&actor| &self.actors[actor]);
            let other = joint.other.map(|id| index.get(&id).map(|&actor| &self.actors[actor]));
            let first = body.and_then(|body| tied(Some(body), joint.point, joint.time));
            let second = match other {
                None => tied(None, joint.other_point, joint.time),
                Some(other) => other.and_then(|it| tied(Some(it), joint.other_point, joint.time)),
            };
            let (Some(first), Some(second)) = (first, second) else { continue };
            let ends = times.iter().filter(|time| (joint.time..end).contains(*time));
            let ends = ends.filter_map(|&time| Some((time, first.at(time)?, second.at(time)?)));
            let ends: Vec<(f64, Vec3, Vec3)> = ends.collect();
            pieces.extend(rope(joint.length, &ends, end));
        }
        self.lines.extend(pieces);
    }
}

/// One of so many recorded steps is kept, so that ropes take no more than [`MOST_POSES`].
fn stride(ropes: usize, steps: usize) -> usize {
    (ropes * PIECES as usize).saturating_mul(steps).div_ceil(MOST_POSES).max(1)
}

/// When joints broke or went \[s\].
fn ends(recording: &Recording) -> BTreeMap<u64, f64> {
    let over = |kind| matches!(kind, EventKind::JointBroken | EventKind::JointGone);
    let events = recording.events.iter().filter(|event| over(event.kind()));
    events.filter_map(|event| Some((event.joint?, event.time))).collect()
}

fn tied<'a>(actor: Option<&'a Actor>, at: Option<Vector3>, time: f64) -> Option<RopeEnd<'a>> {
    let at = at.map(|v| Vec3::new(v.x, v.y, v.z)).filter(|v| v.iter().all(|x| x.is_finite()))?;
    Some(match actor {
        None => RopeEnd::World(at),
        Some(actor) => {
            let pose = actor.at(time)?;
            RopeEnd::Body(actor, pose.rotation.inverse() * (at - pose.translation.vector))
        }
    })
}

/// The pieces of a rope of that length \[m\] whose ends are there at those times.
fn rope(length: f64, ends: &[(f64, Vec3, Vec3)], end: f64) -> Vec<Actor> {
    let radius = (SLIMNESS * length).clamp(RADII.0, RADII.1);
    let share = length / f64::from(PIECES);
    let made = cylinder(radius, OVERLAP * share, Detail { segments: CORNERS, edge: None });
    let Ok(mesh) = made else { return Vec::new() };
    let mesh = Arc::new(Mesh::of(&Solid::outer(mesh)));
    let piece = |k: u32| {
        let place = (f64::from(k) + 0.5) / f64::from(PIECES);
        let pose = |(time, from, to): &(f64, Vec3, Vec3)| {
            let way = to - from;
            let turn = Quat::rotation_between(&Vec3::z(), &way).unwrap_or_else(Quat::identity);
            (*time, Pose::from_parts((from + way * place).into(), turn))
        };
        Actor::line(mesh.clone(), COLOUR, ends.iter().map(pose).collect(), end)
    };
    (0..PIECES).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::{MOST_POSES, OVERLAP, PIECES, Vec3, rope, stride};

    /// From one end to the other, taut or slack, and gone at its end.
    #[test]
    fn a_rope_is_drawn_from_end_to_end() {
        let (top, side) = (Vec3::new(0.0, 0.0, 4.0), Vec3::new(0.0, 3.0, 4.0));
        let ends = [(0.0, Vec3::zeros(), top), (0.5, 2.0 * Vec3::y(), side)];
        let pieces = rope(4.0, &ends, 0.8);
        assert_eq!(pieces.len(), PIECES as usize);
        let half = 0.5 * OVERLAP * 4.0 / f64::from(PIECES);
        for (time, from, to) in ends {
            let way = (to - from).normalize();
            let reach = |k: usize, sign: f64| {
                let pose = pieces[k].at(time).expect("it is there");
                pose.translation.vector + pose.rotation * Vec3::z() * (sign * half)
            };
            let first = reach(0, -1.0);
            let last = reach(PIECES as usize - 1, 1.0);
            assert!((first - from).cross(&way).norm() < 1e-9, "{first}");
            assert!((first - from).dot(&way) <= 1e-9 && (last - to).dot(&way) >= -1e-9);
        }
        assert!(pieces[0].at(0.9).is_none(), "it broke");
    }

    /// A long run with many ropes takes no more memory than a short one with few.
    #[test]
    fn what_ropes_take_is_bounded() {
        assert_eq!((stride(0, 0), stride(1, 432), stride(10, 3000)), (1, 1, 1));
        for (ropes, steps) in [(10, 60_000), (10_000, 60_000), (10_000, 1)] {
            let stride = stride(ropes, steps);
            assert!(ropes * PIECES as usize * (steps / stride) <= MOST_POSES, "{stride}");
        }
    }
}
