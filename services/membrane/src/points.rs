//! Points of a sheet: random, then relaxed until each is the centroid of its cell, so that no
//! direction is weaker than others. In rows a crack would be trapped between them.

use crate::cells::{PlaneGrid, cell};
use crate::outline::SheetOutline;
use cullet_geometry::math::unit;
use cullet_model::{Refusal, SheetPlace};
use rayon::prelude::*;

/// Most points of a sheet.
pub const MAX_POINTS: f64 = cullet_model::sheet_check::MOST_SHEET_POINTS;
/// Sweeps of Lloyd's method. After eight the moduli of the fitted bonds scatter by 0.5 %.
const SWEEPS: usize = 8;
/// Greatest step from the middle of its square, in squares, that a point starts with.
const JITTER: f64 = 0.35;
/// Stream of [`unit`] numbers for places.
const PLACE_STREAM: u64 = 0x6d65_6d62;
/// Least area of a cell over the square of the spacing.
const LEAST_CELL: f64 = 0.05;

/// Points in an outline.
#[derive(Clone, Debug)]
pub struct SheetPoints {
    /// Where each is \[m\].
    pub places: Vec<SheetPlace>,
    /// Area of what is nearest to each within the outline \[m²\].
    pub areas: Vec<f64>,
}

impl SheetPoints {
    /// The same points, those of these numbers in turn.
    pub(crate) fn in_order(&self, order: &[u32]) -> Self {
        Self {
            places: order.iter().map(|&i| self.places[i as usize]).collect(),
            areas: order.iter().map(|&i| self.areas[i as usize]).collect(),
        }
    }
}

/// Places points in an outline at this distance from each other \[m\]: about one for each square
/// of the spacing. Equal seeds give equal points.
///
/// # Errors
///
/// If there would be more than [`MAX_POINTS`], or the outline is finer than its points.
pub(crate) fn relaxed(
    outline: &SheetOutline,
    spacing: f64,
    seed: u64,
) -> Result<SheetPoints, Refusal> {
    let count = outline.area / (spacing * spacing);
    let [low, high] = outline.bounds;
    let squares = (high[0] - low[0]) * (high[1] - low[1]) / (spacing * spacing);
    // A polygon much smaller than the box around it would take long to look through.
    let value = count.max(0.01 * squares);
    if value.is_nan() || value > MAX_POINTS {
        return Err(Refusal::TooLarge { what: "the points of a sheet", value, limit: MAX_POINTS });
    }
    let mut places = scattered(outline, spacing, seed);
    let unfit = |lack: String| Err(Refusal::Unfit { solver: crate::family::NAME, lack });
    if places.len() < 7 {
        return unfit(format!("{} points fit into the outline; 7 are needed", places.len()));
    }
    let cells = |places: &[SheetPlace]| -> Vec<(f64, SheetPlace)> {
        let grid = PlaneGrid::new(places, 1.5 * spacing);
        let own = |i| cell(outline, places, &grid, spacing, i);
        (0..places.len()).into_par_iter().map(own).collect()
    };
    for _ in 0..SWEEPS {
        let moved = cells(&places);
        for (place, (_, centroid)) in places.iter_mut().zip(moved) {
            // In a hook the centroid of a cell may lie outside.
            if outline.contains(centroid) {
                *place = centroid;
            }
        }
    }
    let areas: Vec<f64> = cells(&places).into_iter().map(|(area, _)| area).collect();
    let total: f64 = areas.iter().sum();
    if (total - outline.area).abs() > 1e-9 * outline.area {
        return unfit(format!(
            "{:.3e} m² of the outline are farther than 4 spacings from all points: it has parts \
             thinner than the spacing {spacing:.3e} m",
            outline.area - total
        ));
    }
    if let Some(i) = areas.iter().position(|&a| a < LEAST_CELL * spacing * spacing) {
        let [x, y] = places[i];
        return unfit(format!(
            "the outline is finer than its points near ({x:.3e}, {y:.3e}) m: take a spacing below \
             {spacing:.3e} m"
        ));
    }
    Ok(SheetPoints { places, areas })
}

/// One point in each square whose middle is inside, off that by chance.
fn scattered(outline: &SheetOutline, spacing: f64, seed: u64) -> Vec<SheetPlace> {
    let [low, high] = outline.bounds;
    let counts = [0, 1].map(|k| ((high[k] - low[k]) / spacing).round().max(1.0));
    let pitch = [0, 1].map(|k| (high[k] - low[k]) / counts[k]);
    let mut places = Vec::new();
    for row in 0..counts[1] as u64 {
        for column in 0..counts[0] as u64 {
            let at = [column, row];
            let middle = [0, 1].map(|k| low[k] + (at[k] as f64 + 0.5) * pitch[k]);
            if !outline.contains(middle) {
                continue;
            }
            let number = row * counts[0] as u64 + column;
            let chance = [0, 1].map(|k| unit(seed, PLACE_STREAM, 2 * number + k as u64) - 0.5);
            let off = |share: f64| {
                [0, 1].map(|k: usize| middle[k] + share * 2.0 * JITTER * chance[k] * pitch[k])
            };
            let shares = [1.0, 0.5, 0.25, 0.0].into_iter().map(off);
            places.extend(shares.into_iter().find(|&p| outline.contains(p)));
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::relaxed;
    use crate::outline::SheetOutline;
    use cullet_model::Refusal;

    #[test]
    fn cells_fill_any_outline() {
        let hook = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.15, 0.2], [0.1, 0.1], [0.0, 0.1]];
        let square = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]];
        for corners in [&hook[..], &square] {
            let outline = SheetOutline::new(corners).unwrap();
            let points = relaxed(&outline, 5e-3, 3).unwrap();
            let total: f64 = points.areas.iter().sum();
            assert!((total / outline.area - 1.0).abs() < 1e-13, "{total}");
            let expected = outline.area / 2.5e-5;
            assert!((points.places.len() as f64 / expected - 1.0).abs() < 0.05);
            assert!(points.areas.iter().all(|a| (0.6..1.6).contains(&(a / 2.5e-5))));
            assert!(points.places.iter().all(|&p| outline.contains(p)));
        }
    }

    #[test]
    fn equal_seeds_give_equal_points_and_too_many_are_refused() {
        let outline = SheetOutline::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let places = |seed| relaxed(&outline, 0.05, seed).unwrap().places;
        assert_eq!(places(1), places(1));
        assert_ne!(places(1), places(2));
        assert!(matches!(relaxed(&outline, 1e-3, 1), Err(Refusal::TooLarge { .. })));
    }
}
