//! A block of cells: sixteen side by side in tiles that share their functions.

use super::damping::Damped;
use super::elastic::ElasticLanes;
use super::slot::{PointSlot, Section, strain_of};
use super::strain::{CellVectors, Rows, present, scatter, three};
use super::{PointSetup, SurfaceStrain};
use crate::section::{PointState, SectionLaw, SectionTally};
use cullet_continuum::bytes::held;
use cullet_simd::{LANES, Lanes, Real, V, load, store};
use fearless_simd::{Simd, SimdBase};

/// A displacement \[m\] that is none: less would be subnormal in f32.
const STILL: f64 = 1e-24;

/// A cell, or one side of a cell that a crack runs through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellSide<const N: usize> {
    /// Its control points.
    pub(crate) nodes: [u32; N],
    /// Its functions, by place in the list of tables.
    pub(crate) table: u32,
    /// Its points that are its own, a bit each.
    pub(crate) live: u16,
}

impl<const N: usize> CellSide<N> {
    /// A place that no cell has taken.
    pub(crate) fn vacant(table: u32) -> Self {
        Self { nodes: [0; N], table, live: 0 }
    }
}

/// A vector at a control point; the fourth is nothing.
pub(super) type PaddedVector<R> = [R; 4];

#[derive(Clone, Debug)]
struct CellTile<R, const N: usize> {
    table: u32,
    nodes: [[u16; N]; LANES],
    slots: Vec<PointSlot<R>>,
}

/// Neighbouring cells, and the control points that they see.
#[derive(Clone, Debug)]
pub(super) struct CellBlock<R, const N: usize> {
    /// The control points, ascending.
    pub(super) nodes: Vec<u32>,
    tiles: Vec<CellTile<R, N>>,
}

/// What a thread needs beside a block.
pub(super) struct CellScratch<R, const N: usize> {
    nodes: Vec<PaddedVector<R>>,
    field: Box<CellVectors<R, N>>,
    forces: Box<CellVectors<R, N>>,
}

impl<R: Real, const N: usize> CellScratch<R, N> {
    pub(super) fn new() -> Self {
        let zero = [[Lanes([R::of(0.0); LANES]); 3]; N];
        Self { nodes: Vec::new(), field: Box::new(zero), forces: Box::new(zero) }
    }
}

/// What all blocks share in a step.
pub(super) struct StepInputs<'a, R, const N: usize> {
    pub(super) law: &'a SectionLaw,
    pub(super) tables: &'a [Vec<Rows<R, N>>],
    pub(super) displacement: &'a [[f64; 4]],
}

impl<R: Real, const N: usize> CellBlock<R, N> {
    /// Memory that it takes, about \[bytes\]: less where points have flowed.
    pub(super) fn bytes(&self) -> u64 {
        let slots = self.tiles.iter().map(|tile| held(&tile.slots)).sum::<u64>();
        size_of::<Self>() as u64 + held(&self.nodes) + held(&self.tiles) + slots
    }

    /// Of the elements of whole tiles, whose points have the setup `setup`.
    pub(super) fn new(elements: &[CellSide<N>], setup: &[PointSetup]) -> Self {
        let each = setup.len() / elements.len();
        let mut block = Self { nodes: Vec::new(), tiles: Vec::new() };
        for (t, tile) in elements.chunks(LANES).enumerate() {
            let slots = (0..each).map(|_| PointSlot::empty()).collect();
            let mut made = CellTile { table: tile[0].table, nodes: [[0; N]; LANES], slots };
            for (lane, element) in tile.iter().enumerate() {
                let first = (t * LANES + lane) * each;
                for (q, slot) in made.slots.iter_mut().enumerate() {
                    slot.put(lane, &setup[first + q], element.live >> q & 1 == 1);
                }
            }
            block.tiles.push(made);
        }
        block.connect(elements);
        block
    }

    /// Takes the control points of its elements anew.
    pub(super) fn connect(&mut self, elements: &[CellSide<N>]) {
        let lively = || elements.iter().filter(|e| e.live != 0);
        self.nodes = lively().flat_map(|e| e.nodes).collect();
        self.nodes.sort_unstable();
        self.nodes.dedup();
        if self.nodes.is_empty() {
            self.nodes.push(0);
        }
        for (tile, elements) in self.tiles.iter_mut().zip(elements.chunks(LANES)) {
            for (lane, element) in elements.iter().enumerate() {
                let place = |node: u32| self.nodes.binary_search(&node).unwrap_or(0) as u16;
                tile.nodes[lane] = match element.live {
                    0 => [0; N],
                    _ => element.nodes.map(place),
                };
            }
        }
    }

