//! The pass over bonds: stretches, what they remember, forces along them, and the curvatures and
//! slopes of points.

use super::block::{BlockForces, WideSum, load};
use super::records::{MomentRecord, OWN, window};
use super::rows::SheetRows;
use super::task::{RememberedRows, TaskRows};
use super::touch::{TouchedLanes, touch};
use super::working::WorkingRows;
use crate::forces::{ForceInput, StepSums};
use cullet_simd::{LANES, Lanes, PackedRecord, gather_records};
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, i32x16};
use std::cell::Cell;

/// Forces, where there is no dilatation.
pub(super) const FORCES: u8 = 0;
/// The dilatation of points, and all that bonds remember.
pub(super) const DILATION: u8 = 1;
/// Forces with the dilatation of both ends.
pub(super) const DILATED_FORCES: u8 = 2;

/// What the pass reads.
#[derive(Clone, Copy)]
pub(super) struct SheetPull<'a> {
    pub(super) input: &'a ForceInput<'a>,
    pub(super) layout: &'a SheetRows,
    pub(super) working: &'a WorkingRows,
    /// Place, dilatation and velocity.
    pub(super) records: &'a [PackedRecord],
    /// c = `damping` k/ξ², by unit of length \[s/m\].
    pub(super) damping: f32,
}

/// Rows of a block, as lists of one length.
struct BlockRows<'a> {
    /// Number of the first.
    first: usize,
    bases: &'a [u32],
    ends: &'a [[u16; LANES]],
    rest: &'a [Lanes<f32>],
    pull: &'a [Cell<Lanes<f32>>],
    bounds: &'a [Cell<[f32; 2]>],
}

/// The bond of each lane of a row, as it is now, in units of length.
struct RowShape<S: Simd> {
    /// From the point to the other end.
    off: [f32x16<S>; 3],
    length: f32x16<S>,
    inverse: f32x16<S>,
    /// How fast the other end moves away \[m/s\].
    closing: f32x16<S>,
    /// 2ΛAθ/Σk of the other end \[1\].
    other: f32x16<S>,
}

/// Sums over rows.
struct RowSums<S: Simd> {
    force: WideSum<S>,
    damper: [f32x16<S>; 3],
    /// κ_xx, κ_xy and κ_yy, in units of length and of coefficients.
    curvature: [[f32x16<S>; 3]; 3],
    slope: [[f32x16<S>; 3]; 2],
    /// Σk of what the dilatation counts \[J\].
    dilated: f32x16<S>,
}

impl<S: Simd> RowShape<S> {
    #[inline(always)]
    fn of(
        simd: S,
        records: &[PackedRecord],
        own: &[f32x16<S>; 8],
        base: u32,
        ends: &[u16; LANES],
    ) -> Self {
        let far = gather_records(simd, window(records, base as usize), ends);
        let zero = f32x16::splat(simd, 0.0);
        let mut off = [zero; 3];
        for c in 0..3 {
            let there: i32x16<S> = far[c].bitcast();
            let here: i32x16<S> = own[c].bitcast();
            off[c] = simd.cvt_f32_i32x16(there - here);
        }
        let one = f32x16::splat(simd, 1.0);
        let square = (off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).max(one);
        // The root and the quotient do not wait for each other.
        let (length, quotient) = (square.sqrt(), one / square);
        let inverse = length * quotient;
        let (u, v, w) = (far[4] - own[4], far[5] - own[5], far[6] - own[6]);
        let closing = (off[0] * u + off[1] * v + off[2] * w) * inverse;
        Self { off, length, inverse, closing, other: far[3] }
    }
}

impl<S: Simd> RowSums<S> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        Self {
            force: WideSum::zero(simd),
            damper: [zero; 3],
            curvature: [[zero; 3]; 3],
            slope: [[zero; 3]; 2],
            dilated: zero,
        }
    }
}

/// Adds what a row gives to a curvature or slope.
#[inline(always)]
fn add<S: Simd>(sum: &mut [f32x16<S>; 3], shape: &RowShape<S>, term: f32x16<S>) {
    for (sum, off) in sum.iter_mut().zip(shape.off) {
        *sum += off * term;
    }
}

