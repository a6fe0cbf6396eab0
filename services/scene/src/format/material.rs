//! Materials, and how strength varies within a body, as they are written.

use super::{BondNumbers, GlassTreatment, InterlayerFilm, Plasticity};
use cullet_document::check::tell;
use cullet_document::unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Weibull modulus of a material that does not say \[1\].
pub(crate) const DEFAULT_WEIBULL: f64 = 10.0;

/// Restitution of a material that does not say \[1\].
pub(crate) const DEFAULT_RESTITUTION: f64 = 0.3;

/// Friction of a material that does not say \[1\].
pub(crate) const DEFAULT_FRICTION: f64 = 0.5;

/// What holds for a value that neither the material nor its preset gives, as the schema has it.
fn preset_or(value: f64) -> String {
    format!("the preset's, or {} without `preset`", tell(value))
}

/// What holds for a value that must come from the material or from its preset.
const PRESET: &str = "the preset's, but required without `preset`";

/// A material: either all its values, or a preset and the values that differ from it. Of a material
/// that breaks, `strength` over `young` is from 1e-5 to 0.1, or to 20 in what moves as it deforms.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Name by which bodies refer to the material; unique in the scene.
    pub name: String,
    /// Name of the preset that gives the values that are not written here.
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub preset: Option<String>,
    /// Mass density of the material \[kg/m³\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::density",
        extend("minimum" = 0.01, "maximum" = 30000, "x-default" = PRESET)
    )]
    pub density: Option<f64>,
    /// Young's modulus E \[Pa\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend("minimum" = 1e3, "maximum" = 2e12, "x-default" = PRESET)
    )]
    pub young: Option<f64>,
    /// Poisson's ratio ν \[1\]. `brittle` solves values from -0.5 to 0.49 only.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = -0.99, "maximum" = 0.4999, "x-default" = PRESET)
    )]
    pub poisson: Option<f64>,
    /// Tensile strength σ_f \[Pa\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend("exclusiveMinimum" = 0, "maximum" = 1e11, "x-default" = PRESET)
    )]
    pub strength: Option<f64>,
    /// Fracture energy G_f of cracks in tension (mode I) \[J/m²\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::energy_per_area",
        extend("exclusiveMinimum" = 0, "maximum" = 1e7, "x-default" = PRESET)
    )]
    pub fracture_energy: Option<f64>,
    /// Weibull modulus of the strength \[1\]: strength varies widely within a body at 5, hardly at
    /// 30, and not at all at 1000.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 1, "maximum" = 1000, "x-default" = preset_or(DEFAULT_WEIBULL))
    )]
    pub weibull: Option<f64>,
    /// Distance over which strength stays alike \[m\]; a solve uses at least four grid spacings.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "four grid spacings")
    )]
    pub correlation: Option<f64>,
    /// Direction of planes along which the material splits.
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub weak_plane: Option<WeakPlane>,
    /// Layers that alternate between two strengths.
    #[serde(default)]
    #[schemars(extend("x-default" = "none"))]
    pub layers: Option<Layers>,
    /// How it yields, if it is a metal that dents.
    #[serde(default)]
    #[schemars(extend("x-default" = "the preset's, or none: it is brittle"))]
    pub plasticity: Option<Plasticity>,
    /// How the family `peridynamics` solves it.
    #[serde(default)]
    #[schemars(extend("x-default" = "the defaults of its keys"))]
    pub peridynamics: Option<BondNumbers>,
    /// What was done to glass after it was drawn.
    #[serde(default)]
    #[schemars(extend("x-default" = "the preset's, or `annealed` without `preset`"))]
    pub treatment: Option<GlassTreatment>,
    /// Pressure at the faces of `heat-strengthened` or `toughened` glass \[Pa\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend(
            "minimum" = 1e6,
            "maximum" = 5e8,
            "x-default" = "the preset's, or 40 MPa if `heat-strengthened`, 90 MPa if `toughened`"
        )
    )]
    pub surface_stress: Option<f64>,
    /// The film of `laminated` glass.
    #[serde(default)]
    #[schemars(extend("x-default" = "the preset's, or one of polyvinyl butyral"))]
    pub interlayer: Option<InterlayerFilm>,
    /// Coefficient of restitution \[1\]: speed after a bounce over the speed before it.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = preset_or(DEFAULT_RESTITUTION))
    )]
    pub restitution: Option<f64>,
    /// Coefficient of Coulomb friction \[1\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 10, "x-default" = preset_or(DEFAULT_FRICTION))
    )]
    pub friction: Option<f64>,
    /// Hardness H, the mean pressure at which a contact crushes or yields \[Pa\]: of two that meet
    /// the softer one does.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend(
            "exclusiveMinimum" = 0,
            "maximum" = 1e12,
            "x-default" = "the preset's, or 3 times the flow stress at a strain of 0.08, or 30 \
                           times `strength` if it does not yield"
        )
    )]
    pub hardness: Option<f64>,
    /// Coefficient of Coulomb friction between the sides of a crack \[1\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 10, "x-default" = "0.85")
    )]
    pub crack_friction: Option<f64>,
    /// Whether bodies of this material break, unless a body says otherwise.
    #[serde(default)]
    #[schemars(extend("x-default" = "the preset's, or `true` without `preset`"))]
    pub breakable: Option<bool>,
}

