//! Sums over the bonds of sixteen points, one in each lane.

use cullet_simd::{LANES, Lanes};
use fearless_simd::{Simd, SimdBase, f32x16, f64x8};

/// What the bonds of a block's points do.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct BlockForces {
    /// All that acts along bonds \[N\].
    pub(crate) pulled: [[f64; LANES]; 3],
    /// Of bending, in the unit of [`WorkingRows`](super::working::WorkingRows).
    pub(crate) bent: [[f64; LANES]; 3],
    /// Of what acts along bonds, that of dashpots \[N\].
    pub(crate) damper: [Lanes<f32>; 3],
    /// ∂x/∂X × ∂x/∂Y where there is air \[1\].
    pub(crate) area: [Lanes<f32>; 3],
}

impl Default for BlockForces {
    fn default() -> Self {
        let zero = [Lanes([0.0; LANES]); 3];
        let none = [[0.0; LANES]; 3];
        Self { pulled: none, bent: none, damper: zero, area: zero }
    }
}

/// A vector of each lane in f64: forces at both ends of a bond are opposite to the last bit, and
/// must be so when they are summed up. Sums of whole numbers would cost a third, and have a range.
#[derive(Clone, Copy)]
pub(super) struct WideSum<S: Simd>([[f64x8<S>; 2]; 3]);

impl<S: Simd> WideSum<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self([[f64x8::splat(simd, 0.0); 2]; 3])
    }

    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, c: usize, more: f32x16<S>) {
        let (low, high) = simd.widen_f32x16(more);
        self.0[c][0] += low;
        self.0[c][1] += high;
    }

    #[inline(always)]
    pub(super) fn store(self, to: &mut [[f64; LANES]; 3]) {
        for ([low, high], to) in self.0.iter().zip(to) {
            low.store_slice(&mut to[..8]);
            high.store_slice(&mut to[8..]);
        }
    }
}

/// The register of a row of a list.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, lanes: &Lanes<f32>) -> f32x16<S> {
    f32x16::from_slice(simd, &lanes.0)
}
