//! Where a sheet goes through itself (F95m). It is counted, and reported.

use crate::prepared::PreparedMembrane;
use cullet_continuum::crossings::{SurfaceCrossing, crossings};
use cullet_geometry::Vec3;

/// Whether a bond still holds each of the pairs that hold the surface together.
pub(crate) fn live_pairs(prepared: &PreparedMembrane, damage: &[f64]) -> Vec<bool> {
    let whole = |b: &Option<usize>| b.is_some_and(|b| !prepared.bonds.cut[b] && damage[b] < 1.0);
    prepared.pairs.iter().map(whole).collect()
}

/// Points of the edges and triangles that cross.
pub(crate) fn crossed_points(triangles: &[[u32; 3]], places: &[Vec3]) -> Vec<u32> {
    let all = crossings(triangles, places);
    let points = |one: &SurfaceCrossing| {
        let ([a, b], [c, d, e]) = (one.edge, one.triangle);
        [a, b, c, d, e]
    };
    all.iter().flat_map(points).collect()
}
