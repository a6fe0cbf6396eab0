//! The shell family: thin walls as Kirchhoff–Love shells (rotation-free, total Lagrangian, on
//! NURBS), after chapter 4 of Fan 2024 without its background grid.

pub mod domain;
pub mod kernel;
pub mod midsurface;
pub mod section;
pub mod soft;
pub mod solve;
pub mod specimen;
pub mod treatment;

pub use soft::SoftShellWindow;
pub use solve::ShellSolver;
