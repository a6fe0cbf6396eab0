//! From a body and its hits to a fracture problem for the wire.

use crate::scene::SceneBody;
use crate::scene::format::Fracture;
use cullet_geometry::math::scramble;
use cullet_proto::{FractureJob, Impact, Material, Settings};
use cullet_world::{BodyView, Hit};

/// The family asked when the scene leaves it open.
pub(super) const FIRST: &str = "brittle";
/// The family that takes what the first one declines.
const FALLBACK: &str = "geometric";

/// How the scene wants an object and its fragments solved.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    solver: Option<&'static str>,
    settings: Settings,
}

impl Choice {
    pub(super) fn of(body: &SceneBody, defaults: &Fracture) -> Self {
        let settings = Settings {
            spacing: body.spacing,
            max_particles: body.particles.unwrap_or(defaults.max_particles),
            max_steps: defaults.max_steps,
            min_volume_ratio: defaults.min_volume_ratio,
            detail: defaults.detail.values(),
            max_fragments: defaults.max_fragments,
        };
        Self { solver: body.solver.solver(), settings }
    }

    /// Fragments keep the grid spacing \[m\] of the solve that made them: what they were made of
    /// was not known more finely than that. Zero: that solve had no grid.
    pub(super) fn no_finer_than(&mut self, spacing: f64) {
        if spacing > 0.0 {
            self.settings.spacing = Some(spacing);
        }
    }
}

/// The problem of a body that was hit. `geometric`: the gate found that no stress needs to be
/// solved for.
pub(super) fn problem(
    body: &BodyView<'_>,
    hits: &[Hit],
    choice: &Choice,
    geometric: bool,
    seed: u64,
) -> FractureJob {
    let wanted = if geometric { FALLBACK } else { choice.solver.unwrap_or(FIRST) };
    let material = body.material;
    FractureJob {
        solver: wanted.to_owned(),
        fallback: (wanted != FALLBACK).then(|| FALLBACK.to_owned()),
        solid: (**body.solid).clone(),
        material: Material {
            density: material.density,
            young: material.young,
            poisson: material.poisson,
            failure_stress: material.failure_stress,
            fracture_energy: material.fracture_energy,
        },
        impacts: hits.iter().map(impact).collect(),
        settings: choice.settings,
        seed: scramble(seed ^ scramble(u64::from(body.id.0))),
    }
}

fn impact(hit: &Hit) -> Impact {
    let i = &hit.impact;
    Impact {
        point: i.point,
        normal: i.normal,
        impulse: i.impulse,
        duration: i.duration,
        radius: i.radius,
        energy: i.energy,
        closing_speed: i.closing_speed,
    }
}

#[cfg(test)]
mod tests {
    use super::Choice;
    use cullet_proto::Settings;

    #[test]
    fn a_solve_without_a_grid_leaves_the_spacing_as_it_was() {
        let settings = Settings {
            spacing: None,
            max_particles: 1000,
            max_steps: 100,
            min_volume_ratio: 0.0,
            max_fragments: 10,
            detail: cullet_proto::Detail::default(),
        };
        let mut choice = Choice { solver: None, settings };
        choice.no_finer_than(0.0);
        assert_eq!(choice.settings.spacing, None);
        choice.no_finer_than(0.01);
        choice.no_finer_than(0.0);
        assert_eq!(choice.settings.spacing, Some(0.01));
    }
}
