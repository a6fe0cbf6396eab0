//! Brittle solids: particles, MLS-MPM under the Hertz push, Rankine damage, then the exact cut.

mod chip;
mod crushing;
mod report;
mod schedule;
#[cfg(test)]
mod tests;
mod warnings;

use crate::damage::{BodyWeakPlane, Softening};
use crate::mpm::crushed::CrushRules;
use crate::mpm::diagnostics::{CHECK_PERIOD, Diagnostics};
use crate::mpm::domain::stable_step;
use crate::mpm::elastic_support::ElasticSupport;
use crate::mpm::load::ImpactLoad;
use crate::mpm::load_patch::LEAST_RADIUS;
use crate::mpm::point_damage::{PointDamage, motes};
use crate::mpm::preconditions::{
    check_contacts, check_hairline, check_impacts, check_material, check_spin, check_supports,
    check_thickness, choose_spacing, sample_points, stretch, within,
};
use crate::mpm::{Domain, DomainTally, crushed, motion, quadrature};
use crate::particles::Particles;
use crushing::CrushedZone;
use cullet_fragment::cut::{self, CutError, CutSettings, DamageField, Partition};
use cullet_fragment::finish::{Finish, FinishedParts, FragmentMotion};
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;
use cullet_model::brittle::POINTS_PER_CELL;
use cullet_model::hertz_contact;
use cullet_model::{
    BrittleProblem, Cost, EnergyAccount, EnergyBalance, Failure, Fragmentation, Impact,
    PointPrecision, Problem, Progress, Refusal, Solver, Strength,
};
use cullet_simd::SimdLevel;
pub use schedule::TerminationCriteria;
use schedule::{CrackActivity, Schedule};
pub use warnings::grid_bias_warning;

/// Most points a solve may ask for: 8 million take about 3 GB.
const MOST_PARTICLES: f64 = 8e6;

/// Fewest points worth solving: below, no section has three cells.
const LEAST_PARTICLES: usize = 200;

/// Bytes a point needs, with its share of arenas and nodes.
const BYTES: f64 = 800.0;

/// Share of points that may be crushed before the numbers mean nothing (F07).
const CRUSHED_SHARE: f64 = 0.02;

/// How often an unstable solve is begun again with half the step (F76).
const HALVINGS: u32 = 2;

/// Particle-steps of a slice: some tens of milliseconds.
const SLICE: u64 = 200_000;

/// A brittle solve in progress.
#[derive(Debug)]
pub struct Brittle {
    problem: BrittleProblem,
    domain: Domain,
    loads: Vec<ImpactLoad>,
    supports: Vec<ElasticSupport>,
    /// What crushes under each load.
    zones: Vec<Option<CrushedZone>>,
    /// Whether cracks may start at each contact.
    torn: Vec<bool>,
    schedule: Schedule,
    push_over: Option<f64>,
    setup: SolveSetup,
    record: SolveRecord,
}

/// How a solve is done.
#[derive(Clone, Copy, Debug)]
struct SolveSetup {
    criteria: TerminationCriteria,
    simd_level: SimdLevel,
    /// Strength at which cracks grow, over the material's \[1\].
    strength_ratio: f64,
    /// How often it was begun again with half the step.
    halvings: u32,
}

/// What a solve has seen so far.
#[derive(Debug, Default)]
struct SolveRecord {
    total: DomainTally,
    /// When the push began: what the body held and had spent by then, and its spin's work.
    start: Option<EnergyAccount>,
    balance: EnergyBalance,
    activity: CrackActivity,
    diagnostics: Diagnostics,
    /// Greatest |v|² of a node \[m²/s²\].
    fastest: f64,
    warnings: Vec<String>,
}

