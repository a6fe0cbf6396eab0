//! Contact between the sides of a crack: copies of a node may part and slide, not pass through each
//! other (F18).

use super::grid::Nodes;
use super::kernel::{packed, vector};
use cullet_geometry::Vec3;

/// Least distance between the centres of two sides, in cells, that tells where they lie.
const LEAST: f64 = 1e-9;

/// Each copy meets so many of the heaviest at its node, not the crumbs between them.
const HEAVY: usize = 3;

/// Two copies of a node and the unit normal out of the first, into the second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    first: u32,
    second: u32,
    normal: Vec3,
}

/// The pairs of copies of a body's nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct Contact {
    pairs: Vec<Pair>,
}

impl Contact {
    /// The pairs of copies, and the normals between them from where their points lie.
    pub(super) fn new(nodes: &Nodes, spacing: &Vec3) -> Self {
        let copies = (0..nodes.len() as u32).filter(|&n| nodes.origin[n as usize] != n);
        let mut order: Vec<(u32, u32)> =
            copies.map(|n| (nodes.origin[n as usize], n)).flat_map(|c| [c, (c.0, c.0)]).collect();
        order.sort_unstable();
        order.dedup();
        let mut pairs = Vec::new();
        for copies in order.chunk_by(|a, b| a.0 == b.0) {
            let mut copies: Vec<u32> = copies.iter().map(|&(_, n)| n).collect();
            let mass = |n: &u32| nodes.mass[*n as usize];
            copies.sort_by(|a, b| mass(b).total_cmp(&mass(a)));
            for (i, &first) in copies.iter().enumerate().take(HEAVY) {
                for &second in &copies[i + 1..] {
                    let across = nodes.lean[second as usize] - nodes.lean[first as usize];
                    if across.norm() > LEAST {
                        // The normal of a plane, given in cells, in metres.
                        let normal = across.component_div(spacing).normalize();
                        pairs.push(Pair { first, second, normal });
                    }
                }
            }
        }
        Self { pairs }
    }

    /// Stops the copies that would overlap at the end of the step: to the velocity that closes what
    /// gap there is. Momentum is kept, pair by pair.
    pub(super) fn resolve(&self, nodes: &mut Nodes, step: f64) {
        for pair in &self.pairs {
            let (a, b) = (pair.first as usize, pair.second as usize);
            let gap = vector(nodes.displacement[b] - nodes.displacement[a]).dot(&pair.normal);
            let rate = vector(nodes.velocity[b] - nodes.velocity[a]).dot(&pair.normal);
            let overlap = -(gap.max(0.0) + step * rate);
            if overlap <= 0.0 {
                continue;
            }
            let (first, second) = (nodes.mass[a], nodes.mass[b]);
            let impulse = overlap / step * first * second / (first + second);
            nodes.velocity[a] -= packed(pair.normal * (impulse / first));
            nodes.velocity[b] += packed(pair.normal * (impulse / second));
        }
    }
}