/// A direction in which the material is weaker in tension, as slate, wood and mica are.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeakPlane {
    /// Normal of the planes in the axes of the shape or mesh \[1\]. Its length does not matter, but
    /// is above 1e-6.
    pub normal: [f64; 3],
    /// Strength along the normal over the strength of the material \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 1))]
    pub ratio: f64,
}

/// Layers that alternate between the strength of the material and `ratio` times that strength.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Normal of the layers in the axes of the shape or mesh \[1\]. Its length does not matter, but
    /// is above 1e-6.
    pub normal: [f64; 3],
    /// Thickness of one layer \[m\]; the first begins at the body's origin.
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
    /// Strength of every second layer over the strength of the material \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
    pub ratio: f64,
    /// Each boundary is moved at random, by up to half this share of the thickness \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.9))]
    pub jitter: f64,
}

/// A channel of the colours of a mesh's corners.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Channel {
    /// The red channel.
    #[default]
    Red,
    /// The green channel.
    Green,
    /// The blue channel.
    Blue,
}

/// A region of a body whose strength is multiplied. `kind` names its shape. Places are relative to
/// the origin of the shape or mesh, after `fit` or `scale` and before `rotation`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Paint {
    /// A box along the axes, from `min` to `max`.
    Box {
        /// Lowest corner of the box \[m\].
        #[schemars(schema_with = "unit::length3")]
        min: [f64; 3],
        /// Highest corner of the box \[m\]; above `min` along each axis.
        #[schemars(schema_with = "unit::length3")]
        max: [f64; 3],
        /// Strength inside over strength outside \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the zone over which the factor goes from 1 to its value \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// A ball about `centre`.
    Sphere {
        /// Centre of the ball \[m\].
        #[schemars(schema_with = "unit::length3")]
        centre: [f64; 3],
        /// Radius of the ball \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Strength inside over strength outside \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the zone over which the factor goes from 1 to its value \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// All that lies behind a plane, on the side that its normal points away from.
    HalfSpace {
        /// Any point of the plane \[m\].
        #[schemars(schema_with = "unit::length3")]
        point: [f64; 3],
        /// Normal of the plane, out of the region \[1\]. Its length does not matter, but is above
        /// 1e-6.
        normal: [f64; 3],
        /// Strength inside over strength outside \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the zone over which the factor goes from 1 to its value \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// A cylinder about the line between two points.
    Cylinder {
        /// Centre of one end \[m\].
        #[schemars(schema_with = "unit::length3")]
        from: [f64; 3],
        /// Centre of the other end \[m\]; not equal to `from`.
        #[schemars(schema_with = "unit::length3")]
        to: [f64; 3],
        /// Radius of the cylinder \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Strength inside over strength outside \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
        /// Width of the zone over which the factor goes from 1 to its value \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        edge: f64,
    },
    /// A line scored on the surface: a groove below it that is weaker and less tough, for cracks to
    /// follow. Cracks that are solved lie mostly within a cell of it, cells of `geometric` end at
    /// it; pieces of what is crushed, and those that the scene asks for, do not know of it.
    Line {
        /// Points of the line, on the surface \[m\]: 2 at least, each at most 2 % of the body's
        /// diagonal off it. Between them the line follows the surface in pieces of 5 % of the
        /// diagonal: a body has at most 256 of these and of painted regions.
        #[schemars(schema_with = "unit::places3")]
        points: Vec<[f64; 3]>,
        /// Width of the groove \[m\]; never less than one and a half grid spacings.
        #[serde(default)]
        #[schemars(
            schema_with = "unit::length",
            extend("exclusiveMinimum" = 0, "x-default" = "one and a half grid spacings")
        )]
        width: Option<f64>,
        /// Depth of the groove below the surface \[m\].
        #[serde(default)]
        #[schemars(
            schema_with = "unit::length",
            extend("exclusiveMinimum" = 0, "x-default" = "through the wall")
        )]
        depth: Option<f64>,
        /// Strength inside over strength outside \[1\].
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        factor: f64,
    },
    /// The corners of a mesh file, by their colours or by a file of factors. Only with a `mesh`.
    Corners {
        /// Depth below the surface at which the factor has faded to 1 \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        reach: f64,
        /// Which channel of the colours sets the factor.
        #[serde(default)]
        channel: Channel,
        /// Strength over the unpainted strength where the channel is 0 \[1\].
        #[serde(default = "one")]
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        none: f64,
        /// Strength over the unpainted strength where the channel is full \[1\].
        #[serde(default = "one")]
        #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.01, "maximum" = 100))]
        full: f64,
        /// Text file with one factor from 0.01 to 100 in each line, for the corners in the order of
        /// the mesh file; the path is relative to the scene file.
        #[serde(default)]
        #[schemars(extend("x-default" = "the colours of the mesh, but required if it has none"))]
        file: Option<String>,
    },
}

const fn one() -> f64 {
    1.0
}
