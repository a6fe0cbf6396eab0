//! Many bodies from one template: grids, stacks, scatters and instances.

use super::{Body, Rotation};
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

/// Equal bodies at places that are given one by one, named `name-i` from 0 on or by the names of
/// the places. Either `places` or `file`. All lie within 100000 m of the world's origin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Instances {
    /// First part of the names of its bodies: 1 to 80 bytes, without a slash, and unique in the
    /// scene.
    pub name: String,
    /// The places: at most 100000. The scene has at most `world.max_bodies` bodies.
    #[serde(default)]
    #[schemars(
        length(max = 100_000),
        extend("x-default" = "required without `file`")
    )]
    pub places: Vec<GivenPlace>,
    /// Table of the places (.csv): a line for each, at most 100000, below a head that names the
    /// columns. The path is relative to the scene file. Columns are `x`, `y` and `z` in metres;
    /// `qw`, `qx`, `qy` and `qz` for a quaternion, or `rx`, `ry` and `rz` for angles in degrees as
    /// in `euler_degrees`; and `name`. Bodies of rows without a name are numbered as rows are, from
    /// 0 on. Lines of remarks begin with `#` and stand above the head alone; empty lines are passed
    /// over.
    #[serde(default)]
    #[schemars(extend("x-default" = "required without `places`"))]
    pub file: Option<String>,
    /// Template of the bodies; it has no `position`, and its `rotation` comes before that of a
    /// place.
    pub body: Body,
}

/// A place of a body.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenPlace {
    /// Where the anchor of the body is \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// Rotation of the body about its anchor.
    #[serde(default)]
    #[schemars(extend("x-default" = "that of the template"))]
    pub rotation: Rotation,
    /// Second part of the body's name, in place of its number: without a slash, and unique in the
    /// list. Both parts and the hyphen have at most 80 bytes.
    #[serde(default)]
    #[schemars(extend("x-default" = "its number"))]
    pub name: Option<String>,
}
