//! Which points are within a horizon of each other.

use cullet_geometry::Vec3;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Points in rows four spacings \[m\] wide, so that those which are near each other are near in the
/// list.
pub(crate) fn in_rows(points: &[Vec3], spacing: f64) -> Vec<Vec3> {
    let row = |x: &Vec3| [x.z, x.y].map(|c| (c / (4.0 * spacing)).floor() as i64);
    let mut ordered: Vec<([i64; 2], usize)> =
        points.iter().enumerate().map(|(k, x)| (row(x), k)).collect();
    ordered.sort_by(|a, b| {
        let along = |k: usize| points[k].x;
        a.0.cmp(&b.0).then(along(a.1).total_cmp(&along(b.1))).then(a.1.cmp(&b.1))
    });
    ordered.into_iter().map(|(_, k)| points[k]).collect()
}

/// Points sorted by the cell of a grid they are in; a cell is as wide as the horizon.
pub(crate) struct CellOrder<'a> {
    places: &'a [Vec3],
    low: Vec3,
    horizon: f64,
    order: Vec<([i64; 3], u32)>,
}

impl<'a> CellOrder<'a> {
    /// Of places and a horizon \[m\].
    pub(crate) fn new(places: &'a [Vec3], horizon: f64) -> Self {
        let low = places.iter().fold(Vec3::repeat(f64::INFINITY), |low, x| low.inf(x));
        let mut found = Self { places, low, horizon, order: Vec::new() };
        let entry = |(p, x): (usize, &Vec3)| {
            let cell = found.cell(x);
            ([cell.x, cell.y, cell.z], p as u32)
        };
        let mut order: Vec<_> = places.iter().enumerate().map(entry).collect();
        order.sort_unstable();
        found.order = order;
        found
    }

    /// The cell of a place. What is farther than any cell is counted in the last: distances decide.
    fn cell(&self, x: &Vec3) -> Vector3<i64> {
        (x - self.low).map(|d| (d / self.horizon).min(1e15) as i64)
    }

    /// Visits all others within the horizon of a point, in no order.
    fn visit(&self, point: usize, mut visit: impl FnMut(u32)) {
        let (x, at) = (&self.places[point], self.cell(&self.places[point]));
        for step in 0..9 {
            let (i, j) = (at.x + step / 3 - 1, at.y + step % 3 - 1);
            let first = self.order.partition_point(|entry| entry.0 < [i, j, at.z - 1]);
            let all = self.order[first..].iter();
            for &(_, q) in all.take_while(|entry| entry.0 <= [i, j, at.z + 1]) {
                let apart = (self.places[q as usize] - x).norm_squared();
                if q as usize != point && apart <= self.horizon * self.horizon {
                    visit(q);
                }
            }
        }
    }

    /// How many others are within the horizon of each point.
    pub(crate) fn counts(&self) -> Vec<u32> {
        let count = |point| {
            let mut count = 0;
            self.visit(point, |_| count += 1);
            count
        };
        (0..self.places.len()).into_par_iter().map(count).collect()
    }

    /// The others within the horizon of a point, ascending.
    pub(crate) fn of(&self, point: usize) -> Vec<u32> {
        let mut found = Vec::new();
        self.visit(point, |q| found.push(q));
        found.sort_unstable();
        found
    }
}
