//! Total-Lagrangian MLS-MPM: quadratic B-splines in the frame before the hit, nodes that carry the
//! state, a velocity field for each side of a crack.
//!
//! A step takes strain and stress at the points, sums their forces at the nodes, moves the nodes.
//! Every sum has a fixed order, so the bits do not depend on the number of threads (F75).

mod bonds;
mod clusters;
pub(crate) mod contact;
pub mod crushed;
pub mod diagnostics;
pub mod domain;
pub mod elastic;
pub mod elastic_support;
pub mod flow;
mod front;
pub mod grid;
pub mod kernel;
mod lattice;
pub mod load;
pub mod load_patch;
pub mod motion;
mod node_split;
pub(crate) mod point_damage;
pub(crate) mod preconditions;
pub mod quadrature;
pub mod spin;
pub mod stencil;
pub mod tally;

pub use cullet_geometry::symmetric;
pub use domain::Domain;
pub use tally::DomainTally;
