//! Sheets that wave and tear, in everything that is exported.

use super::common::{Fixture, GlbScene};
use cullet_export::{ExportOptions, ExportReport, Moments, export, page_glb};
use cullet_geometry::Vec3;
use cullet_record::synthetic::waving::{EVERY, POINTS, SHEET, TEARS};
use cullet_record::synthetic::{self, STEP, STEPS};
use cullet_record::{Recording, SheetMoment};

fn waving() -> Fixture {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    synthetic::run_with_sheet(&path, &synthetic::meta()).expect("a recording");
    let recording = Recording::open(&path).expect("it reads");
    Fixture { folder, recording }
}

fn tears() -> f64 {
    TEARS as f64 * STEP
}

/// Up to before it tears: a short cut of one surface.
fn before() -> ExportOptions {
    ExportOptions { end: Some(tears() - 0.5 * STEP), ..ExportOptions::default() }
}

fn report(fixture: &Fixture, name: &str, options: &ExportOptions) -> ExportReport {
    let path = fixture.folder.path().join(name);
    export(&fixture.recording, options, &path).expect("it is exported")
}

fn recorded(fixture: &Fixture, step: u64) -> SheetMoment {
    let moment = fixture.recording.sheet_at(SHEET, step);
    moment.expect("is sound").expect("is there")
}

fn named<'a>(scene: &'a GlbScene, name: &str) -> gltf::Node<'a> {
    let found = scene.document.nodes().find(|node| node.name() == Some(name));
    found.unwrap_or_else(|| panic!("{name}"))
}

/// Where the points of a node are at a time of the file \[m\], with shares of its shapes; and the
/// lengths of their normals.
fn places(scene: &GlbScene, node: &gltf::Node<'_>, time: f64) -> (Vec<Vec3>, Vec<f64>) {
    let mesh = node.mesh().expect("a mesh");
    let part = mesh.primitives().next().expect("faces");
    let reader = part.reader(|_| Some(&scene.blob));
    let of = |[x, y, z]: [f32; 3]| Vec3::new(x.into(), y.into(), z.into());
    let mut at: Vec<Vec3> = reader.read_positions().expect("places").map(of).collect();
    let mut normals: Vec<Vec3> = reader.read_normals().expect("normals").map(of).collect();
    let weights = scene.shapes(node, time);
    for ((moved, turned, _), weight) in reader.read_morph_targets().zip(weights) {
        let moved = moved.expect("places").map(of);
        at.iter_mut().zip(moved).for_each(|(at, by)| *at += by * f64::from(weight));
        let turned = turned.expect("normals").map(of);
        normals.iter_mut().zip(turned).for_each(|(at, by)| *at += by * f64::from(weight));
    }
    let (origin, ..) = node.transform().decomposed();
    let upright = |p: Vec3| Vec3::new(p.x, -p.z, p.y);
    let all = at.into_iter().map(|p| upright(p + of(origin))).collect();
    (all, normals.iter().map(Vec3::norm).collect())
}

