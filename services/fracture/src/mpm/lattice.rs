//! The nodes around a set of points, as one dense array.

use super::stencil::Stencil;
use cullet_geometry::Vec3;

/// The nodes that the kernels of some points reach, z fastest.
pub(crate) struct KernelLattice {
    pub(crate) size: [usize; 3],
    /// Size of a cell by axis \[m\].
    pub(crate) spacing: Vec3,
    origin: [i32; 3],
}

impl KernelLattice {
    pub(crate) fn new(points: &[Vec3], spacing: Vec3) -> Self {
        let mut low = [i32::MAX; 3];
        let mut high = [i32::MIN; 3];
        for x in points {
            let cell = Stencil::new(x, &spacing).cell;
            for a in 0..3 {
                low[a] = low[a].min(cell[a]);
                high[a] = high[a].max(cell[a]);
            }
        }
        if points.is_empty() {
            (low, high) = ([0; 3], [0; 3]);
        }
        let size = std::array::from_fn(|a| (high[a] - low[a]) as usize + 3);
        Self { size, spacing, origin: low }
    }

    pub(crate) fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Calls `visit(node, weight, distance)` for the nodes of the array among the 27 around `x`;
    /// the distance is node less point, in cells.
    #[inline]
    pub(crate) fn visit(&self, x: &Vec3, mut visit: impl FnMut(usize, f64, Vec3)) {
        let Stencil { cell, weight, away } = Stencil::new(x, &self.spacing);
        let first: [i32; 3] = std::array::from_fn(|a| cell[a] - self.origin[a]);
        let within = |a: usize, k: usize| {
            let place = first[a] + k as i32;
            (place >= 0 && (place as usize) < self.size[a]).then_some(place as usize)
        };
        for i in 0..3 {
            let Some(x) = within(0, i) else { continue };
            for j in 0..3 {
                let Some(y) = within(1, j) else { continue };
                for k in 0..3 {
                    let Some(z) = within(2, k) else { continue };
                    let node = (x * self.size[1] + y) * self.size[2] + z;
                    let apart = Vec3::new(away[0][i], away[1][j], away[2][k]);
                    visit(node, weight[0][i] * weight[1][j] * weight[2][k], apart);
                }
            }
        }
    }

    /// Where a node is, in cells.
    pub(crate) fn at(&self, node: usize) -> Vec3 {
        let [_, y, z] = self.size;
        let at = [node / (y * z), node / z % y, node % z];
        Vec3::from_fn(|a, _| f64::from(self.origin[a] + at[a] as i32))
    }

    /// Calls `visit(node, place)` for each node, in order; the place is in metres.
    pub(crate) fn nodes(&self, mut visit: impl FnMut(usize, Vec3)) {
        for node in 0..self.len() {
            visit(node, self.at(node).component_mul(&self.spacing));
        }
    }
}
