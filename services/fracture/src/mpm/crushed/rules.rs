//! What the division of a crushed zone needs to know, and its measures.

use cullet_geometry::Vec3;
use cullet_model::{BrittleProblem, Material, Tolerance};

/// Points by weight that make a node part of the body ...
pub(super) const LEAST_WEIGHT: f64 = 2.0;

/// ... and those of a full one.
pub(super) const FULL_WEIGHT: f64 = 8.0;

/// Points by weight that a sampled piece's middle needs around it: none is put outside the body.
pub(super) const MIDDLE_WEIGHT: f64 = 4.0;

/// Half the width of a crack's band, in cells; a broken node beyond belongs to a crushed zone.
pub(super) const HALF_BAND: f64 = 2.1;

/// Least size of a sampled piece, likewise: what the cut's lattice can still give a shape.
pub(super) const LEAST_SIZE: f64 = 0.7;

/// Stream of the seed's numbers.
pub(super) const STREAM: u64 = 0xf1e5;

/// What the division needs to know of a material and a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrushRules {
    /// Size of a cell along each axis \[m\].
    pub spacing: Vec3,
    /// What it is made of.
    pub material: Material,
    /// The only source of randomness.
    pub seed: u64,
    /// How true the pieces have to be.
    pub tolerance: Tolerance,
    /// Pieces that are wanted at most.
    pub most: u32,
    /// Unit vector along the push; zero where there is none.
    pub push: Vec3,
}

impl CrushRules {
    /// Of a problem on cells of `spacing` \[m\].
    #[must_use]
    pub fn of(problem: &BrittleProblem, spacing: Vec3) -> Self {
        let push: Vec3 = problem.impacts.iter().map(|hit| hit.normal * hit.impulse).sum();
        Self {
            spacing,
            material: problem.material,
            seed: problem.seed,
            tolerance: problem.settings.tolerance(),
            most: problem.settings.max_fragments,
            push: push.try_normalize(0.0).unwrap_or_default(),
        }
    }
}
