//! Places in a plane that keep their distance: a hard-core point process, and which is nearest.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;

/// Least distance of two places over the mean width of their cells: they take 0.28 of the area,
/// half of what places that are put down one after another can.
const CORE: f64 = 0.6;

/// Places tried for each that is wanted.
const TRIES: u64 = 40;

/// Places, and a lattice of boxes to find them by.
#[derive(Clone, Debug)]
pub(super) struct PieceScatter {
    pub(super) places: Vec<Vec3>,
    low: [f64; 2],
    width: f64,
    count: [usize; 2],
    boxes: Vec<Vec<u32>>,
}

impl PieceScatter {
    /// `number` places in a box of the plane, of cells that are `width` \[m\] wide on average,
    /// where `is_in`. Fewer where there is no more room.
    pub(super) fn new(
        (low, high): (Vec3, Vec3),
        width: f64,
        number: usize,
        seed: u64,
        is_in: impl Fn(Vec3) -> bool,
    ) -> Self {
        let count = [0, 1].map(|k| ((high[k] - low[k]) / width).ceil().max(1.0) as usize);
        let boxes = vec![Vec::new(); count[0] * count[1]];
        let mut scatter = Self { places: Vec::new(), low: [low.x, low.y], width, count, boxes };
        let share = |stream: u64, k: u64| unit(seed, stream, k);
        for k in 0..TRIES * number as u64 {
            if scatter.places.len() == number {
                break;
            }
            let place = Vec3::new(
                low.x + (high.x - low.x) * share(0, k),
                low.y + (high.y - low.y) * share(1, k),
                0.0,
            );
            let near =
                |other: &u32| (scatter.places[*other as usize] - place).norm() < CORE * width;
            if !scatter.around(place, 1).any(|other| near(&other)) && is_in(place) {
                let at = scatter.box_of(place);
                scatter.boxes[at[1] * scatter.count[0] + at[0]].push(scatter.places.len() as u32);
                scatter.places.push(place);
            }
        }
        scatter
    }

    fn box_of(&self, place: Vec3) -> [usize; 2] {
        let at = |k: usize| ((place[k] - self.low[k]) / self.width).floor().max(0.0) as usize;
        [0, 1].map(|k| at(k).min(self.count[k] - 1))
    }

    /// The places in the boxes up to so many boxes away.
    fn around(&self, place: Vec3, reach: usize) -> impl Iterator<Item = u32> {
        let at = self.box_of(place);
        let from = at.map(|at| at.saturating_sub(reach));
        let to = [0, 1].map(|k| (at[k] + reach).min(self.count[k] - 1));
        let rows = from[1]..=to[1];
        let boxes = rows.flat_map(move |y| (from[0]..=to[0]).map(move |x| y * self.count[0] + x));
        boxes.flat_map(|b| self.boxes[b].iter().copied())
    }

    /// The place nearest to one in the plane.
    pub(super) fn nearest(&self, place: Vec3) -> usize {
        let place = Vec3::new(place.x, place.y, 0.0);
        let far = |k: &u32| (self.places[*k as usize] - place).norm_squared();
        let most = self.count[0].max(self.count[1]);
        for reach in 1..=most {
            let best = self.around(place, reach).min_by(|a, b| far(a).total_cmp(&far(b)));
            let sure = reach as f64 * self.width;
            if let Some(k) = best.filter(|k| far(k) <= sure * sure || reach == most) {
                return k as usize;
            }
        }
        0
    }
}

#[cfg(test)]
mod tests {
    use super::{CORE, PieceScatter};
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;

    #[test]
    fn places_keep_their_distance_and_the_nearest_is_found() {
        let ends = (Vec3::new(-0.1, -0.05, 0.0), Vec3::new(0.1, 0.05, 0.0));
        let scatter = PieceScatter::new(ends, 5e-3, 800, 3, |place| place.norm() > 0.01);
        let all = &scatter.places;
        assert!((770..=800).contains(&all.len()), "{}", all.len());
        let apart = |(k, a): (usize, &Vec3)| {
            all[..k].iter().map(|b| (a - b).norm()).fold(f64::INFINITY, f64::min)
        };
        let least = all.iter().enumerate().map(apart).fold(f64::INFINITY, f64::min);
        assert!(least >= CORE * 5e-3, "{least}");
        for k in 0..300 {
            let x = Vec3::new(0.24 * unit(1, 0, k) - 0.12, 0.12 * unit(1, 1, k) - 0.06, 0.0);
            let far = |p: &usize| (all[*p] - x).norm();
            let best = (0..all.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
            assert_eq!(Some(scatter.nearest(x)), best);
        }
    }
}
