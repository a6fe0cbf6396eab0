//! From a damage field to closed fragments: the crack between labels of lattice nodes, regions, the
//! cut of the body, sampled pieces of crushed zones, debris. Also what a body that was bent has of
//! the motion of the whole, how its surface goes along, and what rigid strikers and supports do to
//! it.
//!
//! How many pieces there are, where, and what stays whole, where the scene asks for it
//! ([`directed`]).
//!
//! Absent on purpose: how the damage came about.

pub mod carriers;
pub mod crack;
pub mod cut;
pub mod debris;
pub mod directed;
pub mod error;
pub mod field;
pub mod finish;
pub mod grid_bias;
pub mod kinetic_damping;
pub mod motion;
pub mod pieces;
pub mod press;
pub mod pressed_body;
pub mod region;
pub mod reshaped;
pub mod straightened;
pub mod surface_particles;