    /// Takes the state of the point at `seat` of the block anew.
    pub(super) fn touch(&mut self, seat: usize, setup: Option<&PointSetup>, limit: Option<f64>) {
        let each = self.tiles[0].slots.len();
        let (element, q) = (seat / each, seat % each);
        let lane = element % LANES;
        let slot = &mut self.tiles[element / LANES].slots[q];
        match setup {
            Some(setup) => slot.put(lane, setup, true),
            None => slot.area.0[lane] = R::of(0.0),
        }
        slot.watch(lane, limit);
    }

    /// Forces \[N\] of the points on the block's control points.
    #[inline(always)]
    pub(super) fn strain<S: Simd>(
        &mut self,
        simd: S,
        shared: &StepInputs<'_, R, N>,
        states: &mut [PointState],
        forces: &mut [PaddedVector<R>],
        scratch: &mut CellScratch<R, N>,
    ) -> SectionTally {
        gather(&self.nodes, shared.displacement, &mut scratch.nodes);
        forces.fill([R::of(0.0); 4]);
        let mut tallies = [SectionTally::default(); LANES];
        let each = self.tiles[0].slots.len();
        for (tile, states) in self.tiles.iter_mut().zip(states.chunks_mut(LANES * each)) {
            fill(&tile.nodes, &scratch.nodes, &mut scratch.field);
            let mut lane = 0;
            while lane < LANES {
                let special_points = SpecialPoints { states, tallies: &mut tallies };
                column(
                    simd,
                    tile,
                    lane,
                    shared,
                    &scratch.field,
                    &mut scratch.forces,
                    special_points,
                );
                lane += V::<S, R>::LEN;
            }
            drain(&tile.nodes, &scratch.forces, forces);
        }
        tallies.into_iter().fold(SectionTally::default(), SectionTally::plus)
    }

    /// Takes the strains of the points as those of the last step.
    #[inline(always)]
    pub(super) fn remember<S: Simd>(
        &mut self,
        simd: S,
        shared: &StepInputs<'_, R, N>,
        scratch: &mut CellScratch<R, N>,
    ) {
        gather(&self.nodes, shared.displacement, &mut scratch.nodes);
        for tile in &mut self.tiles {
            fill(&tile.nodes, &scratch.nodes, &mut scratch.field);
            let mut lane = 0;
            while lane < LANES {
                for (q, slot) in tile.slots.iter_mut().enumerate() {
                    let rows = &shared.tables[tile.table as usize][q];
                    let now = present::<S, R, N>(simd, rows, &slot.geometry, &scratch.field, lane);
                    slot.remember(simd, [&now.membrane, &now.bending], lane);
                }
                lane += V::<S, R>::LEN;
            }
        }
    }

    /// Strains of the points, in the order of their seats.
    #[inline(always)]
    pub(super) fn strains<S: Simd>(
        &self,
        simd: S,
        shared: &StepInputs<'_, R, N>,
        scratch: &mut CellScratch<R, N>,
        out: &mut [SurfaceStrain],
    ) {
        gather(&self.nodes, shared.displacement, &mut scratch.nodes);
        let each = self.tiles[0].slots.len();
        for (tile, out) in self.tiles.iter().zip(out.chunks_mut(LANES * each)) {
            fill(&tile.nodes, &scratch.nodes, &mut scratch.field);
            let mut lane = 0;
            while lane < LANES {
                for (q, slot) in tile.slots.iter().enumerate() {
                    let rows = &shared.tables[tile.table as usize][q];
                    let now = present::<S, R, N>(simd, rows, &slot.geometry, &scratch.field, lane);
                    for k in 0..V::<S, R>::LEN {
                        out[(lane + k) * each + q] =
                            strain_of::<S, R>(&now.membrane, &now.bending, k);
                    }
                }
                lane += V::<S, R>::LEN;
            }
        }
    }
}

/// Displacements of the block's control points from that of the first: rounding then goes by the
/// strain of the block, not by how far the body has moved.
#[inline(always)]
fn gather<R: Real>(ids: &[u32], displacement: &[[f64; 4]], local: &mut Vec<PaddedVector<R>>) {
    let base = displacement[ids[0] as usize];
    local.clear();
    local.extend(ids.iter().map(|&id| {
        let u = displacement[id as usize];
        let mut from_base = [R::of(0.0); 4];
        for axis in 0..3 {
            let d = u[axis] - base[axis];
            from_base[axis] = R::of(if d.abs() < STILL { 0.0 } else { d });
        }
        from_base
    }));
}

