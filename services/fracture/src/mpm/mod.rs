//! Updated-Lagrangian MLS-MPM: quadratic B-splines, APIC, f64, blocks with private arenas.
//!
//! A step is scatter (points to arenas), gather of arenas to nodes, and update (nodes to points).
//! Every sum has a fixed order, so the bits do not depend on the number of threads (F75).
//! Absent on purpose: contact, gravity, walls, more than one velocity field.

pub mod basin;
pub mod blocks;
pub mod domain;
pub(crate) mod door;
pub mod elastic;
mod front;
pub mod kernel;
mod lattice;
pub mod load;
pub mod motion;
pub mod quadrature;
pub mod symmetric;
pub mod variation;

pub use domain::{Domain, Tally};
