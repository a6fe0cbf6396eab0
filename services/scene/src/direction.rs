//! Directions as a scene writes them.

use cullet_geometry::Vec3;

/// Shortest axis, normal or quaternion that still has a direction \[1\].
pub(super) const MIN_LENGTH: f64 = 1e-6;

/// The direction of a written normal, or what is wrong with it.
pub fn direction(normal: [f64; 3]) -> Result<[f64; 3], &'static str> {
    let found = Vec3::from(normal).try_normalize(MIN_LENGTH);
    found.map(Into::into).ok_or("must have a length above 1e-6")
}
