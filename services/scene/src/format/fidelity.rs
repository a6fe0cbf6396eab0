//! What a scene asks of its solves.

use super::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// How accurate fracture solves must be, and what they may cost. Each hit gets the grid spacing
/// that the keys given here need. Without any of them `fracture.max_particles` sets the spacing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fidelity {
    /// Accepted relative error of the crack area and of the largest fragment \[1\]. Each hit is
    /// solved on a coarse grid first, then on finer ones while two results differ by more, as far
    /// as `fracture.max_particles` and `budget_s` allow. A solve ends early when what still breaks
    /// cannot change the result by more.
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.01, "maximum" = 1, "x-default" = "none")
    )]
    pub error: Option<f64>,
    /// Most processor time for all solves of one hit \[s\], estimated for a common machine so that
    /// the result is the same on every machine.
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0.001, "maximum" = 1e6, "x-default" = "no limit")
    )]
    pub budget_s: Option<f64>,
    /// Size of the smallest fragment that the grid must resolve, with four cells across it \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none")
    )]
    pub smallest: Option<f64>,
    /// Length that one pixel of the picture covers at the bodies \[m\]. Grids are no finer than a
    /// quarter of two pixels; bodies whose halves would be smaller than two pixels are broken by
    /// `geometric`.
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none")
    )]
    pub pixel: Option<f64>,
    /// Whether the cone crack under the contact matters: then the contact radius has four cells.
    pub cone: bool,
    /// Whether cracks must start at the material's strength, which a coarse grid lowers (F01): then
    /// the grid is fine enough for that.
    pub strength: bool,
}

impl Fidelity {
    /// Whether the scene asks for anything.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        *self != Self::default()
    }
}
