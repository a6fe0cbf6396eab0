//! Voronoi cells of sites in a box, computed one at a time and yet consistent with one another.
//!
//! A corner of the diagram is named by its [`Key`]: the four generators (sites or walls of the box)
//! that meet there. Every cell that touches a corner finds the same key, because which corners a
//! cell has is decided by exact predicates; and a position is computed from the key alone, so all
//! cells agree on it to the bit. In general position four generators meet at a corner and three at
//! an edge: the boundary of any union of cells is then a closed 2-manifold. The caller owns that
//! general position: sites on a lattice must be jittered (1e-3 to 5e-2 of the spacing is enough);
//! five generators that meet at one point are reported as [`VoronoiError::Degenerate`].
//!
//! Cost: a cell looks at the sites around it in growing distance until no further one can reach it.
//! A site in a wide void looks far; give such voids sparse ghost sites.

mod cells;
mod clip;
mod grid;
mod plane;
mod predicate;
#[cfg(test)]
mod tests;

pub use cells::{Cells, Face, Key, MAX_SITES, VoronoiError, WALL};

impl Cells {
    /// The faces of the cell of `site`. Site `i` has a face with `j` exactly if `j` has one with
    /// `i`, with the same corners in the opposite order.
    ///
    /// # Errors
    /// [`VoronoiError::Degenerate`].
    ///
    /// # Panics
    /// If there is no such site.
    pub fn cell(&self, site: u32) -> Result<Vec<Face>, VoronoiError> {
        clip::cell(self, site)
    }
}
