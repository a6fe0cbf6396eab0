//! Pieces of deforming bodies that have come to rest become rigid bodies of their shape.

use super::{ObjectOrigin, RunError, SceneRun, job};
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_model::SettledPiece;
use cullet_scene::rigid;
use cullet_world::BodySpec;

impl SceneRun<'_> {
    /// Puts pieces at rest into the world; those that it does not admit stay where they are. Which
    /// became bodies.
    pub(super) fn retire_pieces(
        &mut self,
        index: usize,
        settled: &[SettledPiece],
    ) -> Result<Vec<u32>, RunError> {
        let moving = &self.scene.moving[index];
        let mut retired = Vec::new();
        for piece in settled {
            let volume = piece.solid.mesh.mass_properties().volume;
            let spec = BodySpec {
                name: format!("{}-piece-{}", moving.name, piece.number),
                solid: piece.solid.clone(),
                hulls: convex_parts(&piece.solid, HullSettings::default()),
                material: rigid::contact_material(&moving.material),
                density: Some(piece.mass / volume),
                pose: Pose::from_parts(piece.place.into(), Quat::identity()),
                velocity: Vec3::zeros(),
                spin: Vec3::zeros(),
                fixed: false,
                breakable: false,
                weakest: 1.0,
                threshold: None,
                parent: None,
                generation: 0,
                original_volume: None,
                driven: None,
            };
            if let Err(why) = self.world.admits(&spec) {
                // It is offered anew in each window.
                let told = format!("{}: piece {} stays a deforming one", moving.name, piece.number);
                if self.told_of_sheets.insert(told.clone()) {
                    self.say(format!("{told}: {why}"));
                }
                continue;
            }
            let id = self.world.insert(spec)?;
            let origin = ObjectOrigin {
                object: moving.name.clone(),
                material: moving.material.name.clone(),
                choice: job::Choice::rigid(),
            };
            self.origins.insert(id, origin);
            self.record_birth(id)?;
            retired.push(piece.number);
        }
        Ok(retired)
    }
}
