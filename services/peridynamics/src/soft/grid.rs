//! Points by the cell of a grid they are in.

use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;

/// Most cells over the number of points: where points are far from each other, cells are wider.
const MOST_CELLS: f64 = 16.0;

/// Points, to be found from any place.
#[derive(Clone, Debug)]
pub(super) struct PointCells {
    /// Width of a cell \[m\].
    cell: f64,
    low: Vec3,
    /// Cells along each axis.
    counts: [i64; 3],
    /// First of `order` of each cell, then their number.
    starts: Vec<u32>,
    /// Points by cell, then number.
    order: Vec<u32>,
}

impl PointCells {
    /// Memory that it takes \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        held(&self.starts) + held(&self.order)
    }

    /// In cells of this width \[m\] or more; all places are finite.
    pub(super) fn new(places: &[Vec3], width: f64) -> Self {
        let first = places.first().copied().unwrap_or_default();
        let low = places.iter().fold(first, |low, x| low.inf(x));
        let size = places.iter().fold(first, |high, x| high.sup(x)) - low;
        let most = MOST_CELLS * places.len() as f64 + 64.0;
        let mut cell = width;
        while size.iter().map(|d| (d / cell).floor() + 1.0).product::<f64>() > most {
            cell *= 1.25;
        }
        let counts = [0, 1, 2].map(|axis| (size[axis] / cell).floor() as i64 + 1);
        let mut made = Self { cell, low, counts, starts: Vec::new(), order: Vec::new() };
        let cells: Vec<usize> = places.iter().map(|x| made.number(made.at(x))).collect();
        let mut starts =
            vec![0_u32; made.number([counts[0] - 1, counts[1] - 1, counts[2] - 1]) + 2];
        cells.iter().for_each(|&cell| starts[cell + 1] += 1);
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        made.order = vec![0; places.len()];
        for (p, &cell) in cells.iter().enumerate() {
            made.order[next[cell] as usize] = p as u32;
            next[cell] += 1;
        }
        made.starts = starts;
        made
    }

    /// The cell of a place, which may be out of the grid.
    fn at(&self, x: &Vec3) -> [i64; 3] {
        [0, 1, 2].map(|axis| ((x[axis] - self.low[axis]) / self.cell).floor() as i64)
    }

    fn number(&self, [i, j, k]: [i64; 3]) -> usize {
        ((i * self.counts[1] + j) * self.counts[2] + k) as usize
    }

    /// Visits the points of the cells that are so far or less from that of a place, in one order.
    pub(super) fn around(&self, place: &Vec3, reach: i64, mut visit: impl FnMut(u32)) {
        let at = self.at(place);
        let low = at.map(|c| c.saturating_sub(reach).max(0));
        let high = [0, 1, 2].map(|axis| at[axis].saturating_add(reach).min(self.counts[axis] - 1));
        if (0..3).any(|axis| low[axis] > high[axis]) {
            return;
        }
        for i in low[0]..=high[0] {
            for j in low[1]..=high[1] {
                let from = self.starts[self.number([i, j, low[2]])] as usize;
                let to = self.starts[self.number([i, j, high[2]]) + 1] as usize;
                self.order[from..to].iter().for_each(|&p| visit(p));
            }
        }
    }

    /// The nearest points of `places`, by rising distance, then number.
    pub(super) fn nearest(&self, places: &[Vec3], place: &Vec3, count: usize) -> Vec<u32> {
        let wanted = count.min(places.len());
        for reach in 1.. {
            let mut found: Vec<(f64, u32)> = Vec::new();
            self.around(place, reach, |p| {
                found.push(((places[p as usize] - place).norm_squared(), p));
            });
            found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            // Whatever is nearer than the cells that were looked at reach.
            let far = reach as f64 * self.cell;
            let sure = found.len() >= wanted && (wanted == 0 || found[wanted - 1].0 <= far * far);
            if sure || found.len() == places.len() {
                found.truncate(wanted);
                return found.into_iter().map(|one| one.1).collect();
            }
        }
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::PointCells;
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;

    #[test]
    fn the_nearest_points_are_those_of_a_comparison_with_all() {
        let at = |seed, k: u64| Vec3::new(unit(seed, 0, k), unit(seed, 1, k), unit(seed, 2, k));
        let mut places: Vec<Vec3> = (0..500).map(|k| at(5, k)).collect();
        places.push(Vec3::new(900.0, 0.0, -40.0));
        let cells = PointCells::new(&places, 0.05);
        for k in 0..40 {
            let place = at(6, k) * 1.4 - Vec3::repeat(0.2);
            let mut wanted: Vec<u32> = (0..places.len() as u32).collect();
            wanted.sort_by(|&p, &q| {
                let far = |p: u32| (places[p as usize] - place).norm_squared();
                far(p).total_cmp(&far(q)).then(p.cmp(&q))
            });
            assert_eq!(cells.nearest(&places, &place, 12), wanted[..12]);
        }
        assert_eq!(cells.nearest(&places, &Vec3::x(), 999).len(), 501);
        assert!(PointCells::new(&[], 1.0).nearest(&[], &Vec3::x(), 3).is_empty());
    }
}
