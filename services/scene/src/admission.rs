//! Whether the rigid world takes the bodies of a scene: asked before any of them is simulated, and
//! of all of them, so that nothing that was checked is refused later.

use super::context::ResolveContext;
use super::rigid::{spec, world_settings};
use super::scene::Scene;
use cullet_document::tree::{Path, join};
use cullet_world::{World, WorldError, WorldSettings};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Notes each body that the world refuses; `paths`: where each was written. What a shape of a
/// material comes to is asked once for all bodies that share both.
pub(super) fn check(context: &mut ResolveContext<'_>, scene: &Scene, paths: &[Path]) {
    let world = match World::new(world_settings(scene)) {
        Ok(world) => world,
        Err(error) => {
            // With another error the settings may be the defaults of those that are missing.
            if context.errors.is_empty() {
                context.wrong(&["world".into()], error.to_string());
            }
            match World::new(WorldSettings::default()) {
                Ok(world) => world,
                Err(_) => return,
            }
        }
    };
    let mut asked = BTreeSet::new();
    for (body, path) in scene.bodies.iter().zip(paths) {
        if context.files.is_stopped() {
            return;
        }
        let form = (Arc::as_ptr(&body.hulls) as usize, Arc::as_ptr(&body.solid) as usize);
        let new = asked.insert((form, Arc::as_ptr(&body.material) as usize, body.fixed));
        let spec = spec(body);
        let taken: Result<(), WorldError> = if new { world.admits(&spec) } else { spec.check() };
        if let Err(error) = taken {
            let listed = body.generator.is_some() && body.mesh_object.is_none();
            let template = listed.then(|| join(path, "body"));
            let path = template.unwrap_or_else(|| path.clone());
            let key = if context.root.has(&join(&path, "mesh")) { "mesh" } else { "shape" };
            context.unmade(&join(&path, key), error.to_string(), None);
        }
    }
}
