//! The shipped scenes load; bad files give every error with its place; overrides and bundles hold.

mod advice;
pub(crate) mod animation;
mod assembled;
mod bonds;
mod directed;
mod draft;
mod dynamic;
mod many;
mod objects;
mod pieces;
mod places;
mod plasticity;
mod sheets;
mod surface;
mod treatment;
mod walls;

use super::{Scene, load, load_bundle, schema};
use cullet_document::SceneErrors;
use cullet_document::files::{Bundle, SceneFile};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const SHIPPED: [&str; 47] = [
    "pot",
    "vases",
    "four-shapes",
    "bullet",
    "pair",
    "threshold",
    "column",
    "wall",
    "pane",
    "bottle",
    "bowl",
    "shower",
    "windscreen",
    "lid",
    "can",
    "bell",
    "dent",
    "lead-soldier",
    "clay",
    "clay-pot",
    "plate",
    "panels",
    "walls",
    "window",
    "egg",
    "bulb",
    "drape",
    "towel",
    "film",
    "foil",
    "curtain",
    "two-sources",
    "seaweed",
    "quench",
    "mud",
    "jelly",
    "gummy",
    "beams",
    "cloth",
    "tube",
    "rubber",
    "garment",
    "pierced",
    "spiral",
    "mortar",
    "facade",
    "tea",
];

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn from_text(text: &str, overrides: &[&str]) -> Result<Scene, SceneErrors> {
    let bytes = Arc::new(text.as_bytes().to_vec());
    load_bundle(&Bundle {
        name: "test".to_owned(),
        main: "scene/scene.toml".to_owned(),
        overrides: overrides.iter().map(|&text| text.to_owned()).collect(),
        files: vec![SceneFile { key: "scene/scene.toml".to_owned(), bytes }],
    })
}

const SMALL: &str = r#"
[[body]]
name = "cube"
shape = { kind = "box", size = ["20 cm", "10 cm", "5 cm"] }
position = [0, 0, 1]
material = "granite"

[[body]]
name = "ball"
shape = { kind = "sphere", radius = "5 cm" }
velocity = ["36 km/h", 0, 0]
spin = ["60 rpm", 0, 0]
material = "steel"
"#;

#[test]
fn every_shipped_scene_loads() {
    for name in SHIPPED {
        let scene =
            load(&scenes().join(name), &[]).unwrap_or_else(|errors| panic!("{name}:\n{errors}"));
        assert_eq!(scene.name, name);
        assert!(!scene.description.is_empty(), "{name} says what it shows");
        assert_ne!(scene.expect, super::Expect::default(), "{name} says what it expects");
        assert_eq!(scene.warnings, Vec::<String>::new(), "{name}");
        for body in &scene.bodies {
            let moments = body.solid.mesh.mass_properties();
            assert!(moments.centroid.norm() < 1e-12, "{name}/{} is centred", body.name);
            assert!(!body.hulls.is_empty());
        }
        let again = load_bundle(&scene.bundle()).expect("a bundle of a scene loads");
        assert_eq!(again.bodies.len(), scene.bodies.len());
    }
}

