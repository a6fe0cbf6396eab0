//! The sums that physics keeps.

use cullet_geometry::Vec3;

/// Sums over the moving bodies of a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// \[kg\]
    pub mass: f64,
    /// Momentum \[N·s\].
    pub momentum: Vec3,
    /// Angular momentum about the world's origin \[N·m·s\].
    pub angular_momentum: Vec3,
    /// Kinetic energy \[J\].
    pub kinetic_energy: f64,
    /// Potential energy in the world's gravity, zero at its origin \[J\].
    pub potential_energy: f64,
    /// Momentum that replacements gave to fixed bodies \[N·s\].
    pub given_to_fixed: Vec3,
    /// Angular momentum about the world's origin that they gave to fixed bodies \[N·m·s\].
    pub angular_given_to_fixed: Vec3,
}

/// What fixed bodies swallowed in replacements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sink {
    pub(crate) linear: Vec3,
    pub(crate) angular: Vec3,
}

impl Default for Sink {
    fn default() -> Self {
        Self { linear: Vec3::zeros(), angular: Vec3::zeros() }
    }
}
