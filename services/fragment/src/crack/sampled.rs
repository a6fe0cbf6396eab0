//! Pieces that were sampled from a law, where the lattice's nodes lie in some.

use super::odds::{NONE, ZONE};
use crate::pieces::Rubble;

/// Which nodes lie in which sampled piece, and the labels of these.
#[derive(Debug)]
pub(super) struct SampledPieces {
    /// The sampled piece that a node lies in, or `NONE`.
    pub(super) ball: Vec<u32>,
    /// The label of each sampled piece, or `NONE`.
    pub(super) label: Vec<u32>,
    /// Whether all pieces of a label were sampled; empty where none is known.
    pub(super) whole: Vec<bool>,
    pub(super) rubble: Rubble,
    /// Size of a cell of the rubble \[m\].
    pub(super) cell: f64,
}

impl SampledPieces {
    pub(super) fn new(nodes: usize, rubble: Rubble, cell: f64) -> Self {
        Self { ball: vec![NONE; nodes], label: Vec::new(), whole: Vec::new(), rubble, cell }
    }

    /// What a walk knows a label as.
    pub(super) fn class(&self, label: u32) -> u32 {
        if self.whole.get(label as usize) == Some(&true) { ZONE } else { label }
    }

    /// The sampled pieces that two nodes lie in, if both do.
    pub(super) fn pair(&self, i: usize, j: usize) -> Option<(u32, u32)> {
        let pair = (self.ball[i], self.ball[j]);
        (pair.0 != NONE && pair.1 != NONE).then_some(pair)
    }
}
