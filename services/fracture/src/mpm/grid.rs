//! The background grid: nodes, and the elements through which points see them.
//!
//! Weights are taken where points and nodes were before the hit, once and for all (total
//! Lagrangian): nothing is sorted again, no point leaves its kernel (F15), and no velocity passes
//! through a filter (F05). Nodes carry the state. A node that a crack has passed is there more than
//! once, a copy for each side; the points of one cell that see the same copies are an element.

pub use super::stencil::AROUND;
use super::stencil::Stencil;
use crate::particles::Particles;
use cullet_geometry::Vec3;
use cullet_simd::Incidence;
use wide::f64x4;

/// The points of one cell, which see the same 27 nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct GridElement {
    /// The nodes, z fastest.
    pub nodes: [u32; AROUND],
    /// First point.
    pub first: u32,
    /// Points.
    pub count: u32,
    /// The cell: place of the first node.
    pub cell: [i32; 3],
}

impl GridElement {
    /// The places of its points in the arrays.
    #[must_use]
    pub fn points(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Nodes as a structure of arrays; vectors are \[x, y, z, 0\].
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// Place on the grid; copies share it.
    pub place: Vec<[i32; 3]>,
    /// Mass \[kg\].
    pub mass: Vec<f64>,
    /// Displacement \[m\].
    pub displacement: Vec<f64x4>,
    /// Velocity \[m/s\].
    pub velocity: Vec<f64x4>,
    /// The node that each was copied from, at the start; itself for those of the start.
    pub origin: Vec<u32>,
    /// Which of several bodies each carries.
    pub body: Vec<u8>,
    /// Where the points of a node with copies lie about it, by weight, in cells.
    pub(super) points_offset: Vec<Vec3>,
}

impl Nodes {
    /// How many, copies included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.place.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.place.is_empty()
    }

    /// Nodes at rest without mass.
    fn at(place: Vec<[i32; 3]>) -> Self {
        let n = place.len();
        let zero = vec![f64x4::splat(0.0); n];
        Self {
            place,
            mass: vec![0.0; n],
            displacement: zero.clone(),
            velocity: zero,
            origin: (0..n as u32).collect(),
            body: vec![0; n],
            points_offset: vec![Vec3::zeros(); n],
        }
    }

    /// Adds a copy of a node, moving as it does, without mass.
    pub(super) fn copy(&mut self, node: u32) -> u32 {
        let n = node as usize;
        self.place.push(self.place[n]);
        self.mass.push(0.0);
        self.displacement.push(self.displacement[n]);
        self.velocity.push(self.velocity[n]);
        self.origin.push(self.origin[n]);
        self.body.push(self.body[n]);
        self.points_offset.push(Vec3::zeros());
        (self.place.len() - 1) as u32
    }
}

/// Nodes and elements of a body.
#[derive(Clone, Debug)]
pub struct BackgroundGrid {
    /// Size of a cell along each axis \[m\].
    pub spacing: Vec3,
    /// The nodes.
    pub nodes: Nodes,
    /// The elements, by cell along a Z-order curve.
    pub elements: Vec<GridElement>,
}

impl BackgroundGrid {
    /// Sorts the points by cell, ties by id, and makes the nodes they reach. Cells follow a Z-order
    /// curve, so that elements that follow each other share most of their nodes.
    #[must_use]
    pub fn new(particles: &mut Particles, spacing: Vec3) -> Self {
        let cell_of = |x: &Vec3| Stencil::new(x, &spacing).cell;
        let cells: Vec<[i32; 3]> = particles.reference.iter().map(cell_of).collect();
        let low = cells.iter().fold([i32::MAX; 3], |m, c| [0, 1, 2].map(|a| m[a].min(c[a])));
        let mut keys: Vec<(u64, u32, u32)> = cells
            .iter()
            .enumerate()
            .map(|(p, cell)| (z_order(cell, &low), particles.id[p], p as u32))
            .collect();
        keys.sort_unstable();
        let order: Vec<u32> = keys.iter().map(|key| key.2).collect();
        let sorted: Vec<[i32; 3]> = order.iter().map(|&p| cells[p as usize]).collect();
        particles.reorder(&order);
        let mut places: Vec<[i32; 3]> = Vec::new();
        let mut cells: Vec<([i32; 3], u32, u32)> = Vec::new();
        for (p, &cell) in sorted.iter().enumerate() {
            match cells.last_mut() {
                Some(last) if last.0 == cell => last.2 += 1,
                _ => cells.push((cell, p as u32, 1)),
            }
        }
        for &(cell, _, _) in &cells {
            places.extend((0..AROUND).map(|k| shifted(cell, k)));
        }
        places.sort_unstable();
        places.dedup();
        let find = |place| places.binary_search(&place).map_or(0, |n| n as u32);
        let elements: Vec<GridElement> = cells
            .iter()
            .map(|&(cell, first, count)| GridElement {
                nodes: std::array::from_fn(|k| find(shifted(cell, k))),
                first,
                count,
                cell,
            })
            .collect();
        let nodes = Nodes::at(places);
        let mut grid = Self { spacing, nodes, elements };
        grid.weigh(particles);
        grid
    }

