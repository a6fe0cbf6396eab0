//! What acts on bodies from outside: fields that accelerate them, and what takes them out.

use crate::cluster::Part;
use crate::id::BodyId;
use crate::joints::take_out_of;
use crate::state::WorldState;
use cullet_geometry::Vec3;

/// [`crate::World::accelerate`].
pub(crate) fn accelerate(world: &mut WorldState, id: BodyId, acceleration: Vec3) -> bool {
    let there = world.bodies.get(&id.0).is_some_and(|body| !body.immovable());
    let sound = acceleration.iter().all(|x| x.is_finite());
    if !(there && sound) {
        return false;
    }
    *world.fields.entry(id.0).or_insert_with(Vec3::zeros) += acceleration;
    true
}

/// [`crate::World::remove`].
pub(crate) fn remove(world: &mut WorldState, id: BodyId) -> bool {
    let Some(body) = world.bodies.get(&id.0) else { return false };
    if let Some(motion) = world.rigid.motion(id.0).filter(|_| !body.immovable()) {
        let part = Part::new(body, &motion);
        let flows = &mut world.flows;
        flows.removed_mass += part.mass;
        flows.removed_momentum += part.momentum();
        let height = -world.settings.gravity.dot(&part.centre);
        flows.removed_energy += part.kinetic() + part.mass * height;
    }
    take_out_of(world, id.0);
    forget(world, id.0);
    true
}

/// Takes a body out of all books but those of joints.
pub(crate) fn forget(world: &mut WorldState, id: u32) {
    world.rigid.remove(id);
    world.bodies.remove(&id);
    world.episodes.forget(id);
    world.settling.end(id);
    world.replaced.drop_pending(id);
    world.fields.remove(&id);
    world.last_fields.remove(&id);
}
