//! Where the sites of the diagram lie, and which nodes need none.

use super::{DAMAGED, Lattice, NONE, Nodes, Sites};
use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};

/// Sites move by at most this much of the spacing, to lie level with the edge of the damage (F26).
const LEVEL: f64 = 0.4;
/// Hash jitter of a site, in spacings: brings lattice sites into general position (F25).
const JITTER: f64 = 1e-2;
/// Below this change of the broken share per spacing, damage has no direction.
const FLAT: f64 = 1e-3;
/// A block of this many nodes a side carries one site where all around it is of one label.
const BLOCK: usize = 4;
/// ... if no other label and no damage comes nearer than this many blocks: every point of the block
/// and the body's skin around it is then nearer to its site than to one of another label.
const CALM: usize = 2;
/// Outside the body, empty blocks of this many nodes a side carry a ghost site each, or the cells
/// of the body's skin would reach far into the void, and cost as many tests.
const GHOST: usize = 2;
/// A ghost keeps this many empty blocks between itself and the body, so that its own cell ends
/// outside: 3.5 spacings to the nearest node inside.
const GHOST_GAP: usize = 1;
/// From this many blocks on, ghosts of size `BLOCK` do.
const GHOST_REACH: usize = 5;
/// The box reaches this many spacings beyond the body: more than `LEVEL` and `JITTER` together,
/// and little, for the cells at the box are long ones.
const BOX_MARGIN: f64 = 0.77;

impl Nodes {
    /// The sites: every undamaged node near damage or near another label, one a block elsewhere,
    /// and ghosts outside the body.
    pub(crate) fn sites(&self, seed: u64) -> Sites {
        let h = self.lattice.spacing;
        let coarse = Blocks::new(self, BLOCK);
        let mut sites = Sites {
            places: Vec::new(),
            labels: Vec::new(),
            times: Vec::new(),
            low: self.low - Vec3::repeat(BOX_MARGIN * h),
            high: self.high + Vec3::repeat(BOX_MARGIN * h),
        };
        let mut number = 0;
        let mut add = |place: Vec3, label: u32, time: f64| {
            let key = number;
            number += 1;
            let at = |k| JITTER * h * (2.0 * unit(scramble(seed), k, key) - 1.0);
            let place = place + Vec3::new(at(0), at(1), at(2));
            if (0..3).all(|k| sites.low[k] < place[k] && place[k] < sites.high[k]) {
                sites.places.push(place);
                sites.labels.push(label);
                sites.times.push(time);
            }
        };
        for i in 0..self.lattice.len() {
            let node = self.lattice.node(i);
            if self.label[i] != NONE && !coarse.is_plain(node) {
                add(self.lattice.place(node) + self.level(i), self.label[i], self.time[i]);
            }
        }
        for block in (0..coarse.grid.len()).filter(|&block| coarse.calm[block]) {
            if let Kind::Plain(label) = coarse.kind[block] {
                let middle = coarse.sum[block] / coarse.count[block];
                add(middle, label, self.time[self.nearest(middle)]);
            }
        }
        for place in self.ghosts(&coarse) {
            let node = self.nearest(place);
            add(place, self.reach[node], self.time[node]);
        }
        sites
    }

    /// The node nearest to a point \[m\] near the lattice.
    fn nearest(&self, place: Vec3) -> usize {
        let steps = (place - self.lattice.low) / self.lattice.spacing;
        let node = [0, 1, 2].map(|k| {
            let n = (steps[k] + 0.5).max(0.0) as usize;
            n.min(self.lattice.dims[k] - 1)
        });
        self.lattice.index(node)
    }

