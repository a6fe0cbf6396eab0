//! What is kept of control points for their splits.

use crate::kernel::CellSide;
use std::collections::BTreeMap;

/// What is kept for splits.
#[derive(Clone, Debug)]
pub(super) struct SplitState {
    /// Cells of each control point before any split.
    pub(super) cells: Vec<Vec<u32>>,
    /// Mass of each control point before any split \[kg\].
    pub(super) mass: Vec<f64>,
    /// Places without an element, by table.
    pub(super) vacant: BTreeMap<u32, Vec<u32>>,
    /// Splits so far.
    pub(super) count: u64,
    /// Kinetic energy of mass that was added to copies which would have had too little \[J\].
    pub(super) added: f64,
}

impl SplitState {
    pub(super) fn new<const N: usize>(
        cells: impl Iterator<Item = [u32; N]>,
        elements: &[CellSide<N>],
        mass: &[f64],
    ) -> Self {
        let mut of = vec![Vec::new(); mass.len()];
        for (cell, nodes) in cells.enumerate() {
            for &node in &nodes {
                // Cells with fewer functions name their first control point again.
                if of[node as usize].last() != Some(&(cell as u32)) {
                    of[node as usize].push(cell as u32);
                }
            }
        }
        let mut vacant: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (e, element) in elements.iter().enumerate().filter(|(_, e)| e.live == 0) {
            vacant.entry(element.table).or_default().push(e as u32);
        }
        Self { cells: of, mass: mass.to_vec(), vacant, count: 0, added: 0.0 }
    }

    pub(super) fn scale(&mut self, factor: f64) {
        self.mass.iter_mut().for_each(|mass| *mass *= factor);
    }
}
