//! What a task of the kernel changes.

use super::block::BlockForces;
use super::records::MomentRecord;
use super::working::LaneMemory;
use cullet_geometry::Vec3;
use cullet_simd::Lanes;

/// What a step changes, of some blocks of points and their bonds.
pub(super) struct TaskRows<'a> {
    pub(super) remembered: RememberedRows<'a>,
    pub(super) pull: &'a mut [Lanes<f32>],
    pub(super) bounds: &'a mut [[f32; 2]],
    pub(super) forces: &'a mut [BlockForces],
    pub(super) moments: &'a mut [MomentRecord],
    /// 2ΛAθ/Σk by point \[1\].
    pub(super) dilations: &'a mut [f32],
    pub(super) after: &'a mut [Vec3],
    pub(super) held: &'a mut [Vec3],
}

/// Of it, what changes where bonds soften, flow or break.
pub(super) struct RememberedRows<'a> {
    /// Number of the first block, of its first row, and of the first bond of its points.
    pub(super) first: usize,
    pub(super) first_row: usize,
    pub(super) first_bond: usize,
    pub(super) damage: &'a mut [f64],
    pub(super) plastic: &'a mut [f64],
    pub(super) flowed: &'a mut [f64],
    pub(super) memory: &'a mut [LaneMemory],
    /// What the dilatation has lost in the step, by point \[J\].
    pub(super) lost: &'a mut [f64],
    pub(super) torn: &'a mut [bool],
}
