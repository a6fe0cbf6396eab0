//! What is read of a point from its neighbours.
//!
//! Places are whole numbers of a small unit of length, in 32 bits that wrap around: the difference
//! of two is exact wherever the sheet is, as long as the points are less than thirty horizons
//! apart. f32 places would give a strain that is wrong by their distance from the origin.

use cullet_geometry::Vec3;
use cullet_simd::{LANES, PackedRecord, RecordWindow, WINDOW};
use fearless_simd::{Simd, SimdBase, f32x4, f32x16};

/// Units of length in a horizon: a place is off by half a unit, a strain by 1e-7 at most.
const UNITS: f64 = (1_u64 << 26) as f64;
/// Added to a number below 2⁵¹ it leaves its whole part in the lower bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// A velocity \[m/s\] that is none: products of less would be subnormal in f32, and slow.
const STILL: f64 = 1e-18;
/// The sixteen points of a block.
pub(super) const OWN: [u16; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// A B ∂(½q)/∂κ of a point, for κ_xx, κ_xy and κ_yy; the fourth number of each is nothing.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct MomentRecord(pub(super) [[f32; 4]; 4]);

/// The unit of length \[m\] of places whose bonds are no longer than this.
pub(crate) fn length_unit(horizon: f64) -> f64 {
    horizon / UNITS
}

/// Puts a point's place in units of `1/inverse` \[m\] and its velocity \[m/s\] into its record.
#[inline(always)]
pub(super) fn pack(record: &mut PackedRecord, place: &Vec3, velocity: &Vec3, inverse: f64) {
    for c in 0..3 {
        record.0[c] = f32::from_bits((place[c] * inverse + WHOLE).to_bits() as u32);
        let v = velocity[c];
        record.0[4 + c] = if v.abs() < STILL { 0.0 } else { v as f32 };
    }
}

/// As many records behind the last as a window holds.
pub(super) fn padded<T: Clone + Default>(count: usize) -> Vec<T> {
    vec![T::default(); count + WINDOW]
}

#[inline(always)]
pub(super) fn window(records: &[PackedRecord], base: usize) -> &RecordWindow {
    records[base..base + WINDOW].try_into().expect("a window")
}

/// One of the moments of sixteen points.
#[inline(always)]
pub(super) fn gather_moment<S: Simd>(
    simd: S,
    records: &[MomentRecord; WINDOW],
    ids: &[u16; LANES],
    which: usize,
) -> [f32x16<S>; 3] {
    let r = [
        four(simd, records, [ids[0], ids[1], ids[2], ids[3]], which),
        four(simd, records, [ids[4], ids[5], ids[6], ids[7]], which),
        four(simd, records, [ids[8], ids[9], ids[10], ids[11]], which),
        four(simd, records, [ids[12], ids[13], ids[14], ids[15]], which),
    ];
    let (even, odd) = (r[0].unzip_low(r[1]), r[0].unzip_high(r[1]));
    let (far_even, far_odd) = (r[2].unzip_low(r[3]), r[2].unzip_high(r[3]));
    [even.unzip_low(far_even), odd.unzip_low(far_odd), even.unzip_high(far_even)]
}

#[inline(always)]
fn four<S: Simd>(
    simd: S,
    records: &[MomentRecord; WINDOW],
    ids: [u16; 4],
    which: usize,
) -> f32x16<S> {
    let a = f32x4::from_slice(simd, &records[ids[0] as usize].0[which]);
    let b = f32x4::from_slice(simd, &records[ids[1] as usize].0[which]);
    let c = f32x4::from_slice(simd, &records[ids[2] as usize].0[which]);
    let d = f32x4::from_slice(simd, &records[ids[3] as usize].0[which]);
    simd.combine_f32x8(simd.combine_f32x4(a, b), simd.combine_f32x4(c, d))
}
