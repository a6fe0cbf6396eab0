//! The specimen file as it is written. Numbers are SI when they arrive here.

mod place;
mod watch;

pub use place::{BoxSide, RegionConfig, RegionPart};
pub use watch::{
    Colour, Component, Expected, Metric, ProbeConfig, ProbeKind, ReduceChoice, Reduction,
};

use cullet_document::unit;
use cullet_scene::format::{Axis, Material, Precision, RepairChoice, Rotation, Shape};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A specimen: a body under given supports and loads, what is watched, and what must come out.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpecimenDocument {
    /// What it shows, in a line.
    pub description: String,
    /// Files read before this one, relative to it. This file's values win.
    #[schemars(length(max = 64))]
    pub include: Vec<String>,
    /// Its shape, and how it lies on the grid.
    pub geometry: Geometry,
    /// What it is made of.
    pub material: Option<Material>,
    /// How it is solved.
    pub solver: SolverConfig,
    /// How long, and how often it is looked at.
    pub run: RunConfig,
    /// Parts of it that supports, loads and probes name.
    pub region: Vec<RegionConfig>,
    /// Other bodies beside it on the same grid, which touch it and each other, and do not stick.
    #[schemars(length(max = 15))]
    pub body: Vec<BodyConfig>,
    /// Parts of other materials; of several at a place, the last.
    #[schemars(length(max = 31))]
    pub zone: Vec<ZoneConfig>,
    /// Parts that are stronger, weaker or damaged.
    pub patch: Vec<PatchConfig>,
    /// Cracks without width that are there from the start.
    pub notch: Vec<NotchConfig>,
    /// Parts cut out of it.
    pub slot: Vec<SlotConfig>,
    /// Planes that stand for another half.
    pub symmetry: Vec<Symmetry>,
    /// Velocities at the start; they add up.
    pub start: Vec<StartConfig>,
    /// Prescribed velocities; without one a support stands still.
    pub support: Vec<SupportConfig>,
    /// Loads.
    pub load: Vec<LoadConfig>,
    /// Numbers that are sampled in time.
    pub probe: Vec<ProbeConfig>,
    /// Numbers made of the samples.
    pub metric: Vec<Metric>,
    /// What metrics must come to, by name.
    pub expect: BTreeMap<String, Expected>,
}

/// Its shape, and how it lies on the grid.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Geometry {
    /// A shape by its measures. Either this or `mesh`.
    pub shape: Option<Shape>,
    /// A mesh file: .obj, .stl, .ply or .glb, relative to this file.
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
    /// Where the origin of the shape or mesh lies in the specimen's frame \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// How the specimen, with all that is said of it, is turned against the grid.
    pub rotation: Rotation,
    /// Where the specimen's origin lies on the grid, which has a node at zero \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub shift: [f64; 3],
    /// Rows of the displacement gradient at the start \[1\].
    pub displacement_gradient: [[f64; 3]; 3],
}

/// How points lie in the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Points {
    /// At random but even, with volumes fitted to the grid, as in a scene.
    #[default]
    Scattered,
    /// In rows along the axes of the grid, of equal volumes.
    Rows,
}

/// Velocity fields at a crack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fields {
    /// One for each side.
    #[default]
    Split,
    /// One for all: the sides stay welded at the nodes between them.
    Single,
}

/// How it is solved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(rename = "Solver")]
#[serde(deny_unknown_fields, default)]
pub struct SolverConfig {
    /// Name of the family that solves it: `brittle` is the material-point method. The process that
    /// solves knows which there are.
    #[schemars(length(min = 1, max = 64))]
    pub family: String,
    /// Grid spacing h \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// Time step over the greatest stable one \[1\].
    #[schemars(schema_with = "unit::ratio", extend("exclusiveMinimum" = 0, "maximum" = 100))]
    pub step_factor: f64,
    /// Points a cell.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.5, "maximum" = 1000))]
    pub points_per_cell: f64,
    /// How they lie.
    pub points: Points,
    /// Of the points' pass.
    pub precision: Precision,
    /// Velocity fields at a crack.
    pub fields: Fields,
    /// Whether the material can break.
    pub breaks: bool,
    /// Length over which a crack is spread, in place of the calibrated one \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
    pub softening_length: Option<f64>,
    /// Horizon of bonds over the spacing, of a family that has bonds; else the family's own \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 1.5, "maximum" = 6))]
    pub horizon: Option<f64>,
    /// Whether strength scatters with the material's Weibull modulus.
    pub flaws: bool,
    /// Steps from one look at what has parted to the next.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub look: u32,
    /// Rate at which velocities fall off by themselves \[1/s\].
    #[schemars(schema_with = "unit::rate", extend("minimum" = 0))]
    pub damping: f64,
    /// Until when \[s\].
    #[schemars(schema_with = "unit::time", extend("minimum" = 0))]
    pub damped_until: Option<f64>,
    /// Most points; more are refused.
    #[schemars(range(min = 8, max = 50_000_000))]
    pub max_points: u32,
    /// Most time steps; more are refused.
    #[schemars(range(min = 1, max = 100_000_000))]
    pub max_steps: u32,
    /// Threads of one run; they do not change a bit of it.
    #[schemars(range(min = 1, max = 256))]
    pub threads: u32,
    /// The only source of randomness.
    #[schemars(range(max = 9_223_372_036_854_775_807_u64))]
    pub seed: u64,
}

