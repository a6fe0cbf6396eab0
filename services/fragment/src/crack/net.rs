//! Surface nets: a corner in each cube of eight nodes where labels differ, a quad across each edge
//! of the lattice between different labels. Corners in the middle of their cubes make voxels, which
//! fill the box without overlap; each then moves, for all cells at once, but never out of its cube.

use super::nodes::LatticeNodes;
use super::odds::NONE;
use super::smooth::{SurfaceNet, shape};
use crate::region::terms::ReliefTerms;
use crate::region::{Mosaic, overlap};
use cullet_geometry::Vec3;
use cullet_geometry::voronoi::WALL;

/// Rounds in which corners whose faces cross are pulled half-way back to the middle of their cubes;
/// after them, all the way.
const RETREATS: usize = 8;

impl LatticeNodes {
    /// The box divided among the labels, with relief where its terms are given.
    pub(crate) fn mosaic(&self, relief: Option<&ReliefTerms>) -> Mosaic {
        let (mut mosaic, mut net) = self.net();
        net.project(|(one, two), place| {
            let (way, beyond) = self.sampled.rubble.beyond(one, two, &(place / self.sampled.cell));
            way * (-beyond * self.sampled.cell)
        });
        shape(&mut net, &mosaic);
        self.part(&mut mosaic, &mut net);
        if let Some(terms) = relief {
            let reach = 2.0 * terms.detail.grid;
            let wanted = |ends: [Vec3; 3]| ends.iter().any(|&p| self.is_near_body(p));
            mosaic.engrave(terms, |p| self.front(p, reach), wanted);
        }
        mosaic
    }

    /// Draws corners whose faces cross back to the middle of their cubes, half-way at first, until
    /// no faces cross: those of cubes do not.
    fn part(&self, mosaic: &mut Mosaic, net: &mut SurfaceNet) {
        for round in 1.. {
            mosaic.places.clone_from(&net.place);
            fold(mosaic);
            let crossing = overlap::crossing(&mosaic.places, &mosaic.triangles);
            let corners = crossing.iter().flat_map(|&t| mosaic.triangles[t as usize]);
            let mut corners: Vec<usize> = corners.map(|v| v as usize).collect();
            corners.retain(|&v| net.place[v] != net.middle[v]);
            if corners.is_empty() {
                break;
            }
            corners.sort_unstable();
            corners.dedup();
            net.retreat(corners, if round < RETREATS { 0.5 } else { 0.0 });
        }
    }

    /// The net before it is smoothed.
    pub(super) fn net(&self) -> (Mosaic, SurfaceNet) {
        let mut builder = NetBuilder::new(self);
        for axis in 0..3 {
            builder.across(axis);
        }
        builder.settled()
    }
}

/// Divides each quad along its shorter diagonal.
pub(super) fn fold(mosaic: &mut Mosaic) {
    let Mosaic { facets, triangles, places, .. } = mosaic;
    for facet in facets {
        let pair = &mut triangles[facet.start as usize..facet.end as usize];
        let quad = corners_of(pair);
        let length = |p: usize, q: usize| {
            (places[quad[p] as usize] - places[quad[q] as usize]).norm_squared()
        };
        let [a, b, c, d] = quad;
        let halves = if length(0, 2) <= length(1, 3) {
            [[a, b, c], [a, c, d]]
        } else {
            [[b, c, d], [b, d, a]]
        };
        pair.copy_from_slice(&halves);
    }
}

/// The quad that two triangles `[a, b, c], [a, c, d]` make.
fn corners_of(pair: &[[u32; 3]]) -> [u32; 4] {
    let [a, b, c] = pair[0];
    [a, b, c, pair[1][2]]
}

/// Builds a surface net from the labels of lattice nodes.
pub(super) struct NetBuilder<'a> {
    nodes: &'a LatticeNodes,
    /// The corner in each cube of nodes, or `NONE`.
    corner: Vec<u32>,
    mosaic: Mosaic,
    net: SurfaceNet,
}

impl<'a> NetBuilder<'a> {
    pub(super) fn new(nodes: &'a LatticeNodes) -> Self {
        let net = SurfaceNet::new(nodes.lattice);
        let cubes = nodes.lattice.dims.iter().map(|d| d + 1).product();
        Self { nodes, corner: vec![NONE; cubes], mosaic: Mosaic::default(), net }
    }

    /// The net and its corners, each at the mean of its pulls.
    pub(super) fn settled(self) -> (Mosaic, SurfaceNet) {
        let Self { mut mosaic, mut net, .. } = self;
        net.settle();
        mosaic.places.clone_from(&net.place);
        (mosaic, net)
    }

