//! The numbers of bonds that the kernel reads, sixteen side by side, and what it remembers of them.

use super::rows::SheetRows;
use crate::bending::{BendingStencils, MOST_COEFFICIENT};
use crate::bonds::MembraneBonds;
use crate::law::{BondMemory, untouched};
use crate::table::BondTable;
use cullet_model::MembraneLaw;
use cullet_simd::{LANES, Lanes};
use fearless_simd::{Simd, SimdBase, f32x16, i32x16};

/// By how much bounds on g are narrowed, by their size and beside it: the g of the kernel is
/// rounded to f32, and whether a memory changes is decided in f64.
const NARROWED: [f64; 2] = [2e-6, 1e-6];

/// A length in f32 that is none.
const ZERO: Lanes<f32> = Lanes([0.0; LANES]);

/// What tables are made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowSource<'a> {
    pub(crate) law: MembraneLaw,
    pub(crate) bonds: &'a MembraneBonds,
    pub(crate) table: &'a BondTable,
    /// Points whose bonds may not break.
    pub(crate) guarded: &'a [bool],
    pub(crate) areas: &'a [f64],
    /// B \[J\].
    pub(crate) bending: f64,
    /// What coefficients of curvatures are multiples of \[1/m²\].
    pub(crate) coefficient: f64,
    pub(crate) spacing: f64,
    /// Whether there is a dilatation.
    pub(crate) dilates: bool,
}

/// What a step reads of bonds, by row.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorkingRows {
    /// Fixed-point units of length over the length at rest \[1\].
    pub(crate) rest: Vec<Lanes<f32>>,
    /// k \[J\]; empty where there is no dilatation.
    pub(crate) weights: Vec<Lanes<f32>>,
    /// By row that bending uses.
    pub(crate) pairs: Vec<PairTerms>,
    /// Of ∂x/∂X and ∂x/∂Y by unit of length.
    pub(crate) slope: Vec<[Lanes<f32>; 2]>,
    /// What curvatures of a block's points, in units of length and of coefficients, have to be
    /// multiplied with to give moments whose product with a coefficient is in `bend_unit`.
    pub(crate) bending: Vec<Lanes<f32>>,
    /// Unit of forces of bending \[N\]: f32 holds those of tiny sheets no better than to 1e-38.
    pub(crate) bend_unit: f64,
    /// Length of a unit \[m\].
    unit: f64,
}

/// d of κ_xx, κ_xy and κ_yy of sixteen pairs: the upper 16 bits of a number are the point's own in
/// multiples of [`BendingStencils::unit`], the lower ones the same as the other end has it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct PairTerms(pub(crate) [[i32; LANES]; 3]);

impl PairTerms {
    /// What a coefficient of one unit is in [`PairTerms::own`] and [`PairTerms::back`].
    const ONE: f64 = 65536.0;

    fn set_own(&mut self, lane: usize, k: usize, value: i16) {
        self.0[k][lane] = i32::from(value) << 16 | self.0[k][lane] & 0xffff;
    }

    fn set_back(&mut self, lane: usize, k: usize, value: i16) {
        self.0[k][lane] = self.0[k][lane] & !0xffff | i32::from(value as u16);
    }

    /// One of the points' own coefficients.
    #[inline(always)]
    pub(crate) fn own<S: Simd>(&self, simd: S, k: usize) -> f32x16<S> {
        let both = i32x16::from_slice(simd, &self.0[k]);
        simd.cvt_f32_i32x16(both & i32x16::splat(simd, !0xffff))
    }

    /// The same as the other ends have it.
    #[inline(always)]
    pub(crate) fn back<S: Simd>(&self, simd: S, k: usize) -> f32x16<S> {
        simd.cvt_f32_i32x16(i32x16::from_slice(simd, &self.0[k]) << 16)
    }
}

/// What a step reads of bonds and changes, by row.
#[derive(Clone, Debug, Default)]
pub(crate) struct MemoryRows {
    /// k by the length at rest \[N\]; nothing of a broken bond.
    pub(crate) pull: Vec<Lanes<f32>>,
    /// Between which g no bond of the row has to be looked at by itself; nowhere where one of them
    /// remembers anything.
    pub(crate) bounds: Vec<[f32; 2]>,
    pub(crate) memory: Vec<LaneMemory>,
}

/// What bonds of a row remember.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneMemory {
    /// 1 − d.
    pub(crate) left: Lanes<f32>,
    /// p.
    pub(crate) plastic: Lanes<f32>,
    /// Between which g it does not change.
    pub(crate) low: Lanes<f32>,
    pub(crate) high: Lanes<f32>,
}

impl LaneMemory {
    const NONE: Self = Self {
        left: Lanes([1.0; LANES]),
        plastic: ZERO,
        low: Lanes([f32::NEG_INFINITY; LANES]),
        high: Lanes([f32::INFINITY; LANES]),
    };

    /// Takes what a bond remembers and the bounds between which that does not change.
    pub(crate) fn set(&mut self, lane: usize, memory: BondMemory, bounds: [f64; 2]) {
        let slack = |bound: f64| match bound.is_finite() {
            true => NARROWED[0] * bound.abs() + NARROWED[1],
            false => 0.0,
        };
        self.left.0[lane] = (1.0 - memory.damage) as f32;
        self.plastic.0[lane] = memory.plastic as f32;
        self.low.0[lane] = (bounds[0] + slack(bounds[0])) as f32;
        self.high.0[lane] = (bounds[1] - slack(bounds[1])) as f32;
    }

