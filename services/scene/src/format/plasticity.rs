//! How a metal yields, as it is written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// What yields, most of it metal: at `yield_stress` + `hardening` αⁿ, α being its plastic strain
/// and n `exponent`. It dents and bends where it is hit, and breaks only where it has `failure`.
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
    /// C: how much more it bears at each e-fold of the strain rate over `reference_rate` \[1\].
    /// Only the family `ductile` goes by it.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "0, at any rate alike")
    )]
    pub rate: Option<f64>,
    /// Strain rate up to which it bears what it bears slowly \[1/s\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::rate",
        extend("minimum" = 1e-9, "maximum" = 1e9, "x-default" = "1 1/s")
    )]
    pub reference_rate: Option<f64>,
    /// How it softens as its own flow warms it up; only the family `ductile` goes by it.
    #[serde(default)]
    pub softening: Option<HeatSoftening>,
    /// D₁ to D₅ of the strain at which it tears, (D₁ + D₂ exp(D₃η))(1 + D₄ ln ε̇/ε̇₀)(1 + D₅T*), η
    /// being the mean stress over the equivalent one \[1\]; it then loses its strength over an
    /// opening that costs `fracture_energy`. Only the family `ductile` goes by it. Without it
    /// nothing tears.
    #[serde(default)]
    #[schemars(extend("x-default" = "nothing tears"))]
    pub failure: Option<[f64; 5]>,
}

/// What is warmed up by T − T₀ bears 1 − ((T − T₀)/melting)^exponent of what it bears cold.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatSoftening {
    /// T_m − T₀: how much warmer it is when it melts \[K\].
    #[schemars(
        schema_with = "unit::temperature_difference",
        extend("minimum" = 1, "maximum" = 1e4)
    )]
    pub melting: f64,
    /// m: how soon it softens on the way to melting \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.05, "maximum" = 20))]
    pub exponent: f64,
    /// Heat that a kilogram takes for each kelvin \[J/(kg·K)\].
    #[schemars(schema_with = "unit::heat_capacity", extend("minimum" = 1, "maximum" = 1e6))]
    pub heat_capacity: f64,
    /// Share of the plastic work that becomes heat \[1\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "0.9")
    )]
    pub heat_share: Option<f64>,
}
