//! A body as it is written: what it is made of, where it stands and how it moves.

use super::directed::{BodyAnimation, KeyframeCurve, PoseKeyframe, ShapePart};
use super::dynamic::Dynamics;
use super::interior::Interior;
use super::pieces::WantedPieces;
use super::rotation::{Axis, Rotation};
use super::{Paint, Shape, SolverChoice};
use cullet_document::unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What happens to a mesh file that is not a closed, clean surface.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum RepairChoice {
    /// The mesh is repaired, unless that moves its surface by over 2 % of its size; a warning says
    /// how.
    #[default]
    Auto,
    /// The mesh is repaired, however far that moves its surface: at worst it is made anew on a grid
    /// of an eightieth of its size.
    Remesh,
    /// The mesh is refused; an error says why.
    Refuse,
}

/// What becomes of a mesh file that holds several objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectsChoice {
    /// They are shapes of one body.
    #[default]
    OneBody,
    /// Each is a body of its own, called by the names of this body and of the object with a hyphen
    /// between them. All stand in their places in the file, and other keys hold for each.
    Bodies,
}

/// A point of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Anchor {
    /// The origin of the shape or of the mesh file.
    #[default]
    Origin,
    /// The centre of the body's bounding box before rotation.
    Centre,
    /// The centre of the bottom of that bounding box.
    Base,
}

/// How finely a body is resolved when it breaks: either `spacing` or `particles`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Resolution {
    /// Grid spacing of the solve \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none, but required without `particles`")
    )]
    pub spacing: Option<f64>,
    /// Approximate number of material points of the solve \[1\], in place of
    /// `fracture.max_particles`.
    #[schemars(
        range(min = 64, max = 50_000_000),
        extend("x-default" = "none, but required without `spacing`")
    )]
    pub particles: Option<u32>,
}

