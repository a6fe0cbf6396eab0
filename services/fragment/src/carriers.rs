//! Points that carry the places of a solid with them.

use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Points that carry a place.
const CARRIERS: usize = 6;

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

    /// How far points are from a place, squared, and which they are: those of the cells around it,
    /// as far as there are enough.
    fn near(&self, place: &Vec3) -> Vec<(f64, u32)> {
        let wanted = (CARRIERS + 1).min(self.places.len());
        for ring in 1.. {
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let cell = (place[axis] / self.cell).floor() as i64;
                cell - ring..=cell + ring
            });
            let cells = x.flat_map(|i| y.clone().map(move |j| [i, j]));
            let cells = cells.flat_map(|[i, j]| z.clone().map(move |k| [i, j, k]));
            let inside = cells.filter_map(|cell| self.cells.get(&cell)).flatten();
            let far = |&k: &u32| ((self.places[k as usize] - place).norm_squared(), k);
            let mut found: Vec<_> = inside.map(far).collect();
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
        let near = self.near(place);
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
}