    /// Bounds for the whole row.
    pub(crate) fn bounds(&self) -> [f32; 2] {
        let whole = |lane: usize| self.left.0[lane] == 1.0 && self.plastic.0[lane] == 0.0;
        if !(0..LANES).all(whole) {
            return [f32::INFINITY, f32::NEG_INFINITY];
        }
        let low = self.low.0.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        [low, self.high.0.iter().copied().fold(f32::INFINITY, f32::min)]
    }
}

impl RowSource<'_> {
    /// What a curvature of 3.5 over the spacing gives \[N\].
    fn bend_unit(&self) -> f64 {
        let bends =
            self.areas.iter().zip(&self.table.softness).map(|(area, softness)| area * softness);
        let most = bends.fold(0.0, f64::max) * self.bending;
        let coefficient = MOST_COEFFICIENT / (self.spacing * self.spacing);
        (most * coefficient * coefficient.sqrt()).max(f64::MIN_POSITIVE)
    }
}

impl WorkingRows {
    /// For lengths in units of `unit` \[m\].
    pub(crate) fn new(layout: &SheetRows, unit: f64) -> Self {
        let bent = layout.bent(layout.blocks() - 1).end;
        Self {
            // An empty lane has its own point as the other end, at a length of one unit.
            rest: vec![Lanes([1.0; LANES]); layout.bases.len()],
            weights: Vec::new(),
            pairs: vec![PairTerms([[0; LANES]; 3]); bent],
            slope: vec![[ZERO; 2]; bent],
            bending: vec![ZERO; layout.blocks()],
            bend_unit: 1.0,
            unit,
        }
    }

    /// Takes the numbers of all bonds anew.
    pub(crate) fn take_up(&mut self, layout: &SheetRows, source: &RowSource<'_>) {
        if source.dilates {
            self.weights.resize(self.rest.len(), ZERO);
        }
        for (b, &slot) in layout.slots.iter().enumerate() {
            let (row, lane) = (slot as usize / LANES, slot as usize % LANES);
            self.rest[row].0[lane] = (source.table.rest[b] * self.unit) as f32;
            if source.dilates {
                self.weights[row].0[lane] = source.table.stiffness[b] as f32;
            }
        }
        self.bend_unit = source.bend_unit();
        let term = source.coefficient / PairTerms::ONE;
        let by_unit = source.bending * self.unit * term * term / self.bend_unit;
        for (i, (area, softness)) in source.areas.iter().zip(&source.table.softness).enumerate() {
            self.bending[i / LANES].0[i % LANES] = (area * softness * by_unit) as f32;
        }
    }

    /// Takes the curvature of a point anew.
    pub(crate) fn take_curvature(
        &mut self,
        layout: &SheetRows,
        stencils: &BendingStencils,
        i: usize,
    ) {
        for n in stencils.of(i) {
            let term = stencils.terms[n];
            let (row, lane) = layout.bent_slot(stencils.bonds[n] as usize, i);
            let twin = stencils.twins[n] as usize;
            let j = stencils.ends[n] as usize;
            let (far_row, far_lane) = layout.bent_slot(stencils.bonds[twin] as usize, j);
            for k in 0..3 {
                let whole = (term.curvature[k] / stencils.unit()).round() as i16;
                self.pairs[row].set_own(lane, k, whole);
                self.pairs[far_row].set_back(far_lane, k, whole);
            }
            for k in 0..2 {
                self.slope[row][k].0[lane] = (term.slope[k] * self.unit) as f32;
            }
        }
    }
}

impl MemoryRows {
    pub(crate) fn new(layout: &SheetRows) -> Self {
        let count = layout.bases.len();
        Self {
            pull: vec![ZERO; count],
            bounds: vec![[f32::NEG_INFINITY, f32::INFINITY]; count],
            memory: vec![LaneMemory::NONE; count],
        }
    }

    /// Takes what all bonds remember, and when that changes, anew.
    pub(crate) fn take_up(
        &mut self,
        layout: &SheetRows,
        source: &RowSource<'_>,
        memory: impl Fn(usize) -> BondMemory,
    ) {
        for i in 0..source.areas.len() {
            for b in source.bonds.of(i) {
                let (row, lane) =
                    (layout.slots[b] as usize / LANES, layout.slots[b] as usize % LANES);
                let memory = memory(b);
                let fails = !(source.guarded[i] || source.guarded[source.bonds.ends[b] as usize]);
                let bounds = untouched(source.law, memory, source.table.limits[b], fails);
                self.memory[row].set(lane, memory, bounds);
                self.pull[row].0[lane] = match memory.damage >= 1.0 {
                    true => 0.0,
                    false => (source.table.stiffness[b] * source.table.rest[b]) as f32,
                };
            }
        }
        for (bounds, memory) in self.bounds.iter_mut().zip(&self.memory) {
            *bounds = memory.bounds();
        }
    }
}
