//! What a run of a scene must show, and from where its pictures are taken.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The range in which a count must lie; `min` is at most `max`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Bounds {
    /// Least accepted count \[1\].
    #[schemars(extend("x-default" = "no bound"))]
    pub min: Option<u64>,
    /// Greatest accepted count \[1\].
    #[schemars(extend("x-default" = "no bound"))]
    pub max: Option<u64>,
}

/// The range in which a share must lie; `min` is at most `max`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShareBounds {
    /// Least accepted share \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "no bound")
    )]
    pub min: Option<f64>,
    /// Greatest accepted share \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "no bound")
    )]
    pub max: Option<f64>,
}

/// What a run of the scene must show. A run that does not meet an expectation reports it and ends
/// with exit code 3.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Expect {
    /// Number of bodies that broke \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub fractures: Option<Bounds>,
    /// Number of fragments that were made \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub fragments: Option<Bounds>,
    /// Number of bodies at the end, fragments included \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub bodies_final: Option<Bounds>,
    /// Number of fracture jobs that failed \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub failed: Option<Bounds>,
    /// Names of bodies that must break. The name of a grid, stack, scatter or instances means at
    /// least one of its bodies.
    pub broken: Vec<String>,
    /// Names of bodies that must stay whole. The name of a grid, stack, scatter or instances means
    /// all of its bodies.
    pub unbroken: Vec<String>,
    /// Least number of fragments of a body, or of all bodies of a grid, stack, scatter or
    /// instances, by its name \[1\].
    pub min_fragments_of: BTreeMap<String, u64>,
    /// Greatest accepted relative error of the mass of fragments \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "x-default" = "not checked")
    )]
    pub mass_rel_error: Option<f64>,
    /// Greatest accepted relative error of momentum when fragments replace a body \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "x-default" = "not checked")
    )]
    pub momentum_rel_error: Option<f64>,
    /// Greatest accepted relative growth of kinetic energy when fragments replace a body \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "x-default" = "not checked")
    )]
    pub energy_gain_rel: Option<f64>,
    /// Number of fragments whose surface is not closed \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub open_fragments: Option<Bounds>,
    /// Number of parts that sheets and dynamic bodies have come to at the end, all together \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub sheet_pieces: Option<Bounds>,
    /// Number of joints that broke, those of glue counted \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub joints_broken: Option<Bounds>,
    /// Share, by number, of the fragments at the end that were sampled from a size law and not
    /// solved \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub sampled: Option<ShareBounds>,
    /// Share, by mass, of the fragments and the debris at the end that was sampled from a size law
    /// and not solved \[1\].
    #[schemars(extend("x-default" = "not checked"))]
    pub sampled_mass: Option<ShareBounds>,
}

/// What the recording of a run holds beside what decides the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingSettings {
    /// Whether the recording has each object as viewers of MCAP files draw it, on `/scene/NAME`:
    /// most of its bytes in many scenes. Cullet itself does not read them, and the digest of the
    /// run does not depend on them.
    pub drawings: bool,
}

impl Default for RecordingSettings {
    fn default() -> Self {
        Self { drawings: true }
    }
}

/// The camera and the time window of the preview pictures.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Position of the camera \[m\]; not equal to `target`.
    #[schemars(schema_with = "unit::length3")]
    pub eye: [f64; 3],
    /// Point at which the camera looks \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub target: [f64; 3],
    /// Field of view of the camera from bottom to top \[rad\].
    #[serde(default = "default_field")]
    #[schemars(schema_with = "unit::angle", extend("minimum" = 0.01, "maximum" = 3))]
    pub field: f64,
    /// Simulated time at which the preview starts \[s\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0, "x-default" = "shortly before the first break")
    )]
    pub start: Option<f64>,
    /// Simulated time at which the preview ends \[s\]; after `start`.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::time",
        extend("exclusiveMinimum" = 0, "x-default" = "some time after the last break")
    )]
    pub end: Option<f64>,
}

const fn default_field() -> f64 {
    0.7
}