/// A body; or, inside a grid, stack, scatter or instances, the template of its bodies. A body has
/// one of `shape`, `parts` and `mesh`. Bodies must not overlap at the start, unless neither can
/// move by itself: both are fixed or driven.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// Name of the body in messages, in recordings, in `[expect]` and in `--set`: 1 to 80 bytes,
    /// without a slash, and unique in the scene. A template has no name.
    #[schemars(extend("x-default" = "required in `[[body]]`"))]
    pub name: Option<String>,
    /// Shape given by its dimensions.
    #[schemars(extend("x-default" = "required without `parts` or `mesh`"))]
    pub shape: Option<Shape>,
    /// Shapes that together are the body, such as a cup and its handle: at most 256. Each must
    /// overlap others, so that all of them are one piece; where they overlap there is material
    /// once.
    #[schemars(
        length(max = 256),
        extend("x-default" = "none, but required without `shape` or `mesh`")
    )]
    pub parts: Vec<ShapePart>,
    /// Mesh file (.obj, .stl, .ply, .glb or .gltf), or NURBS patches (.json, as NURBS-Python and
    /// rw3dm write them: degrees 2 and 3, without trims); the path is relative to the scene file.
    /// Its origin is the file's own.
    #[schemars(extend("x-default" = "required without `shape` or `parts`"))]
    pub mesh: Option<String>,
    /// The mesh is scaled so that its longest side has this length \[m\]. Not beside `scale`, and
    /// only with a `mesh`.
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "the size in the file, in metres")
    )]
    pub fit: Option<f64>,
    /// The mesh is scaled by this factor \[1\]. Not beside `fit`, and only with a `mesh`.
    #[schemars(
        schema_with = "unit::ratio",
        extend("exclusiveMinimum" = 0, "x-default" = "1")
    )]
    pub scale: Option<f64>,
    /// Thickness \[m\] of a wall whose middle is the surface in the mesh file, open or closed. It
    /// is not scaled. The wall has no texture coordinates and no materials of the file. Only with a
    /// `mesh`.
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "the mesh bounds a solid")
    )]
    pub thickness: Option<f64>,
    /// Axis of the mesh file that points up.
    #[schemars(extend("x-default" = "`z`, but `y` in .glb and .gltf files"))]
    pub up: Option<Axis>,
    /// What happens to a mesh that is not a closed, clean surface.
    pub repair: RepairChoice,
    /// What becomes of a mesh file that holds several objects: the nodes with a mesh of a .glb
    /// file, the objects and groups (`o`, `g`) of an .obj file. A template is one body.
    pub objects: ObjectsChoice,
    /// Name of the one object of the mesh file that is the body; the others are left out. `fit` is
    /// then the length of this object.
    #[schemars(extend("x-default" = "all objects of the file"))]
    pub object: Option<String>,
    /// Which point of the body is at `position`, and stays there when the body is rotated.
    pub anchor: Anchor,
    /// Where the anchor is \[m\]: at most 100000 m from the world's origin. A template gives the
    /// position of the first body; in a scatter it has none.
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// Rotation about the anchor.
    pub rotation: Rotation,
    /// Velocity of the centre of mass \[m/s\]; at most 10000 m/s. A fixed body has none.
    #[schemars(schema_with = "unit::velocity3")]
    pub velocity: [f64; 3],
    /// Angular velocity in the world's axes \[rad/s\]; at most 10000 rad/s. A fixed body has none.
    #[schemars(schema_with = "unit::angular_velocity3")]
    pub spin: [f64; 3],
    /// Name of a preset or of a `[[material]]`.
    #[schemars(extend("x-default" = "required"))]
    pub material: Option<String>,
    /// Whether the body never moves. A fixed body does not break.
    pub fixed: bool,
    /// Where the body is at rising times, which makes it a driven body: it moves as it is told,
    /// pushes others and feels nothing, and does not break. At most 4096 keyframes; it is at the
    /// first until its time, and stays at the last. Only of a single body, without `velocity`,
    /// `spin`, `fixed` and `dynamic`. Its speed between keyframes is at most 10000 m/s.
    #[schemars(length(max = 4096), extend("x-default" = "it moves by its forces"))]
    pub keyframes: Vec<PoseKeyframe>,
    /// An animation of a GLB file that drives the body, in place of `keyframes` and under their
    /// conditions.
    #[schemars(extend("x-default" = "it moves by its forces"))]
    pub animation: Option<BodyAnimation>,
    /// How a driven body goes from one of its `keyframes` to the next.
    pub interpolation: KeyframeCurve,
    /// Name of a group of bodies that the body is in, for `glue` and `field`: 1 to 80 bytes, and
    /// not that of a body, grid, stack, scatter, instances or sheet.
    #[schemars(extend("x-default" = "it is in no group"))]
    pub group: Option<String>,
    /// Whether the body can break.
    #[schemars(extend(
        "x-default" = "whether the material breaks, but `false` if `fixed` or driven"
    ))]
    pub breakable: Option<bool>,
    /// How finely the body is resolved when it breaks.
    #[schemars(extend("x-default" = "as fine as `fracture.max_particles` allows"))]
    pub resolution: Option<Resolution>,
    /// Least impulse of a hit that can break this body \[N·s\].
    #[schemars(
        schema_with = "unit::impulse",
        extend("minimum" = 0, "x-default" = "`world.impulse_threshold`")
    )]
    pub impulse_threshold: Option<f64>,
    /// Which solver family breaks this body.
    #[schemars(extend("x-default" = "`fracture.solver`"))]
    pub solver: Option<SolverChoice>,
    /// Regions of the body that are weaker or stronger than its material: at most 256, of which at
    /// most one of kind `corners`.
    pub paint: Vec<Paint>,
    /// How it comes apart where the scene says so: how many pieces, where, and what stays whole.
    #[schemars(extend("x-default" = "as the solve finds it"))]
    pub pieces: Option<WantedPieces>,
    /// What it looks like inside.
    #[schemars(extend("x-default" = "by its material"))]
    pub interior: Option<Interior>,
    /// Makes it a body that moves as it deforms; only of a single body.
    #[schemars(extend("x-default" = "it is rigid until it breaks"))]
    pub dynamic: Option<Dynamics>,
}