impl Solver for Brittle {
    const NAME: &'static str = "brittle";
    const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Single, PointPrecision::Double];

    fn accepts(problem: &Problem) -> Result<Cost, Refusal> {
        estimate_cost(&BrittleProblem::of(problem.clone(), Self::NAME)?)
    }

    fn begin(problem: Problem) -> Result<Self, Refusal> {
        let problem = BrittleProblem::of(problem, Self::NAME)?;
        Self::with(problem, TerminationCriteria::default(), SimdLevel::best())
    }

    fn advance(&mut self) -> Progress {
        let slice = (SLICE / self.domain.particles.len().max(1) as u64).max(1);
        for _ in 0..slice {
            let done = match self.step() {
                Ok(()) if self.over() => self.finish().map(|whole| Some(self.chipped(whole))),
                other => other.map(|()| None),
            };
            match done {
                Ok(None) => {}
                Ok(Some(fracture)) => return Progress::Done(fracture.into()),
                Err(failure) => match self.again(&failure) {
                    Some(again) => *self = again,
                    None => return Progress::Failed(failure),
                },
            }
        }
        let Schedule { spin_up, end, .. } = self.schedule;
        Progress::Running(((spin_up + self.domain.time) / (spin_up + end)).min(1.0))
    }
}

/// What a problem would cost, or the bound that it breaks.
fn estimate_cost(problem: &BrittleProblem) -> Result<Cost, Refusal> {
    check_material(problem)?;
    check_impacts(&problem.impacts)?;
    check_supports(&problem.supports)?;
    check_spin(problem)?;
    if let Some(error) = problem.settings.error {
        within("the error that is good enough", error, f64::MIN_POSITIVE, 1.0)?;
    }
    let spacing = choose_spacing(problem)?;
    check_contacts(problem, &spacing, LEAST_RADIUS)?;
    check_hairline(problem, &spacing)?;
    let volume = problem.solid.mesh.signed_volume();
    let particles = POINTS_PER_CELL * volume / spacing.product();
    within("the number of particles", particles, LEAST_PARTICLES as f64, f64::INFINITY)?;
    let most = f64::from(problem.settings.max_particles).min(MOST_PARTICLES);
    // A spacing that was asked for may overshoot by what rounding and sampling do.
    if particles > 1.05 * most {
        return Err(Refusal::TooLarge {
            what: "the number of particles",
            value: particles,
            limit: most,
        });
    }
    let step = time_step(problem, &spacing);
    let schedule = Schedule::new(problem, &TerminationCriteria::default());
    let steps = (schedule.spin_up + schedule.end) / step;
    let limit = f64::from(problem.settings.max_steps);
    if steps > limit {
        return Err(Refusal::TooLarge { what: "the number of steps", value: steps, limit });
    }
    Ok(Cost { particles, steps, bytes: particles * BYTES })
}

/// A cut whose faces show the grid at every attempt is none: another family takes the body (F22).
fn may_be_shown(partition: Partition) -> Result<Partition, CutError> {
    match partition.bias {
        bias if bias.shows() => Err(CutError::Grid { times: bias.times }),
        _ => Ok(partition),
    }
}

