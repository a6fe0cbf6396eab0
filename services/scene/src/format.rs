//! The scene file as it is written: plain data, the one source of the reader, of the schema and of
//! the reference in `docs/scene.md`.
//!
//! Numbers are SI when they arrive here: `check` has turned "6 mm" into 0.006 by the units in it.
//! Each description has its unit in brackets, `[1]` for counts and ratios; `x-default` says what
//! holds without a key whose default is no plain value.

mod body;
mod bonds;
mod directed;
mod dynamic;
mod fidelity;
mod generator;
mod hit;
mod interior;
mod material;
mod pieces;
mod plasticity;
mod rotation;
mod shape;
mod sheet;
mod show;
mod treatment;

pub use body::{Anchor, Body, ObjectsChoice, RepairChoice, Resolution};
pub use bonds::{BondAxis, BondNumbers};
pub use directed::{
    BodyAnimation, FieldEntry, FieldForm, GlueEntry, JointEntry, JointForm, KeyframeCurve,
    PoseKeyframe, ShapePart, WorldBounds,
};
pub use dynamic::{BodyPart, Dynamics, SoftGrip};
pub use fidelity::Fidelity;
pub use generator::{GivenPlace, Grid, Instances, Scatter, Stack};
pub use hit::HitEntry;
pub use interior::Interior;
pub use material::{Channel, Layers, Material, Paint, WeakPlane};
pub(crate) use material::{DEFAULT_FRICTION, DEFAULT_RESTITUTION, DEFAULT_WEIBULL};
pub use pieces::WantedPieces;
pub use plasticity::{HeatSoftening, Plasticity};
pub use rotation::{Axis, Rotation};
pub use shape::Shape;
pub use sheet::{
    Air, Coupling, Diffusion, Diffusions, Grip, GripPlace, SheetBody, SheetInflow, SheetLaw,
    SheetPatch, WavePace,
};
pub use show::{Bounds, Expect, RecordingSettings, ShareBounds, View};
pub use treatment::{GlassTreatment, InterlayerFilm};

use super::surface_detail::Detail;
use cullet_document::unit;
use cullet_plan::family::{DEFAULT, FAMILIES, SAMPLED};
use schemars::{JsonSchema, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// A scene file: which bodies there are, how they move, how they break, and what a run must show.
/// A scene has at least one body or sheet.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
pub struct Document {
    /// What the scene shows, in one line.
    pub description: String,
    /// Other scene files to read before this one; paths are relative to this file. Lists such as
    /// `[[body]]` are joined, those of included files first; for other keys this file's value
    /// replaces theirs. Included files may include more, up to 8 files deep; all together have at
    /// most 256 files and 16 MiB, a file that is included twice counted twice.
    #[schemars(length(max = 64))]
    pub include: Vec<String>,
    /// The simulation of rigid bodies: gravity, time and limits.
    pub world: World,
    /// How bodies are broken.
    pub fracture: Fracture,
    /// How accurate fracture solves must be, and what they may cost.
    pub fidelity: Fidelity,
    /// Materials of this scene, beside the presets.
    pub material: Vec<Material>,
    /// Single bodies, each with its own name.
    pub body: Vec<Body>,
    /// Equal bodies in rows, columns and layers.
    pub grid: Vec<Grid>,
    /// Equal bodies on top of one another.
    pub stack: Vec<Stack>,
    /// Equal bodies at random places in a box.
    pub scatter: Vec<Scatter>,
    /// Many equal bodies at given places.
    pub instances: Vec<Instances>,
    /// Thin sheets that move and tear for as long as the run lasts.
    pub sheet: Vec<SheetBody>,
    /// What holds two bodies together: at most 10000 joints.
    #[schemars(length(max = 10_000))]
    pub joint: Vec<JointEntry>,
    /// Bodies that stick together where they touch: at most 256 entries.
    #[schemars(length(max = 256))]
    pub glue: Vec<GlueEntry>,
    /// What acts on bodies from afar: at most 64 fields.
    #[schemars(length(max = 64))]
    pub field: Vec<FieldEntry>,
    /// Hits that are solved with settings of their own: at most 1000.
    #[schemars(length(max = 1000))]
    pub hit: Vec<HitEntry>,
    /// What a run of the scene must show.
    pub expect: Expect,
    /// What the recording of a run holds beside what decides the run.
    pub recording: RecordingSettings,
    /// The camera and time window of the preview pictures.
    #[schemars(extend("x-default" = "a camera that shows the bodies that break"))]
    pub view: Option<View>,
}

/// The simulation of rigid bodies: gravity, time and limits.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct World {
    /// Acceleration of gravity \[m/s²\]; z points up. Its length is at most 10000 m/s².
    #[schemars(schema_with = "unit::acceleration3")]
    pub gravity: [f64; 3],
    /// Time step of the rigid bodies \[s\]; fracture solves choose their own. A run takes at most
    /// 1e7 steps.
    #[schemars(schema_with = "unit::time", extend("minimum" = 1e-6, "maximum" = 0.05))]
    pub step: f64,
    /// Simulated time \[s\], at least one `step`.
    #[schemars(schema_with = "unit::time", extend("exclusiveMinimum" = 0, "maximum" = 600))]
    pub duration: f64,
    /// Seed of everything random \[1\]. The same scene with the same seed gives the same result,
    /// bit for bit.
    #[schemars(range(max = 9_223_372_036_854_775_807_u64))]
    pub seed: u64,
    /// Time steps between a hit and the appearance of its fragments \[1\]. With 0 the world waits
    /// for the solver, which is exact; otherwise it moves on in the meantime.
    #[schemars(range(max = 100_000))]
    pub latency_steps: u32,
    /// Least impulse of a hit that can break a body \[N·s\]. A body can have a threshold of its
    /// own.
    #[schemars(schema_with = "unit::impulse", extend("minimum" = 0))]
    pub impulse_threshold: f64,
    /// Most bodies in the world at once, fragments included \[1\]. A body whose fragments would
    /// exceed it does not break. At least the number of bodies in the scene.
    #[schemars(range(min = 1, max = 100_000))]
    pub max_bodies: u32,
    /// Generation from which on bodies do not break \[1\]. Bodies of the scene have generation 0,
    /// their fragments 1, the fragments of those 2. With 0 nothing breaks.
    #[schemars(range(max = 16))]
    pub max_generation: u32,
    /// Which fragments can break again, by their size.
    pub tiers: Tiers,
    /// The box outside of which bodies are removed.
    #[schemars(extend("x-default" = "bodies stay wherever they go"))]
    pub bounds: Option<WorldBounds>,
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
            bounds: None,
        }
    }
}

