//! The shell family against formulas and benchmark values.

mod cracks;
mod equilibrium;
mod kernel;
mod pane;
mod statics;
mod treated;
