//! Forces on all points and the kick that follows: sixteen points side by side in f32 (see
//! `cullet_simd`), each bond worked out at both of its ends.
//!
//! Places, velocities and memories are kept in f64. Differences of places are exact
//! ([`records`]), only signs differ between the ends of a bond, and forces are summed up in f64:
//! so inner forces have no sum but by rounding in f64. What each lane does depends on its own bonds
//! alone, in a fixed order; neither the width of registers nor the number of threads changes a bit.
//!
//! At nearly all times nearly all bonds are elastic. A row of bonds has two bounds on g; if all of
//! its bonds are within, nothing of what they remember is read. The few whose memory may change
//! are handed, one by one, to [`touch`], which decides in f64.
//!
//! Inner code has no closures: they are not always inlined where the level's instructions are.

mod bend;
mod block;
mod kick;
pub(crate) mod order;
mod pull;
pub(crate) mod records;
pub(crate) mod rows;
mod task;
mod touch;
pub(crate) mod working;

use crate::bending::BendingStencils;
use crate::bonds::MembraneBonds;
use crate::forces::{ForceInput, StepSums};
use crate::law::BondMemory;
use bend::SheetBend;
use block::BlockForces;
use cullet_geometry::Vec3;
use cullet_model::MembraneLaw;
use cullet_simd::{LANES, PackedRecord, SimdLevel};
use fearless_simd::{Simd, dispatch};
use kick::KickPass;
use pull::{DILATED_FORCES, DILATION, FORCES, SheetPull};
use records::{MomentRecord, pack, padded};
use rows::SheetRows;
use std::sync::Arc;
use task::{RememberedRows, TaskRows};
use working::{MemoryRows, RowSource, WorkingRows};

/// Blocks that one task takes. The split of sums depends on it, and on nothing else.
const TASK: usize = 32;

/// The kernel's own lists, for one run of a sheet.
#[derive(Clone, Debug)]
pub(crate) struct SheetKernel {
    level: SimdLevel,
    layout: Arc<SheetRows>,
    working: WorkingRows,
    memory: MemoryRows,
    /// Length of a unit of places \[m\].
    unit: f64,
    records: Vec<PackedRecord>,
    forces: Vec<BlockForces>,
    moments: Vec<MomentRecord>,
    dilations: Vec<f32>,
    lost: Vec<f64>,
}

/// What a step changes beside the kernel's own lists.
#[derive(Debug)]
pub(crate) struct StepRows<'a> {
    pub(crate) damage: &'a mut [f64],
    /// Of a foil; empty otherwise.
    pub(crate) plastic: &'a mut [f64],
    /// Likewise.
    pub(crate) flowed: &'a mut [f64],
    /// Velocities after the step \[m/s\].
    pub(crate) after: &'a mut [Vec3],
    /// Impulses of grips \[N·s\].
    pub(crate) held: &'a mut [Vec3],
    /// Points of which a bond has broken.
    pub(crate) torn: &'a mut [bool],
}

/// The first `count` of a list, or all, and the rest.
fn part<T>(all: &mut [T], count: usize) -> (&mut [T], &mut [T]) {
    let count = count.min(all.len());
    all.split_at_mut(count)
}

impl RememberedRows<'_> {
    /// The same once more.
    fn again(&mut self) -> RememberedRows<'_> {
        RememberedRows {
            first: self.first,
            first_row: self.first_row,
            first_bond: self.first_bond,
            damage: &mut *self.damage,
            plastic: &mut *self.plastic,
            flowed: &mut *self.flowed,
            memory: &mut *self.memory,
            lost: &mut *self.lost,
            torn: &mut *self.torn,
        }
    }

    /// Two parts, the first of `count` blocks.
    fn split(self, layout: &SheetRows, bonds: &MembraneBonds, count: usize) -> (Self, Self) {
        let middle = self.first + count;
        let rows = layout.of(self.first..middle);
        let first_bond = bonds.starts[middle * LANES] as usize;
        let (slots, points) = (first_bond - self.first_bond, count * LANES);
        let (damage, damage_after) = part(self.damage, slots);
        let (plastic, plastic_after) = part(self.plastic, slots);
        let (flowed, flowed_after) = part(self.flowed, slots);
        let (memory, memory_after) = part(self.memory, rows.len());
        let (lost, lost_after) = part(self.lost, points);
        let (torn, torn_after) = part(self.torn, points);
        let (first, first_row) = (self.first, self.first_row);
        let low = Self { damage, plastic, flowed, memory, lost, torn, first, first_row, ..self };
        let high = Self {
            first: middle,
            first_row: rows.end,
            first_bond,
            damage: damage_after,
            plastic: plastic_after,
            flowed: flowed_after,
            memory: memory_after,
            lost: lost_after,
            torn: torn_after,
        };
        (low, high)
    }
}