impl Brittle {
    /// Like `begin`, with other criteria for the end and other instructions of the processor.
    ///
    /// # Errors
    /// If the problem is not for this solver.
    pub fn with(
        problem: BrittleProblem,
        criteria: TerminationCriteria,
        simd_level: SimdLevel,
    ) -> Result<Self, Refusal> {
        estimate_cost(&problem)?;
        let spacing = choose_spacing(&problem)?;
        let mesh = &problem.solid.mesh;
        let inside = Inside::new(mesh);
        let points = sample_points(&problem, &spacing)?;
        within("the number of particles", points.len() as f64, LEAST_PARTICLES as f64, 1e9)?;
        check_thickness(&problem, &points, &spacing)?;
        let material = &problem.material;
        let mut particles = Particles::at_rest(&points, mesh.signed_volume(), material.density);
        particles.volume = quadrature::volumes(&points, &inside, spacing, mesh.signed_volume());
        let strength = Strength::new(&problem.strength, spacing.max());
        for (factor, x) in particles.strength.iter_mut().zip(&points) {
            *factor = strength.factor(x);
        }
        let mut softening = Softening::on_grid(material, spacing.max());
        softening.weak_plane =
            strength.weak_plane.map(|w| BodyWeakPlane { normal: w.normal.into(), ratio: w.ratio });
        let mut domain = Domain::new(particles, material, softening, spacing);
        domain.select(problem.settings.precision, simd_level);
        domain.rub(problem.surface.friction);
        domain.step = time_step(&problem, &spacing);
        domain.check_cracks_every(problem.settings.tolerance().refresh());
        let schedule = Schedule::new(&problem, &criteria);
        domain.time = -schedule.spin_up;
        let loads: Vec<ImpactLoad> = problem
            .impacts
            .iter()
            .map(|impact| load(impact, &problem, &domain, &schedule))
            .collect();
        for &(id, _) in loads.iter().flat_map(|load| load.patch.shares()) {
            let slot = domain.slot(id);
            domain.particles.shielded[slot] = true;
        }
        let zones = loads.iter().enumerate();
        let zones = zones
            .map(|(index, load)| CrushedZone::under(load, index, &problem, &mut domain))
            .collect();
        let support = |support| ElasticSupport::new(support, &domain, material);
        let supports = problem.supports.iter().map(support).collect();
        let warnings = warnings::first(&problem, &softening, &schedule, &spacing);
        Ok(Self {
            problem,
            domain,
            torn: vec![false; loads.len()],
            supports,
            zones,
            loads,
            schedule,
            push_over: None,
            setup: SolveSetup {
                criteria,
                simd_level,
                strength_ratio: softening.strength_ratio,
                halvings: 0,
            },
            record: SolveRecord { warnings, ..SolveRecord::default() },
        })
    }

    /// The solve from its beginning with half the step, where numbers went wrong and the budget of
    /// steps lasts (F76).
    fn again(&self, failure: &Failure) -> Option<Self> {
        let numbers = matches!(failure, Failure::NotFinite { .. } | Failure::Unstable { .. });
        if !numbers || self.setup.halvings == HALVINGS {
            return None;
        }
        let mut problem = self.problem.clone();
        problem.settings.precision = PointPrecision::Double;
        let mut fresh = Self::with(problem, self.setup.criteria, self.setup.simd_level).ok()?;
        fresh.setup.halvings = self.setup.halvings + 1;
        fresh.domain.step /= f64::from(1_u32 << fresh.setup.halvings);
        let steps = (fresh.schedule.spin_up + fresh.schedule.end) / fresh.domain.step;
        if steps > f64::from(self.problem.settings.max_steps) {
            return None;
        }
        let single = self.problem.settings.precision == PointPrecision::Single;
        let wider = if single { ", in f64" } else { "" };
        let step = fresh.domain.step;
        let warning = format!("{failure}: solved again with steps of {step:.3e} s{wider} (F76)");
        fresh.record.warnings = self.record.warnings.iter().cloned().chain([warning]).collect();
        Some(fresh)
    }