/// Size classes of fragments, by their share of the volume of the scene's body that they come from.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tiers {
    /// Fragments below this share of the volume cannot break, and collide as one convex hull \[1\].
    /// At most `small`.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub tiny: f64,
    /// Fragments below this share of the volume cannot break \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.98))]
    pub small: f64,
}

impl Default for Tiers {
    fn default() -> Self {
        Self { tiny: 0.01, small: 0.1 }
    }
}

/// Which solver family breaks a body: `auto`, or the name of a family.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(transparent)]
pub struct SolverChoice(String);

/// Leaves the choice to Cullet.
const AUTO: &str = "auto";

impl Default for SolverChoice {
    fn default() -> Self {
        Self(AUTO.to_owned())
    }
}

impl SolverChoice {
    /// The family asked for by name; nothing where Cullet chooses.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        (self.0 != AUTO).then_some(self.0.as_str())
    }
}

/// The names are those of [`cullet_plan::family::FAMILIES`], each with what it is.
impl JsonSchema for SolverChoice {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SolverChoice".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let about = format!(
            "Cullet chooses: `{DEFAULT}`, or `{SAMPLED}` where a hit needs no stress field."
        );
        let families = FAMILIES.iter().map(|family| (family.name, family.about));
        let rows = [(AUTO, about.as_str())].into_iter().chain(families);
        let rows = rows
            .map(|(name, about)| json!({"description": about, "type": "string", "const": name}));
        let rows: Vec<_> = rows.collect();
        json_schema!({"description": "Which solver family breaks a body.", "oneOf": rows})
    }
}

/// Floating-point precision of the material points of a solve; its grid nodes keep f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// 64 bits (f64).
    #[default]
    Double,
    /// 32 bits (f32): faster.
    Single,
}

/// How bodies are broken, unless a body says otherwise.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fracture {
    /// Which solver family breaks bodies.
    pub solver: SolverChoice,
    /// Most material points of one solve \[1\]: more resolve finer cracks and take longer.
    #[schemars(range(min = 64, max = 50_000_000))]
    pub max_particles: u32,
    /// Most time steps of one solve \[1\]. A hit that needs more is left to `geometric`.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub max_steps: u32,
    /// Most fragments that one body breaks into \[1\].
    #[schemars(range(min = 2, max = 100_000))]
    pub max_fragments: u32,
    /// Fragments below this share of the body's volume are merged into a neighbour \[1\].
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.5))]
    pub min_volume_ratio: f64,
    /// Detail of crack faces that is finer than the grid of the solve.
    pub detail: Detail,
    /// Parts below this share of the body's volume become debris \[1\]: grains that fly, are
    /// recorded and drawn, and collide with nothing. With 0 there is no debris.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.1))]
    pub debris: f64,
    /// Median grain size of debris by mass \[m\]: larger grains hold half of it.
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "half the grid spacing")
    )]
    pub grain: Option<f64>,
    /// Floating-point precision of the material points of a solve.
    #[schemars(extend("x-default" = "double, or single where `fidelity.error` is given"))]
    pub precision: Option<Precision>,
}

impl Default for Fracture {
    fn default() -> Self {
        Self {
            solver: SolverChoice::default(),
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
