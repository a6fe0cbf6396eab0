//! Examples of the tables of a sheet.

pub(super) const SHEET: &str = r#"[[material]]
name = "paper"
density = 300
young = "50 MPa"
poisson = 0.333
strength = "2 MPa"
fracture_energy = 800

[[sheet]]
name = "towel"
material = "paper"
size = ["20 cm", "24 cm"]
thickness = "0.15 mm"
notches = [[[0, "12 cm"], [0, "11 cm"]]]
"#;

pub(super) const SHEET_PATCH: &str = r#"[[sheet]]
name = "flag"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"
grip = [
    { patch = { low = ["-10 cm", "-12 cm"], high = ["-9 cm", "12 cm"] } },
    { patch = { centre = ["10 cm", "12 cm"], radius = "2 cm" } },
]
"#;

pub(super) const SHEET_GRIP: &str = r#"[[sheet]]
name = "pulled"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"
grip = [
    { patch = { centre = [0, "12 cm"], radius = "2 cm" }, velocity = [0, 0, 1], until = "0.2 s" },
]
"#;

pub(super) const SHEET_PATH: &str = r#"[[sheet]]
name = "led"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"

[[sheet.grip]]
patch = { centre = [0, "12 cm"], radius = "2 cm" }
path = [{ time = 0, offset = [0, 0, 0] }, { time = "0.5 s", offset = [0, 0, "10 cm"] }]
"#;

pub(super) const SHEET_AIR: &str = r#"[[sheet]]
name = "curtain"
material = "pmma"
size = [1, 1.5]
thickness = "1 mm"
air = { wind = [2, 0, 0], gusts = 0.5, gust_rate = "2 Hz" }
"#;

pub(super) const SHEET_DIFFUSION: &str = r#"[[sheet]]
name = "sponge cloth"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"

[sheet.diffusion]
diffusivity = [1e-6, 1e-6]
expansion = [0.01, 0.01]
stiffness = [[0, 1], [1, 0.4]]
toughness = [[0, 1], [1, 0.12]]
source = [{ patch = { centre = [0, 0], radius = "2 cm" }, value = 1 }]

[[body]]
name = "iron"
shape = { kind = "box", size = ["10 cm", "20 cm", "2 cm"] }
position = [0, 0, "5 cm"]
material = "steel"

[[sheet]]
name = "damp towel"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"

[[sheet.diffusion]]
name = "water"
diffusivity = [1e-6, 1e-6]
start = 1
stiffness = [[0, 1], [1, 0.4]]
source = [{ body = "iron", film = 2e-4, towards = 0 }]

[[sheet.diffusion]]
name = "heat"
show = true
diffusivity = [1e-7, 1e-7]
toughness = [[0, 1], [180, 0.7]]
source = [{ body = "iron", film = 5e-4, towards = 180 }]
"#;

pub(super) const SHEET_INFLOW: &str = r#"[[sheet]]
name = "heated"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"
diffusion = { source = [
    { patch = { centre = [0, 0], radius = "2 cm" }, from = "0.1 s", film = 1e-4, towards = 1 },
] }
"#;

pub(super) const SHEET_PACE: &str = r#"[[sheet]]
name = "drape"
material = "pmma"
size = ["20 cm", "24 cm"]
thickness = "1 mm"
pace = { softer = "800 m/s" }
"#;
