//! What becomes of a wall that cracks: the exact cut of its body along what is known of the points.

use super::field::ShellField;
use super::{ShellSolve, frame};
use cullet_fragment::cut::{self, CutSettings, DamageField};
use cullet_fragment::finish::{Finish, FinishedParts};
use cullet_geometry::Vec3;
use cullet_model::{Failure, Fragmentation};
use cullet_simd::Real;

impl<R: Real, const N: usize> ShellSolve<R, N> {
    pub(super) fn finish(&mut self) -> Result<Fragmentation, Failure> {
        self.check()?;
        self.finish_field(ShellField::new(self))
    }

    /// The exact cut along what is known of the points.
    pub(super) fn finish_field(&self, found: ShellField) -> Result<Fragmentation, Failure> {
        let scored = frame::scored(&self.local.strength, self.wall.spacing, &self.wall.pose);
        let field = DamageField {
            spacing: self.wall.spacing,
            positions: &found.positions,
            damage: &found.damage,
            damage_time: &found.times,
            time_step: self.domain.step,
            top_speed: self.local.material.shear_speed(),
            scale: Vec3::repeat(1.0),
            normals: Some(&found.normals),
            pieces: Some(&found.pieces),
            scored: &scored,
        };
        let settings = CutSettings {
            min_volume_ratio: self.local.settings.min_volume_ratio,
            max_fragments: self.local.settings.max_fragments,
            seed: self.local.seed,
            detail: self.local.settings.brittle.detail,
        };
        let partition =
            cut::extract_stretched(&self.local.solid, &field, &settings, &found.stretch)
                .map_err(|error| Failure::Cut(error.to_string()))?;
        let mut report = self.report(&found.damage);
        report.crack_area = partition.crack_area;
        report.fracture_energy = self.local.material.fracture_energy * partition.crack_area;
        report.warnings.extend(partition.warnings);
        if !found.pieces.rubble.balls.is_empty() {
            report.warnings.push(format!(
                "crushed: {:.3} of the body is finer than the cells can tell; {} pieces sampled \
                 there",
                found.pieces.crushed,
                found.pieces.rubble.balls.len()
            ));
        }
        let parts = partition.parts.len();
        let mut origins = found.pieces.origins(&partition.particle_part, parts);
        let motions = found.motions(&partition.particle_part, parts);
        let finish = Finish {
            problem: &self.local,
            spacing: (self.wall.spacing, self.wall.spacing),
            motes: &found.motes(self.wall.spacing),
            pushes: &self.pushes(),
        };
        let FinishedParts { fragments, debris, warnings } =
            finish.fragments(partition.parts, &motions);
        report.warnings.extend(warnings);
        let reactions = self.reactions();
        // Debris is the last of them.
        origins.truncate(fragments.len());
        let fracture = Fragmentation { fragments, origins, debris, reactions, report };
        Ok(frame::from_local(fracture, &self.wall.pose))
    }
}
