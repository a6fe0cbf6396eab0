//! The brittle and the ductile family: a total-Lagrangian material point method, with a local phase
//! field or with J2 flow. Read [`brittle`] first, then [`mpm`], then [`ductile`].
//!
//! Absent on purpose: files, clocks, wires, log lines, rigid bodies. A solver is a pure function of
//! its problem.

pub mod brittle;
pub mod damage;
pub mod ductile;
pub mod mpm;
pub mod particles;
pub mod specimen;

pub use brittle::Brittle;
pub use ductile::Ductile;