impl TaskRows<'_> {
    /// The same once more.
    fn again(&mut self) -> TaskRows<'_> {
        TaskRows {
            remembered: self.remembered.again(),
            pull: &mut *self.pull,
            bounds: &mut *self.bounds,
            forces: &mut *self.forces,
            moments: &mut *self.moments,
            dilations: &mut *self.dilations,
            after: &mut *self.after,
            held: &mut *self.held,
        }
    }

    /// Two parts, the first of `count` blocks.
    fn split(self, layout: &SheetRows, bonds: &MembraneBonds, count: usize) -> (Self, Self) {
        let first = self.remembered.first;
        let (rows, points) = (layout.of(first..first + count).len(), count * LANES);
        let (remembered, remembered_after) = self.remembered.split(layout, bonds, count);
        let (pull, pull_after) = part(self.pull, rows);
        let (bounds, bounds_after) = part(self.bounds, rows);
        let (forces, forces_after) = part(self.forces, count);
        let (moments, moments_after) = part(self.moments, points);
        let (dilations, dilations_after) = part(self.dilations, points);
        let (after, after_after) = part(self.after, points);
        let (held, held_after) = part(self.held, points);
        let low = Self { remembered, pull, bounds, forces, moments, dilations, after, held };
        let high = Self {
            remembered: remembered_after,
            pull: pull_after,
            bounds: bounds_after,
            forces: forces_after,
            moments: moments_after,
            dilations: dilations_after,
            after: after_after,
            held: held_after,
        };
        (low, high)
    }
}

