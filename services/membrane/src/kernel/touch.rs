//! Bonds whose memory may change, one by one and in f64: few at any time.

use super::rows::{EMPTY, SheetRows};
use super::task::RememberedRows;
use crate::forces::{ForceInput, StepSums};
use crate::law::{BondMemory, counted, generalised, stretched, untouched};
use crate::vector::length;
use cullet_model::MembraneLaw;
use cullet_simd::{LANES, Lanes};

/// Bonds of a row that are looked at.
pub(super) struct TouchedLanes {
    /// A bit each.
    pub(super) which: u16,
    /// Those that have broken.
    pub(super) broken: u16,
    /// Whether `tension` is what a dilatation counts.
    pub(super) counted: bool,
    /// T/k \[1\].
    pub(super) tension: Lanes<f32>,
    /// 1 − d.
    pub(super) left: Lanes<f32>,
}

/// Stretches some bonds of a row to where they are.
#[inline(never)]
pub(super) fn touch(
    input: &ForceInput<'_>,
    layout: &SheetRows,
    row: usize,
    lanes: &mut TouchedLanes,
    rows: &mut RememberedRows<'_>,
    sums: &mut StepSums,
) {
    let at = row - rows.first_row;
    let block = rows.block_of(layout, row);
    for lane in (0..LANES).filter(|lane| lanes.which >> lane & 1 == 1) {
        let b = layout.bonds[row][lane];
        if b == EMPTY {
            continue;
        }
        let b = b as usize;
        let i = (rows.first + block) * LANES + lane;
        let j = input.bonds.ends[b] as usize;
        let mut memory = rows.of(b);
        let long = length(&(input.places[j] - input.places[i]));
        let g = generalised(input.law, long * input.table.rest[b]);
        let k = input.table.stiffness[b];
        let before = memory;
        let (fails, limits) = (!(input.guarded[i] || input.guarded[j]), input.table.limits[b]);
        let did = stretched(input.law, g, &mut memory, limits, fails);
        lanes.left.0[lane] = (1.0 - memory.damage) as f32;
        lanes.tension.0[lane] = match lanes.counted {
            true => counted(g, memory) as f32,
            false => did.tension as f32,
        };
        if memory == before {
            continue;
        }
        sums.broken += 0.5 * k * did.broken;
        sums.plastic += 0.5 * k * did.plastic;
        rows.lost[block * LANES + lane] += k * (counted(g, before) - counted(g, memory));
        rows.remember(input.law, b, memory);
        rows.memory[at].set(lane, memory, untouched(input.law, memory, limits, fails));
        if memory.damage >= 1.0 {
            sums.breaks += 1;
            rows.torn[block * LANES + lane] = true;
            lanes.broken |= 1 << lane;
        }
    }
}

impl RememberedRows<'_> {
    /// The block of a row, counted from the first of the task.
    fn block_of(&self, layout: &SheetRows, row: usize) -> usize {
        let (mut low, mut high) = (0, self.torn.len().div_ceil(LANES));
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            let first = layout.of(self.first + middle..self.first + middle).start;
            if first <= row { low = middle } else { high = middle }
        }
        low
    }

    /// What a bond remembers.
    fn of(&self, b: usize) -> BondMemory {
        let slot = b - self.first_bond;
        let of = |all: &[f64]| all.get(slot).copied().unwrap_or(0.0);
        BondMemory { damage: self.damage[slot], plastic: of(self.plastic), flowed: of(self.flowed) }
    }

    fn remember(&mut self, law: MembraneLaw, b: usize, memory: BondMemory) {
        let slot = b - self.first_bond;
        self.damage[slot] = memory.damage;
        if law == MembraneLaw::Foil {
            self.plastic[slot] = memory.plastic;
            self.flowed[slot] = memory.flowed;
        }
    }
}
