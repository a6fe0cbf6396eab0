//! The functions of Loop's subdivision surface in a triangle \[Stam 1998; Cirak, Ortiz & Schröder
//! 2000\].
//!
//! Where all three corners have six neighbours they are the twelve pieces of the quartic box
//! spline, closed forms in the barycentric coordinates u, v, w. Elsewhere one step of subdivision
//! makes the middle one of four smaller triangles such a place, whatever the valences: its control
//! points are sums over those of the triangle, and its parameters run backwards at half the scale.

use crate::midsurface::TablePoint;
use cullet_geometry::nurbs::MOST_FUNCTIONS;

/// Functions of a triangle whose corners have six neighbours each.
const REGULAR: usize = 12;

/// Area of a triangle in its parameters.
const AREA: f64 = 0.5;

/// A term of a polynomial: factor, and powers of u, v, w.
type Term = (f64, [i32; 3]);

/// Twelve times the function of the corner where u is 1.
const CORNER: [Term; 15] = [
    (6.0, [4, 0, 0]),
    (24.0, [3, 1, 0]),
    (24.0, [3, 0, 1]),
    (24.0, [2, 2, 0]),
    (60.0, [2, 1, 1]),
    (24.0, [2, 0, 2]),
    (8.0, [1, 3, 0]),
    (36.0, [1, 2, 1]),
    (36.0, [1, 1, 2]),
    (8.0, [1, 0, 3]),
    (1.0, [0, 4, 0]),
    (6.0, [0, 3, 1]),
    (12.0, [0, 2, 2]),
    (6.0, [0, 1, 3]),
    (1.0, [0, 0, 4]),
];

/// Twelve times the function of the control point across the edge from u to v.
const ACROSS: [Term; 9] = [
    (1.0, [4, 0, 0]),
    (6.0, [3, 1, 0]),
    (12.0, [2, 2, 0]),
    (6.0, [1, 3, 0]),
    (1.0, [0, 4, 0]),
    (2.0, [3, 0, 1]),
    (6.0, [2, 1, 1]),
    (6.0, [1, 2, 1]),
    (2.0, [0, 3, 1]),
];

/// Twelve times the function of a control point that is joined to the corner u only, next to the
/// one across the edge from u to v.
const BESIDE: [Term; 2] = [(1.0, [4, 0, 0]), (2.0, [3, 1, 0])];

/// Value and derivatives R, R,1 R,2 R,11 R,22 R,12 of functions.
type RowsOf<const N: usize> = [[f64; N]; 6];

/// The functions of a regular triangle at v = ξ¹, w = ξ², u = 1 − ξ¹ − ξ². In order: the corners,
/// then for each corner in turn the control point across the edge before it, and the two that are
/// joined to it only, counter-clockwise.
fn regular([v, w]: [f64; 2]) -> RowsOf<REGULAR> {
    let at = [1.0 - v - w, v, w];
    let mut rows = [[0.0; REGULAR]; 6];
    for corner in 0..3 {
        let [u, v, w] = [corner, (corner + 1) % 3, (corner + 2) % 3];
        let first = 3 + 3 * corner;
        let functions: [(usize, &[Term], [usize; 3]); 4] = [
            (corner, &CORNER, [u, v, w]),
            (first, &ACROSS, [w, u, v]),
            (first + 1, &BESIDE, [u, w, v]),
            (first + 2, &BESIDE, [u, v, w]),
        ];
        for (k, terms, axes) in functions {
            let found = polynomial(terms, axes, at);
            (0..6).for_each(|row| rows[row][k] = found[row]);
        }
    }
    rows
}

/// R, R,1 R,2 R,11 R,22 R,12 of a twelfth of a polynomial in the barycentric coordinates `axes`.
fn polynomial(terms: &[Term], axes: [usize; 3], at: [f64; 3]) -> [f64; 6] {
    let mut rows = [0.0; 6];
    for (factor, powers) in terms {
        let mut power = [0; 3];
        (0..3).for_each(|k| power[axes[k]] = powers[k]);
        // The derivative by barycentric coordinates `by` of the product of powers.
        let derivative = |by: &[usize]| -> f64 {
            let mut product = *factor / 12.0;
            for k in 0..3 {
                let mut left = power[k];
                for _ in by.iter().filter(|&&axis| axis == k) {
                    product *= f64::from(left);
                    left -= 1;
                }
                (0..left.max(0)).for_each(|_| product *= at[k]);
            }
            product
        };
        let second = |a: usize, b: usize| {
            derivative(&[a, b]) - derivative(&[a, 0]) - derivative(&[0, b]) + derivative(&[0, 0])
        };
        rows[0] += derivative(&[]);
        rows[1] += derivative(&[1]) - derivative(&[0]);
        rows[2] += derivative(&[2]) - derivative(&[0]);
        rows[3] += second(1, 1);
        rows[4] += second(2, 2);
        rows[5] += second(1, 2);
    }
    rows
}

