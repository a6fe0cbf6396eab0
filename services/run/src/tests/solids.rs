//! Whatever solid a scene takes, the world takes: random shapes, and meshes turned and scaled.

use cullet_document::files::{Bundle, SceneFile};
use cullet_geometry::math::unit;
use cullet_geometry::{Quat, TriMesh, Vec3};
use cullet_scene::rigid::{spec, world_settings};
use cullet_scene::{Scene, load_bundle};
use cullet_world::World;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Where a solid of a test was refused.
#[derive(Debug, Default)]
struct Refused {
    /// By the scene's door.
    by_check: Vec<String>,
    /// Later, by the world.
    by_world: Vec<String>,
}

/// A scene with one body.
fn scene_of(body: &str, mesh: Option<(&str, Vec<u8>)>) -> Result<Scene, String> {
    let text = format!("[[body]]\nname = \"it\"\nmaterial = \"granite\"\n{body}\n");
    let file = |key: &str, bytes: Vec<u8>| SceneFile { key: key.to_owned(), bytes: bytes.into() };
    let mut files = vec![file("scene/scene.toml", text.into_bytes())];
    files.extend(mesh.map(|(name, bytes)| file(&format!("scene/{name}"), bytes)));
    let (name, main) = ("test".to_owned(), "scene/scene.toml".to_owned());
    load_bundle(&Bundle { name, main, overrides: Vec::new(), files })
        .map_err(|errors| errors.to_string())
}

/// Notes where the scene was refused, if it was; says whether it was not, and stepped twice.
fn tried(label: &str, scene: &Result<Scene, String>, refused: &mut Refused) -> bool {
    let scene = match scene {
        Ok(scene) => scene,
        Err(why) => {
            refused.by_check.push(format!("{label}: {why}"));
            return false;
        }
    };
    let mut world = World::new(world_settings(scene)).expect("settings");
    let inserted = scene.bodies.iter().try_for_each(|body| world.insert(spec(body)).map(|_| ()));
    let stepped = inserted.and_then(|()| world.step()).and_then(|_| world.step());
    match stepped {
        Ok(_) => true,
        Err(why) => {
            refused.by_world.push(format!("{label}: {why}"));
            false
        }
    }
}

/// Numbers that look random, one after the other.
struct Dice {
    seed: u64,
    at: u64,
}

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.at += 1;
        low + (high - low) * unit(self.seed, 1, self.at)
    }

    fn count(&mut self, low: usize, high: usize) -> usize {
        low + self.between(0.0, (high - low + 1) as f64) as usize
    }

    /// A power of ten.
    fn power(&mut self, low: f64, high: f64) -> f64 {
        libm::pow(10.0, self.between(low, high))
    }

    fn turn(&mut self) -> Quat {
        let q: [f64; 4] = std::array::from_fn(|_| self.between(-1.0, 1.0));
        Quat::new_normalize(nalgebra::Quaternion::new(q[0] + 2.0, q[1], q[2], q[3]))
    }
}

fn list(points: &[[f64; 2]]) -> String {
    let mut text = String::from("[");
    for [x, y] in points {
        let _ = write!(text, "[{x:?}, {y:?}], ");
    }
    text + "]"
}

/// A turned body: steps, collars, necks and thin discs, from a millimetre to a hundred metres.
fn lathe(dice: &mut Dice) -> String {
    let size = dice.power(-3.0, 2.0);
    let mut z = 0.0;
    let mut profile = Vec::new();
    for _ in 0..dice.count(1, 8) {
        let low = if dice.between(0.0, 1.0) < 0.3 { -2.0 } else { -0.7 };
        let radius = size * dice.power(low, 0.0);
        let height = size * dice.power(-2.5, 0.0);
        profile.extend([[radius, z], [radius, z + height]]);
        z += height;
        // Shoulders are level more often than not, so that faces share planes.
        if dice.between(0.0, 1.0) < 0.4 {
            z += size * dice.power(-2.5, -0.5);
        }
    }
    let segments = dice.count(3, 24);
    format!("shape = {{ kind = \"lathe\", profile = {}, segments = {segments} }}", list(&profile))
}

