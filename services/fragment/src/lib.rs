//! From a damage field to closed fragments: the crack between labels of lattice nodes, regions, the
//! cut of the body, sampled pieces of crushed zones, debris.
//!
//! Absent on purpose: how the damage came about.

pub mod crack;
pub mod cut;
pub mod debris;
pub mod error;
pub mod field;
pub mod finish;
pub mod grid_bias;
pub mod motion;
pub mod pieces;
pub mod region;
