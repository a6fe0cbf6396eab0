//! What can be asked for, and what is said of the rest.

use super::common::fixture;
use cullet_export::{ExportError, ExportOptions, Moments, export};
use cullet_record::synthetic::{BREAK, STEP};

#[test]
fn a_moment_has_who_is_there_and_no_animation() {
    let fixture = fixture();
    let time = BREAK as f64 * STEP + 0.1;
    let options = ExportOptions { moments: Moments::At(time), ..ExportOptions::default() };
    let scene = fixture.glb(&options);
    assert_eq!(scene.document.animations().count(), 0);
    let bodies = scene.bodies();
    assert_eq!(bodies.keys().copied().collect::<Vec<_>>(), [0, 2, 3]);
    for row in fixture.recording.poses_at(time) {
        let pose = scene.pose(&bodies[&row.id], 0.0);
        assert!(super::common::apart(&pose, &row.pose) < 1e-6, "body {}", row.id);
    }
}

#[test]
fn a_sequence_is_a_file_a_moment() {
    let fixture = fixture();
    let output = fixture.folder.path().join("part.usda");
    let options = ExportOptions { moments: Moments::Every(0.25), ..ExportOptions::default() };
    let report = export(&fixture.recording, &options, &output).expect("files");
    let names: Vec<_> = report.files.iter().filter_map(|file| file.file_name()).collect();
    let wanted: Vec<String> = (1..=5).map(|k| format!("part_{k:04}.usda")).collect();
    assert!(names.iter().copied().eq(wanted.iter().map(std::ffi::OsStr::new)), "{names:?}");
    let texts = report.files.iter().map(|file| std::fs::read_to_string(file).expect("a text"));
    let bodies: Vec<usize> = texts.map(|text| text.matches("def Mesh ").count()).collect();
    // Of a part that broke off there is a crack inside, too.
    assert_eq!(bodies, [2, 2, 4, 4, 4]);
}

#[test]
fn what_cannot_be_written_is_refused_with_advice() {
    let fixture = fixture();
    for (name, advice) in [
        ("x.usdc", "usdcat x.usda -o x.usdc"),
        ("x.ABC", "no maintained library writes Alembic"),
        ("x.fbx", ".glb or .usda"),
        ("x.obj", ".glb, .usda or .csv"),
        ("x", ".glb, .usda or .csv"),
    ] {
        let path = fixture.folder.path().join(name);
        let refused = export(&fixture.recording, &ExportOptions::default(), &path);
        let text = refused.expect_err("it is no format of ours").to_string();
        assert!(text.contains(advice) && text.contains(name), "{text}");
        assert!(!path.exists());
    }
}

#[test]
fn bounds_are_named() {
    let fixture = fixture();
    let plain = ExportOptions::default();
    let part = |start, end| ExportOptions { start: Some(start), end: Some(end), ..plain };
    let bad = [
        (ExportOptions { fps: 0.0, ..plain }, "0 frames a second: it must be from 1 to 1000"),
        (part(0.6, 0.5), "no moments from 0.6 s to 0.5 s: the run goes from 0 to 1 s"),
        (part(0.5, 2.0), "from 0.5 s to 2 s"),
        (ExportOptions { moments: Moments::At(1.5), ..plain }, "from 1.5 s to 1.5 s"),
        (ExportOptions { moments: Moments::Every(0.0), ..plain }, "a file each 0 s"),
        (ExportOptions { moments: Moments::Every(1e-6), ..plain }, "1 to 10000 files"),
    ];
    for (options, wanted) in bad {
        let path = fixture.folder.path().join("x.glb");
        let refused = export(&fixture.recording, &options, &path);
        let text = refused.expect_err("it is out of bounds").to_string();
        assert!(text.contains(wanted), "{text}");
        assert!(!path.exists());
    }
}

#[test]
fn a_damaged_mesh_is_an_error_that_names_its_body() {
    let mut fixture = fixture();
    let cube = fixture.recording.body(1).expect("the cube").geometry.clone();
    fixture.recording.geometries.remove(&cube);
    let path = fixture.folder.path().join("x.glb");
    let lost = export(&fixture.recording, &ExportOptions::default(), &path);
    assert!(matches!(lost, Err(ExportError::Record(_))), "{lost:?}");
    assert!(lost.expect_err("it is lost").to_string().contains("body 1"));
}
