//! What a body looks like inside, as it is written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// What a body looks like inside: the crack faces of its fragments, in pictures, viewers and
/// exported files. It changes nothing of the run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interior {
    /// Colour of crack faces on a screen (sRGB): red, green and blue, each from 0 to 1 \[1\].
    #[schemars(schema_with = "unit::colour")]
    pub colour: [f64; 3],
    /// Roughness of crack faces as renderers take it: 0 for a mirror, 1 for chalk \[1\]. Only
    /// exported files have it.
    #[serde(default = "rough")]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub roughness: f64,
}

const fn rough() -> f64 {
    0.9
}
