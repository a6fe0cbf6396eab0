//! Scenes, specimens, and `path=value` arguments.

use super::bytes::{INPUT, damaged};
use super::timed;
use cullet_document::SceneErrors;
use cullet_document::files::{Bundle, SceneFile};
use cullet_lab::specimen;
use cullet_proto::specimen::SpecimenJob;
use cullet_tests::{files, root};
use std::path::Path;
use std::sync::Arc;

/// Every kind of section and value that a scene may have, small.
const SCENE: &str = r#"
description = "everything"
[world]
step = "5 ms"
duration = "20 ms"
seed = 3
gravity = [0, 0, -9.81]
tiers = { tiny = 1e-4, small = 1e-2 }
[fracture]
max_particles = 2000
solver = "geometric"
[[material]]
name = "clay"
preset = "brick"
density = "1.9 g/cm3"
weak_plane = { normal = [0, 0, 1], ratio = 0.5 }
[[body]]
name = "cube"
shape = { kind = "box", size = ["20 cm", "10 cm", "5 cm"] }
position = [0, 0, 1]
rotation = { axis = [0, 1, 0], degrees = 30 }
velocity = ["3.6 km/h", 0, 0]
material = "clay"
[[body]]
name = "ring"
shape = { kind = "torus", ring_radius = 0.1, tube_radius = 0.02, segments = 12 }
position = [1, 0, 1]
material = "soda-lime-glass"
[[grid]]
name = "g"
count = [2, 2, 1]
spacing = [0.3, 0.3, 0]
body = { position = [3, 0, 0], shape = { kind = "sphere", radius = 0.1 }, material = "ice" }
[[scatter]]
name = "s"
count = 3
min = [-3, -3, 0]
max = [-2, -2, 1]
body = { shape = { kind = "box", size = [0.1, 0.1, 0.1] }, material = "granite" }
[expect]
broken = ["cube"]
fragments = { min = 0, max = 9 }
[view]
eye = [1, 2, 3]
target = [0, 0, 0]
"#;

fn load(text: Vec<u8>, overrides: Vec<String>) -> Result<cullet_scene::Scene, SceneErrors> {
    let key = "scene/scene.toml".to_owned();
    let files = vec![SceneFile { key: key.clone(), bytes: Arc::new(text) }];
    cullet_scene::load_bundle(&Bundle { name: "test".to_owned(), main: key, overrides, files })
}

/// An error says what is wrong and where; of a file that is no text, which.
fn has_place(errors: &SceneErrors, text: &[u8]) {
    assert!(!errors.errors.is_empty());
    for error in &errors.errors {
        assert!(!error.message.is_empty());
        let placed = error.origin.is_some() || error.message.contains("no text in TOML");
        assert!(placed, "no place: {}\n{}", error.message, String::from_utf8_lossy(text));
        if let Some(place) = error.place() {
            assert!(place.line > 0 && place.column > 0 && place.width > 0);
        }
    }
    assert!(!errors.to_string().is_empty());
}

fn seeds(folder: &str) -> Vec<Vec<u8>> {
    let texts = files(&root().join(folder), &[".toml"]);
    texts.iter().map(|path| std::fs::read(path).expect("a text")).collect()
}

#[test]
fn scene() {
    let mut seeds = seeds("tests/corpus");
    seeds.push(SCENE.as_bytes().to_vec());
    seeds.push(SCENE.as_bytes().to_vec());
    for seed in &seeds {
        let loaded = timed("a seed", || load(seed.clone(), Vec::new()));
        assert!(loaded.is_ok(), "{}", loaded.err().map_or_else(String::new, |e| e.to_string()));
    }
    bolero::check!().with_iterations(600).with_max_len(INPUT).for_each(|input: &[u8]| {
        let (_, text) = damaged(input, &seeds);
        if let Err(errors) = timed("a scene", || load(text.clone(), Vec::new())) {
            has_place(&errors, &text);
        }
    });
}

#[test]
fn overrides() {
    let seeds = [
        "world.duration=2",
        "body.ring.velocity[1]=3 m/s",
        "material.clay.young=60 GPa",
        "body.cube.shape={kind=\"cone\", radius=0.1, height=0.4}",
        "grid.g.count=[1,1,1]",
    ];
    let seeds = seeds.map(|text| text.as_bytes().to_vec());
    bolero::check!().with_iterations(600).with_max_len(INPUT).for_each(|input: &[u8]| {
        let (_, text) = damaged(input, &seeds);
        let argument = String::from_utf8_lossy(&text).into_owned();
        let bytes = SCENE.as_bytes().to_vec();
        if let Err(errors) = timed("an override", || load(bytes, vec![argument])) {
            has_place(&errors, &text);
        }
    });
}

#[test]
fn specimen() {
    let seeds = seeds("tests/specimens");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz-specimen.toml");
    bolero::check!().with_iterations(600).with_max_len(INPUT).for_each(|input: &[u8]| {
        let (_, text) = damaged(input, &seeds);
        std::fs::write(&file, &text).expect("a file");
        match timed("a specimen", || specimen::load(&file, &[])) {
            Ok(specimen) => {
                let _bytes = specimen.job().map(SpecimenJob::encode);
            }
            Err(errors) => has_place(&errors, &text),
        }
    });
}
