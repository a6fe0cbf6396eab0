//! USD and tables.

use super::common::fixture;
use cullet_export::{ExportOptions, export};
use cullet_record::Recording;
use cullet_record::synthetic::{BREAK, STEP};

/// The lines of a block, from the one that starts with `head` to its end.
fn block(text: &str, head: &str) -> String {
    let start = text.lines().position(|line| line.trim_start().starts_with(head));
    let lines: Vec<&str> = text.lines().skip(start.unwrap_or_else(|| panic!("{head}"))).collect();
    let indent = lines[0].len() - lines[0].trim_start().len();
    let close = format!("{}}}", " ".repeat(indent));
    let end = lines.iter().position(|line| *line == close).expect("an end");
    lines[..=end].join("\n")
}

/// Times and values of the samples of an attribute.
fn samples(block: &str, attribute: &str) -> Vec<(f64, String)> {
    let head = format!("{attribute}.timeSamples = {{");
    let lines = block.lines().skip_while(|line| !line.trim().ends_with(&head)).skip(1);
    let lines = lines.take_while(|line| line.trim() != "}");
    let pair = |line: &str| {
        let (time, value) = line.trim().trim_end_matches(',').split_once(": ").expect("a pair");
        (time.parse().expect("a time"), value.to_owned())
    };
    lines.map(pair).collect()
}

#[test]
fn a_stage_has_a_prim_a_body_below_its_object() {
    let text = fixture().text("x.usda", &ExportOptions::default());
    assert!(text.starts_with("#usda 1.0\n"));
    for line in
        ["upAxis = \"Z\"", "metersPerUnit = 1", "timeCodesPerSecond = 24", "endTimeCode = 24"]
    {
        assert!(text.lines().any(|one| one.trim() == line), "{line}");
    }
    assert_eq!(text.matches('{').count(), text.matches('}').count());
    let cube = block(&text, "def Xform \"cube\"");
    // A part has a crack that ends inside it.
    assert_eq!(cube.matches("def Mesh ").count(), 4);
    let part = block(&cube, "def Mesh \"cube_2\"");
    for line in [
        "uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"",
        "bool physics:kinematicEnabled = 1",
        "string primvars:piecename = \"cube_2\" (",
        "custom int64 userProperties:parent = 1",
    ] {
        assert!(part.lines().any(|one| one.trim() == line), "{line} in {part}");
    }
    let faces = |part: &str, name: &str| {
        let subset = block(part, &format!("def GeomSubset \"{name}\""));
        let line = subset.lines().find(|line| line.contains("int[] indices")).expect("faces");
        line.matches(',').count() + 1
    };
    assert_eq!((faces(&part, "skin"), faces(&part, "crack")), (10, 2));
    // A crack was fully damaged 20 µs after the hit.
    assert!(part.contains("float[] primvars:damage_time = [0, 0.00002] ("));
    let slab = block(&text, "def Mesh \"slab\"");
    assert!(!slab.contains("PhysicsRigidBodyAPI") && !slab.contains("timeSamples"), "{slab}");
}

#[test]
fn a_part_appears_when_its_body_breaks() {
    let text = fixture().text("x.usda", &ExportOptions { fps: 30.0, ..ExportOptions::default() });
    let breaks = BREAK as f64 * STEP * 30.0;
    let [whole, part] =
        ["cube", "cube_2"].map(|name| block(&text, &format!("def Mesh \"{name}\"")));
    let times = |block: &str, attribute: &str| -> Vec<(f64, String)> {
        let near = |t: f64| (t * 1e6).round() / 1e6;
        samples(block, attribute).into_iter().map(|(t, value)| (near(t), value)).collect()
    };
    let seen = |rows: &[(f64, &str)]| -> Vec<(f64, String)> {
        rows.iter().map(|&(time, value)| (time, value.to_owned())).collect()
    };
    let (there, gone) = ("\"inherited\"", "\"invisible\"");
    assert_eq!(times(&whole, "visibility"), seen(&[(0.0, there), (breaks, gone)]));
    assert_eq!(times(&part, "visibility"), seen(&[(0.0, gone), (breaks, there)]));
    let (none, one) = ("(0, 0, 0)", "(1, 1, 1)");
    let wanted = [(0.0, none), (breaks - 0.001, none), (breaks, one)];
    assert_eq!(times(&part, "xformOp:scale"), seen(&wanted));
    let first = samples(&part, "xformOp:translate")[0].0;
    assert!((first - breaks).abs() < 1e-9, "{first}");
    let speed = samples(&part, "physics:velocity");
    assert!(speed[0].1.starts_with("(-0.8, 0, "), "{speed:?}");
}

