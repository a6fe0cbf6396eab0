//! The points' pass over all blocks, in either precision and on any path of the processor.

use super::block::{CellBlock, CellScratch, CellSide, PaddedVector, StepInputs};
use super::strain::Rows;
use super::{PointSetup, Seat, SurfaceStrain};
use crate::midsurface::CellTable;
use crate::section::{PointState, SectionLaw, SectionTally};
use cullet_continuum::bytes::{held, held_lists};
use cullet_simd::{Incidence, LANES, Real, SimdLevel};
use fearless_simd::dispatch;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Tiles of a block.
const TILES: usize = 8;

/// The blocks of a shell with `N` functions a cell.
#[derive(Clone, Debug)]
pub(crate) struct ShellKernel<R, const N: usize> {
    blocks: Vec<CellBlock<R, N>>,
    tables: Vec<Vec<Rows<R, N>>>,
    /// Forces \[N\] on the control points of each block in turn.
    forces: Vec<PaddedVector<R>>,
    /// For each control point its places in `forces`.
    rows: Incidence,
    level: SimdLevel,
    /// Points of a cell.
    each: usize,
}

impl<R: Real, const N: usize> ShellKernel<R, N> {
    /// Elements of a block.
    pub(crate) const ELEMENTS: usize = TILES * LANES;

    /// Of elements in whole tiles; points by their seats.
    pub(crate) fn new(
        tables: &[CellTable],
        elements: &[CellSide<N>],
        setup: &[PointSetup],
        nodes: usize,
        level: SimdLevel,
    ) -> Self {
        let each = tables[0].points.len();
        let of = |table: &CellTable| {
            let point = |p: &crate::midsurface::TablePoint| {
                p.derivatives.map(|row| std::array::from_fn(|k| R::of(row[k])))
            };
            table.points.iter().map(point).collect::<Vec<Rows<R, N>>>()
        };
        let cut = elements.chunks(Self::ELEMENTS).zip(setup.chunks(Self::ELEMENTS * each));
        let blocks = cut.map(|(elements, setup)| CellBlock::new(elements, setup)).collect();
        let tables = tables.iter().map(of).collect();
        let (forces, rows) = (Vec::new(), Incidence::default());
        let mut kernel = Self { blocks, tables, forces, rows, level, each };
        kernel.index(nodes);
        kernel
    }

    /// First element of the block that element `element` is in.
    pub(crate) fn block_start(element: usize) -> usize {
        element / Self::ELEMENTS * Self::ELEMENTS
    }

    /// Takes the control points of the elements `changed` anew. Where there are more elements than
    /// the `before` of the last time, the points of the last block and of those behind it have to
    /// be touched.
    pub(crate) fn connect(
        &mut self,
        elements: &[CellSide<N>],
        setup: &[PointSetup],
        changed: &BTreeSet<usize>,
        before: usize,
        nodes: usize,
    ) {
        if elements.len() > before {
            let first = Self::block_start(before);
            self.blocks.truncate(first / Self::ELEMENTS);
            let setup = &setup[first * self.each..];
            let grown = elements[first..].chunks(Self::ELEMENTS);
            let grown = grown.zip(setup.chunks(Self::ELEMENTS * self.each));
            self.blocks.extend(grown.map(|(elements, setup)| CellBlock::new(elements, setup)));
        }
        let blocks: BTreeSet<usize> = changed.iter().map(|e| e / Self::ELEMENTS).collect();
        for b in blocks {
            let end = elements.len().min((b + 1) * Self::ELEMENTS);
            self.blocks[b].connect(&elements[b * Self::ELEMENTS..end]);
        }
        self.index(nodes);
    }

    fn index(&mut self, nodes: usize) {
        let ids = self.blocks.iter().flat_map(|block| block.nodes.iter().copied());
        self.rows = Incidence::new(ids, nodes);
        self.forces.resize(self.rows.entries.len(), [R::of(0.0); 4]);
    }

    /// Takes the state of the point at `seat` anew; no setup where it has left its seat.
    pub(crate) fn touch(&mut self, seat: Seat, setup: Option<&PointSetup>, limit: Option<f64>) {
        let size = Self::ELEMENTS * self.each;
        self.blocks[seat / size].touch(seat % size, setup, limit);
    }

    /// Steps the points' states and takes the forces.
    pub(crate) fn strain(
        &mut self,
        law: &SectionLaw,
        displacement: &[[f64; 4]],
        states: &mut [PointState],
    ) -> SectionTally {
        let shared = StepInputs { law, tables: &self.tables, displacement };
        let mut rest = self.forces.as_mut_slice();
        let chunks = states.chunks_mut(Self::ELEMENTS * self.each);
        let mut work = Vec::with_capacity(self.blocks.len());
        for (block, states) in self.blocks.iter_mut().zip(chunks) {
            let (forces, after) = std::mem::take(&mut rest).split_at_mut(block.nodes.len());
            rest = after;
            work.push((block, states, forces));
        }
        let level = self.level.level();
        let tallies: Vec<SectionTally> = work
            .into_par_iter()
            .map_init(CellScratch::new, |scratch, (block, states, forces)| {
                dispatch!(level, simd => block.strain(simd, &shared, states, forces, scratch))
            })
            .collect();
        tallies.into_iter().fold(SectionTally::default(), SectionTally::plus)
    }

    /// Takes the strains of all points as those of the last step.
    pub(crate) fn remember(&mut self, law: &SectionLaw, displacement: &[[f64; 4]]) {
        let shared = StepInputs { law, tables: &self.tables, displacement };
        let level = self.level.level();
        let mut scratch = CellScratch::new();
        for block in &mut self.blocks {
            dispatch!(level, simd => block.remember(simd, &shared, &mut scratch));
        }
    }

    /// Strains of all points, by seat.
    pub(crate) fn strains(
        &self,
        law: &SectionLaw,
        displacement: &[[f64; 4]],
        seats: usize,
    ) -> Vec<SurfaceStrain> {
        let shared = StepInputs { law, tables: &self.tables, displacement };
        let mut strains = vec![SurfaceStrain::default(); seats];
        let level = self.level.level();
        let mut scratch = CellScratch::new();
        for (block, out) in self.blocks.iter().zip(strains.chunks_mut(Self::ELEMENTS * self.each)) {
            dispatch!(level, simd => block.strains(simd, &shared, &mut scratch, out));
        }
        strains
    }

    /// Memory that it takes, about \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let blocks = self.blocks.iter().map(CellBlock::bytes).sum::<u64>();
        let rows = held(&self.rows.starts) + held(&self.rows.entries);
        blocks + rows + held_lists(&self.tables) + held(&self.forces)
    }

    /// The path of the processor that it is worked out on.
    pub(crate) fn level(&self) -> SimdLevel {
        self.level
    }

    /// Sum of the forces on a control point \[N\].
    #[inline]
    pub(crate) fn force(&self, node: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &row in self.rows.of(node) {
            let force = &self.forces[row as usize];
            (0..3).for_each(|c| sum[c] += force[c].wide());
        }
        sum
    }
}
