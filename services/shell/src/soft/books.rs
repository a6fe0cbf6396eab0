//! The books of a soft shell's run.

use cullet_geometry::Vec3;

/// What came and went since a run began. Works \[J\] are those of the mean of the velocities before
/// and after each kick: exactly what the kinetic energy gains.
#[derive(Clone, Debug, Default)]
pub(super) struct SoftBooks {
    /// Of gravity, grips, air and bodies \[N·s\].
    pub(super) impulse: Vec3,
    /// Sum of the sizes of all of these \[N·s\].
    pub(super) exchanged: f64,
    pub(super) broken: f64,
    pub(super) plastic: f64,
    pub(super) damped: f64,
    pub(super) air: f64,
    pub(super) grips: f64,
    pub(super) gravity: f64,
    pub(super) bodies: f64,
    /// Impulse of each grip \[N·s\].
    pub(super) held: Vec<Vec3>,
    /// Steps taken.
    pub(super) steps: u64,
    /// Points that have broken.
    pub(super) breaks: u64,
    /// Most that a point was stiffer than at the start, where it was pressed together \[1\].
    pub(super) stiffest: f64,
    /// Whether that was more than steps can be made smaller for.
    pub(super) crushed: bool,
}

impl SoftBooks {
    /// Books an impulse from outside.
    #[inline(always)]
    pub(super) fn give(&mut self, impulse: &Vec3) {
        self.impulse += impulse;
        self.exchanged += impulse.norm();
    }
}