fn apart(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn a_short_glb_of_one_surface_has_each_frame_as_a_shape() {
    let fixture = waving();
    let scene = fixture.glb(&before());
    let node = named(&scene, "towel");
    let frames = TEARS.div_ceil(EVERY);
    let part = node.mesh().expect("a mesh").primitives().next().expect("faces");
    assert_eq!(part.morph_targets().count() as u64, frames - 1);
    assert!(part.material().double_sided());
    let reader = part.reader(|_| Some(&scene.blob));
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    let surface = recorded(&fixture, 0).surface;
    assert_eq!(indices, surface.triangles.as_flattened());
    assert_eq!(reader.read_colors(0).map(|it| it.into_rgb_f32().count() as u32), Some(400));
    for frame in 0..frames {
        let time = (frame * EVERY) as f64 * STEP;
        let (found, lengths) = places(&scene, &node, time);
        let off = apart(&found, &recorded(&fixture, frame * EVERY).places);
        assert!(off < 2e-7, "{time} s: {off} m");
        assert!(lengths.iter().all(|length| (length - 1.0).abs() < 1e-5), "{time} s");
        assert!(scene.is_seen(&node, time));
    }
    // Half way between two frames it is half way.
    let (found, _) = places(&scene, &node, 2.5 * EVERY as f64 * STEP);
    let ends = [2, 3].map(|frame| recorded(&fixture, frame * EVERY).places);
    let due: Vec<Vec3> = ends[0].iter().zip(&ends[1]).map(|(a, b)| (a + b) / 2.0).collect();
    assert!(apart(&found, &due) < 1e-6);
    assert_eq!(scene.facts(&node)["sheet"], SHEET);
    let told = report(&fixture, "y.glb", &before());
    assert_eq!((told.sheets, told.notes.len()), (1, 0));
}

#[test]
fn a_glb_of_a_tear_has_each_surface_as_at_its_last_frame_and_says_so() {
    let fixture = waving();
    let scene = fixture.glb(&ExportOptions::default());
    let [whole, torn] = ["towel_surface_1", "towel_surface_2"].map(|name| named(&scene, name));
    let seen = |node: &gltf::Node<'_>| [-0.01, 0.01].map(|off| scene.is_seen(node, tears() + off));
    assert_eq!((seen(&whole), seen(&torn)), ([true, false], [false, true]));
    assert!(scene.is_seen(&torn, STEPS as f64 * STEP));
    for (node, step) in [(&whole, TEARS - 1), (&torn, STEPS)] {
        let (found, lengths) = places(&scene, node, 0.0);
        assert!(apart(&found, &recorded(&fixture, step).places) < 2e-7);
        assert!(lengths.iter().all(|length| (length - 1.0).abs() < 1e-5));
        assert_eq!(node.mesh().expect("a mesh").weights(), None);
    }
    let told = report(&fixture, "y.glb", &ExportOptions::default());
    let due = "towel: 31 frames of 2 surfaces are more than a GLB takes as shapes of one mesh (64 \
               of one); each surface is there as at its last frame, and .usda has all";
    assert_eq!((told.sheets, &told.notes[..]), (1, &[due.to_owned()][..]));
}

#[test]
fn one_moment_has_it_as_it_is_then() {
    let fixture = waving();
    for (time, step) in [(0.2, 24), (0.21, 24), (0.9, 108)] {
        let moments = Moments::At(time);
        let scene = fixture.glb(&ExportOptions { moments, ..ExportOptions::default() });
        let (found, _) = places(&scene, &named(&scene, "towel"), 0.0);
        assert!(apart(&found, &recorded(&fixture, step).places) < 2e-7, "{time} s");
        assert_eq!(scene.document.animations().count(), 0);
    }
}

#[test]
fn a_part_of_the_run_begins_with_the_frame_before() {
    let fixture = waving();
    let start = 9.5 * STEP;
    let scene = fixture.glb(&ExportOptions { start: Some(start), ..before() });
    let node = named(&scene, "towel");
    assert!(scene.is_seen(&node, 0.0));
    let (found, _) = places(&scene, &node, 0.0);
    assert!(apart(&found, &recorded(&fixture, 8).places) < 2e-7);
    let (found, _) = places(&scene, &node, 12.0 * STEP - start);
    assert!(apart(&found, &recorded(&fixture, 12).places) < 2e-7);
}

#[test]
fn a_page_has_it() {
    let scene = GlbScene::of_page(&page_glb(&waving().recording).expect("a page"));
    assert!(scene.document.nodes().any(|node| node.name() == Some("towel_surface_2")));
}

/// The prim that begins with `head`.
fn prim<'a>(text: &'a str, head: &str) -> &'a str {
    let start = text.find(head).unwrap_or_else(|| panic!("{head}"));
    let end = text[start..].find("\n        }\n").expect("an end");
    &text[start..start + end]
}

/// Times and values of the samples of an attribute.
fn samples<'a>(prim: &'a str, attribute: &str) -> Vec<(f64, &'a str)> {
    let head = format!("{attribute}.timeSamples = {{");
    let lines = prim.lines().skip_while(|line| !line.trim().ends_with(&head)).skip(1);
    let pair = |line: &'a str| {
        let (time, value) = line.trim().trim_end_matches(',').split_once(": ").expect("a pair");
        (time.parse().expect("a time"), value)
    };
    lines.take_while(|line| line.trim() != "}").map(pair).collect()
}

/// The numbers of an array of triples.
fn triples(text: &str) -> Vec<Vec3> {
    let number = |part: &str| part.trim_matches(['(', ')', '[', ']']).parse().expect("a number");
    let all: Vec<f64> = text.split(", ").map(number).collect();
    all.as_chunks::<3>().0.iter().map(|&p| Vec3::from(p)).collect()
}