    /// The body on its grid as it is now.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    fn step(&mut self) -> Result<(), Failure> {
        if self.schedule.spin_up > 0.0 {
            self.domain.spin = Some(self.schedule.spin(self.problem.spin, self.domain.time));
        }
        if self.domain.time >= 0.0 {
            if self.record.start.is_none() {
                self.record.start = Some(self.account());
            }
            self.push_contacts();
            self.open_contacts();
        }
        let tally = self.domain.advance();
        self.book_contacts();
        self.record.total.dissipated += tally.dissipated;
        self.record.total.collided += tally.collided;
        self.record.total.crushed = self.record.total.crushed.max(tally.crushed);
        self.record.total.broken += tally.broken;
        self.record.fastest = self.record.fastest.max(tally.fastest);
        let points = self.domain.particles.len() as f64;
        self.record.activity.note(
            self.domain.time,
            self.record.total.broken,
            points,
            self.schedule.transit,
        );
        let share = f64::from(self.record.total.crushed) / points;
        if share > CRUSHED_SHARE {
            return Err(Failure::Unstable { ratio: share, step: self.domain.steps });
        }
        let step = self.domain.steps;
        if step.is_multiple_of(CHECK_PERIOD) {
            self.check()?;
        }
        Ok(())
    }

    /// What happens under the contacts in the next step.
    fn push_contacts(&mut self) {
        for (load, zone) in self.loads.iter_mut().zip(&mut self.zones) {
            load.push(&mut self.domain);
            if let Some(zone) = zone {
                zone.push(load, &mut self.domain);
            }
        }
        for support in &mut self.supports {
            support.push(&mut self.domain);
        }
    }

    /// Books the work of the contacts in the step that was just taken.
    fn book_contacts(&mut self) {
        self.loads.iter_mut().for_each(|load| load.book(&self.domain));
        self.zones.iter_mut().flatten().for_each(|zone| zone.book(&self.domain));
        self.supports.iter_mut().for_each(|support| support.book(&self.domain));
    }

    /// Work of all contacts on the body so far \[J\].
    pub(super) fn work(&self) -> f64 {
        let loads = self.loads.iter().map(|load| load.work);
        let zones = self.zones.iter().flatten().map(|zone| zone.work);
        loads.chain(zones).chain(self.supports.iter().map(|one| one.work)).sum()
    }

    /// Lets cracks start where the rim tears of a contact that is too narrow for the grid and in
    /// which the body does not crush. On a plate they lie in the face that bending presses
    /// together, and start nothing.
    fn open_contacts(&mut self) {
        if self.domain.grid.spacing.min() < self.domain.grid.spacing.max() {
            return;
        }
        let pairs = self.loads.iter().zip(&self.zones).zip(&mut self.torn);
        for ((load, _), torn) in pairs.filter(|((_, zone), torn)| zone.is_none() && !**torn) {
            if load.cracks(&self.problem.material) {
                *torn = true;
                let time = self.domain.time;
                load.patch.shares().iter().for_each(|&(id, _)| self.domain.open(id, time));
            }
        }
    }

    fn check(&mut self) -> Result<(), Failure> {
        let loads = self.loads.iter().map(|load| load.direction * load.delivered);
        let supports = self.supports.iter().map(|one| one.normal * one.delivered);
        let momentum = self.domain.spin.is_none().then(|| loads.chain(supports).sum());
        self.record.diagnostics.check(&self.domain, momentum)?;
        let Some(start) = self.record.start else { return Ok(()) };
        let mut account = self.account();
        account.given += start.off();
        let hits: f64 = self.problem.impacts.iter().map(|impact| impact.energy).sum();
        let scale = hits + start.kinetic + start.elastic;
        self.record.balance.look(&account, scale, self.domain.steps)
    }

    /// The account of the body's energy; what it was given while its spin was put on is left out.
    fn account(&self) -> EnergyAccount {
        let (step, grid) = (self.domain.step, &self.domain.grid);
        EnergyAccount {
            given: self.work() + self.domain.spin.map_or(0.0, |spin| spin.work(grid, step)),
            broken: self.record.total.dissipated,
            met: self.record.total.collided,
            ..self.domain.energy()
        }
    }

    fn over(&mut self) -> bool {
        let time = self.domain.time;
        if self.loads.iter().any(|load| !load.is_over()) {
            return false;
        }
        let push = *self.push_over.get_or_insert(time);
        let quiet = time - self.record.activity.last.max(push);
        let transit = self.schedule.transit;
        let end = quiet > self.setup.criteria.quiet * transit
            || time > push + self.setup.criteria.after * transit;
        let points = self.domain.particles.len() as f64;
        let growth = self.problem.settings.tolerance().growth();
        let small = growth.is_some_and(|share| self.record.activity.is_small(share, points));
        if let (false, true, Some(error)) = (end, small, self.problem.settings.error) {
            self.record.warnings.push(format!(
                "ended {:.2} of a wave's way after the push: too little broke in one to matter to \
                 an error of {error}",
                (time - push) / transit
            ));
        }
        end || small
    }

    fn finish(&mut self) -> Result<Fragmentation, Failure> {
        self.check()?;
        let damage = PointDamage::of(&self.domain);
        let pieces = self.domain.pieces();
        let rules = CrushRules::of(&self.problem, self.domain.grid.spacing);
        let pieces = crushed::pieces(&self.domain.particles, pieces, &rules);
        let scored = self.problem.strength.scored(self.domain.grid.spacing.max());
        let top_speed = self.problem.material.shear_speed();
        let field =
            DamageField { scored: &scored, ..damage.field(&self.domain, top_speed, &pieces) };
        let settings = self.cut_settings();
        let stretch = stretch(&self.domain.grid.spacing);
        let partition = cut::extract_stretched(&self.problem.solid, &field, &settings, &stretch)
            .and_then(may_be_shown)
            .map_err(|error| Failure::Cut(error.to_string()))?;
        let mut report = self.report(&damage.damage);
        report.crack_area = partition.crack_area;
        report.fracture_energy = self.problem.material.fracture_energy * partition.crack_area;
        report.warnings.extend(partition.warnings);
        if !pieces.rubble.balls.is_empty() {
            report.warnings.push(format!(
                "crushed: {:.3} of the body is finer than the grid can tell; {} pieces drawn there",
                pieces.crushed,
                pieces.rubble.balls.len()
            ));
        }
        let motions =
            motion::of_parts(&self.domain, &partition.particle_part, partition.parts.len());
        let mut origins = pieces.origins(&partition.particle_part, partition.parts.len());
        let pushes = self.loads.iter().zip(&self.problem.impacts);
        let pushes = pushes.map(|(load, hit)| (hit.point, load.direction * load.delivered));
        let supports = self.supports.iter().map(|one| (one.point, one.normal * one.delivered));
        let finish = Finish {
            problem: &self.problem,
            spacing: (self.domain.grid.spacing.min(), self.domain.grid.spacing.max()),
            motes: &motes(&self.domain, |p| self.domain.particles.reference[p]),
            pushes: &pushes.chain(supports).collect::<Vec<_>>(),
        };
        let motions: Vec<FragmentMotion> = motions.iter().map(|m| (m.velocity, m.spin)).collect();
        let FinishedParts { fragments, debris, warnings } =
            finish.fragments(partition.parts, &motions);
        report.warnings.extend(warnings);
        let reactions = self.supports.iter().map(|one| one.delivered).collect();
        // Debris is the last of them.
        origins.truncate(fragments.len());
        Ok(Fragmentation { fragments, origins, debris, reactions, report })
    }

    fn cut_settings(&self) -> CutSettings {
        CutSettings {
            min_volume_ratio: self.problem.settings.min_volume_ratio,
            max_fragments: self.problem.settings.max_fragments,
            seed: self.problem.seed,
            detail: self.problem.settings.brittle.detail,
        }
    }
}

/// The step of a solve that is not repeated \[s\].
fn time_step(problem: &BrittleProblem, spacing: &Vec3) -> f64 {
    problem.settings.tolerance().step() * stable_step(&problem.material, spacing.min())
}

/// The push of an impact: where the schedule shortens it, it has the same peak force and delivers
/// less; the striker keeps the rest.
fn load(
    impact: &Impact,
    problem: &BrittleProblem,
    domain: &Domain,
    schedule: &Schedule,
) -> ImpactLoad {
    let duration = hertz_contact::duration(impact).min(schedule.push);
    let mobility = motion::mobility(problem, &impact.point, &impact.normal);
    ImpactLoad::new(impact, domain, duration, mobility)
}
