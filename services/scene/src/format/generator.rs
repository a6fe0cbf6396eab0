//! Many bodies from one template: grids, stacks and scatters.

use super::Body;
use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// Equal bodies in rows, columns and layers, named `name-i-j-k` from 0 on. All lie within 100000 m
/// of the world's origin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// First part of the names of its bodies: 1 to 80 bytes, without a slash, and unique in the
    /// scene.
    pub name: String,
    /// Number of bodies along x, y and z \[1\], each at least 1. The scene has at most
    /// `world.max_bodies` bodies.
    pub count: [u32; 3],
    /// Distance from one body to the next along x, y and z \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub spacing: [f64; 3],
    /// Every second layer is shifted along x by this share of the spacing \[1\]; 0.5 is a brick
    /// bond.
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub bond: f64,
    /// Template of the bodies; its `position` is that of the first one.
    pub body: Body,
}

/// Equal bodies on top of one another, named `name-i` from 0 on. All lie within 100000 m of the
/// world's origin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stack {
    /// First part of the names of its bodies: 1 to 80 bytes, without a slash, and unique in the
    /// scene.
    pub name: String,
    /// Number of bodies \[1\]. The scene has at most `world.max_bodies` bodies.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u32,
    /// Distance from one body to the next along x, y and z \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub offset: [f64; 3],
    /// Angle about z by which each body is rotated against the one before \[°\].
    #[serde(default)]
    pub twist_degrees: f64,
    /// Template of the bodies; its `position` is that of the first one.
    pub body: Body,
}

/// Equal bodies at random places in a box, named `name-i` from 0 on. The spheres around them lie in
/// the box and do not overlap; a scene whose box is too full is refused.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// First part of the names of its bodies: 1 to 80 bytes, without a slash, and unique in the
    /// scene.
    pub name: String,
    /// Number of bodies \[1\]. The scene has at most `world.max_bodies` bodies.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u32,
    /// Lowest corner of the box that holds the bodies \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub min: [f64; 3],
    /// Highest corner of the box \[m\]. Along each axis the box is at least as wide as the sphere
    /// around a body.
    #[schemars(schema_with = "unit::length3")]
    pub max: [f64; 3],
    /// Least distance between the spheres around the bodies \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
    pub gap: f64,
    /// Whether each body has a random rotation.
    #[serde(default)]
    pub turn: bool,
    /// Seed of the places and rotations \[1\].
    #[serde(default)]
    #[schemars(extend("x-default" = "`world.seed`"))]
    pub seed: Option<u64>,
    /// Template of the bodies; it has no `position`.
    pub body: Body,
}
