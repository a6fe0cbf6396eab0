//! The box of nodes that a crack is found on.

use cullet_geometry::inside::Inside;
use cullet_geometry::{Mat3, Vec3};
use rayon::prelude::*;

/// The bit of `Nodes::inside` for the node itself.
pub(super) const NODE: u8 = 8;

/// A box of lattice nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pub(super) low: Vec3,
    pub(super) spacing: f64,
    pub(super) dims: [usize; 3],
    /// Unit vectors along its three directions, as columns.
    pub(super) axes: Mat3,
}

impl Lattice {
    pub(super) fn len(&self) -> usize {
        self.dims.iter().product()
    }

    pub(super) fn index(&self, node: [usize; 3]) -> usize {
        (node[2] * self.dims[1] + node[1]) * self.dims[0] + node[0]
    }

    pub(super) fn node(&self, index: usize) -> [usize; 3] {
        let row = index / self.dims[0];
        [index % self.dims[0], row % self.dims[1], row / self.dims[1]]
    }

    pub(super) fn place(&self, node: [usize; 3]) -> Vec3 {
        self.at(Vec3::new(node[0] as f64, node[1] as f64, node[2] as f64))
    }

    /// The place so many spacings from the first node along each direction \[m\].
    pub(super) fn at(&self, steps: Vec3) -> Vec3 {
        self.low + self.axes * (steps * self.spacing)
    }

    /// How many spacings a place is from the first node along each direction.
    pub(super) fn steps_to(&self, place: Vec3) -> Vec3 {
        self.along(place - self.low) / self.spacing
    }

    /// A vector's components along the three directions.
    pub(super) fn along(&self, vector: Vec3) -> Vec3 {
        self.axes.tr_mul(&vector)
    }

    /// The node nearest to a point \[m\].
    pub(super) fn nearest(&self, place: Vec3) -> usize {
        let steps = self.steps_to(place);
        let node = [0, 1, 2].map(|k| {
            let n = (steps[k] + 0.5).max(0.0) as usize;
            n.min(self.dims[k] - 1)
        });
        self.index(node)
    }

    /// The up to six nodes one edge away.
    pub(super) fn beside(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (node, dims) = (self.node(index), self.dims);
        let strides = [1, dims[0], dims[0] * dims[1]];
        (0..3).flat_map(move |k| {
            let down = (node[k] > 0).then(|| index - strides[k]);
            let up = (node[k] + 1 < dims[k]).then(|| index + strides[k]);
            down.into_iter().chain(up)
        })
    }

    /// The nodes at most `radius` away along every axis, the node itself included.
    pub(super) fn around(
        &self,
        node: [usize; 3],
        radius: usize,
    ) -> impl Iterator<Item = usize> + use<> {
        let lattice = *self;
        let from = node.map(|n| n.saturating_sub(radius));
        let to = [0, 1, 2].map(|k| (node[k] + radius).min(lattice.dims[k] - 1));
        (from[2]..=to[2]).flat_map(move |z| {
            (from[1]..=to[1])
                .flat_map(move |y| (from[0]..=to[0]).map(move |x| lattice.index([x, y, z])))
        })
    }
}

impl Lattice {
    /// For each node, whether it and the middles of its edges upward are inside.
    pub(super) fn inside(&self, body: &Inside) -> Vec<u8> {
        let half = 0.5 * self.spacing;
        let steps = [0, 1, 2].map(|k| self.axes.column(k) * half);
        let bits = |i: usize| {
            let place = self.place(self.node(i));
            if !body.contains(place) {
                return 0;
            }
            (0..3).fold(NODE, |bits, k| bits | u8::from(body.contains(place + steps[k])) << k)
        };
        (0..self.len()).into_par_iter().map(bits).collect()
    }
}

/// How a lattice lies and how fine it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LatticeChoice {
    /// Unit vectors along its directions, as columns.
    pub(crate) axes: Mat3,
    /// Distance of its nodes over what the pieces ask for.
    pub(crate) refinement: f64,
}

impl Default for LatticeChoice {
    fn default() -> Self {
        Self { axes: Mat3::identity(), refinement: 1.0 }
    }
}

/// Quadratic B-spline weights along each axis, and the first node they fall on.
pub(super) fn weights(at: Vec3) -> ([usize; 3], [[f64; 3]; 3]) {
    let base = [0, 1, 2].map(|k| (at[k] - 0.5) as usize);
    let along = |k: usize| {
        let x = at[k] - base[k] as f64;
        let (a, b, c) = (1.5 - x, x - 1.0, x - 0.5);
        [0.5 * a * a, 0.75 - b * b, 0.5 * c * c]
    };
    (base, [along(0), along(1), along(2)])
}
