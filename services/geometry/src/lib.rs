//! Exact shapes: meshes, repair, sampling, Voronoi cells, cuts. Knows no mechanics.
//!
//! Absent on purpose: files, clocks, threads, randomness other than a seed given as an argument,
//! physics.

pub mod attributes;
pub mod boolean;
pub mod charts;
pub mod divide;
pub mod door;
pub mod hull;
pub mod inside;
pub mod math;
pub mod mesh;
pub mod midsurface;
pub mod motion;
pub mod nurbs;
pub mod plate;
pub mod polygon;
pub mod quads;
pub mod remesh;
pub mod sample;
pub mod shapes;
pub mod sheet;
pub mod surface;
pub mod symmetric;
pub mod voronoi;
mod wall_surface;

pub use math::{Mat3, Pose, Quat, Vec3};
pub use mesh::{MassProperties, Solid, Surface, TriMesh};
pub use sheet::Sheet;
pub use wall_surface::WallSurface;
