//! What bodies did over the step just taken.

use crate::body::Body;
use crate::exchange::Stepped;
use crate::motion::Motion;
use crate::state::WorldState;
use cullet_geometry::Vec3;

/// A body over the step.
pub(crate) fn stepped(world: &WorldState, id: u32) -> Option<(&Body, Stepped)> {
    let body = world.bodies.get(&id).filter(|body| !body.immovable())?;
    let (&before, after) = (world.rigid.before(id)?, world.rigid.motion(id)?);
    let stepped = Stepped {
        mass: body.mass,
        inertia: body.world_inertia(&before.pose),
        inertia_after: body.world_inertia(&after.pose),
        before,
        after,
    };
    Some((body, stepped))
}

/// Gravity and what fields give a body \[m/s²\].
pub(crate) fn acceleration(world: &WorldState, id: u32) -> Vec3 {
    let field = world.fields.get(&id).copied().unwrap_or_else(Vec3::zeros);
    world.settings.gravity + field
}

/// Mean velocity over the step of a place in a body's frame, and the mean spin; nothing of a body
/// that nothing moves.
pub(crate) fn mean_motion(world: &WorldState, id: u32, place: Vec3) -> Option<(Vec3, Vec3)> {
    let (_, Stepped { before, after, .. }) = stepped(world, id)?;
    let speed =
        |motion: &Motion| motion.velocity + motion.spin.cross(&(motion.pose.rotation * place));
    Some(((speed(&before) + speed(&after)) / 2.0, (before.spin + after.spin) / 2.0))
}
