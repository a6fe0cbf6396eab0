//! What a sheet of points looks like: a surface between its points that opens along its cracks.
//!
//! The points are triangulated once, with a row of vertices on the outline. Whole triangles are
//! drawn as they are. A triangle that a crack runs through is drawn as the cells of its corners:
//! the crack crosses each broken side in the middle and meets in the middle of the triangle, and
//! each cell moves with its own point. Sides that hold stay in one, so the triangles beyond them
//! need no division. The line of a crack is smoothed at rest, once for both of its lips, so they
//! fit when it closes, and no area comes or goes.

mod crack;
mod torn;
mod triangulation;

#[cfg(test)]
mod tests;

pub use torn::{SurfaceTie, TornSurface};
pub use triangulation::SheetTriangulation;