/// Runs a pass over all blocks in tasks of fixed size and adds up what they did, in a fixed order.
fn pass(
    layout: &SheetRows,
    bonds: &MembraneBonds,
    rows: TaskRows<'_>,
    task: &(impl Fn(TaskRows<'_>) -> StepSums + Sync),
) -> StepSums {
    let count = rows.forces.len();
    if count <= TASK {
        return task(rows);
    }
    let half = count.div_ceil(2 * TASK) * TASK;
    let (low, high) = rows.split(layout, bonds, half);
    let of = |rows| pass(layout, bonds, rows, task);
    let (a, b) = rayon::join(|| of(low), || of(high));
    a.plus(b)
}

impl SheetKernel {
    /// For places in units of `unit` \[m\].
    pub(crate) fn new(layout: Arc<SheetRows>, count: usize, unit: f64) -> Self {
        let blocks = layout.blocks();
        Self {
            level: SimdLevel::best(),
            working: WorkingRows::new(&layout, unit),
            memory: MemoryRows::new(&layout),
            unit,
            records: padded(count),
            forces: vec![BlockForces::default(); blocks],
            moments: padded(blocks * LANES),
            dilations: vec![0.0; blocks * LANES],
            lost: vec![0.0; blocks * LANES],
            layout,
        }
    }

    /// Takes the instructions of another level.
    #[cfg(test)]
    pub(crate) fn use_level(&mut self, level: SimdLevel) {
        self.level = level;
    }

    /// Takes the numbers of all bonds anew, and what they remember.
    pub(crate) fn take_up(&mut self, source: &RowSource<'_>, memory: impl Fn(usize) -> BondMemory) {
        self.working.take_up(&self.layout, source);
        self.remember(source, memory);
    }

    /// Takes what all bonds remember, and which may break, anew.
    pub(crate) fn remember(
        &mut self,
        source: &RowSource<'_>,
        memory: impl Fn(usize) -> BondMemory,
    ) {
        self.memory.take_up(&self.layout, source, memory);
    }

    /// Takes the curvature of a point anew.
    pub(crate) fn take_curvature(&mut self, stencils: &BendingStencils, i: usize) {
        self.working.take_curvature(&self.layout, stencils, i);
    }

    /// Moves points for a time \[s\], to where forces are found next.
    pub(crate) fn drift(&mut self, places: &mut [Vec3], velocities: &[Vec3], dt: f64) {
        let records = &mut self.records[..places.len()];
        drift(records, places, velocities, [dt, 1.0 / self.unit]);
    }

    /// Finds the forces on all points, and kicks them.
    pub(crate) fn step(&mut self, input: &ForceInput<'_>, rows: StepRows<'_>) -> StepSums {
        let Self { layout, working, records, memory, .. } = self;
        let (layout, working, level) = (&**layout, &*working, self.level.level());
        let damping = (input.damping / self.unit) as f32;
        let mut all = TaskRows {
            remembered: RememberedRows {
                first: 0,
                first_row: 0,
                first_bond: 0,
                damage: rows.damage,
                plastic: rows.plastic,
                flowed: rows.flowed,
                memory: &mut memory.memory,
                lost: &mut self.lost,
                torn: rows.torn,
            },
            pull: &mut memory.pull,
            bounds: &mut memory.bounds,
            forces: &mut self.forces,
            moments: &mut self.moments,
            dilations: &mut self.dilations,
            after: rows.after,
            held: rows.held,
        };
        let (bends, dilates) = (input.bending[0] > 0.0, input.dilatation != 0.0);
        let pull = SheetPull { input, layout, working, records, damping };
        let first = |rows: TaskRows<'_>| dispatch!(level, simd => first_task(simd, &pull, rows));
        let sums = pass(layout, input.bonds, all.again(), &first);
        if !bends && !dilates {
            return sums;
        }
        // The second pass reads what the first has found at all points.
        let dilations = std::mem::take(&mut all.dilations);
        for (record, dilation) in records.iter_mut().zip(&*dilations) {
            record.0[3] = *dilation;
        }
        let pull = SheetPull { input, layout, working, records, damping };
        let moments = std::mem::take(&mut all.moments);
        let bend = SheetBend { layout, working, moments };
        let second =
            |rows: TaskRows<'_>| dispatch!(level, simd => second_task(simd, &pull, &bend, rows));
        sums.plus(pass(layout, input.bonds, all, &second))
    }
}

/// Moves points for a time \[s\] and puts them into their records, in units of one over the second
/// number.
fn drift(
    records: &mut [PackedRecord],
    places: &mut [Vec3],
    velocities: &[Vec3],
    [dt, inverse]: [f64; 2],
) {
    if places.len() > TASK * LANES {
        let middle = places.len().div_ceil(2 * TASK * LANES) * TASK * LANES;
        let (places, places_after) = places.split_at_mut(middle);
        let (records, records_after) = records.split_at_mut(middle);
        let (velocities, velocities_after) = velocities.split_at(middle);
        let times = [dt, inverse];
        rayon::join(
            || drift(records, places, velocities, times),
            || drift(records_after, places_after, velocities_after, times),
        );
        return;
    }
    for (record, (place, velocity)) in records.iter_mut().zip(places.iter_mut().zip(velocities)) {
        *place += velocity * dt;
        pack(record, place, velocity, inverse);
    }
}

/// Stretches and curvatures; where nothing else has to be known, the kick too.
#[inline(always)]
fn first_task<S: Simd>(simd: S, pull: &SheetPull<'_>, mut rows: TaskRows<'_>) -> StepSums {
    let input = pull.input;
    let (bends, dilates) = (input.bending[0] > 0.0, input.dilatation != 0.0);
    let mut sums = match (input.law, dilates) {
        (MembraneLaw::Rubber, _) => pull.run::<S, true, FORCES>(simd, &mut rows),
        (_, false) => pull.run::<S, false, FORCES>(simd, &mut rows),
        (_, true) => pull.run::<S, false, DILATION>(simd, &mut rows),
    };
    if !bends && !dilates {
        let mut kick = KickPass::new(input, pull.working.bend_unit);
        for k in 0..rows.forces.len() {
            kick.block(k, &mut rows);
        }
        sums = sums.plus(kick.sums());
    }
    sums
}

/// Forces that depend on the dilatation and curvature of others, and the kick.
#[inline(always)]
fn second_task<S: Simd>(
    simd: S,
    pull: &SheetPull<'_>,
    bend: &SheetBend<'_>,
    mut rows: TaskRows<'_>,
) -> StepSums {
    let input = pull.input;
    let sums = match input.dilatation != 0.0 {
        true => pull.run::<S, false, DILATED_FORCES>(simd, &mut rows),
        false => StepSums::default(),
    };
    let mut kick = KickPass::new(input, pull.working.bend_unit);
    for k in 0..rows.forces.len() {
        if input.bending[0] > 0.0 {
            bend.block(simd, rows.remembered.first + k, &mut rows.forces[k]);
        }
        kick.block(k, &mut rows);
    }
    sums.plus(kick.sums())
}

#[cfg(test)]
mod tests;
