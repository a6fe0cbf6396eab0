//! What a scene must show, and from where it is looked at.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A range that a count must lie in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Bounds {
    /// Least accepted.
    pub min: Option<u64>,
    /// Greatest accepted.
    pub max: Option<u64>,
}

/// A range that a share must lie in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShareBounds {
    /// Least accepted \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub min: Option<f64>,
    /// Greatest accepted \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub max: Option<f64>,
}

/// What the scene must show.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Expect {
    /// Bodies that broke.
    pub fractures: Option<Bounds>,
    /// Fragments made.
    pub fragments: Option<Bounds>,
    /// Bodies at the end.
    pub bodies_final: Option<Bounds>,
    /// Jobs that failed.
    pub failed: Option<Bounds>,
    /// Names of bodies that break; of a generator: at least one of its bodies breaks.
    pub broken: Vec<String>,
    /// Names of bodies that stay whole; of a generator: all of its bodies stay whole.
    pub unbroken: Vec<String>,
    /// Least number of fragments of a body, by its name.
    pub min_fragments_of: BTreeMap<String, u64>,
    /// Greatest relative error of mass \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0))]
    pub mass_rel_error: Option<f64>,
    /// Greatest relative error of momentum over the replacements \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0))]
    pub momentum_rel_error: Option<f64>,
    /// Greatest relative growth of kinetic energy over the replacements \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0))]
    pub energy_gain_rel: Option<f64>,
    /// Fragments whose surface is not closed.
    pub open_fragments: Option<Bounds>,
    /// Share of the fragments at the end that were sampled, that is drawn from a law, and not
    /// solved \[1\].
    pub sampled: Option<ShareBounds>,
    /// The same by mass, with all debris \[1\].
    pub sampled_mass: Option<ShareBounds>,
}

/// Where the preview looks from.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Where the camera is \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub eye: [f64; 3],
    /// What it looks at \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub target: [f64; 3],
    /// Field of view from bottom to top \[rad\].
    #[serde(default = "default_field")]
    #[schemars(schema_with = "unit::angle", extend("minimum" = 0.01, "maximum" = 3))]
    pub field: f64,
    /// When the preview starts; shortly before the first break without it \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("minimum" = 0))]
    pub start: Option<f64>,
    /// When it ends; a while after the last break without it \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
    pub end: Option<f64>,
}

const fn default_field() -> f64 {
    0.7
}
