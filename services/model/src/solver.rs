//! The contract between a problem and the ways to solve it.

use crate::{Outcome, Precision, Problem};

/// Why a problem is not for this solver. Normal: another tier takes it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A section is thinner than the grid can bend (F14).
    #[error(
        "too thin: the body is {thickness:.3e} m thick, {cells:.2} cells; \
         at least {minimum} are needed"
    )]
    TooThin {
        /// Typical thickness \[m\].
        thickness: f64,
        /// Thickness over spacing \[1\].
        cells: f64,
        /// Fewest cells accepted.
        minimum: f64,
    },
    /// A body or a law that the family does not know.
    #[error("`{solver}` takes no {kind} as {what}")]
    Unknown {
        /// The family.
        solver: &'static str,
        /// A body or a law.
        what: &'static str,
        /// Of what kind.
        kind: &'static str,
    },
    /// The problem would exceed a limit.
    #[error("too large: {what} would be {value:.3e}, the limit is {limit:.3e}")]
    TooLarge {
        /// What would be too large.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The bound.
        limit: f64,
    },
    /// A part of a specimen takes nothing of the body.
    #[error("{what} {number} takes nothing: nothing of the body lies where it is")]
    Idle {
        /// What takes nothing.
        what: &'static str,
        /// Which, in the order in which they are given, from 1.
        number: usize,
    },
    /// An input is outside what the method holds for.
    #[error("{what} is {value:.3e}; it must lie in [{low:.3e}, {high:.3e}]")]
    OutOfRange {
        /// Which input.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
}

/// Numerics that went wrong. Recorded, never hidden.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A number stopped being one (F76).
    #[error("a value of {what} is not finite at step {step}")]
    NotFinite {
        /// Which field.
        what: &'static str,
        /// When.
        step: u64,
    },
    /// Energy appeared from nowhere (F04).
    #[error("there is {ratio:.3} more energy than the strikers have lost at step {step}")]
    Unstable {
        /// Excess over what the strikers have lost \[1\].
        ratio: f64,
        /// When.
        step: u64,
    },
    /// The step budget ran out before the solve was over.
    #[error("not finished after {steps} steps")]
    OutOfSteps {
        /// The budget.
        steps: u64,
    },
    /// The cut did not close or did not add up.
    #[error("the cut failed: {0}")]
    Cut(String),
}

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
    Done(Outcome),
    /// Numerics went wrong.
    Failed(Failure),
}

/// One way to break a body. A family implements this in a crate of its own and has one line in the
/// worker's table.
pub trait Solver: Sized + 'static {
    /// Name on the wire, in charts, in recordings. Never reused for another method.
    const NAME: &'static str;
    /// What its points may be worked out in.
    const PRECISIONS: &'static [Precision];
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
pub trait Run {
    /// See [`Solver::advance`].
    fn advance(&mut self) -> Progress;
}

impl<S: Solver> Run for S {
    fn advance(&mut self) -> Progress {
        Solver::advance(self)
    }
}

/// One line of the table.
pub struct Entry {
    /// [`Solver::NAME`].
    pub name: &'static str,
    /// [`Solver::PRECISIONS`].
    pub precisions: &'static [Precision],
    /// [`Solver::begin`], after [`Solver::accepts`].
    pub begin: fn(Problem) -> Result<Box<dyn Run>, Refusal>,
}

/// The line of a family.
#[must_use]
pub const fn entry<S: Solver>() -> Entry {
    Entry {
        name: S::NAME,
        precisions: S::PRECISIONS,
        begin: |problem| {
            S::accepts(&problem)?;
            Ok(Box::new(S::begin(problem)?))
        },
    }
}
