//! Quadratic B-splines with the MLS gradient, on 27 nodes of 4-wide vectors.

use super::grid::AROUND;
use cullet_geometry::{Mat3, Vec3};
use wide::f64x4;

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

/// Adds −V P ∇w to the nodes' forces: `columns` are those of −V P times 4/h by axis.
#[inline]
pub fn scatter(nodes: &mut [f64x4; AROUND], s: &Stencil, columns: &[f64x4; 3]) {
    let wz = s.weight[2].map(f64x4::splat);
    let wdz = std::array::from_fn::<_, 3, _>(|k| f64x4::splat(s.weight[2][k] * s.away[2][k]));
    for i in 0..3 {
        let wx = f64x4::splat(s.weight[0][i]);
        let at_x = wx * columns[0] * f64x4::splat(s.away[0][i]);
        let (by, bz) = (wx * columns[1], wx * columns[2]);
        for j in 0..3 {
            let wy = f64x4::splat(s.weight[1][j]);
            let at = wy * (at_x + by * f64x4::splat(s.away[1][j]));
            let along = wy * bz;
            let row = &mut nodes[9 * i + 3 * j..9 * i + 3 * j + 3];
            row[0] += wz[0] * at + wdz[0] * along;
            row[1] += wz[1] * at + wdz[1] * along;
            row[2] += wz[2] * at + wdz[2] * along;
        }
    }
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

#[cfg(test)]
mod tests {
    use super::{AROUND, Stencil, gather, packed, scatter, vector};
    use cullet_geometry::{Mat3, Vec3, math::unit};
    use wide::f64x4;

    /// The slow twin: the textbook weight of a node at `place` for a point at `x`.
    fn naive(x: &Vec3, place: &Vec3, spacing: &Vec3) -> (f64, Vec3) {
        let n = |r: f64| match r.abs() {
            r if r < 0.5 => 0.75 - r * r,
            r if r < 1.5 => 0.5 * (1.5 - r) * (1.5 - r),
            _ => 0.0,
        };
        let away = place - x;
        let w: f64 = (0..3).map(|a| n(away[a] / spacing[a])).product();
        let gradient = (0..3).map(|a| 4.0 * w * away[a] / (spacing[a] * spacing[a]));
        (w, Vec3::from_iterator(gradient))
    }

    #[test]
    fn transfers_agree_with_the_textbook() {
        let (spacing, x) = (Vec3::new(0.5, 0.4, 0.25), Vec3::new(1.21, -1.87, 2.2));
        let gain = spacing.map(|h| 4.0 / h);
        let s = Stencil::new(&x, &spacing);
        let value = |k: usize| Vec3::from([0, 1, 2].map(|a| unit(7, a, k as u64) - 0.5));
        let nodes: [f64x4; AROUND] = std::array::from_fn(|k| packed(value(k)));
        let stress = Mat3::new(1.0, 2.0, 3.0, -1.0, 0.5, 0.1, 0.7, -0.3, 0.2);
        let columns = [0, 1, 2].map(|a| packed(stress.column(a) * gain[a]));
        let mut forces = [f64x4::splat(0.0); AROUND];
        scatter(&mut forces, &s, &columns);
        let (mut sum, mut gradient) = (Vec3::zeros(), Mat3::zeros());
        for k in 0..AROUND {
            let place = [s.cell[0] + k as i32 / 9, s.cell[1] + k as i32 / 3 % 3];
            let place = [place[0], place[1], s.cell[2] + k as i32 % 3].map(f64::from);
            let (w, g) = naive(&x, &Vec3::from(place).component_mul(&spacing), &spacing);
            sum += value(k) * w;
            gradient += value(k) * g.transpose();
            assert!((vector(forces[k]) - stress * g).norm() < 1e-13, "node {k}");
        }
        let (a, g) = gather(&nodes, &s, &gain);
        assert!((a - sum).norm() < 1e-14);
        assert!((g - gradient).norm() < 1e-13);
    }
}
