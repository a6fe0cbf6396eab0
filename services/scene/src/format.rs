//! The scene file as it is written: plain data, the one source of the reader and of the schema.
//!
//! Numbers are SI when they arrive here: `check` has turned "6 mm" into 0.006 by the units in it.

mod fidelity;
mod material;
mod show;

pub use fidelity::Fidelity;
pub use material::{Channel, Layers, Material, Paint, WeakPlane};
pub use show::{Bounds, Expect, ShareBounds, View};

use super::look::Detail;
use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// A scene: what there is, how it moves, and what must happen.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
pub struct Document {
    /// What the scene shows, in a line.
    pub description: String,
    /// Files read before this one, relative to it. Their lists come first; this file's values win.
    #[schemars(length(max = 64))]
    pub include: Vec<String>,
    /// The rigid world and its clock.
    pub world: World,
    /// How bodies are broken, unless a body says otherwise.
    pub fracture: Fracture,
    /// How true and how dear solves should be.
    pub fidelity: Fidelity,
    /// Materials beside the presets.
    pub material: Vec<Material>,
    /// Bodies, one each.
    pub body: Vec<Body>,
    /// Bodies in rows, columns and layers.
    pub grid: Vec<Grid>,
    /// Bodies on top of one another.
    pub stack: Vec<Stack>,
    /// Bodies strewn in a box by a seed.
    pub scatter: Vec<Scatter>,
    /// What the scene must show.
    pub expect: Expect,
    /// Where the preview looks from.
    pub view: Option<View>,
}

/// The rigid world and its clock.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct World {
    /// Gravity \[m/s²\].
    #[schemars(schema_with = "unit::acceleration3")]
    pub gravity: [f64; 3],
    /// Time step \[s\].
    #[schemars(schema_with = "unit::time", extend("minimum" = 1e-6, "maximum" = 0.05))]
    pub step: f64,
    /// Simulated time \[s\].
    #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0, "maximum" = 600))]
    pub duration: f64,
    /// The only source of randomness.
    #[schemars(range(max = 9_223_372_036_854_775_807_u64))]
    pub seed: u64,
    /// Steps between a hit and its fragments: 0 means that the world waits for the solver.
    #[schemars(range(max = 100_000))]
    pub latency_steps: u32,
    /// Hits below this impulse break nothing \[N·s\].
    #[schemars(schema_with = "unit::impulse", extend("minimum" = 0))]
    pub impulse_threshold: f64,
    /// Most bodies in the world at once: over it nothing breaks any more.
    #[schemars(range(min = 1, max = 100_000))]
    pub max_bodies: u32,
    /// Fragments of this generation break no more: bodies of the scene have 0, their fragments 1.
    #[schemars(range(max = 16))]
    pub max_generation: u32,
    /// What fragments may do, by their share of the first body's volume.
    pub tiers: Tiers,
}

impl Default for World {
    fn default() -> Self {
        Self {
            gravity: [0.0, 0.0, -9.81],
            step: 1.0 / 240.0,
            duration: 1.0,
            seed: 1,
            latency_steps: 0,
            impulse_threshold: 0.1,
            max_bodies: 4000,
            max_generation: 3,
            tiers: Tiers::default(),
        }
    }
}

/// What fragments may do, by their share of the first body's volume.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tiers {
    /// Below this share a fragment is one convex hull and unbreakable \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub tiny: f64,
    /// Below this share a fragment is unbreakable \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.98))]
    pub small: f64,
}

impl Default for Tiers {
    fn default() -> Self {
        Self { tiny: 0.01, small: 0.1 }
    }
}

/// Which way of breaking is asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SolverChoice {
    /// The gate decides.
    #[default]
    Auto,
    /// Brittle solids: material points and damage.
    Brittle,
    /// Cells around the point of the hit, their number from the energy.
    Geometric,
}

impl SolverChoice {
    /// The solver asked for by name; nothing where the gate decides.
    #[must_use]
    pub const fn solver(self) -> Option<&'static str> {
        match self {
            Self::Auto => None,
            Self::Brittle => Some("brittle"),
            Self::Geometric => Some("geometric"),
        }
    }
}

/// Numbers that the points of a solve are worked out in; its nodes keep f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// f64
    #[default]
    Double,
    /// f32
    Single,
}