    /// Places of ghost sites: dense near the body, sparse far from it.
    fn ghosts(&self, coarse: &Blocks) -> Vec<Vec3> {
        let fine = Blocks::new(self, GHOST);
        let empty = |blocks: &Blocks, block: usize, radius: usize| {
            let mut around = blocks.grid.around(blocks.grid.node(block), radius);
            around.all(|b| blocks.kind[b] == Kind::Empty)
        };
        let near = (0..fine.grid.len())
            .filter(|&b| empty(&fine, b, GHOST_GAP) && !empty(&fine, b, GHOST_REACH))
            .map(|b| self.middle(fine.grid.node(b), GHOST));
        let far = (0..coarse.grid.len())
            .filter(|&b| empty(coarse, b, CALM))
            .map(|b| self.middle(coarse.grid.node(b), BLOCK));
        near.chain(far).collect()
    }

    /// The middle of a block \[m\].
    fn middle(&self, block: [usize; 3], side: usize) -> Vec3 {
        let at = block.map(|b| (b * side) as f64 + 0.5 * (side as f64 - 1.0));
        self.lattice.low + Vec3::from(at) * self.lattice.spacing
    }

    /// The shift that brings a site at the edge of damage to half a spacing from that edge \[m\].
    fn level(&self, i: usize) -> Vec3 {
        if !self.lattice.beside(i).any(|j| self.is_damaged(j)) {
            return Vec3::zeros();
        }
        let node = self.lattice.node(i);
        let strides = [1, self.lattice.dims[0], self.lattice.dims[0] * self.lattice.dims[1]];
        let mut slope = Vec3::zeros();
        for (k, stride) in strides.into_iter().enumerate() {
            let known = |j: usize| self.is_inside(j).then(|| self.broken[j]);
            let down = (node[k] > 0).then(|| known(i - stride)).flatten();
            let up = (node[k] + 1 < self.lattice.dims[k]).then(|| known(i + stride)).flatten();
            slope[k] = match (down, up) {
                (Some(a), Some(b)) => 0.5 * (b - a),
                (Some(a), None) => self.broken[i] - a,
                (None, Some(b)) => b - self.broken[i],
                (None, None) => 0.0,
            };
        }
        let steepness = slope.norm();
        if steepness < FLAT {
            return Vec3::zeros();
        }
        let distance = ((DAMAGED - self.broken[i]) / steepness).min(1.0);
        slope * ((distance - 0.5).clamp(-LEVEL, LEVEL) * self.lattice.spacing / steepness)
    }
}

/// Blocks of nodes, and the one label of each where it has no other and no damage.
struct Blocks {
    grid: Lattice,
    side: usize,
    kind: Vec<Kind>,
    /// All blocks within `CALM` are empty or plain of the same label.
    calm: Vec<bool>,
    /// Sum of the places of the nodes inside the body \[m\], and their number.
    sum: Vec<Vec3>,
    count: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Empty,
    Plain(u32),
    Mixed,
}

impl Blocks {
    fn new(nodes: &Nodes, side: usize) -> Self {
        let grid = Lattice { dims: nodes.lattice.dims.map(|d| d.div_ceil(side)), ..nodes.lattice };
        let mut kind = vec![Kind::Empty; grid.len()];
        let (mut sum, mut count) = (vec![Vec3::zeros(); grid.len()], vec![0.0; grid.len()]);
        for i in (0..nodes.lattice.len()).filter(|&i| nodes.is_inside(i)) {
            let node = nodes.lattice.node(i);
            let block = grid.index(node.map(|n| n / side));
            sum[block] += nodes.lattice.place(node);
            count[block] += 1.0;
            kind[block] = match (kind[block], nodes.label[i]) {
                (_, NONE) | (Kind::Mixed, _) => Kind::Mixed,
                (Kind::Plain(old), new) if old != new => Kind::Mixed,
                (_, new) => Kind::Plain(new),
            };
        }
        let calm = (0..grid.len()).map(|b| {
            let fits = |j: usize| kind[j] == kind[b] || kind[j] == Kind::Empty;
            matches!(kind[b], Kind::Plain(_)) && grid.around(grid.node(b), CALM).all(fits)
        });
        let calm = calm.collect();
        Self { grid, side, kind, calm, sum, count }
    }

    /// Whether a block's site stands for this node.
    fn is_plain(&self, node: [usize; 3]) -> bool {
        self.calm[self.grid.index(node.map(|n| n / self.side))]
    }
}
