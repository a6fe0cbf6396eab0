//! Which block of 4³ cells each point is in, and which arenas meet at each block of nodes.

use crate::particles::Particles;
use cullet_geometry::Vec3;

/// Cells along an edge of a block.
pub const EDGE: usize = 4;
/// Nodes of a block.
pub const NODES: usize = EDGE * EDGE * EDGE;
/// Nodes along an edge of an arena: 4 cells reach 6 nodes, and one more each side is slack, so that
/// a point may drift a whole cell before the blocks are made anew.
pub const ARENA_EDGE: usize = EDGE + 4;
/// Nodes of an arena.
pub const ARENA: usize = ARENA_EDGE * ARENA_EDGE * ARENA_EDGE;
/// Largest local base cell whose three nodes lie inside the arena.
pub const LAST_CELL: i32 = ARENA_EDGE as i32 - 3;
/// No such block.
pub const NONE: u32 = u32::MAX;

/// Blocks with points, and blocks of nodes that any arena touches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    /// Block coordinates, ascending.
    pub filled: Vec<[i32; 3]>,
    /// First point of each filled block, then the number of points.
    pub starts: Vec<u32>,
    /// Coordinates of blocks of nodes, ascending.
    pub nodes: Vec<[i32; 3]>,
    /// For each filled block its 27 blocks of nodes, offset −1 first, z fastest.
    pub nodes_of: Vec<[u32; 27]>,
    /// For each block of nodes the 27 filled blocks around it, likewise, or [`NONE`].
    pub filled_around: Vec<[u32; 27]>,
}

/// The base cell of a point: its quadratic kernel reaches this node and the next two.
#[must_use]
#[inline]
pub fn base_cell(position: &Vec3, inverse: f64) -> [i32; 3] {
    let cell = |x: f64| {
        // floor without a library call, which plain x86-64 would make
        let y = x * inverse - 0.5;
        let whole = y as i32;
        whole - i32::from(f64::from(whole) > y)
    };
    [cell(position.x), cell(position.y), cell(position.z)]
}

/// The node at the low corner of a block's arena.
#[must_use]
#[inline]
pub fn arena_origin(block: [i32; 3]) -> [i32; 3] {
    block.map(|b| b * EDGE as i32 - 1)
}

impl Blocks {
    /// Sorts the points by block and cell, ties by id, and finds the neighbours.
    #[must_use]
    pub fn bin(particles: &mut Particles, spacing: f64) -> Self {
        let inverse = 1.0 / spacing;
        let mut keys: Vec<([i32; 3], [i32; 3], u32, u32)> = particles
            .position
            .iter()
            .enumerate()
            .map(|(p, x)| {
                let cell = base_cell(x, inverse);
                let block = cell.map(|c| c.div_euclid(EDGE as i32));
                (block, cell, particles.id[p], p as u32)
            })
            .collect();
        keys.sort_unstable();
        let order: Vec<u32> = keys.iter().map(|key| key.3).collect();
        particles.reorder(&order);
        let mut filled: Vec<[i32; 3]> = Vec::new();
        let mut starts = Vec::new();
        for (p, key) in keys.iter().enumerate() {
            if filled.last() != Some(&key.0) {
                filled.push(key.0);
                starts.push(p as u32);
            }
        }
        starts.push(keys.len() as u32);
        Self::connect(filled, starts)
    }

    fn connect(filled: Vec<[i32; 3]>, starts: Vec<u32>) -> Self {
        let mut nodes: Vec<[i32; 3]> =
            filled.iter().flat_map(|&b| (0..27).map(move |o| shift(b, o, 1))).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let find = |list: &[[i32; 3]], key: [i32; 3]| {
            list.binary_search(&key).map_or(NONE, |at| at as u32)
        };
        let around =
            |list: &[[i32; 3]], b: [i32; 3]| std::array::from_fn(|o| find(list, shift(b, o, 1)));
        let nodes_of = filled.iter().map(|&b| around(&nodes, b)).collect();
        let filled_around = nodes.iter().map(|&b| around(&filled, b)).collect();
        Self { filled, starts, nodes, nodes_of, filled_around }
    }
}

/// The block at offset `o` (27 offsets, z fastest) from `b`.
fn shift(b: [i32; 3], o: usize, by: i32) -> [i32; 3] {
    let d = offset(o);
    [b[0] + by * d[0], b[1] + by * d[1], b[2] + by * d[2]]
}

/// The `o`-th of the 27 offsets in {−1, 0, 1}³, z fastest.
#[must_use]
#[inline]
pub fn offset(o: usize) -> [i32; 3] {
    [(o / 9) as i32 - 1, (o / 3 % 3) as i32 - 1, (o % 3) as i32 - 1]
}

#[cfg(test)]
mod tests {
    use super::{Blocks, EDGE, base_cell};
    use crate::particles::Particles;
    use cullet_geometry::{Vec3, math::unit};

    #[test]
    fn every_point_lies_in_its_block() {
        let points: Vec<Vec3> = (0..500)
            .map(|i| Vec3::new(unit(1, 0, i) - 0.5, unit(1, 1, i), -unit(1, 2, i)))
            .collect();
        let mut particles = Particles::at_rest(&points, 1.0, 1.0);
        let blocks = Blocks::bin(&mut particles, 0.05);
        assert_eq!(*blocks.starts.last().expect("ends with the count"), 500);
        for (b, block) in blocks.filled.iter().enumerate() {
            for p in blocks.starts[b] as usize..blocks.starts[b + 1] as usize {
                let cell = base_cell(&particles.position[p], 1.0 / 0.05);
                assert_eq!(cell.map(|c| c.div_euclid(EDGE as i32)), *block);
                assert_eq!(points[particles.id[p] as usize], particles.position[p]);
            }
        }
        assert!(blocks.nodes_of.iter().flatten().all(|&n| (n as usize) < blocks.nodes.len()));
    }
}