impl Default for SolverConfig {
    fn default() -> Self {
        Self {
            family: "brittle".to_owned(),
            spacing: None,
            step_factor: 0.8,
            points_per_cell: 8.0,
            points: Points::Scattered,
            precision: Precision::Double,
            fields: Fields::Split,
            breaks: true,
            softening_length: None,
            horizon: None,
            flaws: false,
            look: 4,
            damping: 0.0,
            damped_until: None,
            max_points: 4_000_000,
            max_steps: 10_000_000,
            threads: 1,
            seed: 1,
        }
    }
}

/// How long, and how often it is looked at.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(rename = "Run")]
#[serde(deny_unknown_fields, default)]
pub struct RunConfig {
    /// Simulated time \[s\].
    #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
    pub end: Option<f64>,
    /// Samples of every probe, beside the one at the start.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub samples: u32,
    /// Moments in the recording, beside the start.
    #[schemars(range(min = 1, max = 10_000))]
    pub frames: u32,
    /// What colours the points there.
    pub colour: Colour,
    /// How it must end.
    pub ends: Ends,
}

/// How a run ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ends {
    /// At its end.
    #[default]
    Ok,
    /// Energy appears from nowhere.
    Unstable,
    /// A number stops being one.
    Nan,
    /// It is not for the solver.
    Refused,
    /// The body cannot be made.
    Geometry,
}

impl Default for RunConfig {
    fn default() -> Self {
        Self { end: None, samples: 200, frames: 20, colour: Colour::Damage, ends: Ends::Ok }
    }
}

/// Another body. It may touch the others where it starts, not overlap them.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Body")]
#[serde(deny_unknown_fields)]
pub struct BodyConfig {
    /// Its shape.
    pub shape: Shape,
    /// Where the origin of the shape lies in the specimen's frame \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// How it is turned there.
    #[serde(default)]
    pub rotation: Rotation,
}

/// A part of another material. Scatter, weak planes and layers are those of the whole.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(rename = "Zone")]
#[serde(deny_unknown_fields)]
pub struct ZoneConfig {
    /// Name of the region that it acts on.
    pub region: String,
    /// What it is made of.
    pub material: Material,
}

/// A part that is stronger, weaker or damaged.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Patch")]
#[serde(deny_unknown_fields)]
pub struct PatchConfig {
    /// Name of the region that it acts on.
    pub region: String,
    /// Strength over the material's \[1\].
    #[serde(default = "one")]
    #[schemars(schema_with = "unit::ratio", extend("exclusiveMinimum" = 0, "maximum" = 1e9))]
    pub strength: f64,
    /// Damage at the start \[1\].
    #[serde(default)]
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub damage: f64,
}

const fn one() -> f64 {
    1.0
}

/// A crack without width: the part of a plane that lies in a region.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Notch")]
#[serde(deny_unknown_fields)]
pub struct NotchConfig {
    /// A point of the plane \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub point: [f64; 3],
    /// Its normal; need not have length 1.
    pub normal: [f64; 3],
    /// Where of the plane.
    #[serde(default = "all")]
    pub region: String,
}

fn all() -> String {
    "all".to_owned()
}

/// A part cut out of the specimen.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Slot")]
#[serde(deny_unknown_fields)]
pub struct SlotConfig {
    /// Its shape.
    pub shape: Shape,
    /// Where the origin of the shape lies in the specimen's frame \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub position: [f64; 3],
    /// How it is turned there.
    #[serde(default)]
    pub rotation: Rotation,
}

/// A plane that stands for the other half of the specimen. It must lie on nodes of the grid.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Symmetry {
    /// Its normal.
    pub axis: Axis,
    /// Where along it \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length")]
    pub at: f64,
}