#[test]
fn grains_are_balls_of_half_their_size() {
    let fixture = fixture();
    let text = fixture.text("x.usda", &ExportOptions::default());
    let grains = block(&text, "def PointInstancer \"Grains\"");
    assert!(grains.contains("double radius = 0.5"));
    let last = |attribute: &str| samples(&grains, attribute).pop().expect("samples").1;
    // 2 cm across: the radius is half of it, as the ball has a diameter of 1.
    assert_eq!(last("scales"), "[(0.02, 0.02, 0.02), (0.02, 0.02, 0.02)]");
    assert_eq!(last("ids"), "[0, 1]");
    assert_eq!(samples(&grains, "positions")[0].1, "[]");
    assert!(last("positions").starts_with("[(0.4"), "{}", last("positions"));
    // They lie after 17.7 frames: a sample has all grains, so none is taken between frames.
    let text = fixture.text("z.usda", &ExportOptions { fps: 25.0, ..ExportOptions::default() });
    let (at, _) =
        samples(&block(&text, "def PointInstancer \"Grains\""), "positions").pop().expect("one");
    assert!((at - 18.0).abs() < 1e-9, "{at}");
    let without = ExportOptions { grains: false, ..ExportOptions::default() };
    assert!(!fixture.text("y.usda", &without).contains("PointInstancer"));
}

#[test]
fn tables_have_a_row_a_body_and_a_row_a_frame() {
    let fixture = fixture();
    let bodies = fixture.text("x.csv", &ExportOptions::default());
    assert_eq!(bodies.lines().count(), 5, "{bodies}");
    let poses = fixture.folder.path().join("x_poses.csv");
    let poses = std::fs::read_to_string(poses).expect("a table");
    // 24 frames a second and the last; the cube is there for the first ten.
    let rows = |name: &str| poses.lines().filter(|line| line.starts_with(name)).count();
    assert_eq!((rows("slab,"), rows("cube,"), rows("cube_2,")), (25, 10, 15));
    let row: Vec<&str> = poses
        .lines()
        .find(|line| line.starts_with("cube_3,3,20,"))
        .expect("a row")
        .split(',')
        .collect();
    let recorded = fixture.recording.poses_at(20.0 / 24.0 + 1e-9);
    let recorded = recorded.iter().find(|row| row.id == 3).expect("it is there");
    let numbers: Vec<f64> = row[4..].iter().map(|cell| cell.parse().expect("a number")).collect();
    let (p, q) = (recorded.pose.translation.vector, recorded.pose.rotation);
    let wanted = [p.x, p.y, p.z, q.i, q.j, q.k, q.w];
    assert!(numbers.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{row:?}");
}

/// Names of bodies and materials are anybody's.
#[test]
fn no_cell_of_a_table_is_a_formula() {
    let mut fixture = fixture();
    for body in &mut fixture.recording.bodies {
        (body.object, body.material) = ("+1+1".to_owned(), "@SUM(1,2)".to_owned());
    }
    let bodies = fixture.text("x.csv", &ExportOptions::default());
    let rows: Vec<&str> = bodies.lines().skip(1).collect();
    let is_plain = |row: &&str| row.contains(",'+1+1,") && row.contains(",\"'@SUM(1,2)\",");
    assert!(rows.len() == 4 && rows.iter().all(is_plain), "{bodies}");
}

#[test]
fn what_is_exported_of_a_recording_with_holes_says_what_is_missing() {
    let mut fixture = fixture();
    let path = fixture.folder.path().join("x.glb");
    let notes = |recording: &Recording| {
        export(recording, &ExportOptions::default(), &path).expect("it is exported").notes
    };
    assert!(notes(&fixture.recording).is_empty());
    fixture.recording.holes.unborn = 2;
    let told = notes(&fixture.recording);
    assert!(told[0].contains("has holes") && told[0].contains("2 bodies"), "{told:?}");
}
