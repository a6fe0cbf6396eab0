//! Records of eight numbers, read from sixteen places at once, and sums over sixteen lanes.

use crate::LANES;
use fearless_simd::{Simd, SimdBase, SimdFloat, f32x8, f32x16};
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers of one element, half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct PackedRecord(pub [f32; 8]);

/// Records from which sixteen are read by numbers of 16 bits: none can lie behind the last, and
/// none has to be checked.
pub type RecordWindow = [PackedRecord; WINDOW];

/// Records of a window.
pub const WINDOW: usize = 1 << 16;

/// The records of sixteen elements of a window, one register for each of the eight numbers.
#[inline(always)]
pub fn gather_records<S: Simd>(
    simd: S,
    records: &RecordWindow,
    ids: &[u16; LANES],
) -> [f32x16<S>; 8] {
    // Without closures, which would not always be inlined where the level's instructions are.
    let r = [
        two(simd, records, [ids[0], ids[1]]),
        two(simd, records, [ids[2], ids[3]]),
        two(simd, records, [ids[4], ids[5]]),
        two(simd, records, [ids[6], ids[7]]),
        two(simd, records, [ids[8], ids[9]]),
        two(simd, records, [ids[10], ids[11]]),
        two(simd, records, [ids[12], ids[13]]),
        two(simd, records, [ids[14], ids[15]]),
    ];
    // Each round parts even numbers from odd ones: eight registers of two records become eight
    // numbers of sixteen.
    let ([a0, a1], [b0, b1]) = (part(r[0], r[1]), part(r[2], r[3]));
    let ([c0, c1], [d0, d1]) = (part(r[4], r[5]), part(r[6], r[7]));
    let ([a04, a26], [b04, b26]) = (part(a0, b0), part(c0, d0));
    let ([a15, a37], [b15, b37]) = (part(a1, b1), part(c1, d1));
    let ([f0, f4], [f2, f6]) = (part(a04, b04), part(a26, b26));
    let ([f1, f5], [f3, f7]) = (part(a15, b15), part(a37, b37));
    [f0, f1, f2, f3, f4, f5, f6, f7]
}

#[inline(always)]
fn two<S: Simd>(simd: S, records: &RecordWindow, ids: [u16; 2]) -> f32x16<S> {
    let one = f32x8::from_slice(simd, &records[ids[0] as usize].0);
    let other = f32x8::from_slice(simd, &records[ids[1] as usize].0);
    simd.combine_f32x8(one, other)
}

/// The even lanes of two registers, and the odd ones.
#[inline(always)]
fn part<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> [f32x16<S>; 2] {
    [a.unzip_low(b), a.unzip_high(b)]
}

/// The sum over all lanes, in an order that does not depend on the width of the registers.
#[inline(always)]
pub fn sum_lanes<S: Simd>(simd: S, lanes: f32x16<S>) -> f32 {
    let (low, high) = simd.split_f32x16(lanes);
    let (low, high) = simd.split_f32x8(low + high);
    let four = low + high;
    (four[0] + four[2]) + (four[1] + four[3])
}

/// `N` registers of sixteen numbers, worked on in turn so that none waits for its last result.
#[derive(Clone, Copy, Debug)]
pub struct LaneRows<S: Simd, const N: usize>(pub [f32x16<S>; N]);

impl<S: Simd, const N: usize> LaneRows<S, N> {
    /// One number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self([f32x16::splat(simd, value); N])
    }

    /// The greater of two numbers.
    #[inline(always)]
    #[must_use]
    pub fn max(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].max(other.0[k]);
        }
        self
    }

    /// √x.
    #[inline(always)]
    #[must_use]
    pub fn root(mut self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k].sqrt();
        }
        self
    }
}

impl<S: Simd, const N: usize> Add for LaneRows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] += other.0[k];
        }
        self
    }
}

impl<S: Simd, const N: usize> Sub for LaneRows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] -= other.0[k];
        }
        self
    }
}

impl<S: Simd, const N: usize> Mul for LaneRows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] *= other.0[k];
        }
        self
    }
}

impl<S: Simd, const N: usize> Div for LaneRows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] /= other.0[k];
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::{PackedRecord, RecordWindow, WINDOW, gather_records, sum_lanes};
    use crate::{LANES, SimdLevel};
    use fearless_simd::{SimdBase, dispatch, f32x16};

    #[test]
    fn records_come_to_their_lanes_on_every_level() {
        let record = |k: usize| PackedRecord(std::array::from_fn(|c| (8 * k + c) as f32));
        let records: Vec<PackedRecord> = (0..WINDOW).map(record).collect();
        let window: &RecordWindow = records.as_slice().try_into().expect("a window");
        let ids: [u16; LANES] = std::array::from_fn(|lane| (lane * lane * 7 % 100) as u16);
        for level in SimdLevel::all() {
            let found = dispatch!(level.level(), simd => {
                gather_records(simd, window, &ids).map(|field| {
                    let mut lanes = [0.0; LANES];
                    field.store_slice(&mut lanes);
                    lanes
                })
            });
            for (c, field) in found.iter().enumerate() {
                for (lane, value) in field.iter().enumerate() {
                    assert_eq!(*value, records[ids[lane] as usize].0[c], "{level}: {c}, {lane}");
                }
            }
        }
    }

    #[test]
    fn sums_have_the_same_bits_on_every_level() {
        for k in 1..100 {
            let x: [f32; LANES] = std::array::from_fn(|lane| 1.0 / (k * LANES + lane) as f32);
            let sum = |level: SimdLevel| {
                let level = level.level();
                dispatch!(level, simd => sum_lanes(simd, f32x16::from_slice(simd, &x)))
            };
            let all: Vec<f32> = SimdLevel::all().into_iter().map(sum).collect();
            assert!(all.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits()), "{all:?}");
            let exact: f64 = x.iter().map(|&x| f64::from(x)).sum();
            assert!((f64::from(all[0]) / exact - 1.0).abs() < 1e-6);
        }
    }
}
