//! Settings of one hit alone, as they are written.

use super::SolverChoice;
use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// One hit that is solved with settings of its own, which the recording counts as directed. It is
/// the first hit from `at` on that reaches the body and is solved; all other hits are solved as the
/// scene says. `--set hit.NAME.KEY=VALUE` changes the entry of that body, or makes one.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HitEntry {
    /// Name of the rigid body that is hit, or of a fragment as `cullet inspect` shows it: `pot.3`
    /// is fragment 3 of `pot`.
    pub body: String,
    /// Earliest time of the hit \[s\], to half a `world.step`.
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("minimum" = 0, "maximum" = 600))]
    pub at: f64,
    /// Seed of the flaws and of all else that is random in this solve \[1\]. Fragments keep the
    /// flaws that it gives the body.
    #[serde(default)]
    #[schemars(
        range(max = 9_223_372_036_854_775_807_u64),
        extend("x-default" = "`world.seed`, and of a fragment the flaws that it inherited")
    )]
    pub seed: Option<u64>,
    /// Which solver family solves it.
    #[serde(default)]
    #[schemars(extend("x-default" = "as the body or the scene says"))]
    pub solver: Option<SolverChoice>,
    /// Grid spacing of the solve \[m\]. Not beside `particles`.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "as the body or the scene says")
    )]
    pub spacing: Option<f64>,
    /// Approximate number of material points of the solve \[1\]. Not beside `spacing`.
    #[serde(default)]
    #[schemars(
        range(min = 64, max = 50_000_000),
        extend("x-default" = "as the body or the scene says")
    )]
    pub particles: Option<u32>,
}