    /// A quad across the edge from a node along an axis, crossed at `share` of it, that parts no
    /// labels.
    pub(super) fn open(&mut self, from: usize, axis: usize, share: f64) {
        let lattice = self.nodes.lattice;
        let mut node = lattice.node(from);
        let mut place = lattice.place(node);
        place += lattice.axes.column(axis) * (share * lattice.spacing);
        node[axis] += 1;
        let quad = self.quad(axis, node);
        quad.iter().for_each(|&corner| self.net.pull(corner, place, true));
        let [a, b, c, d] = quad;
        self.mosaic.push((0, 1), f64::INFINITY, [[a, b, c], [a, c, d]].into_iter());
    }

    /// The corners around the edge that ends at a node, along `axis`.
    fn quad(&mut self, axis: usize, node: [usize; 3]) -> [u32; 4] {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[y, z]| {
            let mut cube = node;
            cube[u] += y;
            cube[v] += z;
            self.corner(cube)
        })
    }

    /// The quads across all edges along one axis, those to the walls included.
    fn across(&mut self, axis: usize) {
        let lattice = self.nodes.lattice;
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut node = [0; 3];
        for z in 0..lattice.dims[v] {
            for y in 0..lattice.dims[u] {
                for x in 0..=lattice.dims[axis] {
                    (node[axis], node[u], node[v]) = (x, y, z);
                    self.between(axis, node);
                }
            }
        }
    }

    /// The quad between a node and the one before it along `axis`, if their labels differ.
    fn between(&mut self, axis: usize, node: [usize; 3]) {
        let lattice = self.nodes.lattice;
        let above = (node[axis] < lattice.dims[axis]).then(|| lattice.index(node));
        let below = (node[axis] > 0).then(|| {
            let mut before = node;
            before[axis] -= 1;
            lattice.index(before)
        });
        let label = |i: usize| self.nodes.reach[i];
        let walls = WALL + 2 * axis as u32;
        let (first, behind, forward) = match (below.map(label), above.map(label)) {
            (Some(a), Some(b)) if a == b => return,
            (Some(a), Some(b)) => (a, b, true),
            (Some(a), None) => (a, walls + 1, true),
            (None, Some(b)) => (b, walls, false),
            (None, None) => return,
        };
        let mut quad = self.quad(axis, node);
        if !forward {
            quad.reverse();
        }
        let [a, b, c, d] = quad;
        let mut time = f64::INFINITY;
        if let (Some(i), Some(j)) = (below, above) {
            time = self.cross(i, j, axis, quad);
        } else {
            quad.iter().for_each(|&corner| self.net.lock(corner));
        }
        self.mosaic.push((first, behind), time, [[a, b, c], [a, c, d]].into_iter());
    }

    /// Tells the corners of a quad where its edge is crossed; returns when.
    fn cross(&mut self, i: usize, j: usize, axis: usize, quad: [u32; 4]) -> f64 {
        let nodes = self.nodes;
        let mut place = nodes.lattice.place(nodes.lattice.node(i));
        place += nodes.lattice.axes.column(axis) * (nodes.crossing(i, j) * nodes.lattice.spacing);
        let gap = nodes.is_inside(i) && nodes.is_inside(j) && !nodes.connects(i, j);
        let free = !gap && (nodes.damage.near[i] || nodes.damage.near[j]);
        let drawn = nodes.sampled.pair(i, j);
        for corner in quad {
            self.net.pull(corner, place, free);
            if let Some(pair) = drawn {
                self.net.lay(corner, pair);
            }
            if gap {
                self.net.lock(corner);
            }
        }
        match (nodes.damage.time[i].is_finite(), nodes.damage.time[j].is_finite()) {
            (true, true) => 0.5 * (nodes.damage.time[i] + nodes.damage.time[j]),
            (true, false) => nodes.damage.time[i],
            (false, true) => nodes.damage.time[j],
            // Damage without a time: none is known anywhere.
            (false, false) => 0.0,
        }
    }

    /// The corner in a cube: the one between node `cube` and those before it.
    fn corner(&mut self, cube: [usize; 3]) -> u32 {
        let lattice = self.nodes.lattice;
        let row = cube[2] * (lattice.dims[1] + 1) + cube[1];
        let slot = &mut self.corner[row * (lattice.dims[0] + 1) + cube[0]];
        if *slot == NONE {
            let at = Vec3::from(cube.map(|c| c as f64 - 0.5));
            *slot = self.net.add(lattice.at(at));
        }
        *slot
    }
}
