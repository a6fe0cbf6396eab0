//! The order of points. Sixteen that follow each other are worked on side by side, so they should
//! have about as many bonds each, and what they are bonded to should lie near them in memory.

use crate::cells::PlaneGrid;
use cullet_model::SheetPlace;

/// Width of a strip of the sheet, in spacings.
const WIDTH: f64 = 16.0;
/// Length of the part of a strip whose points are sorted by their bonds, likewise.
const LENGTH: f64 = 4.0;

/// Numbers of points in strips across the longer side of the sheet, within short parts of a strip
/// those with most neighbours within `reach` \[m\] first.
pub(crate) fn lane_order(places: &[SheetPlace], spacing: f64, reach: f64) -> Vec<u32> {
    let bound = |k: usize, pick: fn(f64, f64) -> f64, from: f64| {
        places.iter().map(|p| p[k]).fold(from, pick)
    };
    let low = [0, 1].map(|k| bound(k, f64::min, f64::INFINITY));
    let extent = [0, 1].map(|k| bound(k, f64::max, f64::NEG_INFINITY) - low[k]);
    let along = usize::from(extent[1] > extent[0]);
    let grid = PlaneGrid::new(places, reach);
    let neighbours = |p: SheetPlace| {
        let mut count = 0u32;
        grid.around(p, reach, |j| {
            let q = places[j as usize];
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            count += u32::from(dx * dx + dy * dy < reach * reach);
        });
        count
    };
    let key = |(i, p): (usize, &SheetPlace)| {
        let tile = |k: usize, length: f64| ((p[k] - low[k]) / (length * spacing)) as u32;
        let fewest = u32::MAX - neighbours(*p);
        (tile(along, WIDTH), tile(1 - along, LENGTH), fewest, i as u32)
    };
    let mut keys: Vec<_> = places.iter().enumerate().map(key).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(.., i)| i).collect()
}