/// A star with sharp corners, or a comb with thin teeth, drawn along z.
fn extrusion(dice: &mut Dice) -> String {
    let size = dice.power(-3.0, 2.0);
    let mut polygon = Vec::new();
    if dice.between(0.0, 1.0) < 0.5 {
        let points = dice.count(3, 14);
        for k in 0..points {
            let (sin, cos) = libm::sincos(TAU * k as f64 / points as f64);
            let radius = size * dice.power(-1.5, 0.0);
            polygon.push([radius * cos, radius * sin]);
        }
    } else {
        let (back, mut x) = (size * dice.power(-2.0, -0.5), 0.0);
        polygon.push([0.0, 0.0]);
        for _ in 0..dice.count(1, 5) {
            let (tooth, long) = (size * dice.power(-2.5, -0.5), size * dice.power(-1.0, 0.0));
            polygon.extend([[x, back + long], [x + tooth, back + long], [x + tooth, back]]);
            x += tooth + size * dice.power(-2.5, -0.5);
            polygon.push([x, back]);
        }
        polygon.push([x, 0.0]);
    }
    let height = size * dice.power(-2.0, 0.5);
    let polygon = list(&polygon);
    format!("shape = {{ kind = \"extrusion\", polygon = {polygon}, height = {height:?} }}")
}

