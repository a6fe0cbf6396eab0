//! Which points face one another across a crack.

use super::links::Links;
use cullet_geometry::Vec3;

/// A broken point and the one that it has parted from.
#[derive(Clone, Copy, Debug)]
pub(super) struct SidePair {
    pub(super) own: u32,
    pub(super) other: u32,
    /// From the own to the other, as they lay.
    pub(super) apart: Vec3,
}

/// All pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct Sides {
    pub(super) pairs: Vec<SidePair>,
}

impl Sides {
    /// Adds a point that has broken, with the neighbour that lies most squarely across its crack,
    /// whose normal is `facing`.
    pub(super) fn extend(&mut self, own: u32, parted: &[u32], facing: &Vec3, links: &Links) {
        let apart = |other: u32| links.place(other as usize) - links.place(own as usize);
        let square = |other: &u32| apart(*other).normalize().dot(facing);
        let best = parted.iter().copied().max_by(|a, b| square(a).total_cmp(&square(b)));
        if let Some(other) = best {
            self.pairs.push(SidePair { own, other, apart: apart(other) });
        }
    }
}
