//! A laminated plate: its plies crack as a plain plate does, and the interlayer holds the pieces.

use super::PlateSolve;
use cullet_model::{Failure, Fragmentation, Interlayer};
use cullet_simd::Real;

pub(super) fn finish<R: Real>(
    solve: &mut PlateSolve<R>,
    _interlayer: &Interlayer,
) -> Result<Fragmentation, Failure> {
    solve.finish()
}
