//! The shell family against formulas and benchmark values.

mod cracks;
mod equilibrium;
mod kernel;
mod loop_cracks;
mod loop_meshes;
mod loop_surfaces;
mod pane;
mod statics;
mod treated;
