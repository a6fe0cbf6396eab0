//! The nodes of a lattice in crushed zones, and how they lie in the body.

use super::rules::{FULL_WEIGHT, HALF_BAND, LEAST_WEIGHT, STREAM};
use crate::mpm::lattice::KernelLattice;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;

/// Below this sum of what is missing around a node, in weights times cells, it is inside.
const EVEN: f64 = 60.0;

/// Cells below the skin to which pieces are plates along it.
const SKIN: f64 = 2.5;

impl KernelLattice {
    /// Which way is out of the body at the nodes that are near its skin; zero elsewhere.
    pub(super) fn skin(&self, weights: &[f64]) -> Vec<Vec3> {
        let out = |node: usize| {
            let mut way = Vec3::zeros();
            if weights[node] >= LEAST_WEIGHT {
                self.around(node, SKIN, |near| {
                    let arm = self.at(near) - self.at(node);
                    let within = arm.norm_squared() <= SKIN * SKIN;
                    if within {
                        way += arm * (FULL_WEIGHT - weights[near]).max(0.0);
                    }
                });
            }
            way.try_normalize(EVEN).unwrap_or_default()
        };
        (0..self.len()).map(out).collect()
    }

    /// Calls `visit(node)` for the nodes at most `reach` cells from one, along each axis.
    pub(super) fn around(&self, node: usize, reach: f64, mut visit: impl FnMut(usize)) {
        let [sx, y, z] = self.size;
        let reach = reach.ceil() as usize;
        let range = |at: usize, size: usize| at.saturating_sub(reach)..size.min(at + reach + 1);
        for i in range(node / (y * z), sx) {
            for j in range(node / z % y, y) {
                for k in range(node % z, z) {
                    visit((i * y + j) * z + k);
                }
            }
        }
    }

    /// Nodes of the body farther than half a band from any whole node.
    pub(super) fn crushed(&self, weights: &[f64], whole: &[bool]) -> Vec<usize> {
        let reach = HALF_BAND.floor() as i32 + 1;
        let [_, y, z] = self.size;
        let near: Vec<[i32; 3]> = (0..(2 * reach + 1).pow(3))
            .map(|o| {
                let side = 2 * reach + 1;
                [o / (side * side) - reach, o / side % side - reach, o % side - reach]
            })
            .filter(|d| f64::from(d.iter().map(|c| c * c).sum::<i32>()) <= HALF_BAND * HALF_BAND)
            .collect();
        let holds = |n: usize, d: &[i32; 3]| {
            let place = [n / (y * z), n / z % y, n % z];
            let at: [i32; 3] = std::array::from_fn(|a| place[a] as i32 + d[a]);
            if (0..3).any(|a| at[a] < 0 || at[a] >= self.size[a] as i32) {
                return false;
            }
            let other = (at[0] as usize * y + at[1] as usize) * z + at[2] as usize;
            whole[other]
        };
        (0..self.len())
            .filter(|&n| weights[n] >= LEAST_WEIGHT && !whole[n])
            .filter(|&n| !near.iter().any(|d| holds(n, d)))
            .collect()
    }

    /// Where a node is, in cells, moved a little so that no two distances are equal.
    pub(super) fn place(&self, n: usize, seed: u64) -> Vec3 {
        let off = |axis: u64| unit(seed, STREAM + axis, n as u64) - 0.5;
        self.at(n) + Vec3::new(off(0), off(1), off(2))
    }
}
