//! What a scene asks of its solves.

use super::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// How true and how dear solves should be: each hit then gets the spacing that this needs, and no
/// finer unless it proves too coarse; a third of a hit's energy must be enough for its smallest
/// section. Without any of these values `fracture.max_particles` decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fidelity {
    /// Relative error of crack area and largest fragment that is good enough \[1\]. Coarser
    /// solves come first, and finer ones while they still differ by more, as far as
    /// `fracture.max_particles` and `budget_s` go; each ends when too little breaks to matter to
    /// it, and is in single precision unless the scene asks for double.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 1))]
    pub error: Option<f64>,
    /// Processor time that all solves of one hit may take, as reckoned for a common machine \[s\];
    /// without it, what `fracture.max_particles` allows.
    #[schemars(schema_with = "unit::time", extend("minimum" = 0.001, "maximum" = 1e6))]
    pub budget_s: Option<f64>,
    /// The smallest fragment wanted: four cells across it \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub smallest: Option<f64>,
    /// What a pixel of the picture covers where the bodies are: nothing finer than a quarter of
    /// two pixels is resolved, and bodies whose halves are smaller get geometric pieces \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub pixel: Option<f64>,
    /// Whether the cone under the contact matters: four cells of the contact's radius.
    pub cone: bool,
    /// Whether cracks have to start at the material's strength, which coarse grids lower (F01): the
    /// spacing that this takes.
    pub strength: bool,
}

impl Fidelity {
    /// Whether the scene asks for anything.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        *self != Self::default()
    }
}
