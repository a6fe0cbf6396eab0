//! A rotation, as it is written.

use schemars::JsonSchema;
use serde::Deserialize;

/// A rotation, written in one of three ways: `axis` with `degrees`, `euler_degrees`, or
/// `quaternion`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Rotation {
    /// Axis of the rotation by `degrees` \[1\]. Its length does not matter, but is above 1e-6.
    #[schemars(extend("x-default" = "none, but required beside `degrees`"))]
    pub axis: Option<[f64; 3]>,
    /// Angle about `axis`, by the right-hand rule \[°\].
    #[schemars(extend("x-default" = "none, but required beside `axis`"))]
    pub degrees: Option<f64>,
    /// Rotations about the fixed x, then y, then z axis \[°\].
    #[schemars(extend("x-default" = "none"))]
    pub euler_degrees: Option<[f64; 3]>,
    /// Quaternion as (w, x, y, z) \[1\]. Its length does not matter, but is above 1e-6.
    #[schemars(extend("x-default" = "none"))]
    pub quaternion: Option<[f64; 4]>,
}

/// One of the axes of a coordinate system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}
