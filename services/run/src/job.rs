//! From a body and its hits to a fracture problem for the wire.

use cullet_geometry::Vec3;
use cullet_geometry::math::scramble;
use cullet_model::{
    ArtDirection, BodyShape, BondedSolid, BrittleSettings, JohnsonCook, Law, Material,
    PointPrecision, Problem, Settings, StrengthField, Treatment,
};
use cullet_plan::{AccuracyTarget, Policy, SolveLimits, SolveOrder, family};
use cullet_proto::job::{MAX_IMPACTS, MAX_SUPPORTS};
use cullet_scene::format::{self, Fracture};
use cullet_scene::{SceneBody, SceneHit};
use cullet_world::{BodyId, BodyView, Hit};
use std::sync::Arc;

/// How the scene wants an object and its fragments solved.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    solver: Option<String>,
    settings: Settings,
    /// Whether the precision is the scene's.
    precise: bool,
    strength: StrengthField,
    /// What was done to its glass.
    treatment: Option<Treatment>,
    /// How its metal yields.
    plasticity: Option<JohnsonCook>,
    /// Its bonds, where it is solved as points and bonds.
    bonds: BondedSolid,
    /// How it is to come apart, until it has.
    pub(super) direction: Option<Arc<ArtDirection>>,
}

impl Choice {
    /// `seed`: of the flaws, this body's own.
    pub(super) fn of(body: &SceneBody, defaults: &Fracture, seed: u64) -> Self {
        let settings = Settings {
            spacing: body.spacing,
            max_particles: body.particles.unwrap_or(defaults.max_particles),
            max_steps: defaults.max_steps,
            min_volume_ratio: defaults.min_volume_ratio,
            max_fragments: defaults.max_fragments,
            debris: defaults.debris,
            grain: defaults.grain,
            precision: match defaults.precision.unwrap_or_default() {
                format::Precision::Single => PointPrecision::Single,
                format::Precision::Double => PointPrecision::Double,
            },
            error: None,
            brittle: BrittleSettings {
                detail: defaults.detail.values(),
                hairline: defaults.detail.hairline,
            },
        };
        let strength = StrengthField { seed, ..(*body.strength).clone() };
        let precise = defaults.precision.is_some();
        let (solver, treatment) = (body.solver.name().map(str::to_owned), body.material.treatment);
        let (plasticity, bonds) = (body.material.plasticity, body.material.bonds);
        let direction = body.direction.clone();
        Self { solver, settings, precise, strength, treatment, plasticity, bonds, direction }
    }

    /// Of a body that does not break.
    pub(super) fn rigid() -> Self {
        Self {
            solver: None,
            settings: Settings::default(),
            precise: false,
            strength: StrengthField::even(),
            treatment: None,
            plasticity: None,
            bonds: BondedSolid::default(),
            direction: None,
        }
    }

    /// Fragments keep the grid spacing \[m\] of the solve that made them: what they were made of
    /// was not known more finely than that. Zero: that solve had no grid.
    pub(super) fn no_finer_than(&mut self, spacing: f64) {
        if spacing > 0.0 {
            self.settings.spacing = Some(spacing);
        }
    }

    /// The same on a grid of that spacing \[m\], to the error that is good enough, if any is: then
    /// f32 is too.
    pub(super) fn on_grid(&self, spacing: f64, error: Option<f64>) -> Self {
        let mut choice = self.clone();
        choice.settings.spacing = Some(spacing);
        choice.settings.error = error;
        if error.is_some() && !self.precise {
            choice.settings.precision = PointPrecision::Single;
        }
        choice
    }

    /// What the solves of a body are asked for.
    pub(super) fn policy<'a>(
        &'a self,
        target: Option<AccuracyTarget>,
        material: &'a str,
    ) -> Policy<'a> {
        let limits = SolveLimits {
            most_points: f64::from(self.settings.max_particles),
            most_steps: f64::from(self.settings.max_steps),
            finest: self.settings.spacing.unwrap_or(0.0),
        };
        let family = self.solver.as_deref();
        let weak_plane = self.strength.weak_plane.is_some();
        let treated = self.treatment.is_some();
        let yield_stress = self.plasticity.map(|flow| flow.hardening.yield_stress);
        let most_supports = MAX_SUPPORTS;
        Policy {
            target,
            family,
            weak_plane,
            treated,
            yield_stress,
            material,
            limits,
            most_supports,
        }
    }

    /// The same for one hit that the scene gives settings of its own; `body`: that is hit.
    pub(super) fn of_hit(&self, hit: &SceneHit, body: BodyId) -> Self {
        let mut choice = self.clone();
        if let Some(seed) = hit.seed {
            choice.strength.seed = seed_of(body, seed);
        }
        if let Some(solver) = &hit.solver {
            choice.solver = solver.name().map(str::to_owned);
        }
        if let Some(particles) = hit.particles {
            (choice.settings.max_particles, choice.settings.spacing) = (particles, None);
        }
        choice.settings.spacing = hit.spacing.or(choice.settings.spacing);
        choice
    }

    /// The body has the flaws with which it was solved, and so have its fragments.
    pub(super) fn with_flaws_of(&mut self, solved: &Self) {
        self.strength.seed = solved.strength.seed;
    }

    /// Whether it is of a metal that yields.
    pub(super) fn yields(&self) -> bool {
        self.plasticity.is_some()
    }

    /// A fragment keeps the flaws and the paint of the body it comes from, and what was done to its
    /// glass unless dicing has set that free, but no direction; `centre`: where its own origin was
    /// in that body's frame \[m\].
    pub(super) fn of_fragment(&self, centre: &Vec3) -> Self {
        let mut choice = self.clone();
        choice.strength.offset += centre;
        choice.direction = None;
        choice.treatment = choice.treatment.filter(|it| !matches!(it, Treatment::Toughened { .. }));
        choice
    }
}

