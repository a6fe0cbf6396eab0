//! Balls among sets of corners.

use crate::math::Vec3;

/// Corners of a ball are as far from its centre as each other but for this share: text with six
/// decimals has less \[1\].
const ROUND: f64 = 1e-4;
/// In each of so many directions a ball has a corner …
const DIRECTIONS: usize = 64;
/// … whose way in that direction is at least this share of the radius: within 20° \[1\].
const NEAREST: f64 = 0.94;

/// The radius \[m\] of the ball about the origin on which all corners lie, none of them far from
/// the next. Their hull would hop as it rolls.
#[must_use]
pub fn radius_of_ball(corners: &[Vec3]) -> Option<f64> {
    let radius = corners.iter().map(Vec3::norm).fold(0.0, f64::max);
    let on_it = |p: &Vec3| radius - p.norm() <= ROUND * radius;
    let near = |k: usize| {
        let direction = spiral(k, DIRECTIONS);
        corners.iter().any(|p| direction.dot(p) > NEAREST * radius)
    };
    let is_ball = corners.iter().all(on_it) && (0..DIRECTIONS).all(near);
    is_ball.then_some(radius)
}

/// Direction `k` of `n` on the Fibonacci sphere.
#[must_use]
pub fn spiral(k: usize, n: usize) -> Vec3 {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let z = 1.0 - (2 * k + 1) as f64 / n as f64;
    let (s, c) = libm::sincos(GOLDEN_ANGLE * k as f64);
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * c, r * s, z)
}
