//! Quadratic B-splines: the weights of a point at the nodes around it, and sums over those.

use cullet_geometry::{Mat3, Vec3};
use wide::f64x4;

/// Nodes around a point.
pub const AROUND: usize = 27;

/// Weights and distances of the three nodes along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// Place of the first of the 27 nodes.
    pub cell: [i32; 3],
    /// Weight by axis and node \[1\].
    pub weight: [[f64; 3]; 3],
    /// Node less point by axis and node, in cells.
    pub away: [[f64; 3]; 3],
}

impl Stencil {
    /// The stencil of a point at `x` \[m\] on a grid of `spacing` \[m\].
    #[must_use]
    #[inline]
    pub fn new(x: &Vec3, spacing: &Vec3) -> Self {
        let (mut weight, mut away, mut cell) = ([[0.0; 3]; 3], [[0.0; 3]; 3], [0; 3]);
        for axis in 0..3 {
            let place = x[axis] / spacing[axis];
            cell[axis] = floor(place - 0.5);
            let f = place - f64::from(cell[axis]);
            let (low, high, mid) = (1.5 - f, f - 0.5, f - 1.0);
            weight[axis] = [0.5 * low * low, 0.75 - mid * mid, 0.5 * high * high];
            away[axis] = [-f, -mid, 2.0 - f];
        }
        Self { cell, weight, away }
    }

    /// Calls `visit(k, weight, away)` for the 27 nodes, z fastest; `away` is in cells.
    #[inline]
    pub fn visit(&self, mut visit: impl FnMut(usize, f64, Vec3)) {
        for k in 0..AROUND {
            let [i, j, l] = [k / 9, k / 3 % 3, k % 3];
            let weight = self.weight[0][i] * self.weight[1][j] * self.weight[2][l];
            visit(k, weight, Vec3::new(self.away[0][i], self.away[1][j], self.away[2][l]));
        }
    }
}

/// Weight \[1\] of a point at `x` \[m\] at the `k`-th of its 27 nodes, and node less point, in
/// cells: as [`Stencil`] has them.
#[must_use]
#[inline]
pub fn share(x: &Vec3, spacing: &Vec3, k: usize) -> (f64, Vec3) {
    let numbers = [k / 9, k / 3 % 3, k % 3];
    let (mut weight, mut away) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let place = x[axis] / spacing[axis];
        let f = place - f64::from(floor(place - 0.5));
        let (low, high, mid) = (1.5 - f, f - 0.5, f - 1.0);
        (weight[axis], away[axis]) = match numbers[axis] {
            0 => (0.5 * low * low, -f),
            1 => (0.75 - mid * mid, -mid),
            _ => (0.5 * high * high, 2.0 - f),
        };
    }
    (weight[0] * weight[1] * weight[2], Vec3::from(away))
}

/// floor without a library call, which plain x86-64 would make.
#[inline]
fn floor(x: f64) -> i32 {
    let whole = x as i32;
    whole - i32::from(f64::from(whole) > x)
}

/// Σ w a_i and the gradient Σ a_i ⊗ 4 w (x_i − x_p)/h² of node values a; `gain` is 4/h by axis.
#[must_use]
#[inline]
pub fn gather(nodes: &[f64x4; AROUND], s: &Stencil, gain: &Vec3) -> (Vec3, Mat3) {
    let zero = f64x4::splat(0.0);
    let wz = s.weight[2].map(f64x4::splat);
    let wdz = std::array::from_fn::<_, 3, _>(|k| f64x4::splat(s.weight[2][k] * s.away[2][k]));
    let (mut a, mut gx, mut gy, mut gz) = (zero, zero, zero, zero);
    for i in 0..3 {
        let (mut ai, mut gyi, mut gzi) = (zero, zero, zero);
        for j in 0..3 {
            let row = &nodes[9 * i + 3 * j..9 * i + 3 * j + 3];
            let sum = wz[0] * row[0] + wz[1] * row[1] + wz[2] * row[2];
            let moment = wdz[0] * row[0] + wdz[1] * row[1] + wdz[2] * row[2];
            let wy = s.weight[1][j];
            ai += f64x4::splat(wy) * sum;
            gyi += f64x4::splat(wy * s.away[1][j]) * sum;
            gzi += f64x4::splat(wy) * moment;
        }
        let wx = s.weight[0][i];
        a += f64x4::splat(wx) * ai;
        gx += f64x4::splat(wx * s.away[0][i]) * ai;
        gy += f64x4::splat(wx) * gyi;
        gz += f64x4::splat(wx) * gzi;
    }
    let column = |g: f64x4, axis: usize| vector(g * f64x4::splat(gain[axis]));
    (vector(a), Mat3::from_columns(&[column(gx, 0), column(gy, 1), column(gz, 2)]))
}

/// The first three of four.
#[must_use]
#[inline]
pub fn vector(a: f64x4) -> Vec3 {
    let a = a.to_array();
    Vec3::new(a[0], a[1], a[2])
}

/// Three of four, the last zero.
#[must_use]
#[inline]
pub fn packed(a: Vec3) -> f64x4 {
    f64x4::new([a.x, a.y, a.z, 0.0])
}
