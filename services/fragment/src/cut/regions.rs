//! Which cells of the mosaic have which label, and which regions are still to be cut.

use super::piece::CutPiece;
use crate::region::{FacetSide, Mosaic};

/// Regions cut in one step: large enough to feed every core, small enough to cancel between steps.
const BATCH: usize = 64;

/// The regions of one round: unions of cells of one label.
#[derive(Debug)]
pub(super) struct Regions {
    /// The label of each cell.
    pub(super) labels: Vec<u32>,
    /// Facets around each label.
    pub(super) sides: Vec<Vec<FacetSide>>,
    /// The labels to cut in this round, and how many of them are cut.
    todo: Vec<u32>,
    cut: usize,
}

impl Regions {
    /// `labels`: of each cell, all of 0, 1, 2, … in use.
    pub(super) fn new(mosaic: &Mosaic, labels: Vec<u32>) -> Self {
        let count = labels.iter().max().map_or(0, |&most| most as usize + 1);
        let sides = mosaic.sides(&labels, count);
        Self { labels, sides, todo: (0..count as u32).collect(), cut: 0 }
    }

    /// The share of this round's regions that are cut, in `[0, 1]`.
    pub(super) fn share(&self) -> f64 {
        self.cut as f64 / self.todo.len().max(1) as f64
    }

    /// The labels that are cut next; none at the end of a round.
    pub(super) fn batch(&self) -> &[u32] {
        &self.todo[self.cut..(self.cut + BATCH).min(self.todo.len())]
    }

    /// So many more regions are cut.
    pub(super) fn advance(&mut self, count: usize) {
        self.cut += count;
    }

    /// Gives the cells of pieces that join a host, and are all there is of their label, to the
    /// host's label, and notes what has to be cut again. False if there is no such piece.
    pub(super) fn relabel(
        &mut self,
        mosaic: &Mosaic,
        pieces: &mut Vec<CutPiece>,
        groups: &[u32],
    ) -> bool {
        let mut count = vec![0; self.sides.len()];
        for piece in &*pieces {
            count[piece.label as usize] += 1;
        }
        let mut dirty = vec![false; self.sides.len()];
        let mut name: Vec<u32> = (0..self.sides.len() as u32).collect();
        for (piece, &host) in pieces.iter().zip(groups) {
            let (from, to) = (piece.label, pieces[host as usize].label);
            if from != to && count[from as usize] == 1 {
                name[from as usize] = to;
                dirty[from as usize] = true;
                dirty[to as usize] = true;
            }
        }
        if !dirty.contains(&true) {
            return false;
        }
        for label in &mut self.labels {
            *label = name[*label as usize];
        }
        self.sides = mosaic.sides(&self.labels, self.sides.len());
        pieces.retain(|piece| !dirty[piece.label as usize]);
        self.todo = (0..dirty.len() as u32).filter(|&label| dirty[label as usize]).collect();
        self.cut = 0;
        true
    }
}
