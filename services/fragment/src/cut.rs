//! Cuts a body along the faces between Voronoi cells of different labels, exactly.
//!
//! [`extract`] makes cells and labels from damage, [`by_sites`] takes them from the caller,
//! [`Cutting`] does the work in steps. Regions (unions of cells of one label) are intersected with
//! the body; a region may leave several pieces. Pieces that are too small, too many, or cut off by
//! a crack without damage behind it go to the neighbour with which they share the largest area:
//! their cells change label and the regions concerned are cut again. Every part is closed, and the
//! volumes of the parts sum to the body's within [`VOLUME_TOLERANCE`], or there is an error.

mod again;
mod body;
mod cutting;
mod ground;
mod homes;
mod once;
mod partial;
mod partition;
mod piece;
mod regions;
mod sites;
pub mod slit;
mod stretched;
#[cfg(test)]
mod tests;
mod workpiece;

pub use crate::error::{CutError, VOLUME_TOLERANCE};
pub use crate::field::DamageField;
pub use again::extract_stretched;
pub use cutting::Cutting;
pub use partition::{CutPart, CutSettings, OpenCrack, Partition};

use cullet_geometry::{Solid, Vec3};

/// Diagrams tried, each with sites shaken anew, before a cut is given up.
const ATTEMPTS: u64 = 3;

/// Cuts a body along its damage. One part, the body untouched, if the damage does not go through.
///
/// # Errors
/// A field that is empty, uneven, not finite or too large; a solid that is not closed; a cut that
/// did not close or add up at every attempt.
pub fn extract(
    solid: &Solid,
    field: &DamageField<'_>,
    settings: &CutSettings,
) -> Result<Partition, CutError> {
    extract_stretched(solid, field, settings, &Vec3::repeat(1.0))
}

/// Cuts a body along the faces between the Voronoi cells of `sites` \[m\] that have different
/// `labels`; `times` \[s\] is when the crack passed each site. The caller brings the sites into
/// general position.
///
/// # Errors
/// As [`extract`].
pub fn by_sites(
    solid: &Solid,
    sites: &[Vec3],
    labels: &[u32],
    times: &[f64],
    settings: &CutSettings,
) -> Result<Partition, CutError> {
    attempts(|attempt| {
        Cutting::begin(solid, sites, labels, times, sites.len(), settings, attempt)?.run()
    })
}

/// Tries again with another jitter where that may help.
fn attempts<T>(mut cut: impl FnMut(u64) -> Result<T, CutError>) -> Result<T, CutError> {
    let mut attempt = 0;
    loop {
        attempt += 1;
        match cut(attempt - 1) {
            Err(error) if error.is_accident() && attempt < ATTEMPTS => {}
            other => return other,
        }
    }
}