impl SheetPull<'_> {
    /// Works through the points of a task.
    #[inline(always)]
    pub(super) fn run<S: Simd, const RUBBER: bool, const PASS: u8>(
        &self,
        simd: S,
        rows: &mut TaskRows<'_>,
    ) -> StepSums {
        let mut sums = StepSums::default();
        for k in 0..rows.forces.len() {
            self.block::<S, RUBBER, PASS>(simd, k, rows, &mut sums);
        }
        sums
    }

    #[inline(always)]
    fn block<S: Simd, const RUBBER: bool, const PASS: u8>(
        &self,
        simd: S,
        k: usize,
        rows: &mut TaskRows<'_>,
        sums: &mut StepSums,
    ) {
        let block = rows.remembered.first + k;
        let own = gather_records(simd, window(self.records, block * LANES), &OWN);
        let mut out = RowSums::zero(simd);
        let shaped = PASS != DILATED_FORCES;
        let bends = shaped && self.input.bending[0] > 0.0;
        let blows = shaped && self.input.air.is_some();
        let all = self.layout.of(block..block + 1);
        let (at, count) = (all.start - rows.remembered.first_row, all.len());
        let list = BlockRows {
            first: all.start,
            bases: &self.layout.bases[all.clone()],
            ends: &self.layout.ends[all.clone()],
            rest: &self.working.rest[all],
            pull: Cell::from_mut(&mut rows.pull[at..at + count]).as_slice_of_cells(),
            bounds: Cell::from_mut(&mut rows.bounds[at..at + count]).as_slice_of_cells(),
        };
        let bent = self.layout.bent(block);
        let bent = if bends || blows { bent } else { bent.start..bent.start };
        let pairs = &self.working.pairs[bent.clone()];
        let slope = &self.working.slope[bent];
        let memory = &mut rows.remembered;
        for r in 0..pairs.len().min(count) {
            let shape = RowShape::of(simd, self.records, &own, list.bases[r], &list.ends[r]);
            self.pull::<S, RUBBER, PASS>(simd, &list, r, &own, &shape, memory, &mut out, sums);
            if bends {
                for k in 0..3 {
                    add(&mut out.curvature[k], &shape, pairs[r].own(simd, k));
                }
            }
            if blows {
                for (sum, lanes) in out.slope.iter_mut().zip(&slope[r]) {
                    add(sum, &shape, load(simd, lanes));
                }
            }
        }
        for r in pairs.len()..count {
            let shape = RowShape::of(simd, self.records, &own, list.bases[r], &list.ends[r]);
            self.pull::<S, RUBBER, PASS>(simd, &list, r, &own, &shape, memory, &mut out, sums);
        }
        if PASS == DILATION {
            let mut dilated = [0.0; LANES];
            out.dilated.store_slice(&mut dilated);
            self.dilate(k, &dilated, rows, sums);
        } else {
            let forces: &mut BlockForces = &mut rows.forces[k];
            out.force.store(&mut forces.pulled);
            for c in 0..3 {
                out.damper[c].store_slice(&mut forces.damper[c].0);
            }
        }
        if bends {
            self.moments(simd, block, &out, &mut rows.moments[k * LANES..]);
        }
        if blows {
            let [x, y] = &out.slope;
            for c in 0..3 {
                let (d, e) = ((c + 1) % 3, (c + 2) % 3);
                (x[d] * y[e] - x[e] * y[d]).store_slice(&mut rows.forces[k].area[c].0);
            }
        }
    }

    /// Adds what the bonds of a row do.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a struct of them would not stay in registers")]
    fn pull<S: Simd, const RUBBER: bool, const PASS: u8>(
        &self,
        simd: S,
        list: &BlockRows<'_>,
        r: usize,
        own: &[f32x16<S>; 8],
        shape: &RowShape<S>,
        remembered: &mut RememberedRows<'_>,
        out: &mut RowSums<S>,
        sums: &mut StepSums,
    ) {
        let one = f32x16::splat(simd, 1.0);
        let rest = load(simd, &list.rest[r]);
        let stretch = shape.length * rest;
        let (mut g, mut slope) = (stretch - one, one);
        if RUBBER {
            let half = f32x16::splat(simd, 0.5);
            let inverse = one / stretch;
            g = half * (stretch - inverse);
            slope = half * (one + inverse * inverse);
        }
        let (mut tension, mut left) = (g, one);
        let [low, high] = list.bounds[r].get();
        let beyond = g.simd_gt(f32x16::splat(simd, high)) | g.simd_lt(f32x16::splat(simd, low));
        if beyond.any_true() {
            [tension, left] = self.look::<S, PASS>(simd, list, r, g, remembered, sums);
        }
        if PASS == DILATION {
            out.dilated += load(simd, &self.working.weights[list.first + r]) * tension;
            return;
        }
        if PASS == DILATED_FORCES {
            tension += left * (own[3] + shape.other);
        }
        let pull = load(simd, &list.pull[r].get());
        let damping = f32x16::splat(simd, self.damping);
        let drag = pull * (left * (rest * damping)) * shape.closing;
        let mut both = pull * tension;
        if RUBBER {
            both *= slope;
        }
        let (along, drag) = ((both + drag) * shape.inverse, drag * shape.inverse);
        for c in 0..3 {
            out.force.add(simd, c, shape.off[c] * along);
            out.damper[c] += shape.off[c] * drag;
        }
    }

    /// What the bonds of a row bear of g, and what is left of them, by what they remember.
    #[inline(always)]
    fn look<S: Simd, const PASS: u8>(
        &self,
        simd: S,
        list: &BlockRows<'_>,
        r: usize,
        g: f32x16<S>,
        remembered: &mut RememberedRows<'_>,
        sums: &mut StepSums,
    ) -> [f32x16<S>; 2] {
        let row = list.first + r;
        let at = row - remembered.first_row;
        let memory = &remembered.memory[at];
        let left = load(simd, &memory.left);
        let bears = match PASS {
            DILATION => left,
            _ => {
                let one = f32x16::splat(simd, 1.0);
                g.simd_gt(f32x16::splat(simd, 0.0)).select(left, one)
            }
        };
        let tension = bears * (g - load(simd, &memory.plastic));
        let touched = g.simd_gt(load(simd, &memory.high)) | g.simd_lt(load(simd, &memory.low));
        if PASS == DILATED_FORCES || !touched.any_true() {
            return [tension, left];
        }
        let mut lanes = TouchedLanes {
            which: touched.to_bitmask() as u16,
            broken: 0,
            counted: PASS == DILATION,
            tension: Lanes([0.0; LANES]),
            left: Lanes([0.0; LANES]),
        };
        tension.store_slice(&mut lanes.tension.0);
        left.store_slice(&mut lanes.left.0);
        touch(self.input, self.layout, row, &mut lanes, remembered, sums);
        if lanes.broken != 0 {
            let mut pull = list.pull[r].get();
            for lane in (0..LANES).filter(|lane| lanes.broken >> lane & 1 == 1) {
                pull.0[lane] = 0.0;
            }
            list.pull[r].set(pull);
        }
        list.bounds[r].set(remembered.memory[at].bounds());
        [load(simd, &lanes.tension), load(simd, &lanes.left)]
    }

    /// A B ∂(½q)/∂κ of a block's points.
    #[inline(always)]
    fn moments<S: Simd>(
        &self,
        simd: S,
        block: usize,
        out: &RowSums<S>,
        moments: &mut [MomentRecord],
    ) {
        let scale = load(simd, &self.working.bending[block]);
        let poisson = self.input.bending[1] as f32;
        let straight = f32x16::splat(simd, poisson);
        let twist = f32x16::splat(simd, 2.0 * (1.0 - poisson));
        let [xx, xy, yy] = &out.curvature;
        for c in 0..3 {
            let mut lanes = [[0.0; LANES]; 3];
            ((xx[c] + yy[c] * straight) * scale).store_slice(&mut lanes[0]);
            (xy[c] * twist * scale).store_slice(&mut lanes[1]);
            ((yy[c] + xx[c] * straight) * scale).store_slice(&mut lanes[2]);
            for (lane, record) in moments.iter_mut().take(LANES).enumerate() {
                for (moment, lanes) in record.0.iter_mut().zip(&lanes) {
                    moment[c] = lanes[lane];
                }
            }
        }
    }

    /// What the dilatation of a block's points adds to the stretch of their bonds, and what they
    /// have lost of it by damage and flow.
    fn dilate(
        &self,
        k: usize,
        dilated: &[f32; LANES],
        rows: &mut TaskRows<'_>,
        sums: &mut StepSums,
    ) {
        let input = self.input;
        for (at, dilated) in (k * LANES..rows.after.len()).zip(dilated) {
            let i = rows.remembered.first * LANES + at;
            let scale = 2.0 / input.table.sums[i];
            let theta = scale * f64::from(*dilated);
            let lambda = input.dilatation * input.table.softness[i] * input.areas[i];
            let lost = scale * std::mem::take(&mut rows.remembered.lost[at]);
            sums.broken += lambda * (theta * lost + 0.5 * lost * lost);
            rows.dilations[at] = (scale * lambda * theta) as f32;
        }
    }
}
