//! Parts of a specimen.

use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_model::strength::Region;

/// A part of the specimen: the points in all of these regions; none means everywhere.
pub type Where = Vec<Region>;

/// Whether a place is in a part, or no farther outside of it than `slack` \[m\].
#[must_use]
pub fn within(part: &Where, x: &Vec3, slack: f64) -> bool {
    part.iter().all(|region| region.contains(x, slack))
}

/// Refuses the first of a list of parts that is idle: what takes nothing of the body is a mistake
/// in its place.
///
/// # Errors
/// [`Refusal::Idle`] with its number.
pub fn idle(what: &'static str, mut all: impl Iterator<Item = bool>) -> Result<(), Refusal> {
    let number = all.position(|idle| idle).map(|index| index + 1);
    number.map_or(Ok(()), |number| Err(Refusal::Idle { what, number }))
}
