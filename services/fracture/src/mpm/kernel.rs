//! Transfers between one block's points and its arena: one 4-wide vector [m, p] or [–, v] a node.

use super::blocks::{ARENA_EDGE, base_cell};
use cullet_geometry::{Mat3, Vec3};
use wide::f64x4;

/// Quadratic B-spline weights of the three nodes along each axis, and their distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// First node of the 27 in the arena.
    pub first: usize,
    /// Weight by axis and node \[1\].
    pub weight: [[f64; 3]; 3],
    /// Node less point by axis and node \[m\].
    pub distance: [[f64; 3]; 3],
}

impl Stencil {
    /// The stencil of a point; `origin` is the node at the arena's low corner. The point's base
    /// cell must lie in the arena.
    #[must_use]
    #[inline]
    pub fn new(position: &Vec3, origin: [i32; 3], spacing: f64, inverse: f64) -> Self {
        let mut first = 0;
        let mut weight = [[0.0; 3]; 3];
        let mut distance = [[0.0; 3]; 3];
        let base = base_cell(position, inverse);
        for axis in 0..3 {
            let f = position[axis] * inverse - f64::from(base[axis]);
            let (low, high, mid) = (1.5 - f, f - 0.5, f - 1.0);
            weight[axis] = [0.5 * low * low, 0.75 - mid * mid, 0.5 * high * high];
            distance[axis] = [-f * spacing, -mid * spacing, (2.0 - f) * spacing];
            first = first * ARENA_EDGE + (base[axis] - origin[axis]) as usize;
        }
        Self { first, weight, distance }
    }
}

/// What a point gives to node i: w (`constant` + `slope`·d), d = x_i − x_p.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    /// [m, m v].
    pub constant: f64x4,
    /// Columns of [0, mC − Δt V (4/h²) τ].
    pub slope: [f64x4; 3],
}

/// Adds a point's share to the nodes of its stencil.
#[inline]
pub fn scatter(arena: &mut [f64x4], s: &Stencil, share: &Share) {
    let wz = s.weight[2].map(f64x4::splat);
    let wdz = std::array::from_fn::<_, 3, _>(|k| f64x4::splat(s.weight[2][k] * s.distance[2][k]));
    for i in 0..3 {
        let wx = f64x4::splat(s.weight[0][i]);
        let at_x = wx * (share.constant + share.slope[0] * f64x4::splat(s.distance[0][i]));
        let (by, bz) = (wx * share.slope[1], wx * share.slope[2]);
        for j in 0..3 {
            let wy = f64x4::splat(s.weight[1][j]);
            let at = wy * (at_x + by * f64x4::splat(s.distance[1][j]));
            let along = wy * bz;
            let start = s.first + (i * ARENA_EDGE + j) * ARENA_EDGE;
            let row = &mut arena[start..start + 3];
            row[0] += wz[0] * at + wdz[0] * along;
            row[1] += wz[1] * at + wdz[1] * along;
            row[2] += wz[2] * at + wdz[2] * along;
        }
    }
}

