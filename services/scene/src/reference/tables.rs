//! The tables of a scene file: their headings on the page, their keys in order, and an example of
//! each.

use super::directed::{
    ANIMATION, FIELD, GLUE, HIT, INTERIOR, JOINT, KEYFRAME, PART, WANTED_PIECES, WORLD_BOUNDS,
};
use super::dynamic::{BODY_PART, DYNAMICS, SOFT_GRIP};
use super::keys::keys_of;
use super::sheets::{
    SHEET, SHEET_AIR, SHEET_DIFFUSION, SHEET_GRIP, SHEET_INFLOW, SHEET_PACE, SHEET_PATCH,
    SHEET_PATH,
};
use crate::format::{
    Air, Body, BodyAnimation, BodyPart, BondAxis, BondNumbers, Bounds, Diffusion, Document,
    Dynamics, Expect, Fidelity, FieldEntry, Fracture, GivenPlace, GlueEntry, Grid, Grip, GripPlace,
    HeatSoftening, HitEntry, Instances, Interior, InterlayerFilm, JointEntry, Layers, Material,
    Paint, Plasticity, PoseKeyframe, RecordingSettings, Resolution, Rotation, Scatter, Shape,
    ShapePart, ShareBounds, SheetBody, SheetInflow, SheetPatch, SoftGrip, Stack, Tiers, View,
    WantedPieces, WavePace, WeakPlane, World, WorldBounds,
};
use crate::surface_detail::Detail;

/// A type of the schema that is written as a table.
pub(super) struct Table {
    /// Its name in the schema.
    pub(super) name: &'static str,
    /// What the page calls it.
    pub(super) heading: &'static str,
    /// Its keys in order; of a table of several kinds, those of a kind.
    pub(super) keys: fn(Option<&str>) -> Vec<&'static str>,
    /// Each kind with an example, which is lines of a body; a table of one kind has one example, a
    /// part of a scene file.
    pub(super) examples: &'static [(&'static str, &'static str)],
}

/// The table of that name in the schema.
pub(super) fn table(name: &str) -> Option<&'static Table> {
    TABLES.iter().find(|table| table.name == name)
}

macro_rules! tables {
    ($($type:ident, $heading:literal, $examples:expr;)*) => {
        &[$(Table {
            name: stringify!($type),
            heading: $heading,
            keys: keys_of::<$type>,
            examples: $examples,
        },)*]
    };
}

