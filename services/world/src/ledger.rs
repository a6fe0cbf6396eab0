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
    /// Momentum that replacements gave to bodies that nothing moves \[N·s\].
    pub given_to_fixed: Vec3,
    /// Angular momentum about the world's origin that they gave to such bodies \[N·m·s\].
    pub angular_given_to_fixed: Vec3,
    /// Work that bodies on keyframed paths did on the others, by contacts and by joints \[J\].
    pub driven_work: f64,
    /// Work of the accelerations that [`crate::World::accelerate`] gave \[J\].
    pub field_work: f64,
    /// Momentum that they gave \[N·s\].
    pub field_impulse: Vec3,
    /// Mass that was taken out of the world \[kg\].
    pub removed_mass: f64,
    /// Momentum that it had \[N·s\].
    pub removed_momentum: Vec3,
    /// Kinetic and potential energy that it had \[J\].
    pub removed_energy: f64,
    /// Momentum of bodies when they fell asleep, which stops them \[N·s\].
    pub slept_momentum: Vec3,
    /// Kinetic energy that they had then \[J\].
    pub slept_energy: f64,
}

/// What came in and went out beside contacts between bodies that move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flows {
    pub(crate) driven_work: f64,
    pub(crate) field_work: f64,
    pub(crate) field_impulse: Vec3,
    pub(crate) removed_mass: f64,
    pub(crate) removed_momentum: Vec3,
    pub(crate) removed_energy: f64,
    pub(crate) slept_momentum: Vec3,
    pub(crate) slept_energy: f64,
}

impl Default for Flows {
    fn default() -> Self {
        Self {
            driven_work: 0.0,
            field_work: 0.0,
            field_impulse: Vec3::zeros(),
            removed_mass: 0.0,
            removed_momentum: Vec3::zeros(),
            removed_energy: 0.0,
            slept_momentum: Vec3::zeros(),
            slept_energy: 0.0,
        }
    }
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
