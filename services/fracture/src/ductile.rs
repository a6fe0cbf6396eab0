//! Ductile solids: the material point method of the brittle family with J2 flow in place of cracks.
//! Strikers and supports are rigid and press on the surface; what comes of a hit is a dent.

mod settling;
mod shape;
#[cfg(test)]
mod tests;
mod torn;

use crate::damage::Softening;
use crate::mpm::domain::stable_step;
use crate::mpm::load_patch::LEAST_RADIUS;
use crate::mpm::preconditions::{
    check_impacts, check_supports, check_thickness, choose_spacing, sample_points, within,
};
use crate::mpm::{Domain, motion, quadrature};
use crate::particles::Particles;
use cullet_fragment::press::{RigidPress, share_out};
use cullet_fragment::surface_particles::SurfaceParticles;
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;
use cullet_model::brittle::POINTS_PER_CELL;
use cullet_model::{
    BrittleProblem, Cost, EnergyAccount, EnergyBalance, Failure, JohnsonCook, Material,
    PointPrecision, Problem, Progress, Refusal, SolveOutcome, Solver,
};
use cullet_simd::SimdLevel;
use settling::PieceSettling;

/// Fewest and most points, and bytes that one needs with its share of arenas and nodes.
const LEAST_PARTICLES: f64 = 200.0;
const MOST_PARTICLES: f64 = 8e6;
const BYTES: f64 = 1000.0;

/// Particle-steps of a slice: some tens of milliseconds.
const SLICE: u64 = 100_000;

/// Steps between checks of the energy, and of whether the push is over.
const CHECK: u64 = 64;
const LOOK: u64 = 16;

/// Share of points that may be crushed before the numbers mean nothing (F07).
const CRUSHED_SHARE: f64 = 0.02;

/// How often an unstable solve is begun again with half the step (F76).
const HALVINGS: u32 = 2;

/// Transits L/c_s: that a push may take; that a striker has parted, or that nothing flows, after
/// which it is over; and until the body is at rest.
const PUSH_TRANSITS: f64 = 100.0;
const APART_TRANSITS: f64 = 1.0;
const QUIET_TRANSITS: f64 = 4.0;
const REST_TRANSITS: f64 = 20.0;

/// Greatest eigenvalue of C⁻¹ that the step follows: a point is then a twentieth as thick as it
/// was, and its weights, which are those of the body at rest, say little \[1\].
const THINNEST: f64 = 400.0;

/// Share of the energy of the hits below which flow counts as none \[1\].
const NO_FLOW: f64 = 1e-3;

/// Transits that a typical push takes, for the estimate of the cost.
const TYPICAL_TRANSITS: f64 = 20.0;

/// Yield stress over Young's modulus that the elastic law holds for \[1\].
const MOST_ELASTIC: f64 = 0.1;

/// The ductile family.
#[derive(Debug)]
pub struct Ductile {
    problem: BrittleProblem,
    flow: JohnsonCook,
    domain: Domain,
    points: SurfaceParticles,
    strikers: Vec<RigidPress>,
    supports: Vec<RigidPress>,
    /// L/c_s \[s\].
    transit: f64,
    setup: FlowSetup,
    settling: PieceSettling,
    record: FlowRecord,
}

/// How a solve is done.
#[derive(Clone, Copy, Debug)]
struct FlowSetup {
    /// Step of the undeformed body \[s\].
    step: f64,
    simd_level: SimdLevel,
    /// How often it was begun again with half the step.
    halvings: u32,
}

/// What a solve has seen so far.
#[derive(Debug)]
struct FlowRecord {
    /// Plastic work \[J\].
    plastic: f64,
    /// Energy that tearing took beside that \[J\].
    torn: f64,
    /// Energy that the sides of tears lost as they met \[J\].
    collided: f64,
    /// When so much more had flowed as counts, and the plastic work then \[s\], \[J\].
    flowed: (f64, f64),
    /// Greatest eigenvalue of C⁻¹ so far \[1\].
    thinnest: f64,
    /// Greatest |v|² of a node \[m²/s²\].
    fastest: f64,
    crushed: u32,
    /// Points that tore.
    broken: u32,
    /// Of these, those that were drawn out farther than the grid follows.
    shredded: u32,
    push_over: Option<f64>,
    balance: EnergyBalance,
    warnings: Vec<String>,
}

