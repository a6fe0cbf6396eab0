//! Places of a solid that move with its midsurface.

use crate::domain::ShellDomain;
use cullet_geometry::Vec3;
use cullet_simd::Real;
use std::collections::BTreeMap;

/// Points of the midsurface that carry a vertex.
const CARRIERS: usize = 6;

/// The points of the midsurface by where they lay at first.
pub(super) struct Carriers {
    cell: f64,
    places: Vec<(usize, Vec3)>,
    cells: BTreeMap<[i64; 3], Vec<u32>>,
}

impl Carriers {
    pub(super) fn new(places: Vec<(usize, Vec3)>, spacing: f64) -> Self {
        let mut made = Self { cell: 2.0 * spacing, places, cells: BTreeMap::new() };
        for (k, (_, place)) in made.places.iter().enumerate() {
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
            let far = |&k: &u32| ((self.places[k as usize].1 - place).norm_squared(), k);
            let mut found: Vec<_> = inside.map(far).collect();
            if found.len() >= wanted {
                found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                found.truncate(wanted);
                return found;
            }
        }
        Vec::new()
    }

    /// Where a place of the solid is now ([`ShellDomain::carried`]): the mean of what the nearest
    /// points say, the nearer the more.
    pub(super) fn carry<R: Real, const N: usize>(
        &self,
        domain: &ShellDomain<R, N>,
        place: &Vec3,
    ) -> [Vec3; 2] {
        let near = self.near(place);
        let edge = near.last().map_or(0.0, |last| last.0.sqrt());
        let (mut sum, mut shares) = ([Vec3::zeros(); 2], 0.0);
        for &(far, k) in &near[..near.len() - 1] {
            let share = (1.0 - far.sqrt() / edge).max(1e-6).powi(2);
            let parts = domain.carried(self.places[k as usize].0, place);
            (0..2).for_each(|part| sum[part] += parts[part] * share);
            shares += share;
        }
        sum.map(|part| part / shares)
    }
}
