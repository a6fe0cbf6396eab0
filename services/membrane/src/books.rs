//! The books of a sheet's run.

use crate::forces::StepSums;
use cullet_geometry::Vec3;

/// What came and went since a run began.
#[derive(Clone, Debug, Default)]
pub(crate) struct SheetBooks {
    pub(crate) sums: StepSums,
    /// Energy that changed stiffness and mass gave \[J\].
    pub(crate) quantity_work: f64,
    /// ΣρChAθ of each quantity that came from outside.
    pub(crate) quantities_in: Vec<f64>,
    /// Impulse of each grip \[N·s\].
    pub(crate) grips: Vec<Vec3>,
    /// Steps taken.
    pub(crate) steps: u64,
}
