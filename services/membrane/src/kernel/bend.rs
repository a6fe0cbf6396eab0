//! The pass over pairs that bend: what a point's own curvature and those of its neighbours give
//! it. Both ends of a pair find the same bits, but for the sign.

use super::block::{BlockForces, WideSum};
use super::records::{MomentRecord, OWN, gather_moment};
use super::rows::SheetRows;
use super::working::WorkingRows;
use cullet_simd::{LANES, WINDOW};
use fearless_simd::Simd;

/// What the pass reads.
#[derive(Clone, Copy)]
pub(super) struct SheetBend<'a> {
    pub(super) layout: &'a SheetRows,
    pub(super) working: &'a WorkingRows,
    pub(super) moments: &'a [MomentRecord],
}

impl SheetBend<'_> {
    #[inline(always)]
    fn window(&self, base: usize) -> &[MomentRecord; WINDOW] {
        self.moments[base..base + WINDOW].try_into().expect("a window")
    }

    /// Finds the forces on a block's points.
    #[inline(always)]
    pub(super) fn block<S: Simd>(&self, simd: S, block: usize, forces: &mut BlockForces) {
        let window = self.window(block * LANES);
        let own = [
            gather_moment(simd, window, &OWN, 0),
            gather_moment(simd, window, &OWN, 1),
            gather_moment(simd, window, &OWN, 2),
        ];
        let mut sum = WideSum::zero(simd);
        let first = self.layout.of(block..block).start;
        for (row, n) in (first..).zip(self.layout.bent(block)) {
            let window = self.window(self.layout.bases[row] as usize);
            let ends: &[u16; LANES] = &self.layout.ends[row];
            let far = [
                gather_moment(simd, window, ends, 0),
                gather_moment(simd, window, ends, 1),
                gather_moment(simd, window, ends, 2),
            ];
            let pair = &self.working.pairs[n];
            let there = [pair.own(simd, 0), pair.own(simd, 1), pair.own(simd, 2)];
            let back = [pair.back(simd, 0), pair.back(simd, 1), pair.back(simd, 2)];
            for c in 0..3 {
                let near = own[0][c] * there[0] + own[1][c] * there[1] + own[2][c] * there[2];
                let other = far[0][c] * back[0] + far[1][c] * back[1] + far[2][c] * back[2];
                sum.add(simd, c, near - other);
            }
        }
        sum.store(&mut forces.bent);
    }
}
