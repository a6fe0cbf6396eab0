//! The points' pass: quadratic B-splines with the MLS gradient, stress and damage.
//!
//! Elements lie side by side, one in each lane of a register, and each lane walks through its own
//! element's points. No sum runs across lanes: so the bits do not depend on the registers' width,
//! nor, blocks being summed in order, on the number of threads.

mod block;
mod law;
mod pass;
mod spline;
mod tension;
#[cfg(test)]
mod tests;

use cullet_simd::Lanes;

pub(crate) use {law::MaterialLaw, law::PointLaw, pass::Kernel, pass::least_share};

/// Vectors at the 27 nodes of each element: node times 3 plus axis.
type NodeVectors<R> = [Lanes<R>; 81];