impl Solver for Ductile {
    const NAME: &'static str = "ductile";
    const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Single, PointPrecision::Double];

    fn accepts(problem: &Problem) -> Result<Cost, Refusal> {
        let (problem, flow) = BrittleProblem::yielding(problem.clone(), Self::NAME)?;
        estimate_cost(&problem, &flow)
    }

    fn begin(problem: Problem) -> Result<Self, Refusal> {
        let (problem, flow) = BrittleProblem::yielding(problem, Self::NAME)?;
        Self::with(problem, flow, SimdLevel::best())
    }

    fn advance(&mut self) -> Progress {
        let slice = (SLICE / self.domain.particles.len().max(1) as u64).max(1);
        for _ in 0..slice {
            let done = match self.step() {
                Ok(()) if self.is_over() => self.close(),
                other => other.map(|()| None),
            };
            match done {
                Ok(None) => {}
                Ok(Some(outcome)) => return Progress::Done(outcome),
                Err(failure) => match self.again(&failure) {
                    Some(again) => *self = again,
                    None => return Progress::Failed(failure),
                },
            }
        }
        Progress::Running((self.domain.time / (PUSH_TRANSITS * self.transit)).min(0.99))
    }
}

/// What a problem would cost, or the bound that it breaks.
fn estimate_cost(problem: &BrittleProblem, flow: &JohnsonCook) -> Result<Cost, Refusal> {
    let Material { density, young, poisson, .. } = problem.material;
    within("density [kg/m^3]", density, 1e-3, 1e6)?;
    within("Young's modulus [Pa]", young, 1.0, 1e14)?;
    within("Poisson's ratio", poisson, 0.0, 0.49)?;
    let ratio = flow.hardening.yield_stress / young;
    within("yield stress over Young's modulus", ratio, 1e-6, MOST_ELASTIC)?;
    check_impacts(&problem.impacts)?;
    check_supports(&problem.supports)?;
    let spacing = choose_spacing(problem)?;
    let volume = problem.solid.mesh.signed_volume();
    let particles = POINTS_PER_CELL * volume / spacing.product();
    within("the number of particles", particles, LEAST_PARTICLES, f64::INFINITY)?;
    let most = f64::from(problem.settings.max_particles).min(MOST_PARTICLES);
    let too_large = |what, value, limit| Err(Refusal::TooLarge { what, value, limit });
    if particles > 1.05 * most {
        return too_large("the number of particles", particles, most);
    }
    let steps = TYPICAL_TRANSITS * transit(problem) / time_step(problem, &spacing);
    let limit = f64::from(problem.settings.max_steps);
    if steps > limit {
        return too_large("the number of steps", steps, limit);
    }
    Ok(Cost { particles, steps, bytes: particles * BYTES })
}

fn transit(problem: &BrittleProblem) -> f64 {
    problem.solid.mesh.diagonal() / problem.material.shear_speed()
}

fn time_step(problem: &BrittleProblem, spacing: &Vec3) -> f64 {
    problem.settings.tolerance().step() * stable_step(&problem.material, spacing.min())
}

