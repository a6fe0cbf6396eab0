//! What is done to glass after it was drawn, as it is written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What was done to glass after it was drawn. A body of treated glass that breaks is a flat plate
/// at most a tenth as thick as it is wide.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum GlassTreatment {
    /// Nothing: it cooled slowly, and no stress is frozen in.
    Annealed,
    /// Its faces are under pressure: it needs a harder hit, and breaks into large pieces.
    HeatStrengthened,
    /// Its faces are under so much pressure that all of it dices once it is cut through.
    Toughened,
    /// Plies on a film that holds the pieces.
    Laminated,
}

/// The film between the plies of laminated glass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct InterlayerFilm {
    /// Thickness of the film \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("minimum" = 1e-5, "maximum" = 0.02, "x-default" = "the preset's, or 0.76 mm")
    )]
    pub thickness: Option<f64>,
    /// Tension at which the film tears \[Pa\].
    #[schemars(
        schema_with = "unit::pressure",
        extend("minimum" = 1e4, "maximum" = 5e8, "x-default" = "the preset's, or 20 MPa")
    )]
    pub strength: Option<f64>,
    /// Length at which the film tears over its first length \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 1.01, "maximum" = 10, "x-default" = "the preset's, or 2")
    )]
    pub stretch: Option<f64>,
}
