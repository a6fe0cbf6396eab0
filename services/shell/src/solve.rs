//! A hit on a thin wall, flat or curved, solved as a shell: striker and supports on the midsurface,
//! cracks, then the exact cut of the body along them.

mod contact;
mod cracked;
mod crushed;
mod deformed;
mod field;
mod frame;
mod laminated;
mod nature;
mod preconditions;
mod report;
mod run;
mod scatter;
mod schedule;
mod toughened;
mod treated;
mod wall;

pub(crate) use preconditions::{SLENDER, neither, refusal};
pub use run::ShellSolve;
pub(crate) use wall::SOFTENING_CELLS;

use crate::midsurface::Midsurface;
use cullet_model::{
    BrittleProblem, Cost, Failure, PointPrecision, Problem, Progress, Refusal, SolveOutcome, Solver,
};
use cullet_simd::{Real, SimdLevel};
use nature::WallNature;
use preconditions::{ShellPlan, ThinBody, wall_surface};
use wall::ThinWall;

/// Control-point-steps of a slice: some tens of milliseconds.
const SLICE: u64 = 200_000;

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
    const NAME: &'static str = run::NAME;
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

impl<R: Real, const N: usize> ShellSolve<R, N> {
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
}
