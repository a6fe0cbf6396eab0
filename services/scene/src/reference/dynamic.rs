//! Examples of the tables of a dynamic body.

pub(super) const DYNAMICS: &str = r#"[[material]]
name = "jelly"
density = 1000
young = "30 kPa"
poisson = 0.3
strength = "5 kPa"
fracture_energy = 10

[[body]]
name = "jelly"
material = "jelly"
solver = "peridynamics"
shape = { kind = "box", size = ["20 cm", "10 cm", "10 cm"] }
position = [0, 0, "10 cm"]

[body.dynamic]
damping = 0.05
cuts = [[[0, -1, 0], [0, 1, 0], [0, 1, 1], [0, -1, 1]]]
"#;

pub(super) const BODY_PART: &str = r#"[[material]]
name = "foam"
density = 100
young = "100 kPa"
poisson = 0.2
strength = "20 kPa"
fracture_energy = 50

[[body]]
name = "bar"
material = "foam"
solver = "peridynamics"
shape = { kind = "box", size = ["40 cm", "5 cm", "5 cm"] }

[body.dynamic]
grip = [
    { region = { low = [-1, -1, -1], high = ["-18 cm", 1, 1] } },
    { region = { centre = ["20 cm", 0, 0], radius = "4 cm" }, velocity = [0, 0, "0.5 m/s"] },
]
"#;

pub(super) const SOFT_GRIP: &str = r#"[[material]]
name = "foam"
density = 100
young = "100 kPa"
poisson = 0.2
strength = "20 kPa"
fracture_energy = 50

[[body]]
name = "twisted"
material = "foam"
solver = "peridynamics"
shape = { kind = "box", size = ["40 cm", "5 cm", "5 cm"] }

[[body.dynamic.grip]]
region = { low = [-1, -1, -1], high = ["-18 cm", 1, 1] }

[[body.dynamic.grip]]
region = { low = ["18 cm", -1, -1], high = [1, 1, 1] }
turn = ["90 deg/s", 0, 0]
path = [{ time = 0, offset = [0, 0, 0] }, { time = "1 s", offset = [0, 0, 0] }]
until = "2 s"
"#;
