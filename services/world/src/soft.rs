//! What bodies outside the rigid world do to those in it: sheets, soft shells and soft solids move
//! in windows of their own, in which rigid bodies stand with their mass and inertia.

use crate::body::invert;
use crate::exchange::Exchange;
use crate::id::BodyId;
use crate::motion::Motion;
use crate::state::WorldState;
use cullet_geometry::{Mat3, Pose, Vec3};

/// A body as a window needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyForWindow {
    /// Corners of its convex parts in its own frame \[m\], as contacts have them.
    pub parts: Vec<Vec<Vec3>>,
    /// Greatest distance of a corner from its centre \[m\].
    pub reach: f64,
    /// Coulomb's coefficient of its surface \[1\].
    pub friction: f64,
    /// Its mass \[kg\] and inertia about its centre in its own frame \[kg·m²\], as if no joint held
    /// it; `None`: it never moves, or on its path alone, which a window does not know.
    pub inertia: Option<(f64, Mat3)>,
    /// Whether it touches another body of the rigid world, as of the last step.
    pub touching: bool,
}

pub(crate) fn body_for_window(world: &WorldState, id: BodyId) -> Option<BodyForWindow> {
    let body = world.bodies.get(&id.0)?;
    Some(BodyForWindow {
        parts: world.rigid.corners(id.0),
        reach: body.reach,
        friction: body.material.friction,
        inertia: (!body.immovable()).then_some((body.mass, body.inertia)),
        touching: world.rigid.touches(id.0),
    })
}

/// Gives a body an impulse; whether it is there and can move.
pub(crate) fn push(world: &mut WorldState, id: BodyId, given: &Exchange) -> bool {
    let Some(body) = world.bodies.get(&id.0).filter(|body| !body.immovable()) else { return false };
    let Some(Motion { pose, velocity, spin }) = world.rigid.motion(id.0) else { return false };
    if given.linear == Vec3::zeros() && given.torque == Vec3::zeros() {
        return true;
    }
    let velocity = velocity + given.linear / body.mass;
    let spin = spin + invert(&body.world_inertia(&pose)) * given.torque;
    world.rigid.set_velocity(id.0, &velocity, &spin);
    true
}

/// Puts a body where a window has it at the end of the step just taken. Its velocity and its
/// angular momentum stay. Not so a body that touches another of the rigid world: its window could
/// not know; nor one that joints hold. Whether it was put there.
pub(crate) fn lead(world: &mut WorldState, id: BodyId, pose: &Pose) -> bool {
    let there = world.bodies.get(&id.0).is_some_and(|body| !body.immovable());
    if !there || world.rigid.touches(id.0) || world.joints.of.contains_key(&id.0) {
        return false;
    }
    world.rigid.place(id.0, pose);
    true
}
