//! The membrane family: thin sheets of one layer of points, with bonds to those within a horizon δ,
//! that stretch, bend, take up water or heat, and tear. After Han, Xue and Aanjaneya, "A Lagrangian
//! particle-based formulation for coupled simulation of fracture and diffusion in thin membranes",
//! with its formulas corrected.
//!
//! With X a place in the flat sheet, x one in space, h the thickness, A the area of a point's cell
//! and g the generalised stretch of a bond ([`law`]), the energy of a sheet is
//!
//! U = Σ k φ(g) over bonds + ½ Σ A Λ θ² over points (dilatation) + ½ Σ A B q(κ) (bending),
//!
//! and the force on a point is −∂U/∂x, along the bonds as they are now. Stiffnesses k are fitted so
//! that the sheet is isotropic at each point, at edges too ([`bonds`]); s_c comes from the work
//! that the bonds that are there take; they soften from half of it, for sudden breaking traps
//! cracks.
//! Curvatures are linear in the places, so bending keeps momentum and angular momentum. What
//! diffuses swells, softens and weakens the bonds, and passes none that is broken ([`diffusion`]).
//!
//! A sheet is simulated a window of time at a time ([`window`]): a pure function of a state, which
//! is bytes ([`state`]), and of the rigid bodies in reach, which move inside the window with their
//! own mass. Neither the number of threads nor the cut into windows changes a bit of it.
//!
//! A piece at rest is frozen, and may leave the sheet as a rigid body of its shape. What is gone is
//! in no sum, touches nothing and is not drawn, and stays in the state's bytes where it was.
//!
//! Points are random and relaxed ([`points`]): rows would hold cracks on straight lines.
//!
//! Absent on purpose: exact self-contact (a fast sheet can cross itself), bending that breaks, and
//! Poisson's ratios other than 1/3 at large strains.

mod base;
mod bending;
pub mod bonds;
mod books;
mod cells;
mod crossings;
mod detectors;
pub mod diffusion;
mod energies;
pub mod family;
mod fit;
mod forces;
mod grips;
mod kernel;
pub mod law;
mod lips;
mod outline;
mod pieces;
pub mod points;
pub mod prepared;
mod scatter;
pub mod specimen;
pub mod state;
mod steps;
pub mod surface;
mod table;
#[cfg(test)]
mod tests;
mod vector;
mod watch;
pub mod window;

pub use bonds::MembraneBonds;
pub use family::NAME;
pub use points::SheetPoints;
pub use prepared::PreparedMembrane;
pub use state::SheetState;
pub use window::MembraneWindow;
