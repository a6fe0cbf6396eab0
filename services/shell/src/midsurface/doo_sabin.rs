//! Functions of a cell of Doo & Sabin's subdivision surface \[Doo & Sabin 1978, *Behaviour of
//! recursive division surfaces near extraordinary points*\].
//!
//! A cell lies around a control point with four faces. Where these have four corners its functions
//! are the nine of a uniform B-spline of degree 2. Where one has another number, the cell is
//! divided until the place that is asked for lies in a part whose faces have four.

use cullet_geometry::nurbs::MOST_FUNCTIONS;
use std::f64::consts::TAU;

/// Corners of a face that all others go by.
const REGULAR: usize = 4;

/// Divisions after which a place counts as one in a regular cell: only a corner needs more.
const DEEPEST: usize = 30;

/// ControlShares of control points.
type ControlShares = [f64; MOST_FUNCTIONS];

/// Values of functions and R,1 R,2 R,11 R,22 R,12.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellFunctions {
    pub(super) value: ControlShares,
    pub(super) derivatives: [ControlShares; 5],
}

/// The faces around a cell's control point, counter-clockwise, from the one between the ways of
/// rising first and second parameter on. Each is a loop of points, as shares of the cell's control
/// points, counter-clockwise from the cell's own on.
#[derive(Clone, Debug)]
pub(super) struct CellFaces([Vec<ControlShares>; 4]);

impl CellFaces {
    /// Of a cell whose control points are in order its own, the four that it shares an edge with,
    /// and those that remain of each face.
    pub(super) fn new(corners: [usize; 4]) -> Self {
        let single = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        let mut next = 5;
        Self(std::array::from_fn(|i| {
            let others = next..next + corners[i] - 3;
            next = others.end;
            let list = [0, 1 + i].into_iter().chain(others).chain([1 + (i + 1) % 4]);
            list.map(single).collect()
        }))
    }

    /// Control points of a cell whose faces have so many corners.
    pub(super) fn functions(corners: [usize; 4]) -> usize {
        corners.iter().sum::<usize>() - 7
    }

    /// Functions at a place of [0, 1]².
    pub(super) fn at(&self, place: [f64; 2]) -> CellFunctions {
        self.divided(place, DEEPEST)
    }

    fn divided(&self, [s, t]: [f64; 2], deep: usize) -> CellFunctions {
        if deep == 0 || self.0.iter().all(|face| face.len() == REGULAR) {
            return self.regular([s, t]);
        }
        let (right, upper) = (s >= 0.5, t >= 0.5);
        let part = match (right, upper) {
            (true, true) => 0,
            (false, true) => 1,
            (false, false) => 2,
            (true, false) => 3,
        };
        let inner = |x: f64, far: bool| 2.0 * x - if far { 1.0 } else { 0.0 };
        let mut found = self.part(part).divided([inner(s, right), inner(t, upper)], deep - 1);
        for (row, factor) in found.derivatives.iter_mut().zip([2.0, 2.0, 4.0, 4.0, 4.0]) {
            row.iter_mut().for_each(|x| *x *= factor);
        }
        found
    }

    /// The new point of a corner of a face.
    fn point(&self, face: usize, corner: usize) -> ControlShares {
        let points = &self.0[face];
        let n = points.len();
        let mut sum = [0.0; MOST_FUNCTIONS];
        for (k, point) in points.iter().enumerate() {
            let share = face_share(n, (k + n - corner) % n);
            sum.iter_mut().zip(point).for_each(|(sum, x)| *sum += share * x);
        }
        sum
    }

    /// The cell of the new point in a face.
    fn part(&self, i: usize) -> Self {
        let [after, over, before] = [1, 2, 3].map(|k| (i + k) % 4);
        let last = |face: usize| self.0[face].len() - 1;
        let own = self.point(i, 0);
        let inside = (0..self.0[i].len()).map(|k| self.point(i, k)).collect();
        let first = vec![own, self.point(i, last(i)), self.point(after, 1), self.point(after, 0)];
        let middle = vec![own, first[3], self.point(over, 0), self.point(before, 0)];
        let second = vec![own, middle[3], self.point(before, last(before)), self.point(i, 1)];
        let mut faces = [inside, first, middle, second];
        faces.rotate_right(i);
        Self(faces)
    }