#[test]
fn the_schema_in_the_tree_is_the_types() {
    let path = scenes().join("scene.schema.json");
    if std::env::var_os("CULLET_BLESS").is_some() {
        std::fs::write(&path, schema()).expect("writes");
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(written == schema(), "run `cullet schema > scenes/scene.schema.json`");
}

#[test]
fn the_wall_is_two_hundred_bricks_in_bond_that_share_one_shape() {
    let scene = load(&scenes().join("wall"), &[]).expect("loads");
    let bricks: Vec<_> =
        scene.bodies.iter().filter(|b| b.generator.as_deref() == Some("brick")).collect();
    assert_eq!(bricks.len(), 200);
    assert!(bricks.iter().all(|b| Arc::ptr_eq(&b.solid, &bricks[0].solid)));
    assert!(bricks.iter().all(|b| Arc::ptr_eq(&b.hulls, &bricks[0].hulls)));
    let half = [0.12, 0.0575, 0.0355];
    for (i, a) in bricks.iter().enumerate() {
        for b in &bricks[i + 1..] {
            let apart = a.pose.translation.vector - b.pose.translation.vector;
            let free = (0..3).any(|axis| apart[axis].abs() > 2.0 * half[axis]);
            assert!(free, "{} and {} overlap", a.name, b.name);
        }
    }
    let x = |name: &str| {
        let body = bricks.iter().find(|b| b.name == name).expect("there");
        body.pose.translation.x
    };
    assert!((x("brick-0-0-1") - x("brick-0-0-0") - 0.1205).abs() < 1e-12);
    assert!((x("brick-0-0-2") - x("brick-0-0-0")).abs() < 1e-12);
}

#[test]
fn units_become_si_and_origins_stay_where_the_file_puts_them() {
    let scene =
        from_text(SMALL, &["body.cube.rotation={axis=[0,0,1], degrees=90}"]).expect("loads");
    let (cube, ball) = (&scene.bodies[0], &scene.bodies[1]);
    assert!((cube.volume - 0.001).abs() < 1e-15);
    assert!((ball.velocity.x - 10.0).abs() < 1e-12);
    assert!((ball.spin.x - std::f64::consts::TAU).abs() < 1e-12);
    assert!(cube.breakable && !ball.breakable, "steel is a striker");
    // A cone's centroid is a quarter up from its base: the pose makes up for it.
    let shape = r#"body.cube.shape={kind="cone", radius=0.1, height=0.4}"#;
    let scene = from_text(SMALL, &[shape]).expect("loads");
    assert!((scene.bodies[0].pose.translation.z - 0.9).abs() < 1e-12);
    let scene = from_text(SMALL, &[shape, "body.cube.anchor=base"]).expect("loads");
    assert!((scene.bodies[0].pose.translation.z - 1.1).abs() < 1e-12);
}

#[test]
fn overrides_reach_every_value_by_name() {
    let overrides = [
        "world.duration=2",
        "body.ball.velocity[1]=3 m/s",
        "material.granite.young=60 GPa",
        "body.cube.solver=geometric",
        "body.cube.resolution.spacing=4 mm",
    ];
    let scene = from_text(SMALL, &overrides).expect("loads");
    assert!((scene.world.duration - 2.0).abs() < 1e-15);
    assert!((scene.bodies[1].velocity.y - 3.0).abs() < 1e-15);
    assert!((scene.bodies[0].material.young - 60e9).abs() < 1.0);
    assert!((scene.bodies[0].material.density - 2640.0).abs() < 1e-9, "the rest is the preset's");
    assert_eq!(scene.bodies[0].solver.name(), Some("geometric"));
    assert_eq!(scene.bodies[0].spacing, Some(0.004));
}

const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

#[test]
fn a_mesh_replaces_a_shape_and_fits() {
    let file = |key: &str, text: &str| SceneFile {
        key: key.to_owned(),
        bytes: Arc::new(text.as_bytes().to_vec()),
    };
    let bundle = Bundle {
        name: "test".to_owned(),
        main: "scene/scene.toml".to_owned(),
        overrides: vec!["body.cube.mesh=t.obj".to_owned(), "body.cube.fit=20 cm".to_owned()],
        files: vec![file("scene/scene.toml", SMALL), file("given/t.obj", TETRAHEDRON)],
    };
    let scene = load_bundle(&bundle).unwrap_or_else(|errors| panic!("{errors}"));
    assert!((scene.bodies[0].volume - 0.008 / 6.0).abs() < 1e-12);
    // The file's own origin, a corner of the tetrahedron, stands at `position`.
    let corner = scene.bodies[0].pose.translation.vector;
    assert!((corner - cullet_geometry::Vec3::new(0.05, 0.05, 1.05)).norm() < 1e-9);
    assert_eq!(load_bundle(&scene.bundle()).expect("again").bodies.len(), 2);
}

fn errors_of(text: &str, overrides: &[&str]) -> String {
    match from_text(text, overrides) {
        Ok(_) => panic!("loaded, but must not:\n{text}"),
        Err(errors) => errors.to_string(),
    }
}

/// Eleven mistakes.
const MANY_WRONG: &str = r#"[world]
step = "1 fortnight"
gravty = [0, 0, -9.81]
duration = nan

[[material]]
name = "clay"
preset = "stonewear"
[[material]]
name = "void"
preset = "brick"
density = -3

[[body]]
name = "a"
shape = { kind = "bx", size = [1, 1, 1] }
material = "brick"
[[body]]
name = "b"
shape = { kind = "sphere", radius = "-5 mm" }
material = "brick"
[[body]]
name = "c"
shape = { kind = "sphere", radius = 1 }
material = "granit"
[[body]]
name = "c"
shape = { kind = "sphere", radius = 1 }
mesh = "c.obj"
material = "granite"
fixed = "yes"
"#;

#[test]
fn all_errors_are_told_at_once_with_place_value_and_bound() {
    let expected = "scene.toml:2:8: world.step: \"fortnight\" is not a unit of time; \
         known: s, ms, us, min
  2 | step = \"1 fortnight\"
    |        ^^^^^^^^^^^^^
scene.toml:3:1: world.gravty: unknown key `gravty`
  3 | gravty = [0, 0, -9.81]
    | ^^^^^^
  help: did you mean `gravity`?
scene.toml:4:12: world.duration: must be a finite number; it is NaN
  4 | duration = nan
    |            ^^^
scene.toml:8:10: material.clay.preset: there is no preset \"stonewear\"
  8 | preset = \"stonewear\"
    |          ^^^^^^^^^^^
  help: did you mean `stoneware`?
scene.toml:12:11: material.void.density: must be at least 0.01 kg/m3; it is -3 kg/m3
  12 | density = -3
     |           ^^
scene.toml:16:18: body.a.shape.kind: \"bx\" is not one of box, sphere, \
         cylinder, cone, torus, capsule, extrusion, lathe, sheet, shell
  16 | shape = { kind = \"bx\", size = [1, 1, 1] }
     |                  ^^^^
  help: did you mean `box`?
scene.toml:20:37: body.b.shape.radius: must be above 0 m; it is -0.005 m
  20 | shape = { kind = \"sphere\", radius = \"-5 mm\" }
     |                                     ^^^^^^^
scene.toml:25:12: body[2].material: there is no material \"granit\"
  25 | material = \"granit\"
     |            ^^^^^^^^
  help: did you mean `granite`?
scene.toml:27:8: body[3].name: a second one is called \"c\"
  27 | name = \"c\"
     |        ^^^
scene.toml:29:8: body[3].mesh: a body has a `shape` or a `mesh`, not both
  29 | mesh = \"c.obj\"
     |        ^^^^^^^
scene.toml:31:9: body[3].fixed: must be true or false, not \"yes\"
  31 | fixed = \"yes\"
     |         ^^^^^";
    assert_eq!(errors_of(MANY_WRONG, &[]), expected);
}

/// What is broken in a scene, and words that its error must have.
const BAD: [(&str, &str); 16] = [
    ("body.cube.position=[0,0,0.04]", "\"ball\" overlaps \"cube\" at the start"),
    ("body.cube.material=rubber", "did you"),
    ("body.cuba.fixed=true", "did you mean `cube`?"),
    ("wrld.step=1", "did you mean `world`?"),
    ("body.cube.posítion=1", "unknown key `posítion`"),
    ("body.cube.mesh=nothere.obj", "given/nothere.obj is not in the bundle"),
    ("body.cube.mesh=/etc/passwd", "mesh: \"passwd\" is no mesh that is read here: those end in"),
    ("body.cube.mesh=a.b/c", "mesh: \"c\" is no mesh"),
    ("body.cube.fit=1", "is for a `mesh`"),
    ("body.cube.shape.size=[1,2]", "must have 3 items; it has 2"),
    ("material.granite.strength=1 kPa", "strength over Young's modulus must lie in [1e-5, 20]"),
    ("material.granite.poisson=0.5", "must be at most 0.4999"),
    ("body.cube.velocity=[inf,0,0]", "must be a finite number"),
    ("body.cube.rotation={axis=[0,0,0],degrees=3}", "must have a length above 1e-6"),
    ("expect.broken=[\"cubes\"]", "there is no body \"cubes\""),
    ("world.max_bodies=99999999999", "must be at most"),
];

/// Where a path is taken from is told where nothing is there.
#[test]
fn a_mesh_that_is_not_there_is_told_with_where_it_was_looked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.toml");
    let text =
        SMALL.replace("shape = { kind = \"sphere\", radius = \"5 cm\" }", "mesh = \"no.obj\"");
    std::fs::write(&file, text).expect("a file");
    let why = load(&file, &["body.cube.mesh=no-such/x.stl".to_owned()]).expect_err("no meshes");
    let why = why.to_string();
    let own = folder.path().join("no.obj").display().to_string();
    assert!(why.contains(&format!("cannot read {own}: there is no such file")), "{why}");
    assert!(why.contains("a path in a file is taken from the folder of that file"), "{why}");
    assert!(why.contains("cannot read no-such/x.stl: there is no such file"), "{why}");
    assert!(why.contains("a path in --set is taken from the current folder"), "{why}");
    let why = load(&file, &["body.ball.mesh=/no-such/x.stl".to_owned()]).expect_err("no mesh");
    assert!(!why.to_string().contains("is taken from"), "{why}");
}

#[test]
fn bad_values_are_refused_in_words() {
    for (set, words) in BAD {
        if set == "body.cube.material=rubber" {
            assert!(from_text(SMALL, &[set]).is_ok(), "a striker may be any body");
            continue;
        }
        let errors = errors_of(SMALL, &[set]);
        assert!(errors.contains(words), "{set} gave:\n{errors}");
    }
}

#[test]
fn drawings_are_recorded_unless_the_scene_says_otherwise() {
    let recording = |set: &[&str]| from_text(SMALL, set).expect("loads").recording;
    assert!(recording(&[]).drawings);
    assert!(!recording(&["recording.drawings=false"]).drawings);
    let said = errors_of(SMALL, &["recording.drawing=false"]);
    assert!(said.contains("did you mean `drawings`"), "{said}");
}

#[test]
fn what_does_not_fit_together_is_refused_in_words() {
    let grid = "[[grid]]\nname = \"g\"\ncount = [2, 1, 1]\nspacing = [1e6, 0, 0]\n\
                body = { shape = { kind = \"sphere\", radius = 0.1 }, material = \"ice\" }\n";
    let wide = errors_of(&format!("{SMALL}{grid}"), &[]);
    assert!(wide.contains("must lie within 100000 m of the origin; one lies at 1e6 m"), "{wide}");
    let cases: [(&[&str], &str); 7] = [
        (&["world.max_bodies=1"], "must be at least 2, the bodies of the scene; it is 1"),
        (
            &["world.gravity=[0, 0, 1e300]"],
            "its length must be at most 10000 m/s2; a component is 1e300 m/s2",
        ),
        (&["world.step=1e-6", "world.duration=600"], "600 s would take 6e8 steps; at most 1e7"),
        (&["world.duration=0.001"], "must be at least one step"),
        (&["expect.failed={ min = 1, max = 0 }"], "they are 1 and 0"),
        (&["world.tiers={ tiny = 0.5, small = 0.2 }"], "they are 0.5 and 0.2"),
        (&["view={ eye = [1, 2, 3], target = [1, 2, 3] }"], "must differ from `target`"),
    ];
    for (set, must_say) in cases {
        let said = errors_of(SMALL, set);
        assert!(said.contains(must_say), "{set:?}: {said}");
    }
}

#[test]
fn includes_come_first_and_cycles_are_told() {
    let file = |key: &str, text: &str| SceneFile {
        key: key.to_owned(),
        bytes: Arc::new(text.as_bytes().to_vec()),
    };
    let bundle = |common: &str| Bundle {
        name: "test".to_owned(),
        main: "scene/scene.toml".to_owned(),
        overrides: Vec::new(),
        files: vec![
            file("scene/scene.toml", &format!("include = [\"lib/c.toml\"]\n{SMALL}")),
            file("scene/lib/c.toml", common),
        ],
    };
    let floor = "[world]\nduration = 3\n[[body]]\nname='floor'\nfixed=true\nmaterial='brick'\n\
                 position=[0,0,-5]\nshape={kind='box',size=[1,1,1]}\n";
    let scene = load_bundle(&bundle(floor)).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(scene.bodies[0].name, "floor");
    assert!((scene.world.duration - 3.0).abs() < 1e-15);
    let errors = load_bundle(&bundle("include = [\"../scene.toml\"]")).expect_err("a cycle");
    assert!(errors.to_string().contains("../scene.toml includes itself"), "{errors}");
}

#[test]
fn scattered_bodies_do_not_meet_and_follow_the_seed() {
    let text = r#"
[[scatter]]
name = "stone"
count = 30
min = [-1, -1, 0]
max = [1, 1, 1]
turn = true
[scatter.body]
shape = { kind = "box", size = [0.1, 0.1, 0.2] }
material = "granite"
"#;
    let scene = from_text(text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let places = |scene: &Scene| -> Vec<_> { scene.bodies.iter().map(|b| b.pose).collect() };
    assert_eq!(scene.bodies.len(), 30);
    assert_eq!(places(&scene), places(&from_text(text, &[]).expect("loads")));
    assert_ne!(places(&scene), places(&from_text(text, &["world.seed=2"]).expect("loads")));
    assert!(errors_of(text, &["scatter.stone.count=3000"]).contains("fit between"));
}

/// Meshes that do not lie in the tree: tried where `CULLET_MESHES` names their folder.
#[test]
fn the_bullet_takes_other_targets() {
    let Some(folder) = std::env::var_os("CULLET_MESHES") else {
        return;
    };
    for name in ["stanford-bunny.obj", "spot.obj", "rocker-arm.obj"] {
        let mesh = Path::new(&folder).join(name);
        let overrides =
            [format!("body.target.mesh=\"{}\"", mesh.display()), "body.target.fit=0.2".to_owned()];
        let scene = load(&scenes().join("bullet"), &overrides)
            .unwrap_or_else(|errors| panic!("{name}:\n{errors}"));
        let target = scene.bodies.iter().find(|b| b.name == "target").expect("there");
        let world = target
            .solid
            .mesh
            .vertices
            .iter()
            .map(|v| target.pose.rotation * v + target.pose.translation.vector);
        let lowest = world.map(|v| v.z).fold(f64::INFINITY, f64::min);
        assert!((lowest - 0.0005).abs() < 1e-9, "{name} stands on its base");
        eprintln!(
            "{name}: {} triangles, {} hulls, {:.3e} m³; {:?}",
            target.solid.mesh.triangles.len(),
            target.hulls.len(),
            target.volume,
            scene.warnings
        );
    }
}

/// F02: a tower of 20 m of a stuff that 20 kPa tear, and a flywheel of it.
#[test]
fn a_body_too_weak_for_its_weight_or_spin_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.toml");
    let scene = |height: &str, spin: &str| {
        let text = format!(
            "[[material]]\nname = \"mud\"\ndensity = 1500\nyoung = \"50 MPa\"\npoisson = 0.3\n\
             strength = \"20 kPa\"\nfracture_energy = 1\nrestitution = 0.1\nfriction = 0.5\n\
             [[body]]\nname = \"tower\"\nshape = {{ kind = \"box\", size = [1, 1, {height}] }}\n\
             position = [0, 0, 30]\nspin = [0, 0, {spin}]\nmaterial = \"mud\"\n"
        );
        std::fs::write(&file, text).expect("a file");
        let scene = load(&file, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        scene.warnings.into_iter().filter(|line| line.contains("(F02)")).collect::<Vec<_>>()
    };
    assert!(scene("1", "0").is_empty());
    let heavy = scene("20", "0");
    // 1500 · 9.81 · 20 Pa.
    assert!(heavy.len() == 1 && heavy[0].contains("own weight stresses it by 2.94"), "{heavy:?}");
    // 1500 · (8 · 0.7071)² Pa.
    let fast = scene("1", "8");
    assert!(fast.len() == 1 && fast[0].contains("its spin stresses it by 4.800e4 Pa"), "{fast:?}");
}
