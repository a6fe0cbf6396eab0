//! Whether, by which family of solvers and how finely a hit is solved. [`decide()`] answers all
//! three at once; [`Refinement`] then says after each solve whether a finer one follows.
//!
//! A family that has a model of its cost has a file here, such as [`brittle`], and every family has
//! a row in [`family::FAMILIES`].
//!
//! Absent on purpose: clocks. Costs are estimated from the problem, so that a decision is the same
//! on every machine.

pub mod brittle;
mod decide;
mod ductile;
pub mod family;
mod gate;
mod reason;
mod refinement;
mod shell;

pub use brittle::{AccuracyTarget, SolveLimits};
pub use decide::{Decision, Policy, SolveOrder, decide};
pub use gate::{Gate, GateLimits, gate, stressing_spin};
pub use reason::RigidReason;
pub use refinement::{Experience, HitClass, Next, Refinement};
pub use shell::{thin_plate, thin_wall};
