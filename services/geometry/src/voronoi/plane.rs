//! The planes that bound a cell, and where three of them meet.

use crate::math::Vec3;

/// `normal · x <= offset` with x measured from the site; `length` = |normal|.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClipPlane {
    pub(super) id: u32,
    pub(super) normal: Vec3,
    pub(super) offset: f64,
    pub(super) length: f64,
}

/// Rounding of a 3×3 solve by cofactors: about 30 operations, each within half an epsilon, doubled.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The point that three planes share and a bound on its rounding error.
pub(super) fn meet(planes: [&ClipPlane; 3]) -> (Vec3, f64) {
    let [a, b, c] = planes;
    let bc = b.normal.cross(&c.normal);
    let ca = c.normal.cross(&a.normal);
    let ab = a.normal.cross(&b.normal);
    let det = a.normal.dot(&bc);
    let place = (bc * a.offset + ca * b.offset + ab * c.offset) / det;
    let steepness = (a.length * b.length * c.length / det).abs();
    let distances = (a.offset / a.length).abs()
        + (b.offset / b.length).abs()
        + (c.offset / c.length).abs()
        + place.norm();
    let slack = ROUNDING * steepness * distances;
    (place, if slack.is_finite() { slack } else { f64::INFINITY })
}
