//! A hit on a thin wall, flat or curved, solved as a shell: striker and supports on the midsurface,
//! cracks, then the exact cut of the body along them.

mod contact;
mod crushed;
mod deformed;
mod field;
mod frame;
mod laminated;
mod nature;
mod preconditions;
mod report;
mod scatter;
mod schedule;
mod toughened;
mod treated;
mod wall;

use crate::domain::{ShellDomain, ShellMaterial};
use crate::midsurface::Midsurface;
use crate::section::SectionLaw;
use contact::{PressedPoints, ShellStriker, ShellSupport};
use cullet_fragment::cut::{self, CutSettings, DamageField};
use cullet_fragment::finish::{Finish, FinishedParts};
use cullet_fragment::kinetic_damping::KineticDamping;
use cullet_geometry::Vec3;
use cullet_model::strength::CORRELATION;
use cullet_model::{
    BrittleProblem, Cost, Failure, Fragmentation, PointPrecision, Problem, Progress, Refusal,
    SolveOutcome, Solver, Strength, StrengthField, Treatment,
};
use cullet_simd::{Real, SimdLevel};

use nature::WallNature;
pub(crate) use preconditions::{SLENDER, neither, refusal};
use preconditions::{ShellPlan, ThinBody, wall_surface};
use schedule::ShellSchedule;
pub(crate) use wall::SOFTENING_CELLS;
use wall::ThinWall;

/// Steps between looks at the energy.
const CHECK: u64 = 64;

/// Excess of energy over what was given, above which a solve has failed \[1\].
const UNSTABLE: f64 = 0.1;

/// Control-point-steps of a slice: some tens of milliseconds.
const SLICE: u64 = 200_000;

/// Face under tension in the tests that strengths of glass come from: 0.004 m² in ASTM C158, 0.07
/// m² in EN 1288-3  \[m²\].
const TESTED_AREA: f64 = 0.01;

/// How far from a contact a shell overstates the stress, in thicknesses \[shells §2.10\].
const NEAR: f64 = 2.0;

/// Most mass that small cells may get, over that of the shell \[1\]: a piece that breaks off there
/// may be heavier by far more.
const MOST_ADDED: f64 = 0.02;

/// The same of metal, where none break.
const MOST_ADDED_TO_METAL: f64 = 0.1;

/// Steps of a curved wall that are tried, over that of cells as large as most: one with jagged rims
/// has small ones there.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// The shell family.
#[derive(Debug)]
pub struct ShellSolver(Box<dyn InSlices>);

/// A solve that goes on slice by slice.
trait InSlices: std::fmt::Debug + Send {
    fn advance(&mut self) -> Progress;
}

impl<R: Real, const N: usize> InSlices for ShellSolve<R, N> {
    fn advance(&mut self) -> Progress {
        Self::advance(self)
    }
}

impl Solver for ShellSolver {
    const NAME: &'static str = "shell";
    const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Single, PointPrecision::Double];

    fn accepts(problem: &Problem) -> Result<Cost, Refusal> {
        let (problem, nature) = WallNature::of(problem.clone(), Self::NAME)?;
        let plan = ShellPlan::new(&problem, nature.hardening.is_some())?;
        treated::check(nature.treatment.as_ref(), &plan.body)?;
        Ok(plan.cost)
    }

    fn begin(problem: Problem) -> Result<Self, Refusal> {
        let (problem, nature) = WallNature::of(problem, Self::NAME)?;
        let ShellPlan { body, spacing, .. } = ShellPlan::new(&problem, nature.hardening.is_some())?;
        treated::check(nature.treatment.as_ref(), &body)?;
        let wall = match body {
            ThinBody::Plate(plate) => ThinWall::of_plate(&plate, &problem, spacing)?,
            ThinBody::Wall(flat) => {
                ThinWall::of_surface(&wall_surface(&problem, &flat, spacing)?, spacing)?
            }
        };
        of_functions(&problem, nature, wall).map(Self)
    }

    fn advance(&mut self) -> Progress {
        self.0.advance()
    }
}

