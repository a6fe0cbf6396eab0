//! Soft solids that move for as long as a scene lasts: points and bonds, a window of time at a
//! time ([`window`]).
//!
//! A window is a pure function of a state, which is bytes ([`state`]), and of the rigid bodies in
//! reach, which move inside it with their own mass. Neither the number of threads nor the cut into
//! windows changes a bit.
//!
//! Bonds are those of [`crate::domain`]: each pulls along itself as it is now, so that a body may
//! turn, bend and twist by any angle. Displacements are counted from where the piece of each point
//! is as a whole, so that pieces may fall and fly far.
//!
//! Points lie in a layer under the surface, and relaxed behind it ([`sampling`]):
//! a body rests on another where its surface does. The surface is carried by the points; where
//! bonds have broken it opens along the faces between the cells of points (`surface`), along a
//! prescribed cut in its plane.
//!
//! Absent on purpose: a law for large compression (cores of points keep a crushed corner from
//! turning inside out, and more than that is refused), and exact contact of surfaces (points touch,
//! not triangles).

mod air;
mod grid;
mod grips;
mod pace;
mod pieces;
pub mod prepared;
pub mod sampling;
pub mod state;
mod steps;
mod sums;
mod surface;
#[cfg(test)]
mod tests;
mod touch;
pub mod window;

pub use prepared::PreparedSoftSolid;
pub use state::SoftSolidState;
pub use window::SoftSolidWindow;

/// Name on the wire and in recordings.
pub const NAME: &str = "soft-solid";
