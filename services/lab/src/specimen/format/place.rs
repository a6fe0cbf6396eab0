//! Parts of a specimen, as they are written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// A side of the box around the specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[schemars(rename = "Side")]
pub enum BoxSide {
    /// Least x.
    #[serde(rename = "-x")]
    LowX,
    /// Greatest x.
    #[serde(rename = "+x")]
    HighX,
    /// Least y.
    #[serde(rename = "-y")]
    LowY,
    /// Greatest y.
    #[serde(rename = "+y")]
    HighY,
    /// Least z.
    #[serde(rename = "-z")]
    LowZ,
    /// Greatest z.
    #[serde(rename = "+z")]
    HighZ,
}

impl BoxSide {
    /// Every side with its name.
    pub const ALL: [(&'static str, Self); 6] = [
        ("-x", Self::LowX),
        ("+x", Self::HighX),
        ("-y", Self::LowY),
        ("+y", Self::HighY),
        ("-z", Self::LowZ),
        ("+z", Self::HighZ),
    ];

    /// Its axis, and whether it is the upper one.
    #[must_use]
    pub const fn axis(self) -> (usize, bool) {
        match self {
            Self::LowX => (0, false),
            Self::HighX => (0, true),
            Self::LowY => (1, false),
            Self::HighY => (1, true),
            Self::LowZ => (2, false),
            Self::HighZ => (2, true),
        }
    }
}

/// A part of space in the specimen's frame.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Part")]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum RegionPart {
    /// A box along the axes.
    Box {
        /// Lowest corner \[m\].
        #[schemars(schema_with = "unit::length3")]
        min: [f64; 3],
        /// Highest corner \[m\].
        #[schemars(schema_with = "unit::length3")]
        max: [f64; 3],
    },
    /// A ball.
    Ball {
        /// Centre \[m\].
        #[schemars(schema_with = "unit::length3")]
        centre: [f64; 3],
        /// Radius \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
    },
    /// All that lies against the normal of a plane.
    HalfSpace {
        /// A point of the plane \[m\].
        #[schemars(schema_with = "unit::length3")]
        point: [f64; 3],
        /// Normal of the plane, out of the half-space; need not have length 1.
        normal: [f64; 3],
    },
    /// A cylinder.
    Cylinder {
        /// Middle of one end \[m\].
        #[schemars(schema_with = "unit::length3")]
        from: [f64; 3],
        /// Middle of the other \[m\].
        #[schemars(schema_with = "unit::length3")]
        to: [f64; 3],
        /// Radius \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
    },
    /// What lies under a side of the box around the specimen.
    Face {
        /// Which side.
        side: BoxSide,
        /// How deep \[m\].
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        depth: f64,
    },
}

/// A part of the specimen with a name.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Region")]
#[serde(deny_unknown_fields)]
pub struct RegionConfig {
    /// What others call it.
    pub name: String,
    /// The points in all of these.
    #[schemars(length(min = 1, max = 16))]
    pub parts: Vec<RegionPart>,
}
