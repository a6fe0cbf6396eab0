//! Materials, and how strength varies within a body, as they are written.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// A material: all its values, or a preset and what differs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// What bodies call it.
    pub name: String,
    /// The preset that gives what is not said here.
    #[serde(default)]
    pub preset: Option<String>,
    /// Mass density \[kg/m³\].
    #[serde(default)]
    #[schemars(schema_with = "unit::density", extend("minimum" = 0.01, "maximum" = 30000))]
    pub density: Option<f64>,
    /// Young's modulus E \[Pa\].
    #[serde(default)]
    #[schemars(schema_with = "unit::pressure", extend("minimum" = 1e3, "maximum" = 2e12))]
    pub young: Option<f64>,
    /// Poisson's ratio ν \[1\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = -0.99, "maximum" = 0.4999)
    )]
    pub poisson: Option<f64>,
    /// Tensile strength σ_f \[Pa\].
    #[serde(default)]
    #[schemars(schema_with = "unit::pressure", extend("exclusiveMinimum" = 0, "maximum" = 1e11))]
    pub strength: Option<f64>,
    /// Fracture energy G_f \[J/m²\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::energy_per_area",
        extend("exclusiveMinimum" = 0, "maximum" = 1e7)
    )]
    pub fracture_energy: Option<f64>,
    /// Weibull modulus of the flaws: 5 scatters widely, 30 hardly \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 1, "maximum" = 1000))]
    pub weibull: Option<f64>,
    /// Distance over which flaws are alike: at least four grid spacings, and that without it
    /// \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub correlation: Option<f64>,
    /// Planes along which it splits.
    #[serde(default)]
    pub weak_plane: Option<WeakPlane>,
    /// Layers of two strengths.
    #[serde(default)]
    pub layers: Option<Layers>,
    /// Speed after over speed before a bounce \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub restitution: Option<f64>,
    /// Coulomb friction \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 10))]
    pub friction: Option<f64>,
    /// Whether bodies of it break unless they say otherwise.
    #[serde(default)]
    pub breakable: Option<bool>,
}

/// Across planes of one direction the material is weaker: slate, wood, mica.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeakPlane {
    /// Normal of the planes in the body's own frame; need not have length 1.
    pub normal: [f64; 3],
    /// Strength across them over the material's \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 1))]
    pub ratio: f64,
}

/// Layers that are in turn as strong as the material and `ratio` of it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Normal of the layers in the body's own frame; need not have length 1.
    pub normal: [f64; 3],
    /// Thickness of one layer; the first begins at the body's origin \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
    /// Strength of every second layer over the material's \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
    pub ratio: f64,
    /// Each boundary is moved at random by up to half this share of the thickness \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.9))]
    pub jitter: f64,
}

/// A colour of a mesh's corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Channel {
    /// Red.
    #[default]
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
}

/// A part of a body whose strength is multiplied, in the frame of its shape or mesh as it stands
/// after `fit` or `scale`, before `rotation`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Paint {
    /// A box along the axes.
    Box {
        /// Lowest corner \[m\].
        #[schemars(schema_with = "unit::length3")]
        min: [f64; 3],
        /// Highest corner \[m\].
        #[schemars(schema_with = "unit::length3")]
        max: [f64; 3],
        /// Strength within over strength without \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the seam over which the factor comes in \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// A ball.
    Sphere {
        /// Centre \[m\].
        #[schemars(schema_with = "unit::length3")]
        centre: [f64; 3],
        /// Radius \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Strength within over strength without \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the seam over which the factor comes in \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// All that lies against the normal of a plane.
    HalfSpace {
        /// A point of the plane \[m\].
        #[schemars(schema_with = "unit::length3")]
        point: [f64; 3],
        /// Normal of the plane, out of the half-space; need not have length 1.
        normal: [f64; 3],
        /// Strength within over strength without \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the seam over which the factor comes in \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
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
        /// Strength within over strength without \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the seam over which the factor comes in \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// The corners of a mesh file: by their colours, or by a file of one factor a line.
    Corners {
        /// How deep the paint goes, fading \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        reach: f64,
        /// Which colour counts.
        #[serde(default)]
        channel: Channel,
        /// Strength over unpainted strength where that colour is 0 \[1\].
        #[serde(default = "one")]
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        none: f64,
        /// The same where it is full \[1\].
        #[serde(default = "one")]
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        full: f64,
        /// In place of colours: a text file of one factor a corner, in the order of the mesh file,
        /// relative to this file.
        #[serde(default)]
        file: Option<String>,
    },
}

const fn one() -> f64 {
    1.0
}
