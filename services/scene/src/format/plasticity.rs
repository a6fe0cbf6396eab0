//! How a metal yields, as it is written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// What yields, most of it metal: at `yield_stress` + `hardening` αⁿ, α being its plastic strain
/// and n `exponent`. It dents and bends where it is hit, and does not break.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plasticity {
    /// Stress at which it yields first \[Pa\].
    #[schemars(schema_with = "unit::pressure", extend("minimum" = 1e3, "maximum" = 1e10))]
    pub yield_stress: f64,
    /// How much more it bears at a plastic strain of 1 \[Pa\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend("minimum" = 0, "maximum" = 1e11, "x-default" = "0, it does not harden")
    )]
    pub hardening: Option<f64>,
    /// How the strain goes into that \[1\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.05, "maximum" = 1, "x-default" = "1, in proportion")
    )]
    pub exponent: Option<f64>,
}
