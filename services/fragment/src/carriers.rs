//! Points that carry the places of a solid with them.

use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Points that carry a place.
const CARRIERS: usize = 6;

/// Cells within which a point is looked for.
const FAR: i64 = 4;

/// Points by where they lay at first.
#[derive(Debug)]
pub struct Carriers {
    cell: f64,
    places: Vec<Vec3>,
    cells: BTreeMap<[i64; 3], Vec<u32>>,
}

impl Carriers {
    /// Of points about `spacing` \[m\] apart, at their places \[m\]; at least one.
    #[must_use]
    pub fn new(places: Vec<Vec3>, spacing: f64) -> Self {
        let mut made = Self { cell: 2.0 * spacing, places, cells: BTreeMap::new() };
        for (k, place) in made.places.iter().enumerate() {
            let cell = [0, 1, 2].map(|axis| (place[axis] / made.cell).floor() as i64);
            made.cells.entry(cell).or_default().push(k as u32);
        }
        made
    }

    /// How far points are from a place, squared, and which they are: those of the cells that are so
    /// far or less from its own.
    fn around(&self, place: &Vec3, reach: i64) -> impl Iterator<Item = (f64, u32)> {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let cell = (place[axis] / self.cell).floor() as i64;
            cell - reach..=cell + reach
        });
        let cells = x.flat_map(move |i| y.clone().map(move |j| [i, j]));
        let cells = cells.flat_map(move |[i, j]| z.clone().map(move |k| [i, j, k]));
        let inside = cells.filter_map(|cell| self.cells.get(&cell)).flatten();
        inside.map(move |&k| ((self.places[k as usize] - place).norm_squared(), k))
    }

    /// Those of the cells around it, as far as there are enough.
    fn near(&self, place: &Vec3) -> Vec<(f64, u32)> {
        let wanted = (CARRIERS + 1).min(self.places.len());
        for reach in 1.. {
            let mut found: Vec<_> = self.around(place, reach).collect();
            if found.len() >= wanted {
                found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                found.truncate(wanted);
                return found;
            }
        }
        Vec::new()
    }

    /// The nearest points to a place, and their shares of it, the nearer the more; 1 together.
    #[must_use]
    pub fn shares(&self, place: &Vec3) -> Vec<(usize, f64)> {
        shares(&self.near(place))
    }

    /// The nearest point to a place that `may` says carries it; none within four cells.
    #[must_use]
    pub fn nearest(&self, place: &Vec3, may: impl Fn(usize) -> bool) -> Option<usize> {
        for reach in 1..=FAR {
            // Whatever is nearer than the cells that were looked at reach.
            let far = reach as f64 * self.cell;
            let found = self.around(place, reach);
            let near = found.filter(|&(d, k)| d <= far * far && may(k as usize));
            let best = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if let Some((_, k)) = best {
                return Some(k as usize);
            }
        }
        None
    }

    /// As [`Carriers::shares`], of some of the points.
    #[must_use]
    pub fn shares_of(
        &self,
        place: &Vec3,
        points: impl Iterator<Item = usize>,
    ) -> Vec<(usize, f64)> {
        let far = |k: usize| ((self.places[k] - place).norm_squared(), k as u32);
        let mut near: Vec<_> = points.map(far).collect();
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.dedup();
        near.truncate(CARRIERS + 1);
        shares(&near)
    }
}

/// Of those points, from near to far: all but the farthest, which has none.
fn shares(near: &[(f64, u32)]) -> Vec<(usize, f64)> {
    let edge = near.last().map_or(0.0, |last| last.0.sqrt());
    let few = near.len().saturating_sub(1).max(1);
    let share = |&(far, k): &(f64, u32)| {
        let share = (1.0 - far.sqrt() / edge).max(1e-6);
        (k as usize, share * share)
    };
    let mut found: Vec<(usize, f64)> = near.iter().take(few).map(share).collect();
    let all: f64 = found.iter().map(|share| share.1).sum();
    found.iter_mut().for_each(|one| one.1 /= all);
    found
}
