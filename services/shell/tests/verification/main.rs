//! The shell family against formulas and benchmark values.

mod cracks;
mod equilibrium;
mod kernel;
mod pane;
mod quad_cracks;
mod quad_meshes;
mod quad_surfaces;
mod radials;
mod soft;
mod splits;
mod statics;
mod tear;
mod treated;
mod yielding;
