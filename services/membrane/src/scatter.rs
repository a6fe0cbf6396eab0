//! Scatter of a sheet's strength: weak and strong patches a few spacings wide.

use cullet_geometry::math::unit;
use cullet_model::SheetPlace;

/// Width of a patch over the spacing: narrower ones would be averaged away by bonds.
const PATCH: f64 = 4.0;
/// Least factor on s_c: nothing is without strength.
const LEAST: f64 = 0.2;
/// Stream of [`unit`] numbers for patches.
const PATCH_STREAM: u64 = 0x7061_7463;

/// Factors on s_c, one a point: of mean 1 and this standard deviation; none where that is 0.
pub(crate) fn factors(
    places: &[SheetPlace],
    spacing: f64,
    deviation: f64,
    seed: u64,
) -> Option<Vec<f64>> {
    if deviation == 0.0 {
        return None;
    }
    let of = |p: &SheetPlace| (1.0 + deviation * patch(p, PATCH * spacing, seed)).max(LEAST);
    let all: Vec<f64> = places.iter().map(of).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    Some(all.iter().map(|f| f / mean).collect())
}

/// A smooth random field of mean 0 and deviation 1.
fn patch(place: &SheetPlace, width: f64, seed: u64) -> f64 {
    let at = place.map(|c| c / width);
    let low = at.map(f64::floor);
    let share = [0, 1].map(|k| {
        let t = at[k] - low[k];
        t * t * (3.0 - 2.0 * t)
    });
    let corner = |dx: f64, dy: f64| {
        let [x, y] = [low[0] + dx, low[1] + dy].map(|c| c as i64 as u64);
        let index = x.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ y.rotate_left(32);
        // Four even numbers have the variance 1/3: nearly normal.
        let chance = |k: u64| unit(seed, PATCH_STREAM + k, index);
        ((0..4).map(chance).sum::<f64>() - 2.0) * 3.0_f64.sqrt()
    };
    let (mut sum, mut square) = (0.0, 0.0);
    for (dx, wx) in [(0.0, 1.0 - share[0]), (1.0, share[0])] {
        for (dy, wy) in [(0.0, 1.0 - share[1]), (1.0, share[1])] {
            sum += wx * wy * corner(dx, dy);
            square += (wx * wy) * (wx * wy);
        }
    }
    sum / square.sqrt()
}
