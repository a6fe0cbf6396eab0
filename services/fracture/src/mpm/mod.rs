//! Total-Lagrangian MLS-MPM: quadratic B-splines in the frame before the hit, nodes that carry the
//! state, a velocity field for each side of a crack.
//!
//! A step takes strain and stress at the points, sums their forces at the nodes, moves the nodes.
//! Every sum has a fixed order, so the bits do not depend on the number of threads (F75).

pub(crate) mod contact;
pub mod crushed;
pub mod domain;
pub(crate) mod door;
pub mod elastic;
pub mod footing;
mod front;
pub mod grid;
pub mod kernel;
mod knots;
mod lattice;
pub mod load;
pub mod motion;
mod parting;
pub mod quadrature;
pub mod rest;
mod separation;
pub mod spin;
pub mod spring;
pub mod watch;

pub use cullet_geometry::symmetric;
pub use domain::{Domain, Tally};
