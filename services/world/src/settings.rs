//! What a scene decides about its world, with safe defaults.

use crate::error::WorldError;
use cullet_geometry::Vec3;

/// Size classes by volume ratio to the original body \[1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tiers {
    /// Below this a fragment is [`crate::Tier::Tiny`]: unbreakable, one hull of few corners.
    pub tiny: f64,
    /// Below this it is [`crate::Tier::Small`]: unbreakable.
    pub small: f64,
    /// Below this it is [`crate::Tier::Large`]; from here on [`crate::Tier::Whole`].
    pub large: f64,
}

/// How the world moves and what it lets happen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldSettings {
    /// Acceleration of free fall \[m/s²\].
    pub gravity: Vec3,
    /// Time step \[s\].
    pub step: f64,
    /// Least impulse of one contact episode that is reported as a [`crate::Hit`] \[N·s\].
    pub impulse_threshold: f64,
    /// Contacts that close more slowly than this are rest, not hits (F37) \[m/s\].
    pub resting_speed: f64,
    /// Longest contact episode; also how long a pair must wait for its next one (F38) \[s\].
    pub episode: f64,
    /// A fragment younger than this is not hit (F43) \[s\].
    pub birth_grace: f64,
    /// Size classes.
    pub tiers: Tiers,
    /// Bodies in the world at once.
    pub max_bodies: usize,
    /// Fragments of this generation do not break again (F43); the bodies of the scene have
    /// generation 0.
    pub max_generation: u32,
    /// Typical size of a fragment: the engine's tolerances scale with it \[m\].
    pub length_unit: f64,
    /// Solver iterations a step.
    pub iterations: usize,
    /// Damping of slow fragments below [`Tiers::large`], so that heaps come to rest \[1/s\].
    pub debris_damping: f64,
}

impl Default for WorldSettings {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, 0.0, -9.81),
            step: 1.0 / 240.0,
            impulse_threshold: 0.1,
            resting_speed: 0.1,
            episode: 0.02,
            birth_grace: 0.01,
            tiers: Tiers { tiny: 0.01, small: 0.1, large: 0.98 },
            max_bodies: 4000,
            max_generation: 3,
            length_unit: 0.1,
            iterations: 8,
            debris_damping: 0.5,
        }
    }
}

/// Bodies for which the engine's memory and pair search stay bearable on one machine.
const MOST_BODIES: f64 = 1e6;

impl WorldSettings {
    /// Refuses what the engine would silently bend or what would stop the world.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let rows = [
            ("gravity [m/s²]", self.gravity.norm(), 0.0, 1e4),
            ("step [s]", self.step, 1e-6, 0.1),
            ("impulse_threshold [N·s]", self.impulse_threshold, 0.0, f64::MAX),
            ("resting_speed [m/s]", self.resting_speed, 1e-9, 1e3),
            ("episode [s]", self.episode, 1e-6, 10.0),
            ("birth_grace [s]", self.birth_grace, 0.0, 1e3),
            ("tiers.tiny [1]", self.tiers.tiny, 0.0, self.tiers.small),
            ("tiers.small [1]", self.tiers.small, self.tiers.tiny, self.tiers.large),
            ("tiers.large [1]", self.tiers.large, self.tiers.small, 1.0),
            ("max_bodies", self.max_bodies as f64, 1.0, MOST_BODIES),
            ("length_unit [m]", self.length_unit, 1e-4, 1e4),
            ("iterations", self.iterations as f64, 1.0, 256.0),
            ("debris_damping [1/s]", self.debris_damping, 0.0, 1e3),
        ];
        for (what, value, low, high) in rows {
            if !(low..=high).contains(&value) {
                return Err(WorldError::Setting { what, value, low, high });
            }
        }
        Ok(())
    }
}
