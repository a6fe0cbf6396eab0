//! Cracks that end inside a body are in what is exported, from when they were recorded.

use super::common::{Fixture, GlbScene};
use cullet_export::{ExportOptions, Moments, export, export_pieces};
use cullet_geometry::Vec3;
use cullet_record::synthetic::{BREAK, STEP, STEPS};
use cullet_record::{Recording, synthetic};

/// When the second crack appears \[steps\].
const LATER: u64 = BREAK + 24;

/// The synthetic run, whose part 2 has a crack when it breaks off, and another 0.2 s later.
fn cracked() -> Fixture {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    for k in 0..=STEPS {
        synthetic::step(&mut recorder, k).expect("a step");
        if k == LATER {
            let (half, time) = (synthetic::half(), k as f64 * STEP);
            let (block, fin) = (synthetic::block(half, 1.0), synthetic::fin(half));
            recorder.cracks((k, time), 2, &block, &fin).expect("is recorded");
        }
    }
    recorder.finish(STEPS, STEPS as f64 * STEP).expect("ends");
    let recording = Recording::open(&path).expect("it reads");
    Fixture { folder, recording }
}

fn node<'a>(scene: &'a GlbScene, name: &str) -> gltf::Node<'a> {
    let found = scene.document.nodes().find(|node| node.name() == Some(name));
    found.unwrap_or_else(|| panic!("{name}"))
}

#[test]
fn a_glb_has_them_below_their_body_from_when_they_were_recorded() {
    let fixture = cracked();
    let scene = fixture.glb(&ExportOptions::default());
    let bodies = scene.bodies();
    let below: Vec<_> =
        bodies[&2].children().filter_map(|it| it.name().map(str::to_owned)).collect();
    assert_eq!(below, ["cube_2_open_crack", "cube_2_open_crack_n2"]);
    assert!([0, 1, 3].iter().all(|id| bodies[id].children().count() == 0));
    let [early, late] = [&below[0], &below[1]].map(|name| node(&scene, name));
    let seen =
        |node: &gltf::Node<'_>| [-0.01, 0.01].map(|off| scene.is_seen(node, late_time() + off));
    assert_eq!((seen(&early), seen(&late)), ([true; 2], [false, true]));
    let part = early.mesh().expect("a mesh").primitives().next().expect("faces");
    assert_eq!(part.material().name(), Some("cube open crack"));
    assert!(part.material().double_sided());
    let reader = part.reader(|_| Some(&scene.blob));
    let sheet = synthetic::fin(synthetic::half());
    let places: Vec<Vec3> = reader
        .read_positions()
        .expect("places")
        .map(|[x, y, z]| Vec3::new(x.into(), -f64::from(z), y.into()))
        .collect();
    let far = |place: &Vec3| {
        let corners = sheet.mesh.vertices.iter();
        corners.map(|corner| (corner - place).norm()).fold(f64::INFINITY, f64::min)
    };
    assert!(places.len() == 4 && places.iter().all(|place| far(place) < 1e-6), "{places:?}");
    assert_eq!(reader.read_indices().map(|all| all.into_u32().count()), Some(6));
}

fn late_time() -> f64 {
    LATER as f64 * STEP
}

#[test]
fn a_stage_has_them_beside_their_body() {
    let fixture = cracked();
    let text = fixture.text("x.usda", &ExportOptions { fps: 30.0, ..ExportOptions::default() });
    let start = text.find("def Mesh \"cube_2_open_crack_n2\"").expect("the second");
    let late = &text[start..start + text[start..].find("\n        }\n").expect("an end")];
    for line in [
        "uniform bool doubleSided = 1",
        "custom int64 userProperties:open_crack_of = 2",
        "rel material:binding = </World/Looks/cube_crack>",
        "int[] faceVertexCounts = [3, 3]",
        "float[] primvars:front_speed = [900] (",
    ] {
        assert!(late.lines().any(|one| one.trim() == line), "{line} in {late}");
    }
    let appears = format!("{}: \"inherited\",", 30.0 * late_time());
    let appears = late.lines().any(|line| line.trim() == appears);
    assert!(appears && late.contains("xformOp:translate.timeSamples"), "{late}");
    assert!(!late.contains("physics:"), "{late}");
}

#[test]
fn a_moment_has_those_of_before_and_a_piece_all() {
    let fixture = cracked();
    let count = |time: f64| {
        let moments = Moments::At(time);
        let scene = fixture.glb(&ExportOptions { moments, ..ExportOptions::default() });
        let named = |node: &gltf::Node<'_>| node.name().is_some_and(|it| it.contains("open_crack"));
        scene.document.nodes().filter(named).count()
    };
    let [before, after] = [late_time() - 0.01, late_time() + 0.01].map(count);
    assert_eq!((count(0.1), before, after), (0, 1, 2));
    let folder = fixture.folder.path().join("pieces");
    export_pieces(&fixture.recording, &folder).expect("exports");
    assert_eq!(GlbScene::read(&folder.join("cube_2.glb")).document.nodes().count(), 3);
    // A part of the run that ends before.
    let options = ExportOptions { end: Some(late_time() - 0.01), ..ExportOptions::default() };
    let path = fixture.folder.path().join("early.glb");
    export(&fixture.recording, &options, &path).expect("exports");
    assert!(
        !GlbScene::read(&path).document.nodes().any(|it| it.name() == Some("cube_2_open_crack_n2"))
    );
}