/// The solve of a wall, with as many functions a cell as it needs.
fn of_functions(
    problem: &BrittleProblem,
    nature: WallNature,
    wall: (ThinWall, Midsurface),
) -> Result<Box<dyn InSlices>, Refusal> {
    use PointPrecision::{Double, Single};
    let level = SimdLevel::best();
    match (wall.1.functions, problem.settings.precision) {
        (..=9, Single) => boxed(ShellSolve::<f32, 9>::of_wall(problem, nature, wall, level)),
        (..=9, Double) => boxed(ShellSolve::<f64, 9>::of_wall(problem, nature, wall, level)),
        (..=12, Single) => boxed(ShellSolve::<f32, 12>::of_wall(problem, nature, wall, level)),
        (..=12, Double) => boxed(ShellSolve::<f64, 12>::of_wall(problem, nature, wall, level)),
        (_, Single) => boxed(ShellSolve::<f32, 16>::of_wall(problem, nature, wall, level)),
        (_, Double) => boxed(ShellSolve::<f64, 16>::of_wall(problem, nature, wall, level)),
    }
}

fn boxed<S: InSlices + 'static>(solve: Result<S, Refusal>) -> Result<Box<dyn InSlices>, Refusal> {
    solve.map(|solve| Box::new(solve) as Box<dyn InSlices>)
}

/// A thin wall under its hits, whose cells have `N` functions, worked out in `R`.
#[derive(Debug)]
pub struct ShellSolve<R: Real, const N: usize> {
    /// In the frame of the solve.
    local: BrittleProblem,
    wall: ThinWall,
    nature: WallNature,
    domain: ShellDomain<R, N>,
    strikers: Vec<ShellStriker>,
    supports: Vec<ShellSupport>,
    schedule: ShellSchedule,
    settling: KineticDamping,
    record: ShellRecord,
}

/// What a solve has seen so far.
#[derive(Debug, Default)]
struct ShellRecord {
    time: f64,
    steps: u64,
    dissipated: f64,
    met: f64,
    broken: u32,
    last_growth: f64,
    grown_then: u32,
    push_over: Option<f64>,
    /// Energy found less energy given, over that of the hits, where it was most \[1\].
    energy_off: f64,
    warnings: Vec<String>,
}

impl<R: Real> ShellSolve<R, 9> {
    /// Of a plate, with certain instructions of the processor.
    ///
    /// # Errors
    /// If the problem is not for this family, or its body is no plate.
    pub fn of_plate(
        problem: &BrittleProblem,
        treatment: Option<Treatment>,
        level: SimdLevel,
    ) -> Result<Self, Refusal> {
        let ShellPlan { body, spacing, .. } = ShellPlan::new(problem, false)?;
        let ThinBody::Plate(plate) = body else {
            let lack = "it is no flat plate".to_owned();
            return Err(Refusal::Unfit { solver: ShellSolver::NAME, lack });
        };
        let wall = ThinWall::of_plate(&plate, problem, spacing)?;
        let nature = WallNature { treatment, hardening: None };
        Self::of_wall(problem, nature, wall, level)
    }
}