/// Share of each neighbour of a control point with `valence` of them in its new place after a step
/// of subdivision: β = (5/8 − (3/8 + ¼ cos 2π/n)²)/n \[Loop 1987\].
fn smoothing(valence: usize) -> f64 {
    let n = valence as f64;
    let inner = 0.375 + 0.25 * libm::cos(std::f64::consts::TAU / n);
    (0.625 - inner * inner) / n
}

/// Share of each neighbour of a control point in the place on the surface that it tends to:
/// 1/(n + 3/(8β)).
pub(super) fn limit_share(valence: usize) -> f64 {
    1.0 / (valence as f64 + 0.375 / smoothing(valence))
}

/// How the control points of a triangle are counted whose corners have so many neighbours: the
/// corners, then for each corner in turn those of its neighbours, counter-clockwise, that the
/// triangle before it does not have, less the last, which the next corner has too.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleCount {
    pub(super) valences: [usize; 3],
}

impl TriangleCount {
    /// Control points.
    pub(super) fn all(&self) -> usize {
        (self.valences.iter().sum::<usize>()).saturating_sub(6)
    }

    /// The number of neighbour `k` of a corner, counter-clockwise from the next corner on.
    fn neighbour(&self, corner: usize, k: usize) -> usize {
        let k = k % self.valences[corner];
        match k {
            0 => (corner + 1) % 3,
            1 => (corner + 2) % 3,
            k if k + 1 == self.valences[corner] => self.neighbour((corner + 1) % 3, 2),
            k => {
                let before: usize = self.valences[..corner].iter().map(|n| n - 3).sum();
                3 + before + k - 2
            }
        }
    }

    /// Shares in the new place of a corner.
    fn corner_point(&self, corner: usize) -> [f64; MOST_FUNCTIONS] {
        let (n, mut row) = (self.valences[corner], [0.0; MOST_FUNCTIONS]);
        let share = smoothing(n);
        row[corner] = 1.0 - n as f64 * share;
        (0..n).for_each(|k| row[self.neighbour(corner, k)] += share);
        row
    }

    /// Shares in the new control point on the edge from a corner to its neighbour `k`.
    fn edge_point(&self, corner: usize, k: usize) -> [f64; MOST_FUNCTIONS] {
        let (n, mut row) = (self.valences[corner], [0.0; MOST_FUNCTIONS]);
        row[corner] += 0.375;
        row[self.neighbour(corner, k)] += 0.375;
        row[self.neighbour(corner, k + n - 1)] += 0.125;
        row[self.neighbour(corner, k + 1)] += 0.125;
        row
    }

    /// The functions at the triangle's middle, with the whole of its area.
    pub(super) fn middle(&self) -> TablePoint {
        let third = [1.0 / 3.0; 2];
        let rows = regular(third);
        if self.valences == [6; 3] {
            let wide = |row: &[f64; REGULAR]| {
                std::array::from_fn(|k| if k < REGULAR { row[k] } else { 0.0 })
            };
            let derivatives = std::array::from_fn(|d| wide(&rows[d + 1]));
            return TablePoint { weight: AREA, value: wide(&rows[0]), derivatives };
        }
        let mut child = [[0.0; MOST_FUNCTIONS]; REGULAR];
        for corner in 0..3 {
            // Its corner `corner` lies on the edge across from ours.
            let [next, last] = [(corner + 1) % 3, (corner + 2) % 3];
            child[corner] = self.edge_point(next, 0);
            child[3 + 3 * corner] = self.corner_point(next);
            child[4 + 3 * corner] = self.edge_point(next, self.valences[next] - 1);
            child[5 + 3 * corner] = self.edge_point(last, 2);
        }
        let sum = |row: &[f64; REGULAR], scale: f64| {
            let at = |k: usize| row.iter().zip(&child).map(|(r, c)| scale * r * c[k]).sum();
            std::array::from_fn(at)
        };
        let scales = [-2.0, -2.0, 4.0, 4.0, 4.0];
        let derivatives = std::array::from_fn(|d| sum(&rows[d + 1], scales[d]));
        TablePoint { weight: AREA, value: sum(&rows[0], 1.0), derivatives }
    }
}