/// All of them; the page has them in the order of the types.
pub(super) const TABLES: &[Table] = tables! {
    Document, "Top of the file", &[("", DOCUMENT)];
    World, "`[world]`", &[("", WORLD)];
    Tiers, "`[world.tiers]`", &[("", TIERS)];
    WorldBounds, "`bounds` of the world", &[("", WORLD_BOUNDS)];
    Fracture, "`[fracture]`", &[("", FRACTURE)];
    Detail, "`[fracture.detail]`", &[("", DETAIL)];
    Fidelity, "`[fidelity]`", &[("", FIDELITY)];
    Material, "`[[material]]`", &[("", MATERIAL)];
    WeakPlane, "`weak_plane` of a material", &[("", WEAK_PLANE)];
    Layers, "`layers` of a material", &[("", LAYERS)];
    InterlayerFilm, "`interlayer` of a material", &[("", INTERLAYER)];
    Plasticity, "`plasticity` of a material", &[("", PLASTICITY)];
    HeatSoftening, "`softening` of `plasticity`", &[("", SOFTENING)];
    BondNumbers, "`peridynamics` of a material", &[("", BONDS)];
    BondAxis, "`grain` of bonds", &[("", GRAIN)];
    SheetBody, "`[[sheet]]`", &[("", SHEET)];
    SheetPatch, "`patch` of a sheet", &[("", SHEET_PATCH)];
    Grip, "`grip` of a sheet", &[("", SHEET_GRIP)];
    GripPlace, "`path` of a grip", &[("", SHEET_PATH)];
    Air, "`air` of a sheet", &[("", SHEET_AIR)];
    Diffusion, "`diffusion` of a sheet", &[("", SHEET_DIFFUSION)];
    SheetInflow, "`source` of `diffusion`", &[("", SHEET_INFLOW)];
    WavePace, "`pace` of a sheet", &[("", SHEET_PACE)];
    Body, "`[[body]]`", &[("", BODY)];
    Shape, "`shape` of a body", SHAPES;
    ShapePart, "`parts` of a body", &[("", PART)];
    PoseKeyframe, "`keyframes` of a body", &[("", KEYFRAME)];
    BodyAnimation, "`animation` of a body", &[("", ANIMATION)];
    Rotation, "`rotation` of a body", &[("", ROTATION)];
    Resolution, "`resolution` of a body", &[("", RESOLUTION)];
    Paint, "`paint` of a body", PAINTS;
    Interior, "`interior` of a body", &[("", INTERIOR)];
    WantedPieces, "`pieces` of a body", &[("", WANTED_PIECES)];
    BodyPart, "Part of a body", &[("", BODY_PART)];
    Dynamics, "`dynamic` of a body", &[("", DYNAMICS)];
    SoftGrip, "`grip` of a dynamic body", &[("", SOFT_GRIP)];
    Grid, "`[[grid]]`", &[("", GRID)];
    Stack, "`[[stack]]`", &[("", STACK)];
    Scatter, "`[[scatter]]`", &[("", SCATTER)];
    Instances, "`[[instances]]`", &[("", INSTANCES)];
    GivenPlace, "`places` of instances", &[("", PLACE)];
    JointEntry, "`[[joint]]`", &[("", JOINT)];
    GlueEntry, "`[[glue]]`", &[("", GLUE)];
    FieldEntry, "`[[field]]`", &[("", FIELD)];
    HitEntry, "`[[hit]]`", &[("", HIT)];
    Expect, "`[expect]`", &[("", EXPECT)];
    Bounds, "Range of a count", &[("", BOUNDS)];
    ShareBounds, "Range of a share", &[("", SHARE_BOUNDS)];
    RecordingSettings, "`[recording]`", &[("", RECORDING)];
    View, "`[view]`", &[("", VIEW)];
};

const DOCUMENT: &str = r#"description = "A porcelain vase falls onto a stone floor."
include = ["floor.toml"]
"#;

const WORLD: &str = r#"[world]
gravity = [0, 0, -9.81]
step = "1/480 s"
duration = "1.5 s"
seed = 7
impulse_threshold = "0.5 N s"
max_generation = 2
"#;

const TIERS: &str = r#"[world.tiers]
tiny = 0.02
small = "15 %"
"#;

const FRACTURE: &str = r#"[fracture]
solver = "brittle"
max_particles = 50000
max_fragments = 200
debris = 0.001
grain = "1 mm"
"#;

const DETAIL: &str = r#"[fracture.detail]
look = "glass"
ribs = 0.3
hairline = "0.2 mm"
"#;

const FIDELITY: &str = r#"[fidelity]
error = "30 %"
budget_s = "20 s"
smallest = "8 mm"
"#;

const MATERIAL: &str = r#"[[material]]
name = "weak plaster"
preset = "plaster"
strength = "1 MPa"

[[material]]
name = "sandstone"
density = "2.2 g/cm3"
young = "15 GPa"
poisson = 0.2
strength = "3 MPa"
fracture_energy = "30 J/m2"
weibull = 12
"#;

const WEAK_PLANE: &str = r#"[[material]]
name = "slate"
preset = "limestone"
weak_plane = { normal = [0, 0, 1], ratio = 0.2 }
"#;

const INTERLAYER: &str = r#"[[material]]
name = "windscreen"
preset = "laminated-glass"
interlayer = { thickness = "1.52 mm", strength = "20 MPa", stretch = 2 }

[[material]]
name = "door"
preset = "soda-lime-glass"
treatment = "toughened"
surface_stress = "110 MPa"
"#;

const PLASTICITY: &str = r#"[[material]]
name = "car body"
preset = "steel"
plasticity = { yield_stress = "180 MPa", hardening = "400 MPa", exponent = 0.45 }
breakable = true
"#;