    /// Where each of `nodes` is: element times 27 plus the node's number in it; no rows for others.
    pub(super) fn rows_of(&self, nodes: impl Iterator<Item = u32>) -> Incidence {
        let mut asked = vec![false; self.nodes.len()];
        nodes.for_each(|node| asked[node as usize] = true);
        let mut found: Vec<(u32, u32)> = Vec::new();
        for (row, &node) in self.elements.iter().flat_map(|e| &e.nodes).enumerate() {
            if asked[node as usize] {
                found.push((node, row as u32));
            }
        }
        let mut rows = Incidence::new(found.iter().map(|&(node, _)| node), self.nodes.len());
        rows.entries.iter_mut().for_each(|entry| *entry = found[*entry as usize].1);
        rows
    }

    /// Gives each node the mass of its points.
    pub(super) fn weigh(&mut self, particles: &Particles) {
        self.nodes.mass.fill(0.0);
        for element in &self.elements {
            for p in element.points() {
                let stencil = Stencil::new(&particles.reference[p], &self.spacing);
                let mass = particles.mass(p);
                stencil.visit(|k, weight, _| {
                    self.nodes.mass[element.nodes[k] as usize] += weight * mass;
                });
            }
        }
    }

    /// Where a node was before the hit \[m\].
    #[must_use]
    pub fn place(&self, node: usize) -> Vec3 {
        Vec3::from(self.nodes.place[node].map(f64::from)).component_mul(&self.spacing)
    }
}

/// The `k`-th of the 27 nodes of a cell, z fastest.
fn shifted(cell: [i32; 3], k: usize) -> [i32; 3] {
    [cell[0] + (k / 9) as i32, cell[1] + (k / 3 % 3) as i32, cell[2] + (k % 3) as i32]
}

/// The bits of a cell's place from `low`, interleaved.
fn z_order(cell: &[i32; 3], low: &[i32; 3]) -> u64 {
    let mut key = 0;
    for (axis, (c, l)) in cell.iter().zip(low).enumerate() {
        let from_low = (c - l) as u64;
        key |= (0..21).fold(0, |bits, b| bits | (from_low >> b & 1) << (3 * b + 2 - axis));
    }
    key
}

#[cfg(test)]
mod tests {
    use super::BackgroundGrid;
    use crate::particles::Particles;
    use cullet_geometry::{Vec3, math::unit};

    #[test]
    fn every_point_is_in_one_element_and_every_row_has_its_node() {
        let points: Vec<Vec3> = (0..500)
            .map(|i| Vec3::new(unit(1, 0, i) - 0.5, unit(1, 1, i), -unit(1, 2, i)))
            .collect();
        let mut particles = Particles::at_rest(&points, 1.0, 1.0);
        let grid = BackgroundGrid::new(&mut particles, Vec3::new(0.1, 0.1, 0.2));
        let mut next = 0;
        for element in &grid.elements {
            assert_eq!(element.first, next);
            next += element.count;
            assert_eq!(grid.nodes.place[element.nodes[0] as usize], element.cell);
        }
        assert_eq!(next, 500);
        for (p, &id) in particles.id.iter().enumerate() {
            assert_eq!(particles.reference[p], points[id as usize]);
        }
        assert!((grid.nodes.mass.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let all: Vec<u32> = (0..grid.nodes.len() as u32).collect();
        let rows = grid.rows_of(all.into_iter());
        assert_eq!(rows.entries.len(), super::AROUND * grid.elements.len());
        for n in 0..grid.nodes.len() {
            for &row in rows.of(n) {
                let element = &grid.elements[row as usize / super::AROUND];
                assert_eq!(element.nodes[row as usize % super::AROUND] as usize, n);
            }
        }
    }
}
