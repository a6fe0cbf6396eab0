//! The Voronoi cells of given sites, in a box around the body.

use super::body::CutBody;
use crate::error::CutError;
use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};
use cullet_geometry::voronoi::Cells;

/// Shift of a site when a cut is tried again, in typical distances between sites.
const SHAKE: f64 = 1e-3;
/// The box of the cells reaches this share of the body's diagonal beyond it.
const BOX_MARGIN: f64 = 0.0317;

/// The cells of the sites in a box around the body and them, shaken from the second attempt on.
pub(super) fn cells_of(
    body: &CutBody,
    places: &[Vec3],
    labels: &[u32],
    times: &[f64],
    seed: u64,
    attempt: u64,
) -> Result<Cells, CutError> {
    let counts = [places.len(), labels.len(), times.len()];
    if counts.contains(&0) || counts[0] != counts[1] || counts[0] != counts[2] {
        return Err(CutError::Lengths { counts });
    }
    if let Some(index) = places.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(CutError::NotFinite { what: "site", index });
    }
    if let Some(index) = times.iter().position(|t| t.is_nan() || *t < 0.0) {
        return Err(CutError::NotFinite { what: "damage time of site", index });
    }
    let low = places.iter().fold(body.low, |a, p| a.inf(p));
    let high = places.iter().fold(body.high, |a, p| a.sup(p));
    let margin = Vec3::repeat(BOX_MARGIN * (high - low).norm());
    let (low, high) = (low - margin, high + margin);
    let extent = high - low;
    let width = libm::cbrt(extent.x * extent.y * extent.z / places.len() as f64);
    let shake = if attempt == 0 { 0.0 } else { SHAKE * width.min(margin.x) };
    let shaken = places.iter().enumerate().map(|(i, p)| {
        let key = scramble(seed).wrapping_add(attempt);
        let at = |k| shake * (2.0 * unit(key, k, i as u64) - 1.0);
        p + Vec3::new(at(0), at(1), at(2))
    });
    Ok(Cells::new(shaken.collect(), low, high)?)
}
