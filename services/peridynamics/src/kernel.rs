//! The two passes over all bonds, sixteen side by side in f32 (see `cullet_simd`).
//!
//! Lengths are in horizons, volumes in mean volumes, and displacements are counted from where the
//! body as a whole is ([`crate::frame`]). With ξ a bond at rest, L = |ξ|², and η the difference of
//! its ends' displacements, N = 2ξ·η + |η|² = |y|² − L has no cancellation, and q = λ − 1 is
//! N/(√(L(L + N)) + L): its error is that of rounding η, not that of rounding places.
//!
//! A bond is worked out at both of its ends with the same bits, since only signs differ. So each
//! end keeps what has flowed of the bond as the other end sees it, nothing is looked up in the
//! other end's list, and forces are equal and opposite to the last bit. They are summed up in f64.
//!
//! Inner code has no closures: they are not always inlined where the level's instructions are,
//! which makes it ten times as slow.

mod dashpot;
mod pull;
mod stretch;

use crate::bonds::BondGraph;
use crate::law::PeridynamicLaw;
use cullet_simd::{LaneRows, Lanes, PackedRecord, RecordWindow, WINDOW, gather_records};
use fearless_simd::{Simd, SimdBase, f32x16};

pub(crate) use dashpot::DashpotPass;
pub(crate) use pull::{PullBlock, PullPass};
pub(crate) use stretch::StretchPass;

/// Groups of bonds that are worked on together: while one waits for a result, others do not.
pub(crate) const ABREAST: usize = 4;

/// Share of L² that L|y|² has at least, so that ends in one place make no infinities.
const LEAST_RATIO: f32 = 1e-12;

/// Of a list, the numbers of `N` groups from the one at `first`.
#[inline(always)]
pub(crate) fn lanes<S: Simd, const N: usize>(
    simd: S,
    list: &[Lanes<f32>],
    first: usize,
) -> LaneRows<S, N> {
    let list = &list[first..first + N];
    let mut rows = LaneRows::splat(simd, 0.0);
    for (row, lanes) in rows.0.iter_mut().zip(list) {
        *row = f32x16::from_slice(simd, &lanes.0);
    }
    rows
}

/// `N` groups of a point's bonds as they are now.
pub(crate) struct BondShape<S: Simd, const N: usize> {
    /// y from the point to the other end, over the horizon.
    pub(crate) along: [LaneRows<S, N>; 3],
    /// q \[1\].
    pub(crate) stretch: LaneRows<S, N>,
    /// 1/(l₀|y|), times the horizon squared.
    pub(crate) inverse: LaneRows<S, N>,
    /// The fourth and the eighth number of the other ends' records.
    pub(crate) other: [LaneRows<S, N>; 2],
}

impl<S: Simd, const N: usize> BondShape<S, N> {
    /// Of the groups from the one at `first`.
    #[inline(always)]
    pub(crate) fn of(
        simd: S,
        records: &[PackedRecord],
        own: &PackedRecord,
        bonds: &BondGraph,
        first: usize,
    ) -> Self {
        let (bases, ends) = (&bonds.bases[first..first + N], &bonds.ends[first..first + N]);
        let zero = LaneRows::splat(simd, 0.0);
        let mut fields = [zero; 8];
        for (k, (&base, ends)) in bases.iter().zip(ends).enumerate() {
            let found = gather_records(simd, window(records, base), ends);
            for (field, found) in fields.iter_mut().zip(found) {
                field.0[k] = found;
            }
        }
        let splat = |c: usize| LaneRows::splat(simd, own.0[c]);
        let [x, y, z, fourth, u, v, w, eighth] = fields;
        let rest = [x - splat(0), y - splat(1), z - splat(2)];
        let moved = [u - splat(4), v - splat(5), w - splat(6)];
        let along = [rest[0] + moved[0], rest[1] + moved[1], rest[2] + moved[2]];
        let both = [rest[0] + along[0], rest[1] + along[1], rest[2] + along[2]];
        let square = rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2];
        let grown = both[0] * moved[0] + both[1] * moved[1] + both[2] * moved[2];
        let now = square + grown;
        let least = square * square * LaneRows::splat(simd, LEAST_RATIO);
        let product = (square * now).max(least);
        let root = product.root();
        let inverse = LaneRows::splat(simd, 1.0) / root;
        let stretch = grown / (root + square);
        Self { along, stretch, inverse, other: [fourth, eighth] }
    }
}

/// The records from one on; there are as many as a window holds behind the last point's.
#[inline(always)]
fn window(records: &[PackedRecord], base: u32) -> &RecordWindow {
    let from = base as usize;
    records[from..from + WINDOW].try_into().expect("a window")
}

/// What of a bond's pull goes with a point's mean extension and what with its own, in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PullModuli {
    /// 9K \[Pa\].
    pub(crate) mean: f32,
    /// 15μ \[Pa\].
    pub(crate) deviatoric: f32,
}

impl PullModuli {
    pub(crate) fn of(law: &PeridynamicLaw) -> Self {
        Self { mean: (9.0 * law.bulk) as f32, deviatoric: (15.0 * law.shear) as f32 }
    }
}