/// How bodies are broken, unless a body says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fracture {
    /// Which solver.
    pub solver: SolverChoice,
    /// Most material points of one solve.
    #[schemars(range(min = 64, max = 50_000_000))]
    pub max_particles: u32,
    /// Most time steps of one solve.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub max_steps: u32,
    /// Most fragments of one body.
    #[schemars(range(min = 2, max = 100_000))]
    pub max_fragments: u32,
    /// Smaller shares of the body's volume are merged into a neighbour \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.5))]
    pub min_volume_ratio: f64,
    /// How crack faces look closer than the grid resolves.
    pub detail: Detail,
    /// Parts below this share of the body's volume become debris: grains that fly, are recorded and
    /// drawn, and hit nothing; 0 makes none \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.1))]
    pub debris: f64,
    /// Size of its grains, half the mass being in larger ones; half a grid spacing without it
    /// \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub grain: Option<f64>,
    /// What points are worked out in; without it double, and single where a solve has an error that
    /// is good enough.
    pub precision: Option<Precision>,
}

impl Default for Fracture {
    fn default() -> Self {
        Self {
            solver: SolverChoice::Auto,
            max_particles: 16_000,
            max_steps: 20_000,
            max_fragments: 400,
            min_volume_ratio: 1e-4,
            detail: Detail::default(),
            debris: 5e-4,
            grain: None,
            precision: None,
        }
    }
}

/// A shape by its measures. z is up; see each kind for its origin.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// A box; its origin is its centre.
    Box {
        /// Edge lengths along x, y, z \[m\].
        #[schemars(schema_with = "unit::size3")]
        size: [f64; 3],
    },
    /// A ball; its origin is its centre.
    Sphere {
        /// Radius \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Corners around the equator.
        #[serde(default = "default_segments")]
        #[schemars(range(min = 8, max = 256))]
        segments: u32,
    },
    /// A cylinder about z; its origin is its centre.
    Cylinder {
        /// Radius \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Height along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        height: f64,
        /// Corners around.
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
    /// A cone about z; its origin is the middle of its axis.
    Cone {
        /// Radius of the base \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Radius of the top: 0 is a tip \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
        top_radius: f64,
        /// Height along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        height: f64,
        /// Corners around.
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
    /// A ring about z; its origin is its centre.
    Torus {
        /// From the centre to the middle of the tube \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        ring_radius: f64,
        /// Radius of the tube \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        tube_radius: f64,
        /// Corners around the ring.
        #[serde(default = "default_segments")]
        #[schemars(range(min = 8, max = 256))]
        segments: u32,
    },
    /// A cylinder about z with half balls as ends; its origin is its centre.
    Capsule {
        /// Radius \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Length of the cylinder between the half balls \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        length: f64,
        /// Corners around.
        #[serde(default = "default_segments")]
        #[schemars(range(min = 8, max = 256))]
        segments: u32,
    },
    /// A polygon in x, y drawn along z; its origin is the polygon's own, at half its height.
    Extrusion {
        /// Corners in order, either way round \[m\].
        #[schemars(schema_with = "unit::points2")]
        polygon: Vec<[f64; 2]>,
        /// Height along z \[m\].
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        height: f64,
    },
    /// A profile turned about z: solid, or a vessel with walls. Its origin is the profile's own.
    Lathe {
        /// Outline from bottom to top: radius and height of each point \[m\].
        #[schemars(schema_with = "unit::points2")]
        profile: Vec<[f64; 2]>,
        /// Wall and floor thickness of an open vessel; solid without it \[m\].
        #[serde(default)]
        #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
        wall: Option<f64>,
        /// Corners around.
        #[serde(default = "default_segments")]
        #[schemars(range(min = 3, max = 256))]
        segments: u32,
    },
}

const fn default_segments() -> u32 {
    32
}

/// What happens to a mesh file that is not a closed, clean surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RepairChoice {
    /// It is repaired, and the report says how.
    #[default]
    Auto,
    /// It is refused, and the error says why.
    Refuse,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

/// A point of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Anchor {
    /// The origin of the shape or of the mesh file.
    #[default]
    Origin,
    /// The middle of the box around it, before it is turned.
    Centre,
    /// The middle of the bottom of that box.
    Base,
}

