//! A body that moves as it deforms, as it is written.

use super::sheet::{Air, Coupling, GripPlace, WavePace};
use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// Part of a body, in its own frame: either a box from `low` to `high`, or a ball of `radius`
/// around `centre`. The frame's origin is that of the shape or of the mesh file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyPart {
    /// Least coordinates of a box \[m\].
    #[schemars(schema_with = "unit::length3", extend("x-default" = "none, but required for a box"))]
    pub low: Option<[f64; 3]>,
    /// Greatest coordinates of a box \[m\].
    #[schemars(schema_with = "unit::length3", extend("x-default" = "none, but required for a box"))]
    pub high: Option<[f64; 3]>,
    /// Centre of a ball \[m\].
    #[schemars(
        schema_with = "unit::length3",
        extend("x-default" = "none, but required for a ball")
    )]
    pub centre: Option<[f64; 3]>,
    /// Radius of a ball \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none, but required for a ball")
    )]
    pub radius: Option<f64>,
}

/// Something that holds part of a dynamic body: it stays, or moves at `velocity` or along `path`,
/// and may turn.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SoftGrip {
    /// The part of the body that it holds.
    pub region: BodyPart,
    /// How fast it moves \[m/s\]. Not beside `path`.
    #[serde(default)]
    #[schemars(schema_with = "unit::velocity3", extend("x-default" = "it stays"))]
    pub velocity: Option<[f64; 3]>,
    /// Where it is at rising times; straight lines lie between them, and it stays at the last. Not
    /// beside `velocity`.
    #[serde(default)]
    #[schemars(length(max = 1024), extend("x-default" = "it stays"))]
    pub path: Vec<GripPlace>,
    /// How fast it turns about the middle of its region, in the world's axes \[rad/s\]: until the
    /// last time of `path`, or for good without one.
    #[serde(default)]
    #[schemars(schema_with = "unit::angular_velocity3", extend("x-default" = "it does not turn"))]
    pub turn: Option<[f64; 3]>,
    /// When it lets go \[s\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0, "maximum" = 600, "x-default" = "never")
    )]
    pub until: Option<f64>,
}

/// A body that moves as it deforms for as long as the run lasts: with `solver = "shell"` a soft
/// shell, with `solver = "peridynamics"` a soft solid. It is no rigid body: it takes no hits, but
/// bends, stretches and tears as it is pushed and pulled.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Dynamics {
    /// What holds it.
    #[schemars(length(max = 256))]
    pub grip: Vec<SoftGrip>,
    /// What it is cut along at the start: each a polygon by its corners, in the body's own
    /// frame \[m\].
    #[schemars(schema_with = "unit::polygons3", extend("x-default" = "none"))]
    pub cuts: Vec<Vec<[f64; 3]>>,
    /// Share of critical damping that its fastest motion has \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = "0.1")
    )]
    pub damping: Option<f64>,
    /// The air around it.
    #[schemars(extend("x-default" = "none"))]
    pub air: Option<Air>,
    /// How fast waves run in it.
    pub pace: WavePace,
    /// Steps of the rigid world that are simulated at once \[1\].
    #[schemars(range(min = 1, max = 256), extend("x-default" = "4"))]
    pub window: Option<u32>,
    /// Whether rigid bodies feel it.
    pub coupling: Coupling,
    /// Whether pieces of it that come to rest become rigid bodies of their shape, which deform no
    /// more.
    pub retire: bool,
}
