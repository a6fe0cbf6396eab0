//! What directs a shot: keyframes of a body, joints, glue and fields, as they are written.

use super::rotation::{Axis, Rotation};
use cullet_document::unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a driven body is at a time.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseKeyframe {
    /// Time of the keyframe \[s\]; later than that of the keyframe before.
    #[schemars(schema_with = "unit::time", extend("minimum" = 0, "maximum" = 600))]
    pub at: f64,
    /// Where the anchor of the body is then \[m\]: at most 100000 m from the world's origin.
    #[serde(default)]
    #[schemars(schema_with = "unit::length3", extend("x-default" = "the body's `position`"))]
    pub position: Option<[f64; 3]>,
    /// Rotation of the body about its anchor then. From one keyframe to the next a body turns the
    /// short way, by 180° at most: a full turn takes three keyframes or more.
    #[serde(default)]
    #[schemars(extend("x-default" = "the body's `rotation`"))]
    pub rotation: Option<Rotation>,
}

/// How a driven body goes from one keyframe to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KeyframeCurve {
    /// In a straight line at constant speed: its velocity jumps at a keyframe.
    #[default]
    Linear,
    /// Along a smooth curve through the keyframes: its velocity does not jump, and it is at rest at
    /// the first and at the last.
    Smooth,
}

/// An animation of a GLB file that moves a node, and with it a driven body: at every time the body
/// is where the file has it. The nodes that the node hangs on move it too. Keys are followed as the
/// file says, linear (turns by slerp) or cubic (CUBICSPLINE); what jumps (STEP), is scaled by the
/// animation or deformed by bones or shape keys is refused. A body whose `mesh` is the same file
/// moves as its mesh does in the file; any other body has its anchor at the node and turns with it.
/// The body's `position` and `rotation` place the whole in the world. The animations of all bodies
/// have at most 10 million keys.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyAnimation {
    /// The glTF file (.glb or .gltf); the path is relative to the scene file.
    pub file: String,
    /// Name of the animation in the file.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only animation of the file"))]
    pub name: Option<String>,
    /// Name of the node in the file: an object, an empty or a bone.
    pub node: String,
    /// When the animation begins \[s\]: its time zero is then. Before its first key and after its
    /// last one the body stands still.
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("minimum" = -600, "maximum" = 600))]
    pub start: f64,
    /// The ways of the animation are scaled by this factor \[1\]. Not of a body whose `mesh` is the
    /// same file: the scale of its mesh holds.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("exclusiveMinimum" = 0, "maximum" = 1e6, "x-default" = "1")
    )]
    pub scale: Option<f64>,
    /// Axis of the file that points up. Not of a body whose `mesh` is the same file: the `up` of
    /// its mesh holds.
    #[serde(default)]
    #[schemars(extend("x-default" = "`y`"))]
    pub up: Option<Axis>,
}

/// One of the shapes that a body is made of. Its rotation is about its own origin.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapePart {
    /// The shape of the part, given by its dimensions.
    pub shape: super::Shape,
    /// Where the origin of the part is in the frame of the body \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// Rotation of the part about its own origin.
    #[serde(default)]
    pub rotation: Rotation,
}

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointForm {
    /// Nothing: the two bodies move as one.
    Rigid,
    /// Turning about an axis.
    Hinge,
    /// Turning about a point, in all directions.
    Ball,
    /// Everything, as long as its two ends are no farther apart than its length. It has no mass.
    Rope,
}

/// Two bodies that are held together, or a body and the world. The joint breaks when a step asks
/// more of it than it can bear. It has no effect on how a body breaks: hits alone decide that.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointEntry {
    /// What the joint leaves free.
    pub kind: JointForm,
    /// Names of the two rigid bodies; one of them may be `world`, which never moves.
    #[schemars(length(min = 2, max = 2))]
    pub between: Vec<String>,
    /// Where the joint is at the start, in the world \[m\]. Of a rope, where it is tied to the
    /// first of the two.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length3",
        extend("x-default" = "required of a hinge and a ball joint, and where a rope is tied to \
                              the world; else the body's centre of mass")
    )]
    pub at: Option<[f64; 3]>,
    /// Where a rope is tied to the second of the two at the start, in the world \[m\]. Only of a
    /// rope.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length3",
        extend("x-default" = "required where a rope is tied to the world; else the body's centre \
                              of mass")
    )]
    pub to: Option<[f64; 3]>,
    /// Axis of a hinge, in the world at the start \[1\]. Its length does not matter, but is above
    /// 1e-6. Only of a hinge.
    #[serde(default)]
    #[schemars(extend("x-default" = "required of a hinge"))]
    pub axis: Option<[f64; 3]>,
    /// Length of a rope \[m\]; no shorter than its ends are apart at the start, and at most 10000
    /// m. Only of a rope.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "maximum" = 10_000,
               "x-default" = "the distance of its ends at the start")
    )]
    pub length: Option<f64>,
    /// Greatest force that the joint bears, averaged over a step \[N\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::force",
        extend("exclusiveMinimum" = 0, "maximum" = 1e30, "x-default" = "it never breaks by a force")
    )]
    pub force: Option<f64>,
    /// Greatest moment that the joint bears, averaged over a step \[N·m\]. Not of a ball joint or a
    /// rope, which bear none.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::moment",
        extend("exclusiveMinimum" = 0, "maximum" = 1e30,
            "x-default" = "it never breaks by a moment")
    )]
    pub torque: Option<f64>,
    /// Whether the two bodies collide with each other. Only of a ball joint and a rope: bodies that
    /// a rigid joint or a hinge joins never do.
    #[serde(default)]
    #[schemars(extend("x-default" = "`true` of a rope, `false` of a ball joint"))]
    pub collide: Option<bool>,
}