const SOFTENING: &str = r#"[[material]]
name = "armour"
preset = "steel"
breakable = true

[material.plasticity]
yield_stress = "792 MPa"
hardening = "510 MPa"
exponent = 0.26
rate = 0.014
softening = { melting = 1500, exponent = 1.03, heat_capacity = 477 }
failure = [0.05, 3.44, -2.12, 0.002, 0.61]
"#;

const BONDS: &str = r#"[[material]]
name = "hard alloy"
preset = "aluminium-6061"
peridynamics = { dust = 0.5, max_plastic_stretch = 0.15, failure = [0.1, 0.5, -1.5] }
"#;

const GRAIN: &str = r#"[[material]]
name = "fibrous"
preset = "limestone"
peridynamics = { grain = { axis = [1, 0, 0], strength = 3, softness = 0.8 } }
"#;

const LAYERS: &str = r#"[[material]]
name = "banded granite"
preset = "granite"
layers = { normal = [0, 0, 1], thickness = "2 cm", ratio = 0.5, jitter = 0.3 }
"#;

const BODY: &str = r#"[[body]]
name = "plate"
shape = { kind = "box", size = ["20 cm", "20 cm", "6 mm"] }
anchor = "base"
position = [0, 0, "1 m"]
velocity = [0, 0, "-18 km/h"]
spin = ["60 rpm", 0, 0]
material = "soda-lime-glass"
impulse_threshold = "0.05 N s"

[[body]]
name = "figure"
mesh = "figure.obj"
fit = "20 cm"
position = [1, 0, "5 cm"]
material = "plaster"
"#;

const SHAPES: &[(&str, &str)] = &[
    (
        "box",
        r#"shape = { kind = "box", size = ["20 cm", "10 cm", "6 mm"] }
"#,
    ),
    (
        "sphere",
        r#"shape = { kind = "sphere", radius = "25 mm", segments = 48 }
"#,
    ),
    (
        "cylinder",
        r#"shape = { kind = "cylinder", radius = "5 cm", height = "1 m" }
"#,
    ),
    (
        "cone",
        r#"shape = { kind = "cone", radius = "10 cm", top_radius = "4 cm", height = "30 cm" }
"#,
    ),
    (
        "torus",
        r#"shape = { kind = "torus", ring_radius = "10 cm", tube_radius = "2 cm" }
"#,
    ),
    (
        "capsule",
        r#"shape = { kind = "capsule", radius = "2 cm", length = "10 cm" }
"#,
    ),
    (
        "extrusion",
        r#"shape = { kind = "extrusion", height = "3 cm", polygon = [
    [0, 0], ["20 cm", 0], ["20 cm", "4 cm"], ["4 cm", "4 cm"], ["4 cm", "20 cm"], [0, "20 cm"],
] }
"#,
    ),
    (
        "lathe",
        r#"shape = { kind = "lathe", wall = "8 mm", profile = [
    [0, 0], [0.05, 0], [0.07, 0.025], [0.085, 0.065], [0.073, 0.135], [0.068, 0.172],
] }
"#,
    ),
    (
        "sheet",
        r#"shape = { kind = "sheet", thickness = "4 mm", outline = [
    [0, 0], ["30 cm", 0], ["25 cm", "20 cm"], ["5 cm", "20 cm"],
] }
"#,
    ),
    (
        "shell",
        r#"shape = { kind = "shell", thickness = "4 mm", profile = [
    [0, 0], [0.03, 0], [0.055, 0.02], [0.07, 0.05], [0.075, 0.08],
] }
"#,
    ),
];

const ROTATION: &str = r#"[[body]]
name = "tilted"
shape = { kind = "box", size = ["10 cm", "5 cm", "2 cm"] }
position = [0, 0, 1]
rotation = { axis = [1, 0, 0], degrees = 25 }
material = "brick"

[[body]]
name = "turned"
shape = { kind = "box", size = ["10 cm", "5 cm", "2 cm"] }
position = [0, 0, 2]
rotation = { euler_degrees = [0, 30, 90] }
material = "brick"

