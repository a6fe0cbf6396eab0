//! What came and went over steps.

use cullet_geometry::Vec3;

/// What came and went, in sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SolidSums {
    pub(super) broken: f64,
    pub(super) plastic: f64,
    pub(super) damped: f64,
    pub(super) air: f64,
    pub(super) grips: f64,
    pub(super) gravity: f64,
    pub(super) bodies: f64,
    /// Impulses from outside \[N·s\].
    pub(super) impulse: Vec3,
    /// Sum of the sizes of all changes of momentum \[N·s\].
    pub(super) exchanged: f64,
}

impl SolidSums {
    pub(super) fn plus(mut self, other: Self) -> Self {
        self.broken += other.broken;
        self.plastic += other.plastic;
        self.damped += other.damped;
        self.air += other.air;
        self.grips += other.grips;
        self.gravity += other.gravity;
        self.bodies += other.bodies;
        self.impulse += other.impulse;
        self.exchanged += other.exchanged;
        self
    }
}
