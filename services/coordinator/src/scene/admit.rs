//! What the world says of a scene's bodies, asked before the scene runs: nothing that was checked is
//! refused later.

use super::Scene;
use crate::run::convert::{spec, world_settings};
use cullet_world::{World, WorldError};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Bodies that the world does not take, by their places in the list. What a shape comes to is asked
/// once for all bodies that share it.
///
/// # Errors
/// A setting of the world that is out of its range.
pub(super) fn refused(scene: &Scene) -> Result<Vec<(usize, WorldError)>, WorldError> {
    let world = World::new(world_settings(scene))?;
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for (index, body) in scene.bodies.iter().enumerate() {
        let new = seen.insert(Arc::as_ptr(&body.solid));
        let spec = spec(body);
        let taken = if new { world.admits(&spec) } else { spec.check() };
        found.extend(taken.err().map(|why| (index, why)));
    }
    Ok(found)
}
