//! The shell family against formulas and benchmark values.

mod equilibrium;
mod kernel;
mod statics;
