//! Whether bodies touch.

use rapier3d_f64::prelude::{ContactPair, PhysicsWorld, RigidBody, RigidBodyHandle};

/// Whether a body touched another in the last step.
pub(super) fn is_touching(world: &PhysicsWorld, body: RigidBodyHandle) -> bool {
    let colliders = world.bodies.get(body).map_or(&[][..], RigidBody::colliders);
    let mut pairs = colliders.iter().flat_map(|&it| world.narrow_phase.contact_pairs_with(it));
    pairs.any(ContactPair::has_any_active_contact)
}
