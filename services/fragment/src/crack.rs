//! From damaged particles to a box divided among labels: the faces between different labels are
//! the crack, a smooth medial surface of the damaged set.
//!
//! Damage is spread to the nodes of a lattice. Undamaged nodes inside the body that connect along
//! lattice edges carry one label; an edge whose middle is outside the body connects nothing, so
//! legs half a spacing apart stay apart. The other nodes take the label that a random walk from
//! them most likely meets first, so labels fill the damaged band from both sides, meet in its
//! middle, and reach outward to the box: the crack crosses the body's surface by itself. A band
//! that ends inside leaves one label around its tip: nothing separates there. Faces between labels
//! have one corner in each cube of eight nodes (surface nets), smoothed inside its cube.

mod damage;
mod front;
mod lattice;
mod net;
mod nodes;
mod odds;
mod partial;
mod sampled;
mod smooth;
#[cfg(test)]
mod tests;
mod walk;

pub use damage::BROKEN;
pub(crate) use lattice::LatticeChoice;
pub(crate) use nodes::LatticeNodes;