impl Ductile {
    /// Like `begin`, with other instructions of the processor.
    ///
    /// # Errors
    /// If the problem is not for this solver.
    pub fn with(
        problem: BrittleProblem,
        flow: JohnsonCook,
        simd_level: SimdLevel,
    ) -> Result<Self, Refusal> {
        estimate_cost(&problem, &flow)?;
        let spacing = choose_spacing(&problem)?;
        let mesh = &problem.solid.mesh;
        let points = sample_points(&problem, &spacing)?;
        within("the number of particles", points.len() as f64, LEAST_PARTICLES, 1e9)?;
        check_thickness(&problem, &points, &spacing)?;
        let material = &problem.material;
        let mut particles = Particles::at_rest(&points, mesh.signed_volume(), material.density);
        let inside = Inside::new(mesh);
        particles.volume = quadrature::volumes(&points, &inside, spacing, mesh.signed_volume());
        let softening = Softening::on_grid(material, spacing.max());
        let mut domain = Domain::new(particles, material, softening, spacing);
        domain.let_flow(material, &flow);
        domain.select(problem.settings.precision, simd_level);
        let step = time_step(&problem, &spacing);
        domain.step = step;
        let ids = 0..domain.particles.len() as u32;
        let first = ids.map(|id| domain.particles.reference[domain.slot(id)]);
        let surface = SurfaceParticles::new(first, domain.grid.spacing.max(), mesh);
        let least = LEAST_RADIUS * surface.spacing;
        let hits = problem.impacts.iter().map(|hit| {
            let own = motion::mobility(&problem, &hit.point, &hit.normal);
            RigidPress::striker(hit, own, mesh, least)
        });
        let mut strikers: Vec<RigidPress> = hits.collect();
        let mut supports: Vec<RigidPress> =
            problem.supports.iter().map(|it| RigidPress::support(it, least)).collect();
        let all = strikers.iter_mut().chain(&mut supports);
        all.for_each(|press| press.put(material.young, &surface, &domain, step));
        share_out(&mut supports, &surface, &domain);
        let mut made = Self {
            transit: transit(&problem),
            problem,
            flow,
            domain,
            points: surface,
            strikers,
            supports,
            setup: FlowSetup { step, simd_level, halvings: 0 },
            settling: PieceSettling::default(),
            record: FlowRecord {
                plastic: 0.0,
                torn: 0.0,
                collided: 0.0,
                flowed: (0.0, 0.0),
                thinnest: 1.0,
                fastest: 0.0,
                crushed: 0,
                broken: 0,
                shredded: 0,
                push_over: None,
                balance: EnergyBalance::default(),
                warnings: Vec::new(),
            },
        };
        made.record.warnings = made.first_warnings();
        Ok(made)
    }

    /// The solve from its beginning with half the step, where numbers went wrong (F76).
    fn again(&self, failure: &Failure) -> Option<Self> {
        let numbers = matches!(failure, Failure::NotFinite { .. } | Failure::Unstable { .. });
        if !numbers || self.setup.halvings == HALVINGS {
            return None;
        }
        let mut problem = self.problem.clone();
        problem.settings.precision = PointPrecision::Double;
        let mut fresh = Self::with(problem, self.flow, self.setup.simd_level).ok()?;
        fresh.setup.halvings = self.setup.halvings + 1;
        fresh.setup.step /= f64::from(1_u32 << fresh.setup.halvings);
        let step = fresh.setup.step;
        fresh.domain.step = step;
        let warning = format!("{failure}: solved again with steps of {step:.3e} s (F76)");
        fresh.record.warnings.push(warning);
        Some(fresh)
    }

    /// Of the hits \[J\].
    fn energy(&self) -> f64 {
        self.problem.impacts.iter().map(|hit| hit.energy).sum()
    }

    /// Whether the budget of steps is spent.
    fn is_spent(&self) -> bool {
        self.domain.steps >= u64::from(self.problem.settings.max_steps)
    }

    fn step(&mut self) -> Result<(), Failure> {
        let energy = self.energy();
        self.domain.step = self.setup.step / self.record.thinnest.min(THINNEST).sqrt();
        let fastest = self.record.fastest.sqrt();
        if self.record.push_over.is_none() {
            for press in self.strikers.iter_mut().chain(&mut self.supports) {
                press.push(&mut self.domain, &self.points, fastest);
            }
        }
        let tally = self.domain.advance();
        let record = &mut self.record;
        record.plastic += tally.plastic;
        record.torn += tally.dissipated;
        record.collided += tally.collided;
        record.broken += tally.broken;
        record.shredded += tally.shredded;
        let tears = tally.broken > 0;
        if record.plastic > record.flowed.1 + NO_FLOW * energy {
            record.flowed = (self.domain.time, record.plastic);
        }
        record.thinnest = record.thinnest.max(tally.thinnest);
        record.fastest = record.fastest.max(tally.fastest);
        record.crushed = record.crushed.max(tally.crushed);
        let share = f64::from(tally.crushed) / self.domain.particles.len() as f64;
        if share > CRUSHED_SHARE {
            return Err(Failure::Unstable { ratio: share, step: self.domain.steps });
        }
        if tears {
            self.lay_open();
        }
        if self.domain.steps.is_multiple_of(CHECK) {
            self.check()?;
        }
        Ok(())
    }

