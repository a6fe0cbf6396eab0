//! A hit on a thin wall, step by step.

use super::contact::{self, PressedPoints, ShellStriker, ShellSupport};
use super::frame;
use super::nature::WallNature;
use super::preconditions::{ShellPlan, ThinBody};
use super::schedule::{self, ShellSchedule};
use super::wall::{SOFTENING_CELLS, ThinWall};
use crate::domain::{ShellDomain, ShellMaterial};
use crate::midsurface::Midsurface;
use crate::section::SectionLaw;
use crate::treatment;
use cullet_fragment::kinetic_damping::KineticDamping;
use cullet_geometry::Vec3;
use cullet_model::strength::CORRELATION;
use cullet_model::{BrittleProblem, Failure, Refusal, Strength, StrengthField, Treatment};
use cullet_simd::{Real, SimdLevel};
/// Name of the family.
pub(super) const NAME: &str = "shell";

/// Steps between looks at the energy.
const CHECK: u64 = 64;

/// Excess of energy over what was given, above which a solve has failed \[1\].
const UNSTABLE: f64 = 0.1;

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

/// Mass added to small cells, over that of the body, above which it is worth a word \[1\].
const HEAVIER: f64 = 0.01;

/// A thin wall under its hits, whose cells have `N` functions, worked out in `R`.
#[derive(Debug)]
pub struct ShellSolve<R: Real, const N: usize> {
    /// In the frame of the solve.
    pub(super) local: BrittleProblem,
    pub(super) wall: ThinWall,
    pub(super) nature: WallNature,
    pub(super) domain: ShellDomain<R, N>,
    pub(super) strikers: Vec<ShellStriker>,
    pub(super) supports: Vec<ShellSupport>,
    pub(super) schedule: ShellSchedule,
    pub(super) settling: KineticDamping,
    pub(super) record: ShellRecord,
}

/// What a solve has seen so far.
#[derive(Debug, Default)]
pub(super) struct ShellRecord {
    pub(super) time: f64,
    pub(super) steps: u64,
    pub(super) dissipated: f64,
    pub(super) met: f64,
    pub(super) broken: u32,
    pub(super) last_growth: f64,
    pub(super) grown_then: u32,
    pub(super) push_over: Option<f64>,
    /// Energy found less energy given, over that of the hits, where it was most \[1\].
    pub(super) energy_off: f64,
    pub(super) warnings: Vec<String>,
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
            return Err(Refusal::Unfit { solver: NAME, lack });
        };
        let wall = ThinWall::of_plate(&plate, problem, spacing)?;
        let nature = WallNature { treatment, hardening: None };
        Self::of_wall(problem, nature, wall, level)
    }
}

impl<R: Real, const N: usize> ShellSolve<R, N> {
    pub(super) fn of_wall(
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

    /// Lets go of what swings: whether the wall is at rest.
    pub(super) fn settle(&mut self) -> bool {
        let (_, places) = self.domain.node_places();
        self.settling.look(&self.domain.mass, &places, &mut self.domain.velocity)
    }

    pub(super) fn step(&mut self) -> Result<(), Failure> {
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

    pub(super) fn check(&mut self) -> Result<(), Failure> {
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

    pub(super) fn is_over(&mut self) -> bool {
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

    /// Whether the plate dices: it is cut through somewhere, and holds what pays for it.
    pub(super) fn is_dicing(&self) -> bool {
        let (material, t) = (&self.local.material, self.wall.typical);
        self.record.broken > 0 && treatment::dices(material, self.nature.treatment.as_ref(), t)
    }

    /// Where something pushed \[m\], and what it gave \[N·s\].
    pub(super) fn pushes(&self) -> Vec<(Vec3, Vec3)> {
        let hits = self.strikers.iter().zip(&self.local.impacts);
        let hits = hits.map(|(striker, hit)| (hit.point, hit.normal * striker.delivered()));
        hits.chain(self.supports.iter().map(ShellSupport::given)).collect()
    }

    /// What each support gave \[N·s\].
    pub(super) fn reactions(&self) -> Vec<f64> {
        self.supports.iter().map(|one| one.given().1.norm()).collect()
    }

    fn first_warnings(&self, heavier: f64) -> Vec<String> {
        let mut warnings = Vec::new();
        let tip = self.domain.tip_strength(self.wall.spacing);
        let strength = self.local.material.failure_stress;
        if tip < strength && self.nature.hardening.is_none() {
            warnings.push(format!(
                "toughness-controlled: cracks grow at {:.3} of the material's strength at this \
                 spacing (F01)",
                tip / strength
            ));
        }
        if heavier > HEAVIER {
            warnings.push(format!(
                "small cells: {heavier:.3} of the mass was added to them so that they need no \
                 smaller step"
            ));
        }
        warnings
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
    Err(Refusal::Unfit { solver: NAME, lack })
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
