//! The families, one file each, and the table of them.

pub mod brittle;
pub mod geometric;

use crate::solver::{Problem, Progress, Refusal, Solver};

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
    /// [`Solver::begin`], after [`Solver::accepts`].
    pub begin: fn(Problem) -> Result<Box<dyn Run>, Refusal>,
}

const fn entry<S: Solver>() -> Entry {
    Entry {
        name: S::NAME,
        begin: |problem| {
            S::accepts(&problem)?;
            Ok(Box::new(S::begin(problem)?))
        },
    }
}

/// Every family.
pub const SOLVERS: &[Entry] = &[entry::<brittle::Brittle>(), entry::<geometric::Geometric>()];

/// The family of that name.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static Entry> {
    SOLVERS.iter().find(|entry| entry.name == name)
}
