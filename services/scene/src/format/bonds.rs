//! What bonds of the family `peridynamics` do, as it is written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// How `peridynamics` solves a material: points and bonds to those around them. It yields as
/// `plasticity` says, and bonds break so that a plane costs `fracture_energy`; its strength comes
/// out of that and the spacing. Other families do not read it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BondNumbers {
    /// Whether bonds break.
    #[schemars(extend("x-default" = "true"))]
    pub breaks: Option<bool>,
    /// How much later bonds break whose points have lost others \[1\]: more makes less dust.
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 10, "x-default" = "0")
    )]
    pub dust: Option<f64>,
    /// D₁, D₂ and D₃ of the plastic strain D₁ + D₂ exp(D₃ η) at which bonds in tension break, η
    /// being the triaxiality \[1\].
    #[schemars(extend("x-default" = "none: flow alone breaks none"))]
    pub failure: Option<[f64; 3]>,
    /// Plastic stretch up to which a point flows \[1\]; it is elastic beyond.
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 1e-4, "maximum" = 0.3, "x-default" = "none")
    )]
    pub max_plastic_stretch: Option<f64>,
    /// An axis along which bonds are stronger or softer.
    #[schemars(extend("x-default" = "none"))]
    pub grain: Option<BondAxis>,
    /// Coefficient of Coulomb friction of parts that touch while they break \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 10, "x-default" = "0.3")
    )]
    pub friction: Option<f64>,
    /// Share of critical damping that bonds give the fastest motion \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "0.1")
    )]
    pub damping: Option<f64>,
    /// Share of its velocity that a point loses to the air in a second \[1/s\].
    #[schemars(
        schema_with = "unit::rate",
        extend("minimum" = 0, "maximum" = 1e6, "x-default" = "0")
    )]
    pub air: Option<f64>,
    /// Reach of bonds over the distance of points, which is half a grid spacing \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 2, "maximum" = 4.1, "x-default" = "3.015")
    )]
    pub horizon: Option<f64>,
}

/// An axis along which bonds are stronger or softer.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondAxis {
    /// The axis in the axes of the shape or mesh \[1\]. Its length does not matter, but is above
    /// 1e-6.
    pub axis: [f64; 3],
    /// Stretch at which bonds along it break over that of those across \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.1, "maximum" = 10))]
    pub strength: f64,
    /// How much softer bonds along it are than those across \[1\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.5, "maximum" = 2, "x-default" = "1, as stiff")
    )]
    pub softness: Option<f64>,
}