#[test]
fn a_stage_has_all_frames_and_surfaces_that_are_seen_in_turn() {
    let fixture = waving();
    let text = fixture.text("x.usda", &ExportOptions { fps: 30.0, ..ExportOptions::default() });
    assert_eq!(text.matches('{').count(), text.matches('}').count());
    let own = &text[text.find("def Xform \"towel\"").expect("its group")..];
    let line = own.lines().find(|line| line.contains("xformOp:translate =")).expect("a place");
    let origin = triples(line.split(" = ").nth(1).expect("a value"))[0];
    let [whole, torn] = [1, 2].map(|k| prim(own, &format!("def Mesh \"towel_surface_{k}\"")));
    let near = |time: f64, frame: u64| (time - frame as f64).abs() < 1e-9;
    for (mesh, frames) in [(whole, 0..TEARS / EVERY), (torn, TEARS / EVERY..STEPS / EVERY + 1)] {
        let points = samples(mesh, "points");
        assert_eq!(points.len() as u64, frames.end - frames.start);
        for ((time, value), frame) in points.into_iter().zip(frames.clone()) {
            assert!(near(time, frame), "{time} is frame {frame}");
            let places: Vec<Vec3> = triples(value).iter().map(|p| p + origin).collect();
            assert!(apart(&places, &recorded(&fixture, frame * EVERY).places) < 2e-7);
        }
        for attribute in ["extent", "primvars:normals", "primvars:displayColor"] {
            assert_eq!(samples(mesh, attribute).len() as u64, frames.end - frames.start);
        }
        let warm = samples(mesh, "primvars:quantity").last().expect("samples").1;
        assert!(warm.matches(',').count() as u32 >= POINTS * POINTS - 1);
        for line in
            ["uniform bool doubleSided = 1", "rel material:binding = </World/Looks/towel_sheet>"]
        {
            assert!(mesh.lines().any(|one| one.trim() == line), "{line}");
        }
    }
    let seen = |mesh: &str| -> Vec<(u64, bool)> {
        let all = samples(mesh, "visibility").into_iter();
        all.map(|(time, word)| (time.round() as u64, word == "\"inherited\"")).collect()
    };
    let tear = TEARS / EVERY;
    assert_eq!(seen(whole), [(0, true), (tear, false)]);
    assert_eq!(seen(torn), [(0, false), (tear, true)]);
    assert!(text.contains("UsdPrimvarReader_float3"), "the colours of points are read");
    let moments = Moments::At(0.2);
    let text = fixture.text("y.usda", &ExportOptions { moments, ..ExportOptions::default() });
    let still = prim(&text, "def Mesh \"towel_surface_1\"");
    assert!(!still.contains("timeSamples"), "a moment does not move");
}

#[test]
fn tables_have_a_row_a_window_and_a_row_a_piece() {
    let fixture = waving();
    let told = report(&fixture, "x.csv", &ExportOptions::default());
    let names = told.files.iter().map(|file| file.file_name().expect("a name").to_string_lossy());
    let wanted = ["x_poses.csv", "x_windows.csv", "x_sheet_pieces.csv", "x.csv"];
    assert_eq!(names.collect::<Vec<_>>(), wanted);
    let read = |name: &str| {
        let text = std::fs::read_to_string(fixture.folder.path().join(name)).expect("a table");
        text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let windows: Vec<Vec<String>> = read("x_windows.csv");
    assert_eq!(windows.len() as u64, 1 + STEPS / EVERY);
    assert!(windows.iter().all(|row| row.len() == windows[0].len()));
    let cell = |row: &[String], name: &str| {
        row[windows[0].iter().position(|it| it == name).expect("a column")].clone()
    };
    let first = &windows[3];
    assert_eq!((&cell(first, "sheet")[..], &cell(first, "gap_m")[..]), ("\"towel\"", "0.00002"));
    assert_eq!((&cell(first, "first_step")[..], cell(first, "state").len()), ("8", 64));
    assert_eq!(
        (&cell(first, "momentum_z_kg_m_s")[..], &cell(first, "gravity_J")[..]),
        ("-0.01", "0.001")
    );
    assert_eq!(&cell(&windows[16], "torn_area_m2")[..], "0.00012");
    let pieces: Vec<Vec<String>> = read("x_sheet_pieces.csv");
    let column = |k: usize| pieces[1..].iter().map(|row| row[k].clone()).collect::<Vec<_>>();
    assert_eq!(
        (column(1), column(3)),
        (
            ["0", "1", "2"].map(str::to_owned).to_vec(),
            ["0", "60", "60"].map(str::to_owned).to_vec()
        )
    );
    let last = column(4).iter().map(|it| it.parse().expect("a time")).collect::<Vec<f64>>();
    assert!((last[0] - tears()).abs() < 1e-9 && (last[2] - 1.0).abs() < 1e-9, "{last:?}");
}

#[test]
fn damage_is_an_error_that_names_its_sheet_and_step() {
    let mut fixture = waving();
    fixture.recording.sheet_frames[5].offsets[7] = f32::NAN;
    let path = fixture.folder.path().join("x.glb");
    let told = export(&fixture.recording, &ExportOptions::default(), &path);
    let told = told.expect_err("is damaged").to_string();
    assert_eq!(told, "sheet 3 at step 20: entry 7 of offsets is not finite");
    assert!(!path.exists());
}

#[test]
fn a_run_without_sheets_says_nothing_of_them() {
    let fixture = super::common::fixture();
    let told = report(&fixture, "x.csv", &ExportOptions::default());
    assert_eq!(told.files.len(), 2);
    let text = serde_json::to_string(&told).expect("JSON");
    assert!(!text.contains("sheets") && !text.contains("notes"), "{text}");
}
