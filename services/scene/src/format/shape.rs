//! Shapes given by their dimensions.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// A shape given by its dimensions; z points up. `kind` names it. The longest side of a body is
/// from 0.0001 m to 10000 m.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// A box. Its origin is its centre.
    Box {
        /// Edge lengths along x, y and z \[m\].
        #[schemars(schema_with = "unit::size3")]
        size: [f64; 3],
    },
    /// A ball. Its origin is its centre.
    Sphere {
        /// Radius of the ball \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Number of corners around the equator \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 8, max = 256))]
        segments: u32,
    },
    /// A cylinder about z. Its origin is its centre.
    Cylinder {
        /// Radius of the cylinder \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Height along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        height: f64,
        /// Number of corners around it \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
    /// A cone about z, pointed or truncated. Its origin is the middle of its axis.
    Cone {
        /// Radius of the base \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Radius of the top \[m\]; 0 makes a tip.
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        top_radius: f64,
        /// Height along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        height: f64,
        /// Number of corners around it \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
    /// A ring about z. Its origin is its centre.
    Torus {
        /// Radius from the centre to the middle of the tube \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        ring_radius: f64,
        /// Radius of the tube \[m\]; below `ring_radius`.
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        tube_radius: f64,
        /// Number of corners around the ring \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 8, max = 256))]
        segments: u32,
    },
    /// A cylinder about z with half balls as ends. Its origin is its centre.
    Capsule {
        /// Radius of the cylinder and of its ends \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Length of the cylinder between the half balls \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        length: f64,
        /// Number of corners around it \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 8, max = 256))]
        segments: u32,
    },
    /// A polygon in x and y, extruded along z. Its origin is the polygon's own, at half its height.
    Extrusion {
        /// Corners as (x, y), in order, either way round \[m\]: at least three that differ. Edges
        /// must not cross or touch.
        #[schemars(schema_with = "unit::points2")]
        polygon: Vec<[f64; 2]>,
        /// Height along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        height: f64,
    },
    /// A profile turned about z: a solid, or a vessel with a wall. Its origin is the profile's own.
    Lathe {
        /// Outline from bottom to top as (radius, height) \[m\]. Radii are not negative; only the
        /// first and the last point may lie on the axis. The outline must not cross itself.
        #[schemars(schema_with = "unit::points2")]
        profile: Vec<[f64; 2]>,
        /// Thickness of the wall and the floor of an open vessel \[m\]. The wall must fit inside
        /// the profile.
        #[serde(default)]
        #[schemars(
            schema_with = "unit::length",
            extend("exclusiveMinimum" = 0, "x-default" = "a solid body")
        )]
        wall: Option<f64>,
        /// Number of corners around it \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
    /// A flat sheet in x and y. Its origin is the outline's own, at half its thickness.
    Sheet {
        /// Corners of its outline as (x, y), in order, either way round \[m\]: at least three that
        /// differ. Edges must not cross or touch.
        #[schemars(schema_with = "unit::points2")]
        outline: Vec<[f64; 2]>,
        /// Thickness along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        thickness: f64,
    },
    /// A thin wall about a line that is turned about z: a bottle, a bowl, a bulb. A line with both
    /// ends on the axis makes a closed one with a cavity. Its origin is the line's own.
    Shell {
        /// The middle of the wall from bottom to top as (radius, height) \[m\]. Radii are not
        /// negative; only the first and the last point may lie on the axis. The line must not cross
        /// itself, and must leave room for half the thickness on either side.
        #[schemars(schema_with = "unit::points2")]
        profile: Vec<[f64; 2]>,
        /// Thickness of the wall \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        thickness: f64,
        /// Number of corners around it \[1\].
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
}

const fn default_segments() -> u32 {
    32
}
