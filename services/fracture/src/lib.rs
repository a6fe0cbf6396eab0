//! Ways to break a body. Read [`solver`] first.
//!
//! Absent on purpose: files, clocks, wires, log lines, rigid bodies. A solver is a pure function of
//! its problem.

pub mod crack;
pub mod cut;
pub mod damage;
pub mod debris;
pub mod detail;
pub mod grid_bias;
pub mod material;
pub mod mpm;
pub mod particles;
pub mod pieces;
pub mod region;
pub mod solver;
pub mod solvers;
pub mod specimen;
pub mod strength;
pub mod tolerance;

pub use debris::Grain;
pub use material::Material;
pub use solver::{
    Cost, Failure, Fracture, Fragment, Impact, Problem, Progress, Refusal, Report, Settings,
    Solver, Support,
};
pub use strength::{Strength, StrengthField};