/// The text of an OBJ file of a mesh, turned.
fn obj(mesh: &TriMesh, turn: &Quat) -> Vec<u8> {
    let mut text = String::new();
    for p in &mesh.vertices {
        let p: Vec3 = turn * p;
        let _ = writeln!(text, "v {:e} {:e} {:e}", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

/// 500 lathes and 500 extrusions, each as a shape and, turned and scaled, as a mesh: nearly all are
/// taken, and none that the scene's door took is refused by the world.
#[test]
fn a_thousand_random_lathes_and_extrusions_run() {
    let (mut shapes, mut turned) = (Refused::default(), Refused::default());
    let (mut ran, mut ran_turned) = (0, 0);
    for seed in 0..1000 {
        let mut dice = Dice { seed, at: 0 };
        let body = if seed % 2 == 0 { lathe(&mut dice) } else { extrusion(&mut dice) };
        let scene = scene_of(&body, None);
        ran += usize::from(tried(&format!("{seed}"), &scene, &mut shapes));
        let Ok(scene) = scene else { continue };
        let mesh = obj(&scene.bodies[0].solid.mesh, &dice.turn());
        let fit = dice.power(-3.0, 2.0);
        let body = format!("mesh = \"it.obj\"\nfit = {fit:?}");
        let scene = scene_of(&body, Some(("it.obj", mesh)));
        ran_turned += usize::from(tried(&format!("{seed} turned"), &scene, &mut turned));
    }
    println!("{ran} and {ran_turned} of 1000 run; refused: {shapes:#?} {turned:#?}");
    assert!(shapes.by_world.is_empty() && turned.by_world.is_empty());
    assert_eq!((ran, ran_turned), (1000, 1000));
}

/// Sheets, hairs, wedges and thin walls, at the bounds of what a scene may ask for.
const THIN: [&str; 19] = [
    "{ kind = 'box', size = [1, 0.7, 1e-6] }",
    "{ kind = 'box', size = [1000, 700, 1e-6] }",
    "{ kind = 'box', size = [9999, 9999, 9999] }",
    "{ kind = 'box', size = [1e-4, 1e-6, 1e-6] }",
    "{ kind = 'box', size = [1, 1e-6, 1e-6] }",
    "{ kind = 'cylinder', radius = 1e-5, height = 10 }",
    "{ kind = 'cylinder', radius = 1000, height = 1e-6 }",
    "{ kind = 'cone', radius = 1, top_radius = 0, height = 1e-6 }",
    "{ kind = 'torus', ring_radius = 1, tube_radius = 1e-6 }",
    "{ kind = 'torus', ring_radius = 1, tube_radius = 0.999999 }",
    "{ kind = 'capsule', radius = 1e-5, length = 10 }",
    "{ kind = 'lathe', wall = 1e-6, profile = [[0, 0], [1, 0], [1, 1]] }",
    "{ kind = 'lathe', wall = 1e-5, profile = [[0, 0], [0.5, 0.1], [1, 0.5], [0.8, 1]] }",
    "{ kind = 'lathe', profile = [[0.5, 0], [1e-6, 0.5], [0.5, 1]] }",
    "{ kind = 'lathe', profile = [[1e-6, 0], [1e-6, 1]] }",
    "{ kind = 'extrusion', polygon = [[0, 0], [1, 0], [1, 1e-9]], height = 1 }",
    "{ kind = 'extrusion', polygon = [[0, 0], [1, 0], [1, 1e-7], [0.5, 1e-8]], height = 1 }",
    "{ kind = 'extrusion', polygon = [[9e5, 9e5], [900001, 9e5], [900001, 900001]], height = 1 }",
    "{ kind = 'extrusion', height = 1, polygon = [[0, 0], [1, 0], [1, 1], [0.999999, 1], \
     [0.999999, 1e-6], [0, 1e-6]] }",
];

/// What is too thin to have a volume or moments in f64, or too large; each with what is said of it.
const TOO_MUCH: [(&str, &str); 3] = [
    ("{ kind = 'box', size = [10000, 1e-6, 1e-6] }", "rounding of its thin volume"),
    ("{ kind = 'capsule', radius = 1e-6, length = 100 }", "rounding of its thin volume"),
    ("{ kind = 'box', size = [10000, 10000, 10001] }", "the longest side must lie in"),
];

#[test]
fn what_is_thin_runs_and_what_is_too_thin_is_told_by_check() {
    let mut refused = Refused::default();
    for shape in THIN {
        tried(shape, &scene_of(&format!("shape = {shape}"), None), &mut refused);
    }
    println!("{refused:#?}");
    assert!(refused.by_check.is_empty() && refused.by_world.is_empty());
    for (shape, said) in TOO_MUCH {
        let scene = scene_of(&format!("shape = {shape}"), None);
        tried(shape, &scene, &mut refused);
        let told = scene.err().unwrap_or_default();
        assert!(told.contains(said) && told.contains("body.it"), "{shape}: {told}");
    }
    assert!(refused.by_world.is_empty(), "{refused:#?}");
}

/// Real meshes at ten sizes, turned three ways: tried where `CULLET_MESHES` names their folder.
#[test]
fn real_meshes_run_at_any_size_and_turn() {
    let Some(folder) = std::env::var_os("CULLET_MESHES") else {
        return;
    };
    let files = std::fs::read_dir(Path::new(&folder)).expect("a folder").flatten();
    let mut paths: Vec<_> = files.map(|f| f.path()).filter(|path| path.is_file()).collect();
    paths.sort();
    let mut refused = Refused::default();
    let (mut ran, mut all) = (0, 0);
    for path in paths {
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let Ok(mesh) = cullet_assets::read(&name, &std::fs::read(&path).expect("a file")) else {
            continue;
        };
        let mut dice = Dice { seed: 3, at: 0 };
        for turn in [Quat::identity(), dice.turn(), dice.turn()] {
            let text = Arc::new(obj(&mesh, &turn));
            for power in 0..10 {
                let fit = libm::pow(10.0, -3.0 + 5.0 * f64::from(power) / 9.0);
                let body = format!("mesh = \"it.obj\"\nfit = {fit:?}");
                let scene = scene_of(&body, Some(("it.obj", text.to_vec())));
                ran += usize::from(tried(&format!("{name} at {fit:.3e} m"), &scene, &mut refused));
                all += 1;
            }
        }
        println!("{name}: {ran} of {all} so far");
    }
    println!("{refused:#?}");
    assert_eq!(ran, all);
}
