//! Where each bond is worked on. Points stand side by side, sixteen in a block, and each row of a
//! block has one bond of each of them: no sum runs across lanes. Bonds that bending uses come in
//! the first rows.

use crate::bending::BendingStencils;
use crate::bonds::MembraneBonds;
use cullet_continuum::bytes::held;
use cullet_simd::{LANES, WINDOW};
use std::ops::Range;

/// The bond of a lane that has none.
pub(crate) const EMPTY: u32 = u32::MAX;

/// The rows of all blocks.
#[derive(Clone, Debug)]
pub(crate) struct SheetRows {
    /// First row of each block, then their number.
    starts: Vec<u32>,
    /// Rows of earlier blocks that have bonds which bending uses.
    bent: Vec<u32>,
    /// A point before all ends of a row.
    pub(crate) bases: Vec<u32>,
    /// Other ends from there; an empty lane has its own point.
    pub(crate) ends: Vec<[u16; LANES]>,
    pub(crate) bonds: Vec<[u32; LANES]>,
    /// Where each bond is: its row times [`LANES`], plus its lane.
    pub(crate) slots: Vec<u32>,
}

/// A bond and its other end.
#[derive(Clone, Copy, Debug)]
struct LaneEntry {
    bond: u32,
    end: u32,
}

impl SheetRows {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let lists = [&self.starts, &self.bent, &self.bases, &self.slots].map(|list| held(list));
        lists.iter().sum::<u64>() + held(&self.ends) + held(&self.bonds)
    }

    pub(crate) fn new(bonds: &MembraneBonds, stencils: &BendingStencils) -> Self {
        let count = bonds.starts.len() - 1;
        let mut rows = Self {
            starts: vec![0],
            bent: vec![0],
            bases: Vec::new(),
            ends: Vec::new(),
            bonds: Vec::new(),
            slots: vec![0; bonds.ends.len()],
        };
        let mut bent = 0;
        for first in (0..count).step_by(LANES) {
            let lists: [Vec<LaneEntry>; LANES] = std::array::from_fn(|lane| match first + lane {
                i if i < count => entries(bonds, stencils, i),
                _ => Vec::new(),
            });
            let stencil = |lane: usize| match first + lane {
                i if i < count => stencils.of(i).len(),
                _ => 0,
            };
            let of_stencils = (0..LANES).map(stencil).max().unwrap_or(0);
            let most = lists.iter().map(Vec::len).max().unwrap_or(0);
            for depth in 0..most {
                let entry = |lane: usize| lists[lane].get(depth).copied();
                rows.push(first, count, std::array::from_fn(entry));
                if depth + 1 == of_stencils {
                    bent += rows.bases.len() as u32 - rows.starts[rows.starts.len() - 1];
                }
            }
            rows.starts.push(rows.bases.len() as u32);
            rows.bent.push(bent);
        }
        rows
    }

    /// Adds the rows that hold one bond of each lane: one, unless ends lie far apart in memory.
    fn push(&mut self, first: usize, count: usize, entries: [Option<LaneEntry>; LANES]) {
        let mut left = entries;
        loop {
            let own = |lane: usize| (first + lane).min(count - 1) as u32;
            let end = |lane: usize| left[lane].map_or(own(lane), |entry| entry.end);
            let base = (0..LANES).map(end).min().unwrap_or(0);
            let row = self.bases.len() as u32;
            let (mut ends, mut bonds) = ([0; LANES], [EMPTY; LANES]);
            let within = |point: u32| ((point - base) as usize) < WINDOW;
            for lane in 0..LANES {
                match left[lane] {
                    Some(entry) if within(entry.end) => {
                        ends[lane] = (entry.end - base) as u16;
                        bonds[lane] = entry.bond;
                        self.slots[entry.bond as usize] = row * LANES as u32 + lane as u32;
                        left[lane] = None;
                    }
                    // Whatever is read there has no stiffness.
                    _ if within(own(lane)) => ends[lane] = (own(lane) - base) as u16,
                    _ => {}
                }
            }
            self.bases.push(base);
            self.ends.push(ends);
            self.bonds.push(bonds);
            if left.iter().all(Option::is_none) {
                return;
            }
        }
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.starts.len() - 1
    }

    /// Rows of some blocks.
    #[inline(always)]
    pub(crate) fn of(&self, blocks: Range<usize>) -> Range<usize> {
        self.starts[blocks.start] as usize..self.starts[blocks.end] as usize
    }

    /// Numbers of a block's rows in lists of those that bending uses alone. They are its first.
    #[inline(always)]
    pub(crate) fn bent(&self, block: usize) -> Range<usize> {
        self.bent[block] as usize..self.bent[block + 1] as usize
    }

    /// Place in lists of rows that bending uses, and lane, of a bond that it uses.
    pub(crate) fn bent_slot(&self, bond: usize, point: usize) -> (usize, usize) {
        let slot = self.slots[bond] as usize;
        let block = point / LANES;
        let behind = slot / LANES - self.starts[block] as usize;
        (self.bent[block] as usize + behind, slot % LANES)
    }
}

/// The bonds of a point, those that bending uses first.
fn entries(bonds: &MembraneBonds, stencils: &BendingStencils, i: usize) -> Vec<LaneEntry> {
    let used: Vec<u32> = stencils.of(i).map(|n| stencils.bonds[n]).collect();
    let others = bonds.of(i).map(|b| b as u32).filter(|b| used.binary_search(b).is_err());
    let entry = |bond: u32| LaneEntry { bond, end: bonds.ends[bond as usize] };
    used.iter().copied().chain(others).map(entry).collect()
}
