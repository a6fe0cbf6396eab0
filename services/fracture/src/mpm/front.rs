//! Which points a crack may have come near: strength where the grid is too coarse for it (F01).
//!
//! A crack that grows is seen on the grid as a stress of about √(EG_f/h), however strong the
//! material, so growth goes by a cap of half of that and spends G_f. Away from cracks the cap has
//! no business: there the material breaks at its own strength, the more sharply the more it then
//! holds. A broken point therefore opens its neighbourhood to growth, no sooner than a crack could
//! arrive: at most with Rayleigh's speed (D1).

use cullet_geometry::Vec3;

/// How far a broken point opens the way, in spacings: the kernel's reach.
const REACH: f64 = 1.5;

/// The points before the hit, by place.
#[derive(Clone, Debug)]
pub(crate) struct Front {
    /// Cells of the size of the reach, ascending, with the points in them by id and place \[m\].
    cells: Vec<([i32; 3], u32, Vec3)>,
    /// Place of each point by id \[m\].
    places: Vec<Vec3>,
    reach: f64,
    speed: f64,
}

impl Front {
    /// For points at `places` \[m\], by id; `speed` is that of Rayleigh waves \[m/s\].
    pub(crate) fn new(places: Vec<Vec3>, spacing: f64, speed: f64) -> Self {
        let reach = REACH * spacing;
        let entries = places.iter().enumerate().map(|(id, x)| (cell(x, reach), id as u32, *x));
        let mut cells: Vec<([i32; 3], u32, Vec3)> = entries.collect();
        cells.sort_unstable_by_key(|&(cell, id, _)| (cell, id));
        Self { cells, places, reach, speed }
    }

    /// Calls `visit(id, time)` for each point that a crack at the point `id` opens, and how much
    /// later it can be there \[s\].
    pub(crate) fn around(&self, id: u32, mut visit: impl FnMut(u32, f64)) {
        let centre = self.places[id as usize];
        let [i, j, k] = cell(&centre, self.reach);
        // Most of what is near by is not within reach, and roots are dear.
        let nearly = self.reach * self.reach * (1.0 + 1e-9);
        for (x, y) in (i - 1..=i + 1).flat_map(|x| (j - 1..=j + 1).map(move |y| (x, y))) {
            let first = self.cells.partition_point(|(cell, ..)| *cell < [x, y, k - 1]);
            let rest = self.cells[first..].iter();
            for &(_, other, place) in rest.take_while(|(cell, ..)| *cell <= [x, y, k + 1]) {
                let square = (place - centre).norm_squared();
                if square > nearly {
                    continue;
                }
                let distance = square.sqrt();
                if distance <= self.reach {
                    visit(other, distance / self.speed);
                }
            }
        }
    }
}

fn cell(x: &Vec3, size: f64) -> [i32; 3] {
    [x.x, x.y, x.z].map(|c| (c / size).floor() as i32)
}

#[cfg(test)]
mod tests {
    use super::{Front, REACH};
    use cullet_geometry::{Vec3, math::unit};

    #[test]
    fn a_crack_opens_all_points_within_reach_and_no_other() {
        let places: Vec<Vec3> =
            (0..800).map(|i| Vec3::from([0, 1, 2].map(|a| 6.0 * unit(2, a, i) - 3.0))).collect();
        let front = Front::new(places.clone(), 1.0, 2.0);
        for id in [0, 17, 400] {
            let mut found = Vec::new();
            front.around(id, |other, delay| found.push((other, delay)));
            found.sort_unstable_by_key(|f| f.0);
            let from = places[id as usize];
            let wanted: Vec<(u32, f64)> = (0..800)
                .map(|other| (other, (places[other as usize] - from).norm()))
                .filter(|(_, far)| *far <= REACH)
                .map(|(other, far)| (other, far / 2.0))
                .collect();
            assert_eq!(found, wanted);
            assert!(wanted.len() > 20);
        }
    }
}