    fn regular(&self, [s, t]: [f64; 2]) -> CellFunctions {
        let [f0, f1, f2, f3] = &self.0;
        // Rows of rising t, each of rising s.
        let grid = [f2[2], f2[3], f3[2], f1[3], f0[0], f0[1], f1[2], f0[3], f0[2]];
        let basis = |x: f64| {
            [
                [0.5 * (1.0 - x) * (1.0 - x), 0.5 + x - x * x, 0.5 * x * x],
                [x - 1.0, 1.0 - 2.0 * x, x],
                [1.0, -2.0, 1.0],
            ]
        };
        let (a, b) = (basis(s), basis(t));
        let row = |i: usize, j: usize| -> ControlShares {
            let mut sum = [0.0; MOST_FUNCTIONS];
            for (k, point) in grid.iter().enumerate() {
                let share = a[i][k % 3] * b[j][k / 3];
                sum.iter_mut().zip(point).for_each(|(sum, x)| *sum += share * x);
            }
            sum
        };
        CellFunctions {
            value: row(0, 0),
            derivatives: [row(1, 0), row(0, 1), row(2, 0), row(0, 2), row(1, 1)],
        }
    }
}

/// Share of a corner of a face with `n` corners in the new point of the one that is `away` from it.
fn face_share(n: usize, away: usize) -> f64 {
    let n = n as f64;
    match away {
        0 => (n + 5.0) / (4.0 * n),
        _ => (3.0 + 2.0 * libm::cos(TAU * away as f64 / n)) / (4.0 * n),
    }
}

#[cfg(test)]
mod tests {
    use super::{CellFaces, face_share};

    #[test]
    fn shares_of_a_face_are_those_of_the_paper() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        [9.0, 3.0, 1.0, 3.0].iter().enumerate().for_each(|(k, x)| near(face_share(4, k), x / 16.0));
        for n in 3..8 {
            near((0..n).map(|k| face_share(n, k)).sum(), 1.0);
        }
    }

    /// Dividing a regular cell changes none of its functions; those of others join smoothly where
    /// parts meet.
    #[test]
    fn parts_of_a_cell_are_the_cell() {
        let regular = CellFaces::new([4; 4]);
        for place in [[0.1, 0.2], [0.7, 0.3], [0.9, 0.8], [0.2, 0.6]] {
            let whole = regular.at(place);
            let part = match place {
                [s, t] if s >= 0.5 && t >= 0.5 => 0,
                [_, t] if t >= 0.5 => 1,
                [s, _] if s < 0.5 => 2,
                _ => 3,
            };
            let [s, t] = place.map(|x: f64| 2.0 * x - if x >= 0.5 { 1.0 } else { 0.0 });
            let inner = regular.part(part).at([s, t]);
            for k in 0..9 {
                assert!((whole.value[k] - inner.value[k]).abs() < 1e-15);
                assert!((whole.derivatives[4][k] - 4.0 * inner.derivatives[4][k]).abs() < 1e-14);
            }
        }
        for corners in [[3, 4, 4, 4], [4, 5, 4, 3], [4, 4, 4, 6]] {
            let (faces, functions) = (CellFaces::new(corners), CellFaces::functions(corners));
            let near = [[0.5 - 1e-9, 0.3], [0.5 + 1e-9, 0.3]].map(|place| faces.at(place));
            for k in 0..functions {
                for d in 0..2 {
                    let [a, b] = [0, 1].map(|i| near[i].derivatives[d][k]);
                    assert!((a - b).abs() < 1e-7, "{corners:?}: {a} {b}");
                }
            }
            assert!(near[0].value[functions..].iter().all(|x| *x == 0.0));
        }
    }
}
