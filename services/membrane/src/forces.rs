//! What forces on points depend on, and what is booked of a step.

use crate::bonds::MembraneBonds;
use crate::lips::LipPairs;
use crate::table::BondTable;
use cullet_geometry::Vec3;
use cullet_model::{MembraneLaw, SheetAir};

/// What forces depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceInput<'a> {
    pub(crate) law: MembraneLaw,
    pub(crate) bonds: &'a MembraneBonds,
    pub(crate) table: &'a BondTable,
    pub(crate) lips: &'a LipPairs,
    pub(crate) places: &'a [Vec3],
    pub(crate) velocities: &'a [Vec3],
    /// Mass that weighs, and inertia \[kg\].
    pub(crate) masses: &'a [[f64; 2]],
    pub(crate) areas: &'a [f64],
    /// B \[J\] and ν \[1\]; no bending where B is 0.
    pub(crate) bending: [f64; 2],
    /// Λ \[N/m\].
    pub(crate) dilatation: f64,
    /// Of a bond: c = `damping` k/ξ² \[s\].
    pub(crate) damping: f64,
    pub(crate) gravity: Vec3,
    /// The air, where it acts, and its wind now.
    pub(crate) air: Option<(&'a SheetAir, Vec3)>,
    /// Forces of rigid bodies \[N\].
    pub(crate) touch: &'a [Vec3],
    /// Grip of each point.
    pub(crate) holders: &'a [u32],
    /// Points that are not simulated.
    pub(crate) frozen: &'a [bool],
    /// Whether its bonds may not break.
    pub(crate) guarded: &'a [bool],
    /// Velocity of each grip after the step \[m/s\].
    pub(crate) led: &'a [Vec3],
    pub(crate) dt: f64,
}

/// What a step did, in sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StepSums {
    pub(crate) broken: f64,
    pub(crate) plastic: f64,
    pub(crate) damped: f64,
    pub(crate) air: f64,
    pub(crate) grips: f64,
    pub(crate) gravity: f64,
    pub(crate) bodies: f64,
    /// Impulses from outside \[N·s\].
    pub(crate) impulse: Vec3,
    /// Sum of the sizes of all changes of momentum \[N·s\].
    pub(crate) exchanged: f64,
    /// Bonds broken, each counted at both ends.
    pub(crate) breaks: u32,
}

impl StepSums {
    pub(crate) fn plus(mut self, other: Self) -> Self {
        self.broken += other.broken;
        self.plastic += other.plastic;
        self.damped += other.damped;
        self.air += other.air;
        self.grips += other.grips;
        self.gravity += other.gravity;
        self.bodies += other.bodies;
        self.impulse += other.impulse;
        self.exchanged += other.exchanged;
        self.breaks += other.breaks;
        self
    }
}
