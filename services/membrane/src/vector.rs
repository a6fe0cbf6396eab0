//! Vectors in inner loops.

use cullet_geometry::Vec3;

/// The length of a vector. `norm` of nalgebra calls an instruction of old encoding through libm,
/// which stalls a processor whose wide registers are in use: a step took three times as long.
#[inline(always)]
pub(crate) fn length(v: &Vec3) -> f64 {
    v.norm_squared().sqrt()
}
