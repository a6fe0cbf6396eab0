//! The nodes around a set of points, as one dense array.

use super::blocks::base_cell;
use super::kernel::Stencil;
use cullet_geometry::Vec3;

/// The nodes that the quadratic kernels of some points reach.
pub(crate) struct Lattice {
    pub(crate) origin: [i32; 3],
    pub(crate) size: [usize; 3],
    pub(crate) spacing: f64,
}

impl Lattice {
    pub(crate) fn new(points: &[Vec3], spacing: f64) -> Self {
        let mut low = [i32::MAX; 3];
        let mut high = [i32::MIN; 3];
        for x in points {
            let cell = base_cell(x, 1.0 / spacing);
            for a in 0..3 {
                low[a] = low[a].min(cell[a]);
                high[a] = high[a].max(cell[a]);
            }
        }
        let size = std::array::from_fn(|a| (high[a] - low[a]).max(0) as usize + 3);
        Self { origin: low, size, spacing }
    }

    pub(crate) fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Calls `visit(node, weight, distance)` for the 27 nodes around `x` that are in the array; the
    /// distance is node less point, in spacings.
    pub(crate) fn visit(&self, x: &Vec3, mut visit: impl FnMut(usize, f64, [f64; 3])) {
        let inverse = 1.0 / self.spacing;
        let cell = base_cell(x, inverse);
        let stencil = Stencil::new(x, cell, 1.0, 1.0);
        let _ = stencil;
        let s = Stencil::new(&(x * inverse), cell, 1.0, 1.0);
        let at = |a: usize, k: usize| (cell[a] - self.origin[a]) + k as i32;
        for n in 0..27 {
            let k = [n / 9, n / 3 % 3, n % 3];
            let place: [i32; 3] = std::array::from_fn(|a| at(a, k[a]));
            if (0..3).any(|a| place[a] < 0 || place[a] >= self.size[a] as i32) {
                continue;
            }
            let node =
                (place[0] as usize * self.size[1] + place[1] as usize) * self.size[2] + place[2] as usize;
            let weight = s.weight[0][k[0]] * s.weight[1][k[1]] * s.weight[2][k[2]];
            visit(node, weight, std::array::from_fn(|a| s.distance[a][k[a]]));
        }
    }

    /// Calls `visit` with the low corner \[m\] of each cell between nodes of the array.
    pub(crate) fn cells(&self, mut visit: impl FnMut(Vec3)) {
        for i in 0..self.size[0] {
            for j in 0..self.size[1] {
                for k in 0..self.size[2] {
                    let at = [i, j, k];
                    let low: [f64; 3] =
                        std::array::from_fn(|a| f64::from(self.origin[a] + at[a] as i32) * self.spacing);
                    visit(Vec3::from(low));
                }
            }
        }
    }
}