/// Velocity Σ w v_i \[m/s\] and C = (4/h²) Σ w v_i (x_i − x_p)ᵀ \[1/s\]; `gain` is 4/h².
#[must_use]
#[inline]
pub fn gather(arena: &[f64x4], s: &Stencil, gain: f64) -> (Vec3, Mat3) {
    let zero = f64x4::splat(0.0);
    let wz = s.weight[2].map(f64x4::splat);
    let wdz = std::array::from_fn::<_, 3, _>(|k| f64x4::splat(s.weight[2][k] * s.distance[2][k]));
    let (mut v, mut cx, mut cy, mut cz) = (zero, zero, zero, zero);
    for i in 0..3 {
        let (mut vi, mut cyi, mut czi) = (zero, zero, zero);
        for j in 0..3 {
            let start = s.first + (i * ARENA_EDGE + j) * ARENA_EDGE;
            let row = &arena[start..start + 3];
            let sum = wz[0] * row[0] + wz[1] * row[1] + wz[2] * row[2];
            let moment = wdz[0] * row[0] + wdz[1] * row[1] + wdz[2] * row[2];
            let wy = s.weight[1][j];
            vi += f64x4::splat(wy) * sum;
            cyi += f64x4::splat(wy * s.distance[1][j]) * sum;
            czi += f64x4::splat(wy) * moment;
        }
        let wx = s.weight[0][i];
        v += f64x4::splat(wx) * vi;
        cx += f64x4::splat(wx * s.distance[0][i]) * vi;
        cy += f64x4::splat(wx) * cyi;
        cz += f64x4::splat(wx) * czi;
    }
    let gain = f64x4::splat(gain);
    let columns = [cx * gain, cy * gain, cz * gain].map(f64x4::to_array);
    let v = v.to_array();
    let c = columns.map(|c| Vec3::new(c[1], c[2], c[3]));
    (Vec3::new(v[1], v[2], v[3]), Mat3::from_columns(&c))
}

#[cfg(test)]
mod tests {
    use super::{Share, Stencil, gather, scatter};
    use crate::mpm::blocks::{ARENA, ARENA_EDGE};
    use cullet_geometry::{Mat3, Vec3};
    use wide::f64x4;

    /// The slow twin: one loop over 27 nodes with the textbook weight.
    fn naive_weight(position: &Vec3, node: [usize; 3], spacing: f64) -> (f64, Vec3) {
        let at = Vec3::new(node[0] as f64, node[1] as f64, node[2] as f64) * spacing;
        let d = at - position;
        let n = |x: f64| {
            let r = x.abs() / spacing;
            if r < 0.5 {
                0.75 - r * r
            } else if r < 1.5 {
                0.5 * (1.5 - r) * (1.5 - r)
            } else {
                0.0
            }
        };
        (n(d.x) * n(d.y) * n(d.z), d)
    }

    #[test]
    fn transfers_agree_with_the_textbook() {
        let (spacing, position) = (0.5, Vec3::new(1.21, 1.87, 2.2));
        let stencil = Stencil::new(&position, [0, 0, 0], spacing, 1.0 / spacing);
        let share = Share {
            constant: f64x4::new([2.0, 0.3, -0.4, 0.5]),
            slope: [
                f64x4::new([0.0, 1.0, 2.0, 3.0]),
                f64x4::new([0.0, -1.0, 0.5, 0.1]),
                f64x4::new([0.0, 0.7, -0.3, 0.2]),
            ],
        };
        let mut arena = vec![f64x4::splat(0.0); ARENA];
        scatter(&mut arena, &stencil, &share);
        let (velocity, affine) = gather(&arena, &stencil, 4.0 / (spacing * spacing));
        let (mut v, mut c) = (Vec3::zeros(), Mat3::zeros());
        for (n, value) in arena.iter().enumerate() {
            let node = [n / (ARENA_EDGE * ARENA_EDGE), n / ARENA_EDGE % ARENA_EDGE, n % ARENA_EDGE];
            let (w, d) = naive_weight(&position, node, spacing);
            let slope = share.slope.map(f64x4::to_array);
            let got = value.to_array();
            for lane in 0..4 {
                let sum = slope[0][lane] * d.x + slope[1][lane] * d.y + slope[2][lane] * d.z;
                let wanted = w * (share.constant.to_array()[lane] + sum);
                assert!((got[lane] - wanted).abs() < 1e-14, "node {n} lane {lane}");
            }
            let node_velocity = Vec3::new(got[1], got[2], got[3]);
            v += node_velocity * w;
            c += node_velocity * d.transpose() * w * (4.0 / (spacing * spacing));
        }
        assert!((velocity - v).norm() < 1e-14);
        assert!((affine - c).norm() < 1e-13);
    }
}