[[body]]
name = "upside down"
shape = { kind = "box", size = ["10 cm", "5 cm", "2 cm"] }
position = [0, 0, 3]
rotation = { quaternion = [0, 1, 0, 0] }
material = "brick"
"#;

const RESOLUTION: &str = r#"[[body]]
name = "pane"
shape = { kind = "box", size = ["30 cm", "20 cm", "8 mm"] }
position = [0, 0, 1]
material = "soda-lime-glass"
resolution = { spacing = "2 mm" }
"#;

const PAINTS: &[(&str, &str)] = &[
    (
        "box",
        r#"paint = [
    { kind = "box", min = ["-1 cm", -1, -1], max = ["1 cm", 1, 1], factor = 0.3, edge = "5 mm" },
]
"#,
    ),
    (
        "sphere",
        r#"paint = [{ kind = "sphere", centre = [0, 0, "5 cm"], radius = "2 cm", factor = "50 %" }]
"#,
    ),
    (
        "half-space",
        r#"paint = [{ kind = "half-space", point = [0, 0, 0], normal = [0, 0, 1], factor = 3 }]
"#,
    ),
    (
        "cylinder",
        r#"paint = [
    { kind = "cylinder", from = [0, 0, -1], to = [0, 0, 1], radius = "1 cm", factor = 0.2 },
]
"#,
    ),
    (
        "line",
        r#"paint = [
    { kind = "line", points = [[-0.1, 0.02, 0.05], [0.1, 0.03, 0.05]], factor = 0.1 },
]
"#,
    ),
    (
        "corners",
        r#"mesh = "figure.obj"
fit = "20 cm"
paint = [{ kind = "corners", reach = "1 cm", file = "factors.txt" }]
"#,
    ),
];

const GRID: &str = r#"[[grid]]
name = "brick"
count = [10, 1, 6]
spacing = ["241 mm", "120 mm", "71.5 mm"]
bond = 0.5

[grid.body]
shape = { kind = "box", size = ["240 mm", "115 mm", "71 mm"] }
position = [0, 0, "36 mm"]
material = "brick"
"#;

const STACK: &str = r#"[[stack]]
name = "slab"
count = 5
offset = [0, 0, "21 mm"]
twist_degrees = 10

[stack.body]
shape = { kind = "box", size = ["20 cm", "10 cm", "20 mm"] }
position = [0, 0, "11 mm"]
material = "stoneware"
"#;

const INSTANCES: &str = r#"[[instances]]
name = "brick"
file = "places.csv"

[instances.body]
shape = { kind = "box", size = ["20 cm", "10 cm", "6 cm"] }
material = "concrete"
anchor = "base"
"#;

const PLACE: &str = r#"[[instances]]
name = "post"
places = [
    { position = [-2, 0, 0.1] },
    { position = [2, 0, 0.1], rotation = { axis = [0, 0, 1], degrees = 45 } },
    { position = [0, 3, 0.1], name = "far" },
]

[instances.body]
shape = { kind = "box", size = ["10 cm", "10 cm", 1] }
material = "granite"
anchor = "base"
"#;

const SCATTER: &str = r#"[[scatter]]
name = "pebble"
count = 40
min = [-1, -1, 0]
max = [1, 1, 1]
gap = "1 cm"
turn = true

[scatter.body]
shape = { kind = "box", size = ["10 cm", "8 cm", "6 cm"] }
material = "granite"
"#;

const EXPECT: &str = r#"[expect]
fractures = { min = 1 }
broken = ["vase"]
unbroken = ["floor"]
min_fragments_of = { vase = 3 }
mass_rel_error = 1e-9
"#;

const BOUNDS: &str = r#"[expect]
fragments = { min = 3, max = 200 }
failed = { max = 0 }
"#;

const SHARE_BOUNDS: &str = r#"[expect]
sampled_mass = { max = "5 %" }
"#;

const RECORDING: &str = r#"[recording]
drawings = false
"#;

const VIEW: &str = r#"[view]
eye = [0.7, -0.9, 0.55]
target = [0, 0, 0.1]
field = "40 deg"
start = "0.2 s"
end = "0.8 s"
"#;