impl<R: Real, const N: usize> ShellSolve<R, N> {
    fn of_wall(
        problem: &BrittleProblem,
        nature: WallNature,
        (wall, surface): (ThinWall, Midsurface),
        level: SimdLevel,
    ) -> Result<Self, Refusal> {
        let local = frame::to_local(problem, &wall.pose);
        let (material, spacing) = (&local.material, wall.spacing);
        let strength = Strength::new(&problem.strength, spacing);
        let at = |p: usize| wall.in_body(&surface.surface_point(p).place);
        let stress = material.failure_stress * place_factor(&local.strength, spacing);
        let frozen = nature.treatment.map_or(0.0, |treatment| treatment.surface_stress());
        let cracks = |p: usize| frozen + stress * strength.factor(&at(p));
        let scores = (0..surface.points()).map(|p| (p, strength.score(&at(p))));
        let scores: Vec<(usize, f64)> = scores.filter(|(_, score)| *score != 1.0).collect();
        let metal = nature.hardening.is_some();
        let strength = |p: usize| if metal { f64::INFINITY } else { cracks(p) };
        let law = SectionLaw::new(material);
        let shell = ShellMaterial {
            law: nature.hardening.map_or(law.clone(), |hardening| law.yielding(hardening)),
            density: material.density,
            thickness: wall.thickness.clone(),
            strength: (0..surface.points()).map(strength).collect(),
            softening_cells: SOFTENING_CELLS,
        };
        let mut domain = ShellDomain::new(surface, shell, level);
        // The mesh's mass, whatever the cells make of it.
        let volume = |p: usize| domain.state(p).area * domain.state(p).thickness;
        let volume: f64 = domain.live().map(volume).sum();
        domain.scale_mass(local.solid.mesh.signed_volume() / volume);
        for (point, score) in scores {
            if !domain.is_on(point) {
                continue;
            }
            domain.change(point, |state| state.score = score);
        }
        let schedule = ShellSchedule::new(&local, metal);
        let heavier = match wall.is_flat {
            true => 0.0,
            false => {
                let step = wall.step(&domain.surface.steps, material);
                let most = f64::from(local.settings.max_steps);
                steady(&mut domain, step, (schedule.end, most))?
            }
        };
        let strikers: Vec<ShellStriker> = local
            .impacts
            .iter()
            .map(|hit| ShellStriker::new(hit, &local, &domain, wall.typical, &schedule))
            .collect();
        for striker in &strikers {
            shield(&mut domain, striker, wall.typical);
        }
        let support = |support| ShellSupport::new(support, &domain, material, spacing);
        let mut supports: Vec<_> = local.supports.iter().map(support).collect();
        contact::soften(&mut supports, &domain);
        let (record, settling) = (ShellRecord::default(), KineticDamping::default());
        let mut solve =
            Self { record, settling, local, wall, nature, domain, strikers, supports, schedule };
        solve.record.warnings = solve.first_warnings(heavier);
        Ok(solve)
    }

    /// As [`Solver::advance`].
    pub fn advance(&mut self) -> Progress {
        let slice = (SLICE / self.domain.mass.len().max(1) as u64).max(1);
        for _ in 0..slice {
            let done = match self.step() {
                Ok(()) if self.is_over() => self.close(),
                other => other.map(|()| None),
            };
            match done {
                Ok(None) => {}
                Ok(Some(outcome)) => return Progress::Done(outcome),
                Err(failure) => return Progress::Failed(failure),
            }
        }
        Progress::Running((self.record.time / self.schedule.end).min(1.0))
    }

    /// Lets go of what swings: whether the wall is at rest.
    fn settle(&mut self) -> bool {
        let (_, places) = self.domain.node_places();
        self.settling.look(&self.domain.mass, &places, &mut self.domain.velocity)
    }

    /// After the hits: what comes of them, or nothing while metal still swings.
    fn close(&mut self) -> Result<Option<SolveOutcome>, Failure> {
        if self.nature.hardening.is_none() {
            return self.finish_treated().map(|fracture| Some(fracture.into()));
        }
        match !self.is_dented() || self.settle() {
            true => self.finish_metal().map(Some),
            false => Ok(None),
        }
    }

    fn step(&mut self) -> Result<(), Failure> {
        let time = self.record.time;
        for striker in &mut self.strikers {
            striker.push(&mut self.domain, time);
        }
        for support in &mut self.supports {
            support.push(&mut self.domain);
        }
        let tally = self.domain.advance(|_, v| v);
        let record = &mut self.record;
        record.time += self.domain.step;
        record.steps += 1;
        record.dissipated += tally.points.dissipated;
        record.met += tally.met;
        record.broken += tally.points.broken;
        let points = self.domain.points() as f64;
        if f64::from(record.broken - record.grown_then) > schedule::GROWTH * points {
            (record.last_growth, record.grown_then) = (record.time, record.broken);
        }
        if record.steps.is_multiple_of(CHECK) {
            self.check()?;
        }
        Ok(())
    }

    /// Energy that the strikers have lost and the supports hold \[J\].
    fn given(&self) -> f64 {
        let lost: f64 = self.strikers.iter().map(ShellStriker::lost).sum();
        let added = self.domain.added_energy();
        lost + added - self.supports.iter().map(ShellSupport::stored).sum::<f64>()
    }