/// Puts the control points of cells side by side, less the first of each.
#[inline(always)]
fn fill<R: Real, const N: usize>(
    nodes: &[[u16; N]; LANES],
    local: &[PaddedVector<R>],
    field: &mut CellVectors<R, N>,
) {
    for (lane, around) in nodes.iter().enumerate() {
        let first = local[around[0] as usize];
        for (k, &node) in around.iter().enumerate() {
            let u = local[node as usize];
            for axis in 0..3 {
                field[k][axis].0[lane] = u[axis] - first[axis];
            }
        }
    }
}

/// Adds the forces of cells side by side to the control points'.
#[inline(always)]
fn drain<R: Real, const N: usize>(
    nodes: &[[u16; N]; LANES],
    field: &CellVectors<R, N>,
    forces: &mut [PaddedVector<R>],
) {
    for (lane, around) in nodes.iter().enumerate() {
        for (k, &node) in around.iter().enumerate() {
            let force = &mut forces[node as usize];
            for axis in 0..3 {
                force[axis] += field[k][axis].0[lane];
            }
        }
    }
}

/// What the few points need that are not simply elastic.
struct SpecialPoints<'a> {
    states: &'a mut [PointState],
    /// By lane, since registers of other widths take the lanes in another order.
    tallies: &'a mut [SectionTally; LANES],
}

/// The cells of one register of a tile.
#[inline(always)]
fn column<S: Simd, R: Real, const N: usize>(
    simd: S,
    tile: &mut CellTile<R, N>,
    lane: usize,
    shared: &StepInputs<'_, R, N>,
    field: &CellVectors<R, N>,
    forces: &mut CellVectors<R, N>,
    special_points: SpecialPoints<'_>,
) {
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    for lanes in forces.iter_mut().flatten() {
        store(simd, zero, lanes, lane);
    }
    let (elastic, each) = (ElasticLanes::of(shared.law), tile.slots.len());
    for (q, slot) in tile.slots.iter_mut().enumerate() {
        let rows = &shared.tables[tile.table as usize][q];
        let now = present::<S, R, N>(simd, rows, &slot.geometry, field, lane);
        let Section { whole, borne: [mut n, mut m], stirred } =
            slot.section(simd, &elastic, [&now.membrane, &now.bending], lane);
        let mut damped = slot.damped(simd, &elastic, [&now.membrane, &now.bending], lane);
        for k in (0..V::<S, R>::LEN).filter(|&k| stirred >> k & 1 == 1) {
            if slot.area.0[lane + k].wide() == 0.0 {
                (0..3).for_each(|i| (n[i][k], m[i][k]) = (R::of(0.0), R::of(0.0)));
                continue;
            }
            let strain = strain_of::<S, R>(&now.membrane, &now.bending, k);
            let state = &mut special_points.states[(lane + k) * each + q];
            let borne = shared.law.step(state, &strain, &mut special_points.tallies[lane + k]);
            for i in 0..3 {
                n[i][k] = R::of(borne.force[i]);
                m[i][k] = R::of(borne.moment[i]);
            }
            slot.watch(lane + k, shared.law.elastic_limit(state));
            if let (Some(damped), true) = (&mut damped, state.crack.is_some()) {
                damped.taken[k] = R::of(0.0);
                damped.borne.iter_mut().flatten().for_each(|part| part[k] = R::of(0.0));
            }
            if elastic.yields && elastic.soft.is_none() {
                let [all_n, all_m] = &whole;
                let less = [three(|i| all_n[i][k] - n[i][k]), three(|i| all_m[i][k] - m[i][k])];
                slot.note_flow(lane + k, &less, &strain);
            }
        }
        if let Some(Damped { borne: [more_n, more_m], taken }) = &damped {
            for i in 0..3 {
                n[i] += more_n[i];
                m[i] += more_m[i];
            }
            for k in 0..V::<S, R>::LEN {
                special_points.tallies[lane + k].damped += taken[k].wide();
            }
        }
        let area = load(simd, &slot.area, lane);
        scatter::<S, R, N>(simd, rows, &now, [&n, &m], area, forces, lane);
    }
}