/// Bodies that stick together where they touch: a rigid joint between each two of them that lie
/// within `gap` of each other at the start. Its strength is either that of each pair (`force`,
/// `torque`), or by the area where they touch (`tensile`, `shear`).
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GlueEntry {
    /// Names of bodies, of grids, stacks, scatters and instances, or of groups. Fixed bodies may
    /// be among them.
    #[schemars(length(min = 1, max = 256))]
    pub bodies: Vec<String>,
    /// Greatest force that the glue between two bodies bears \[N\]. Not beside `tensile` and
    /// `shear`.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::force",
        extend("exclusiveMinimum" = 0, "maximum" = 1e30,
            "x-default" = "required without `tensile` and `shear`")
    )]
    pub force: Option<f64>,
    /// Greatest moment that the glue between two bodies bears \[N·m\]. Only beside `force`.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::moment",
        extend("exclusiveMinimum" = 0, "maximum" = 1e30,
            "x-default" = "it never breaks by a moment")
    )]
    pub torque: Option<f64>,
    /// Tensile strength of the glue \[Pa\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend("exclusiveMinimum" = 0, "maximum" = 1e30, "x-default" = "required without `force`")
    )]
    pub tensile: Option<f64>,
    /// Shear strength of the glue \[Pa\].
    #[serde(default)]
    #[schemars(
        schema_with = "unit::pressure",
        extend("exclusiveMinimum" = 0, "maximum" = 1e30, "x-default" = "required without `force`")
    )]
    pub shear: Option<f64>,
    /// Greatest distance of two bodies that stick together \[m\], such as the thickness of a bed of
    /// mortar.
    #[serde(default = "default_gap")]
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "maximum" = 1)
    )]
    pub gap: f64,
}

const fn default_gap() -> f64 {
    1e-3
}

/// What a field does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FieldForm {
    /// Air that moves at `velocity` drags bodies along, by the area of a ball of the same volume.
    Wind,
    /// Bodies are accelerated towards `point`.
    Attractor,
    /// Bodies are accelerated in directions that change from place to place, as if stirred.
    Turbulence,
    /// Bodies behind a plane are removed from the world.
    Kill,
}

/// Something that acts on rigid bodies from afar in every step. Fixed and driven bodies, debris,
/// sheets and dynamic bodies do not feel it.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldEntry {
    /// What the field does.
    pub kind: FieldForm,
    /// Names of bodies, of grids, stacks, scatters and instances, or of groups that feel it, with
    /// all their fragments.
    #[serde(default)]
    #[schemars(length(max = 256), extend("x-default" = "all bodies feel it"))]
    pub bodies: Vec<String>,
    /// Velocity of the air \[m/s\]; at most 10000 m/s. Only of wind, which needs it.
    #[serde(default)]
    #[schemars(schema_with = "unit::velocity3", extend("x-default" = "required of wind"))]
    pub velocity: Option<[f64; 3]>,
    /// Drag coefficient of bodies \[1\]. Only of wind.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 10, "x-default" = "0.47, that of a ball")
    )]
    pub drag: Option<f64>,
    /// Density of the air \[kg/m³\]. Only of wind.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::density",
        extend("minimum" = 0, "maximum" = 10_000, "x-default" = "1.2")
    )]
    pub density: Option<f64>,
    /// Where an attractor draws to, or a point of the plane of `kill` \[m\]. Only of these, which
    /// need it.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length3",
        extend("x-default" = "required of an attractor and of `kill`")
    )]
    pub point: Option<[f64; 3]>,
    /// Acceleration \[m/s²\]: of an attractor at the distance `size`, where a negative one pushes
    /// away; of turbulence its root mean square. At most 10000 m/s² either way. Only of these,
    /// which need it.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::acceleration",
        extend("minimum" = -10_000, "maximum" = 10_000,
               "x-default" = "required of an attractor and of turbulence")
    )]
    pub strength: Option<f64>,
    /// Beyond `size` the pull of an attractor falls with this power of the distance \[1\]: 0 for
    /// none, 2 for that of gravity. Within `size` it falls linearly towards the point. Only of an
    /// attractor.
    #[serde(default)]
    #[schemars(range(min = 0, max = 4), extend("x-default" = "2"))]
    pub falloff: Option<u32>,
    /// Distance \[m\]: of an attractor, where its pull is greatest; of turbulence, the size of its
    /// eddies. Only of these.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::length",
        extend("minimum" = 1e-6, "maximum" = 10_000, "x-default" = "1")
    )]
    pub size: Option<f64>,
    /// How often eddies of turbulence change \[1/s\]. Only of turbulence.
    #[serde(default)]
    #[schemars(
        schema_with = "unit::rate",
        extend("minimum" = 0, "maximum" = 1000, "x-default" = "they stand still")
    )]
    pub rate: Option<f64>,
    /// Seed of turbulence \[1\]. Only of turbulence.
    #[serde(default)]
    #[schemars(extend("x-default" = "`world.seed`"))]
    pub seed: Option<u64>,
    /// Normal of the plane of `kill` \[1\]: bodies are removed on the side that it points away
    /// from, once their centre of mass is there. Its length does not matter, but is above 1e-6.
    /// Only of `kill`, which needs it.
    #[serde(default)]
    #[schemars(extend("x-default" = "required of `kill`"))]
    pub normal: Option<[f64; 3]>,
}

/// The box outside of which bodies are removed, once their centre of mass is there; what is fixed
/// or driven stays.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldBounds {
    /// Lowest corner of the box \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub min: [f64; 3],
    /// Highest corner of the box \[m\]; greater than `min` along each axis.
    #[schemars(schema_with = "unit::length3")]
    pub max: [f64; 3],
}
