//! What every family of fracture solvers shares: the body, its material, its hits and supports, the
//! settings of a solve, what comes of it, and the [`Solver`] trait. Read [`solver`] first.
//!
//! Absent on purpose: how anything is solved.

pub mod detail;
pub mod material;
pub mod precision;
pub mod solver;
pub mod strength;
pub mod tolerance;

pub use detail::Detail;
pub use material::Material;
pub use precision::Precision;
pub use solver::{
    Cost, Entry, Failure, Fracture, Fragment, Grain, Impact, Problem, Progress, Refusal, Report,
    Run, Settings, Solver, Support, entry,
};
pub use strength::{Strength, StrengthField};
pub use tolerance::Tolerance;
