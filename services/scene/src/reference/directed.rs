//! Examples of what directs a shot.

pub(super) const KEYFRAME: &str = r#"[[body]]
name = "pendulum"
shape = { kind = "sphere", radius = "20 cm" }
material = "steel"
interpolation = "smooth"
keyframes = [
    { at = 0, position = [-2, 0, 5] },
    { at = "0.5 s", position = [0, 0, 4.5] },
    { at = "1 s", position = [2, 0, 5], rotation = { axis = [0, 1, 0], degrees = 40 } },
]
"#;

pub(super) const ANIMATION: &str = r#"[[body]]
name = "arm"
shape = { kind = "box", size = ["1 m", "20 cm", "20 cm"] }
position = [0, 0, 3]
material = "steel"
animation = { file = "arm.glb", name = "Swing", node = "arm", start = "0.2 s" }
"#;

pub(super) const PART: &str = r#"[[body]]
name = "mug"
material = "stoneware"
position = [0, 0, 1]
parts = [
    { shape = { kind = "lathe", wall = "5 mm", profile = [
        [0, 0], [0.038, 0], [0.04, 0.05], [0.04, 0.095],
    ] } },
    { shape = { kind = "extrusion", height = "8 mm", polygon = [
        [0.036, 0.02], [0.07, 0.03], [0.07, 0.07], [0.036, 0.08],
        [0.036, 0.072], [0.062, 0.064], [0.062, 0.036], [0.036, 0.028],
    ] }, rotation = { axis = [1, 0, 0], degrees = 90 } },
]
"#;

pub(super) const JOINT: &str = r#"[[body]]
name = "ball"
shape = { kind = "sphere", radius = "10 cm" }
position = [2, 0, 4]
material = "steel"

[[body]]
name = "door"
shape = { kind = "box", size = [1, "4 cm", 2] }
position = [-3, 0, 3]
material = "granite"

[[joint]]
kind = "rope"
between = ["world", "ball"]
at = [0, 0, 5]
force = "20 kN"

[[joint]]
kind = "hinge"
between = ["door", "world"]
at = [-3.5, 0, 3]
axis = [0, 0, 1]
force = "5 kN"
torque = "1.2 kN m"
"#;

pub(super) const GLUE: &str = r#"[[stack]]
name = "block"
count = 4
offset = [0, 0, "20.5 cm"]

[stack.body]
shape = { kind = "box", size = ["40 cm", "20 cm", "20 cm"] }
position = [2, 0, "11 cm"]
material = "concrete"

[[glue]]
bodies = ["block"]
tensile = "0.2 MPa"
shear = "0.4 MPa"
gap = "1 cm"
"#;

pub(super) const FIELD: &str = r#"[[scatter]]
name = "leaf"
count = 20
min = [-2, -2, 1]
max = [2, 2, 3]

[scatter.body]
shape = { kind = "box", size = ["6 cm", "4 cm", "2 mm"] }
material = "porcelain"
group = "light"

[[field]]
kind = "wind"
velocity = [8, 0, 0]
bodies = ["light"]

[[field]]
kind = "turbulence"
strength = "3 m/s2"
size = "50 cm"
rate = 2
bodies = ["light"]

[[field]]
kind = "attractor"
point = [0, 0, 4]
strength = "2 m/s2"

[[field]]
kind = "kill"
point = [0, 0, -2]
normal = [0, 0, 1]
"#;

pub(super) const WORLD_BOUNDS: &str = r#"[world]
bounds = { min = [-20, -20, -1], max = [20, 20, 30] }
"#;

pub(super) const HIT: &str = r#"[[body]]
name = "jar"
shape = { kind = "cylinder", radius = "6 cm", height = "20 cm" }
position = [2, 0, "1.5 m"]
material = "stoneware"

[[hit]]
body = "jar"
at = "0.5 s"
seed = 5
particles = 40000
"#;

pub(super) const WANTED_PIECES: &str = r#"[[body]]
name = "urn"
shape = { kind = "lathe", wall = "8 mm", profile = [
    [0, 0], [0.05, 0], [0.07, 0.025], [0.085, 0.065], [0.073, 0.135], [0.068, 0.172],
] }
position = [0, 0, 1]
material = "stoneware"

[body.pieces]
count = 24
guides = [["81 mm", 0, "65 mm"], ["-81 mm", 0, "65 mm"]]
whole = [{ low = ["-6 cm", "-6 cm", 0], high = ["6 cm", "6 cm", "1 cm"] }]
"#;

pub(super) const INTERIOR: &str = r#"[[body]]
name = "glazed"
shape = { kind = "sphere", radius = "5 cm" }
position = [0, 0, 1]
material = "brick"
interior = { colour = [0.72, 0.33, 0.2], roughness = 1 }
"#;