/// How a part moves at the start: `velocity + spin × (x − centre) + gradient (x − centre) + noise`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Start")]
#[serde(deny_unknown_fields, default)]
pub struct StartConfig {
    /// Name of the region that it acts on.
    pub region: String,
    /// Velocity \[m/s\].
    #[schemars(schema_with = "unit::velocity3")]
    pub velocity: [f64; 3],
    /// Angular velocity \[rad/s\].
    #[schemars(schema_with = "unit::angular_velocity3")]
    pub spin: [f64; 3],
    /// Rows of the velocity's gradient \[1/s\].
    pub gradient: [[f64; 3]; 3],
    /// Where spin and gradient give nothing \[m\].
    #[schemars(schema_with = "unit::length3")]
    pub centre: [f64; 3],
    /// Greatest size of a random velocity of each point, by component \[m/s\].
    #[schemars(schema_with = "unit::velocity", extend("minimum" = 0))]
    pub noise: f64,
}

impl Default for StartConfig {
    fn default() -> Self {
        Self {
            region: all(),
            velocity: [0.0; 3],
            spin: [0.0; 3],
            gradient: [[0.0; 3]; 3],
            centre: [0.0; 3],
            noise: 0.0,
        }
    }
}

/// How a load or velocity goes with time: a factor.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Course")]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum AmplitudeConfig {
    /// 1 from the start.
    #[default]
    Constant,
    /// From 0 to 1 in a straight line, then 1.
    Ramp {
        /// How long that takes \[s\].
        #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
        rise: f64,
    },
    /// 1 between two moments, else 0.
    Step {
        /// First moment \[s\].
        #[serde(default)]
        #[schemars(schema_with = "unit::time", extend("minimum" = 0))]
        from: f64,
        /// Last moment \[s\].
        #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
        until: f64,
    },
    /// Half a sine, then 0.
    HalfSine {
        /// When it begins \[s\].
        #[serde(default)]
        #[schemars(schema_with = "unit::time", extend("minimum" = 0))]
        from: f64,
        /// How long it lasts \[s\].
        #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0))]
        duration: f64,
    },
    /// Straight lines between rows.
    Table {
        /// Ascending; two equal ones are a jump \[s\].
        #[schemars(schema_with = "unit::times")]
        times: Vec<f64>,
        /// As many factors.
        factors: Vec<f64>,
    },
}

/// Nodes whose velocity is given. They are the nodes in the region and those outside the specimen
/// beyond it.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Support")]
#[serde(deny_unknown_fields)]
pub struct SupportConfig {
    /// What probes call it.
    pub name: String,
    /// Name of the region that it acts on.
    pub region: String,
    /// Along which axes of the specimen: some of x, y, z.
    #[serde(default = "xyz")]
    pub axes: String,
    /// Velocity \[m/s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::velocity3")]
    pub velocity: [f64; 3],
    /// Rows of its gradient by place \[1/s\].
    #[serde(default)]
    pub gradient: [[f64; 3]; 3],
    /// Where the gradient gives nothing \[m\].
    #[serde(default)]
    #[schemars(schema_with = "unit::length3")]
    pub centre: [f64; 3],
    /// Its course.
    #[serde(default)]
    pub time: AmplitudeConfig,
    /// When it lets go \[s\].
    #[serde(default)]
    #[schemars(schema_with = "unit::time", extend("minimum" = 0))]
    pub until: Option<f64>,
}

fn xyz() -> String {
    "xyz".to_owned()
}

/// A load: one of `traction`, `pressure`, `force`, `acceleration`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Load")]
#[serde(deny_unknown_fields)]
pub struct LoadConfig {
    /// What probes call it.
    pub name: String,
    /// Name of the region that it acts on.
    pub region: String,
    /// On the surface in the region \[Pa\].
    #[serde(default)]
    #[schemars(schema_with = "unit::pressure3")]
    pub traction: Option<[f64; 3]>,
    /// On the surface in the region, into the body \[Pa\].
    #[serde(default)]
    #[schemars(schema_with = "unit::pressure")]
    pub pressure: Option<f64>,
    /// On all of the region together, spread by mass \[N\].
    #[serde(default)]
    #[schemars(schema_with = "unit::force3")]
    pub force: Option<[f64; 3]>,
    /// On all mass of the region \[m/s²\].
    #[serde(default)]
    #[schemars(schema_with = "unit::acceleration3")]
    pub acceleration: Option<[f64; 3]>,
    /// Its course.
    #[serde(default)]
    pub time: AmplitudeConfig,
}