    fn check(&mut self) -> Result<(), Failure> {
        let (sums, step) = (self.domain.sums(), self.record.steps);
        let lost = self.record.dissipated + self.record.met + self.settling.taken;
        let found = sums.kinetic + sums.elastic + lost;
        let given = self.given();
        let scale: f64 = self.local.impacts.iter().map(|hit| hit.energy).sum();
        if !found.is_finite() {
            return Err(Failure::NotFinite { what: "the shell's energy", step });
        }
        let off = (found - given) / scale;
        if off.abs() > self.record.energy_off.abs() {
            self.record.energy_off = off;
        }
        if off > UNSTABLE {
            return Err(Failure::Unstable { ratio: off, step });
        }
        Ok(())
    }

    fn is_over(&mut self) -> bool {
        if self.is_dicing() {
            return true;
        }
        if self.strikers.iter().any(|striker| !striker.is_over()) {
            return false;
        }
        let time = self.record.time;
        let push = *self.record.push_over.get_or_insert(time);
        let quiet = time - self.record.last_growth.max(push);
        quiet > self.schedule.quiet || time > push + self.schedule.after
    }

    fn finish(&mut self) -> Result<Fragmentation, Failure> {
        self.check()?;
        self.finish_field(field::ShellField::new(self))
    }

    /// Where something pushed \[m\], and what it gave \[N·s\].
    fn pushes(&self) -> Vec<(Vec3, Vec3)> {
        let hits = self.strikers.iter().zip(&self.local.impacts);
        let hits = hits.map(|(striker, hit)| (hit.point, hit.normal * striker.delivered()));
        hits.chain(self.supports.iter().map(ShellSupport::given)).collect()
    }

    /// What each support gave \[N·s\].
    fn reactions(&self) -> Vec<f64> {
        self.supports.iter().map(|one| one.given().1.norm()).collect()
    }

    /// The exact cut along what is known of the points.
    fn finish_field(&self, found: field::ShellField) -> Result<Fragmentation, Failure> {
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

/// Makes small cells heavier, so that steps of `step` \[s\] hold, or else of a part of it; the mass
/// that this adds, over that of the shell \[1\].
fn steady<R: Real, const N: usize>(
    domain: &mut ShellDomain<R, N>,
    step: f64,
    (end, limit): (f64, f64),
) -> Result<f64, Refusal> {
    let (shares, most) = match domain.law.hardening {
        None => (&STEPS[..], MOST_ADDED),
        Some(_) => (&STEPS[..1], MOST_ADDED_TO_METAL),
    };
    for share in shares {
        let value = end / (share * step);
        if *share < 1.0 && value > limit {
            return Err(Refusal::TooLarge { what: "the number of steps", value, limit });
        }
        if let Some(added) = domain.steady(share * step, most) {
            return Ok(added);
        }
    }
    let lack = format!("its cells are so uneven that over {most} of its mass would be added");
    Err(Refusal::Unfit { solver: ShellSolver::NAME, lack })
}

/// Strength of a place as large as its flaws are correlated over that of a bending test's face, by
/// Weibull's (A₀/A)^(1/m)  \[1\].
fn place_factor(strength: &StrengthField, spacing: f64) -> f64 {
    let length = strength.correlation.unwrap_or(0.0).max(CORRELATION * spacing);
    libm::pow(TESTED_AREA / (length * length), 1.0 / strength.weibull)
}

/// Keeps the middle of a contact whole, where a shell overstates the stress: what is under a
/// striker is pressed together, goes on carrying it, and parts from the rest at its rim.
fn shield<R: Real, const N: usize>(
    domain: &mut ShellDomain<R, N>,
    striker: &ShellStriker,
    thickness: f64,
) {
    let PressedPoints { place, radius, .. } = striker.patch();
    let (place, reach) = (*place, radius.max(NEAR * thickness));
    for point in domain.live() {
        let far = (domain.surface.surface_point(point).place - place).norm();
        if far <= reach {
            domain.change(point, |state| state.flaw = f64::INFINITY);
        }
    }
}