/// A hit that is solved with settings of its own.
pub(super) struct DirectedHit {
    /// Its place in the scene.
    pub(super) index: usize,
    /// How the body is solved for it.
    pub(super) choice: Choice,
    /// In place of the scene's.
    pub(super) seed: u64,
    /// Whether a job of it was opened.
    pub(super) opened: bool,
}

/// The problem of a body that was hit.
pub(super) fn problem(
    body: &BodyView<'_>,
    hits: &[Hit],
    order: &SolveOrder,
    choice: &Choice,
    seed: u64,
) -> Problem {
    let material = Material { density: body.density, ..body.material.solid };
    let strength = choice.strength.clone();
    // The plan asks the shell of thin plates only; what is none is taken as annealed.
    let treatment = choice.treatment.filter(|_| order.family == family::SHELL);
    let law = match (choice.plasticity, treatment) {
        (flow, _) if order.family == family::PERIDYNAMICS => {
            let hardening = flow.map(|flow| flow.hardening);
            Law::Bonded { material, bonds: BondedSolid { hardening, ..choice.bonds } }
        }
        // A wall flows slow and cold, and tears by its own law.
        (Some(flow), _) if flow.is_plain() || order.family == family::SHELL => {
            Law::Yielding { material, hardening: flow.hardening }
        }
        (Some(flow), _) => Law::JohnsonCook { material, flow },
        (None, None) => Law::Brittle { material, strength, surface: body.material.surface },
        (None, Some(treatment)) => Law::Treated { material, strength, treatment },
    };
    Problem {
        body: BodyShape::Solid(Arc::clone(body.solid)),
        law,
        impacts: strongest(hits).into_iter().map(|hit| hit.impact).collect(),
        supports: order.supports.iter().map(|support| support.held).collect(),
        spin: order.spin,
        settings: choice.settings,
        seed: seed_of(body.id, seed),
    }
}

/// The seed of a body's own randomness.
pub(super) fn seed_of(body: BodyId, seed: u64) -> u64 {
    scramble(seed ^ scramble(u64::from(body.0)))
}

/// The hits, or the strongest where there are more than a job takes, in their order.
fn strongest(hits: &[Hit]) -> Vec<&Hit> {
    let mut ranked: Vec<&Hit> = hits.iter().collect();
    ranked.sort_by(|a, b| b.impact.impulse.total_cmp(&a.impact.impulse));
    ranked.truncate(MAX_IMPACTS);
    ranked.sort_by_key(|hit| hit.episode);
    ranked
}

#[cfg(test)]
mod tests {
    use super::Choice;
    use cullet_geometry::Vec3;
    use cullet_model::{
        ArtDirection, BondedSolid, PointPrecision, Settings, StrengthField, Treatment,
    };
    use std::sync::Arc;

    #[test]
    fn a_solve_without_a_grid_leaves_the_spacing_as_it_was() {
        let settings = Settings { max_particles: 1000, max_steps: 100, ..Settings::default() };
        let strength = StrengthField::even();
        let treatment = Some(Treatment::Toughened { surface_stress: 90e6 });
        let (solver, precise, plasticity) = (None, false, None);
        let direction = Some(Arc::new(ArtDirection { pieces: Some(9), ..ArtDirection::default() }));
        let bonds = BondedSolid::default();
        let mut choice =
            Choice { solver, settings, precise, strength, treatment, plasticity, bonds, direction };
        choice.no_finer_than(0.0);
        assert_eq!(choice.settings.spacing, None);
        choice.no_finer_than(0.01);
        choice.no_finer_than(0.0);
        assert_eq!(choice.settings.spacing, Some(0.01));
        let part = choice.of_fragment(&Vec3::x()).of_fragment(&Vec3::new(1.0, 0.0, -0.5));
        assert_eq!(part.strength.offset, Vec3::new(2.0, 0.0, -0.5));
        assert_eq!(part.settings.spacing, Some(0.01));
        assert_eq!((choice.treatment, part.treatment), (treatment, None));
        assert!(choice.direction.is_some() && part.direction.is_none(), "only the first fracture");
        // An error that is good enough is reported, and f32 is good enough for it.
        let asked = |choice: &Choice, error| {
            let settings = choice.on_grid(0.02, error).settings;
            (settings.spacing, settings.error, settings.precision)
        };
        let (single, double) = (PointPrecision::Single, PointPrecision::Double);
        assert_eq!(asked(&choice, None), (Some(0.02), None, double));
        assert_eq!(asked(&choice, Some(0.5)), (Some(0.02), Some(0.5), single));
        choice.precise = true;
        assert_eq!(asked(&choice, Some(0.5)), (Some(0.02), Some(0.5), double));
    }
}
