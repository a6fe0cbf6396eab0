//! The contract between a problem and the ways to solve it.

use crate::outcome::SolveOutcome;
use crate::precision::PointPrecision;
use crate::problem::Problem;
use crate::refusal::{Failure, Refusal};

/// An estimate made before any work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Material points.
    pub particles: f64,
    /// Time steps.
    pub steps: f64,
    /// Memory \[bytes\].
    pub bytes: f64,
}

/// How far a solve has come.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Share done \[0, 1\].
    Running(f64),
    /// Finished.
    Done(SolveOutcome),
    /// Numerics went wrong.
    Failed(Failure),
}

/// One way to break a body. A family implements this in a crate of its own and has one line in the
/// worker's table.
pub trait Solver: Sized + 'static {
    /// Name on the wire, in charts, in recordings. Never reused for another method.
    const NAME: &'static str;
    /// What its points may be worked out in.
    const PRECISIONS: &'static [PointPrecision];
    /// What the problem would cost here, or why it is not for this solver.
    ///
    /// # Errors
    /// The bound that the problem breaks.
    fn accepts(problem: &Problem) -> Result<Cost, Refusal>;
    /// Discretise.
    ///
    /// # Errors
    /// As [`Solver::accepts`], for bounds that only show once the body is sampled.
    fn begin(problem: Problem) -> Result<Self, Refusal>;
    /// Advance by one bounded slice; the host looks for cancellation between slices.
    fn advance(&mut self) -> Progress;
}

/// A solve in progress, whatever its family.
pub trait SolveInProgress {
    /// See [`Solver::advance`].
    fn advance(&mut self) -> Progress;
}

impl<S: Solver> SolveInProgress for S {
    fn advance(&mut self) -> Progress {
        Solver::advance(self)
    }
}

/// One line of the worker's table of solvers.
pub struct SolverEntry {
    /// [`Solver::NAME`].
    pub name: &'static str,
    /// [`Solver::PRECISIONS`].
    pub precisions: &'static [PointPrecision],
    /// [`Solver::begin`], after [`Solver::accepts`].
    pub begin: fn(Problem) -> Result<Box<dyn SolveInProgress>, Refusal>,
}

/// The line of a family.
#[must_use]
pub const fn entry<S: Solver>() -> SolverEntry {
    SolverEntry {
        name: S::NAME,
        precisions: S::PRECISIONS,
        begin: |problem| {
            S::accepts(&problem)?;
            Ok(Box::new(S::begin(problem)?))
        },
    }
}
