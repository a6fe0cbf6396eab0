//! Numbers of either precision, sixteen side by side.

use fearless_simd::{Simd, SimdBase, SimdFloatElement};

/// Elements side by side; a multiple of the lanes of every register.
pub const LANES: usize = 16;

/// Numbers that a kernel can be worked out in.
pub trait Real: SimdFloatElement + Send + Sync {
    /// A strain that is none: added to every component, so that products of the faint strains ahead
    /// of a wave do not become subnormal, which costs a hundred times as much.
    const FAINT: Self;

    /// The nearest number to `x`.
    fn of(x: f64) -> Self;

    /// Without rounding.
    fn wide(self) -> f64;
}

impl Real for f32 {
    const FAINT: Self = 1e-12;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x as Self
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    const FAINT: Self = 1e-100;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

/// A register of the path `S`.
pub type V<S, R> = <R as SimdFloatElement>::Native<S>;

/// One number for each of the elements; aligned, since a load across cache lines costs two.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Lanes<R>(pub [R; LANES]);

/// The register that begins at `lane`.
#[inline(always)]
pub fn load<S: Simd, R: Real>(simd: S, from: &Lanes<R>, lane: usize) -> V<S, R> {
    V::<S, R>::from_slice(simd, &from.0[lane..lane + V::<S, R>::LEN])
}

/// Writes the register that begins at `lane`.
#[inline(always)]
pub fn store<S: Simd, R: Real>(_: S, value: V<S, R>, to: &mut Lanes<R>, lane: usize) {
    value.store_slice(&mut to.0[lane..lane + V::<S, R>::LEN]);
}
