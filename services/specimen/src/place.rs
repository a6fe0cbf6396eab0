//! Parts of a specimen.

use cullet_geometry::Vec3;
use cullet_model::strength::Region;

/// A part of the specimen: the points in all of these regions; none means everywhere.
pub type Where = Vec<Region>;

/// Whether a place is in a part, or no farther outside of it than `slack` \[m\].
#[must_use]
pub fn within(part: &Where, x: &Vec3, slack: f64) -> bool {
    part.iter().all(|region| region.contains(x, slack))
}
