//! The joints of a world: made, looked at, dropped. What they carry is in `loads.rs`.

use crate::body::Body;
use crate::id::BodyId;
use crate::joint::{JointError, JointId, JointKind, JointLimit, JointLoad, JointSpec, JointView};
use crate::jointed::{CarryingFace, JointLink, Jointed, points};
use crate::motion::Motion;
use crate::state::WorldState;
use cullet_geometry::{Pose, Vec3};

/// Greatest force, torque, length and area \[SI\] that a joint may be given.
const MOST: f64 = 1e30;
/// Without an area a joint is a square of this share of the smaller body's extent \[1\].
const SIDE: f64 = 0.1;

/// [`crate::World::join`].
pub(crate) fn join(world: &mut WorldState, spec: &JointSpec) -> Result<JointId, JointError> {
    let made = made(world, spec)?;
    Ok(JointId(put(world, made)))
}

fn made(world: &WorldState, spec: &JointSpec) -> Result<Jointed, JointError> {
    let (one, motion) = known(world, spec.a)?;
    let other = spec.b.map(|b| known(world, b)).transpose()?;
    check(one, other.as_ref().map(|(body, _)| *body), spec)?;
    let pose_b = other.as_ref().map_or_else(Pose::identity, |(_, motion)| motion.pose);
    let reach = other.as_ref().map_or(one.reach, |(body, _)| body.reach.min(one.reach));
    let side = SIDE * 2.0 * reach;
    let into = |pose: &Pose, point: &Vec3| {
        pose.inverse_transform_point(&nalgebra::Point3::from(*point)).coords
    };
    let back = motion.pose.rotation.inverse();
    Ok(Jointed {
        a: spec.a.0,
        b: spec.b.map(|b| b.0),
        link: match spec.kind {
            JointKind::Rigid => JointLink::Rigid,
            JointKind::Hinge { axis } => JointLink::Hinge { axis: back * axis.normalize() },
            JointKind::Ball => JointLink::Ball,
            JointKind::Rope { length } => JointLink::Rope { length },
        },
        ends: [
            into(&motion.pose, &spec.anchor),
            into(&pose_b, &spec.anchor_b.unwrap_or(spec.anchor)),
        ],
        turn: pose_b.rotation.inverse() * motion.pose.rotation,
        face: CarryingFace::square(spec.area.unwrap_or(side * side)),
        limit: JointLimit::Whole(spec.limits),
        gap: 0.0,
        collide: spec.collide && matches!(spec.kind, JointKind::Ball | JointKind::Rope { .. }),
        load: JointLoad::zero(),
    })
}

/// A body and its motion.
pub(crate) fn known(world: &WorldState, id: BodyId) -> Result<(&Body, Motion), JointError> {
    let body = world.bodies.get(&id.0).zip(world.rigid.motion(id.0));
    body.ok_or(JointError::Unknown(id))
}

/// Refuses a pair that no joint can hold.
pub(crate) fn check_pair(one: &Body, other: Option<&Body>) -> Result<(), JointError> {
    if one.immovable() && other.is_none_or(Body::immovable) {
        let b = other.map_or_else(|| "the world".to_owned(), |body| body.name.clone());
        return Err(JointError::Immovable { a: one.name.clone(), b });
    }
    Ok(())
}

/// Refuses a number outside its range.
pub(crate) fn within(
    body: &Body,
    what: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<(), JointError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(JointError::OutOfRange { name: body.name.clone(), what, value, low, high })
}

fn check(one: &Body, other: Option<&Body>, spec: &JointSpec) -> Result<(), JointError> {
    if spec.b == Some(spec.a) {
        return Err(JointError::Itself { name: one.name.clone() });
    }
    check_pair(one, other)?;
    let least = f64::MIN_POSITIVE;
    let anchors = [Some(spec.anchor), spec.anchor_b].into_iter().flatten();
    let farthest =
        anchors.map(|p| p.norm()).fold(0.0, |a, b| if b.is_nan() { b } else { b.max(a) });
    within(one, "anchor: distance from the world's origin [m]", farthest, 0.0, 1e9)?;
    for (what, value) in [
        ("limit of the force [N]", spec.limits.force),
        ("limit of the torque [N·m]", spec.limits.torque),
        ("area [m²]", spec.area),
    ] {
        if let Some(value) = value {
            within(one, what, value, least, MOST)?;
        }
    }
    let apart = spec.anchor_b.map_or(0.0, |b| (b - spec.anchor).norm());
    match spec.kind {
        JointKind::Rope { length } => {
            within(one, "length of the rope [m]", length, least, 1e9)?;
            // A rope that is too short would pull at once.
            within(one, "distance of the ends of the rope [m]", apart, 0.0, length * (1.0 + 1e-9))
        }
        kind => {
            if let JointKind::Hinge { axis } = kind {
                within(one, "length of the axis [1]", axis.norm(), 1e-9, 1e9)?;
            }
            within(one, "distance of the two anchors [m]", apart, 0.0, 0.0)
        }
    }
}

/// Puts a joint in; its number.
pub(crate) fn put(world: &mut WorldState, joint: Jointed) -> u32 {
    let id = world.joints.next;
    world.joints.next += 1;
    world.rigid.join(id, &joint);
    world.joints.bind(id, &joint);
    world.joints.all.insert(id, joint);
    id
}

/// Takes a joint out; what it was.
pub(crate) fn take_out(world: &mut WorldState, id: u32) -> Option<Jointed> {
    let joint = world.joints.unbind(id)?;
    world.rigid.unjoin(id);
    Some(joint)
}

/// Takes all joints of a body out.
pub(crate) fn take_out_of(world: &mut WorldState, body: u32) -> Vec<Jointed> {
    let own = world.joints.of_body(body);
    own.into_iter().filter_map(|id| take_out(world, id)).collect()
}

/// A joint as others see it.
pub(crate) fn view(world: &WorldState, id: u32) -> Option<JointView> {
    let joint = world.joints.all.get(&id)?;
    let a = world.rigid.motion(joint.a)?.pose;
    let b = match joint.b {
        Some(b) => world.rigid.motion(b)?.pose,
        None => Pose::identity(),
    };
    let [point, point_b] = points(joint, &a, &b);
    Some(JointView {
        id: JointId(id),
        a: BodyId(joint.a),
        b: joint.b.map(BodyId),
        kind: match joint.link {
            JointLink::Rigid => JointKind::Rigid,
            JointLink::Hinge { axis } => JointKind::Hinge { axis: a.rotation * axis },
            JointLink::Ball => JointKind::Ball,
            JointLink::Rope { length } => JointKind::Rope { length },
        },
        point,
        point_b,
        area: joint.face.area,
        limit: joint.limit,
        load: joint.load,
    })
}