/// How fine a body is resolved when it breaks: one of the two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Resolution {
    /// Grid spacing h \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// About so many material points.
    #[schemars(range(min = 64, max = 50_000_000))]
    pub particles: Option<u32>,
}

/// A turn, in one of three ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Rotation {
    /// Axis of a turn by `degrees`; need not have length 1.
    pub axis: Option<[f64; 3]>,
    /// Angle about `axis`, by the right hand \[°\].
    pub degrees: Option<f64>,
    /// Turns about the fixed x, then y, then z axis \[°\].
    pub euler_degrees: Option<[f64; 3]>,
    /// w, x, y, z; need not have length 1.
    pub quaternion: Option<[f64; 4]>,
}

/// A body, or the template of many.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// What messages, `[expect]` and `--set` call it. A template has none.
    pub name: Option<String>,
    /// A shape by its measures. Either this or `mesh`.
    pub shape: Option<Shape>,
    /// A mesh file: .obj, .stl, .ply or .glb, relative to this file. Its origin is the file's own.
    pub mesh: Option<String>,
    /// The mesh is scaled so that its longest side is this \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub fit: Option<f64>,
    /// The mesh is scaled by this \[1\].
    #[schemars(schema_with = "unit::ratio", extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
    /// The axis of the mesh file that points up; z without it, but y in .glb files.
    pub up: Option<Axis>,
    /// What happens to a mesh that is not closed and clean.
    pub repair: RepairChoice,
    /// Which point of the body `position` places.
    pub anchor: Anchor,
    /// Where the anchor is put: the origin of the shape or of the mesh, unless `anchor` says else
    /// \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// The turn about the anchor.
    pub rotation: Rotation,
    /// Velocity of the centre of mass \[m/s\].
    #[schemars(schema_with = "unit::velocity3")]
    pub velocity: [f64; 3],
    /// Angular velocity \[rad/s\].
    #[schemars(schema_with = "unit::angular_velocity3")]
    pub spin: [f64; 3],
    /// A preset or a `[[material]]`.
    pub material: Option<String>,
    /// Whether it never moves.
    pub fixed: bool,
    /// Whether it can break; without it, if it is not fixed and its material breaks.
    pub breakable: Option<bool>,
    /// How fine it is resolved when it breaks.
    pub resolution: Option<Resolution>,
    /// In place of the world's impulse threshold \[N·s\].
    #[schemars(schema_with = "unit::impulse", extend("minimum" = 0))]
    pub impulse_threshold: Option<f64>,
    /// In place of the scene's solver.
    pub solver: Option<SolverChoice>,
    /// Where it is weaker or stronger than its material.
    pub paint: Vec<Paint>,
}

/// Bodies in rows, columns and layers, called `name-i-j-k`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// First part of their names.
    pub name: String,
    /// How many along x, y, z.
    pub count: [u32; 3],
    /// From one to the next along x, y, z \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub spacing: [f64; 3],
    /// Every second layer is shifted along x by this share of the spacing: 0.5 is a brick bond
    /// \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub bond: f64,
    /// What is repeated; its position is the first one's.
    pub body: Body,
}

/// Bodies on top of one another, called `name-i`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stack {
    /// First part of their names.
    pub name: String,
    /// How many.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u32,
    /// From one to the next \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub offset: [f64; 3],
    /// Each is turned about z by so much more than the one before \[°\].
    #[serde(default)]
    pub twist_degrees: f64,
    /// What is repeated; its position is the first one's.
    pub body: Body,
}

/// Bodies strewn in a box without overlap, called `name-i`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// First part of their names.
    pub name: String,
    /// How many.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u32,
    /// Lowest corner of the box that holds them \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub min: [f64; 3],
    /// Highest corner \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub max: [f64; 3],
    /// Least distance between the spheres around them \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length", extend("minimum" = 0))]
    pub gap: f64,
    /// Whether each is turned at random.
    #[serde(default)]
    pub turn: bool,
    /// In place of the world's seed.
    #[serde(default)]
    pub seed: Option<u64>,
    /// What is repeated; it has no position.
    pub body: Body,
}