    /// Lets strikers touch what the tears of the last step have laid open.
    fn lay_open(&mut self) {
        for id in self.domain.laid_open() {
            self.points.lay_open(id);
        }
        for press in &mut self.strikers {
            press.meet(&self.points, &self.domain);
        }
    }

    fn presses(&self) -> impl Iterator<Item = &RigidPress> {
        self.strikers.iter().chain(&self.supports)
    }

    fn check(&mut self) -> Result<(), Failure> {
        let account = EnergyAccount {
            given: self.presses().map(|it| it.lost - it.stored - it.crushed).sum(),
            broken: self.record.torn,
            flowed: self.record.plastic,
            met: self.record.collided,
            damped: self.settling.taken(),
            ..self.domain.energy()
        };
        let lost: f64 = self.strikers.iter().map(|it| it.lost).sum();
        self.record.balance.look(&account, self.energy().max(lost), self.domain.steps)
    }

    /// Whether nothing is to come from outside any more: each striker has given all, or has parted
    /// for a while and does not come on, and each support has parted, or what presses makes nothing
    /// flow; or the push took longer than any should.
    fn is_over(&mut self) -> bool {
        if self.record.push_over.is_some() {
            return true;
        }
        let time = self.domain.time;
        let late = time > PUSH_TRANSITS * self.transit || self.is_spent();
        if !late && !self.domain.steps.is_multiple_of(LOOK) {
            return false;
        }
        let whole = self.domain.momentum() / self.domain.grid.nodes.mass.iter().sum::<f64>();
        // What is pressed and flows no further goes along with its striker.
        let (last, work) = self.record.flowed;
        let quiet = work > 0.0 && time - last > QUIET_TRANSITS * self.transit;
        let apart =
            |it: &RigidPress| time - it.touched.unwrap_or(0.0) > APART_TRANSITS * self.transit;
        let rests = |it: &RigidPress| apart(it) || quiet;
        // What is pierced lets its striker go on.
        let torn = self.record.broken > 0;
        let parted = |it: &RigidPress| {
            let comes_on = match torn {
                true => it.comes_on(&self.points, &self.domain),
                false => it.speed > whole.dot(&it.normal),
            };
            it.left <= 0.0 || if apart(it) { !comes_on } else { quiet }
        };
        let over = self.strikers.iter().all(parted) && self.supports.iter().all(rests);
        if !over && late {
            self.record.warnings.push(format!(
                "still pushed after {:.0} of a wave's ways through the body and {} steps: ended \
                 there",
                time / self.transit,
                self.domain.steps
            ));
        }
        if over || late {
            // Springs that are let go of take what they hold with them.
            self.record.push_over = Some(time);
        }
        over || late
    }

    /// After the push: what comes of it, or nothing while the body still swings.
    fn close(&mut self) -> Result<Option<SolveOutcome>, Failure> {
        let since = self.domain.time - self.record.push_over.unwrap_or(0.0);
        let late = since > REST_TRANSITS * self.transit || self.is_spent();
        if late || !self.is_dented() || self.settling.settle(&mut self.domain, self.record.broken) {
            return self.finish().map(Some);
        }
        Ok(None)
    }

    /// Where nodes were before the hit and where they are now \[m\].
    fn node_places(&self) -> (Vec<Vec3>, Vec<Vec3>) {
        let first: Vec<Vec3> =
            (0..self.domain.grid.nodes.len()).map(|n| self.domain.grid.place(n)).collect();
        let moved = self.domain.node_displacements();
        let now = first.iter().zip(moved).map(|(x, u)| x + u).collect();
        (first, now)
    }
}
