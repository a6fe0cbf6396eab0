//! The brittle family: a total-Lagrangian material point method with a local phase field. Read
//! [`brittle`] first, then [`mpm`].
//!
//! Absent on purpose: files, clocks, wires, log lines, rigid bodies. A solver is a pure function of
//! its problem.

pub mod brittle;
pub mod damage;
pub mod mpm;
pub mod particles;
pub mod specimen;

pub use brittle::Brittle;
