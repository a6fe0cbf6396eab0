//! Sheets that wave and tear, in everything that is exported.

use super::common::{Fixture, GlbScene};
use cullet_export::{ExportOptions, ExportReport, Moments, export, page_glb};
use cullet_geometry::Vec3;
use cullet_record::synthetic::waving::{EVERY, POINTS, SHEET, TEARS};
use cullet_record::synthetic::{self, STEP, STEPS};
use cullet_record::{Recording, SheetMoment};
use std::collections::BTreeMap;

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

/// Where the points of a sheet are, from those of its two faces, which come first; and how far the
/// faces are apart at least and at most \[m\].
fn middle(faces: &[Vec3], points: usize) -> (Vec<Vec3>, [f64; 2]) {
    let pairs = || (0..points).map(|k| (faces[k], faces[k + points]));
    let ways = || pairs().map(|(above, below)| (above - below).norm());
    let thickness = [ways().fold(f64::INFINITY, f64::min), ways().fold(0.0, f64::max)];
    (pairs().map(|(above, below)| (above + below) / 2.0).collect(), thickness)
}

/// How far a node has a sheet from where it is, as it was recorded, at a time of the file \[m\].
fn off(scene: &GlbScene, node: &gltf::Node<'_>, time: f64, due: &[Vec3]) -> f64 {
    let (faces, lengths) = places(scene, node, time);
    let (found, [thin, thick]) = middle(&faces, due.len());
    // Half way between two frames it is a little thinner where it turns.
    assert!(thick < 2.01e-4 && thin > 1.8e-4, "{thin} to {thick} m thick");
    assert!(lengths.iter().all(|length| (length - 1.0).abs() < 0.05), "{time} s");
    apart(&found, due)
}

/// Where the points are between two recorded steps.
fn way(fixture: &Fixture, [from, to]: [u64; 2], share: f64) -> Vec<Vec3> {
    let ends = [from, to].map(|step| recorded(fixture, step).places);
    ends[0].iter().zip(&ends[1]).map(|(a, b)| a + (b - a) * share).collect()
}

/// Whether each edge of a node's faces runs once in each direction; corners at one place are one.
fn is_closed(scene: &GlbScene, node: &gltf::Node<'_>) -> bool {
    let part = node.mesh().expect("a mesh").primitives().next().expect("faces");
    let reader = part.reader(|_| Some(&scene.blob));
    let at: Vec<[u32; 3]> =
        reader.read_positions().expect("places").map(|p| p.map(f32::to_bits)).collect();
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    let mut edges: BTreeMap<[[u32; 3]; 2], usize> = BTreeMap::new();
    for corners in indices.as_chunks::<3>().0 {
        let [a, b, c] = corners.map(|v| at[v as usize]);
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    edges.iter().all(|(&[a, b], &count)| count == 1 && edges.get(&[b, a]) == Some(&1))
}

#[test]
fn both_faces_and_walls_along_rim_and_tear_close_it() {
    let fixture = waving();
    // Its rim; the tear's two lips with theirs.
    for (time, torn) in [(0.2, false), (0.9, true)] {
        let moments = Moments::At(time);
        let scene = fixture.glb(&ExportOptions { moments, ..ExportOptions::default() });
        let node = named(&scene, "towel");
        assert!(is_closed(&scene, &node), "{time} s");
        let side = u64::from(POINTS) - 1;
        let rims = 4 * side + if torn { 2 * side } else { 0 };
        let part = node.mesh().expect("a mesh").primitives().next().expect("faces");
        let count = part.indices().expect("indices").count() as u64;
        assert_eq!(count, 3 * (2 * 2 * side * side + 2 * rims));
        assert!(!part.material().double_sided());
    }
}

#[test]
fn a_short_glb_of_one_surface_has_each_frame_as_a_shape() {
    let fixture = waving();
    let scene = fixture.glb(&before());
    let node = named(&scene, "towel");
    let frames = TEARS.div_ceil(EVERY);
    let part = node.mesh().expect("a mesh").primitives().next().expect("faces");
    assert_eq!(part.morph_targets().count() as u64, frames - 1);
    let reader = part.reader(|_| Some(&scene.blob));
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    let surface = recorded(&fixture, 0).surface;
    assert_eq!(indices[..3 * surface.triangles.len()], *surface.triangles.as_flattened());
    // Both faces, and the corners of the walls.
    let count = 2 * (POINTS * POINTS + 4 * (POINTS - 1));
    assert_eq!(reader.read_colors(0).map(|it| it.into_rgb_f32().count() as u32), Some(count));
    for frame in 0..frames {
        let time = (frame * EVERY) as f64 * STEP;
        let off = off(&scene, &node, time, &recorded(&fixture, frame * EVERY).places);
        assert!(off < 2e-7, "{time} s: {off} m");
        let (_, lengths) = places(&scene, &node, time);
        assert!(lengths.iter().all(|length| (length - 1.0).abs() < 1e-5), "{time} s");
        assert!(scene.is_seen(&node, time));
    }
    // Half way between two frames it is half way.
    let due = way(&fixture, [2 * EVERY, 3 * EVERY], 0.5);
    assert!(off(&scene, &node, 2.5 * EVERY as f64 * STEP, &due) < 1e-6);
    assert_eq!(scene.facts(&node)["sheet"], SHEET);
    let told = report(&fixture, "y.glb", &before());
    assert_eq!((told.sheets, told.notes.len()), (1, 0));
}

#[test]
fn a_glb_of_a_tear_moves_and_has_its_surfaces_one_after_another() {
    let fixture = waving();
    let scene = fixture.glb(&ExportOptions::default());
    let [whole, torn] = ["towel_surface_1", "towel_surface_2"].map(|name| named(&scene, name));
    let seen = |node: &gltf::Node<'_>| [-0.01, 0.01].map(|off| scene.is_seen(node, tears() + off));
    assert_eq!((seen(&whole), seen(&torn)), ([true, false], [false, true]));
    assert!(scene.is_seen(&torn, STEPS as f64 * STEP));
    for frame in 0..=STEPS / EVERY {
        let step = frame * EVERY;
        let node = if step < TEARS { &whole } else { &torn };
        let off = off(&scene, node, step as f64 * STEP, &recorded(&fixture, step).places);
        assert!(off < 2e-7, "step {step}: {off} m");
    }
    // The whole one stays where it was last, until the torn one is there.
    let last = recorded(&fixture, TEARS - EVERY).places;
    assert!(off(&scene, &whole, tears() - 0.5 * STEP, &last) < 2e-7);
    let told = report(&fixture, "y.glb", &ExportOptions::default());
    assert_eq!((told.sheets, told.notes.len()), (1, 0));
}

/// A sheet of one surface whose first frames come again and again, as many as these.
fn long(frames: usize) -> Fixture {
    let mut fixture = waving();
    let first: Vec<_> = fixture.recording.sheet_frames[..10].to_vec();
    fixture.recording.windows.clear();
    let frame = |k: usize| {
        let mut frame = first[if (k / 10).is_multiple_of(2) { k % 10 } else { 9 - k % 10 }].clone();
        (frame.step, frame.time) = (k as u64 * EVERY, k as f64 * EVERY as f64 * STEP);
        frame
    };
    fixture.recording.sheet_frames = (0..frames).map(frame).collect();
    fixture
}

#[test]
fn a_long_one_has_several_meshes_that_join() {
    let fixture = long(40);
    let scene = fixture.glb(&ExportOptions::default());
    let names = ["towel_surface_1", "towel_surface_1_from_16", "towel_surface_1_from_31"];
    let all = names.map(|name| named(&scene, name));
    for k in 0..40 {
        let time = (k * EVERY) as f64 * STEP;
        // A jump may lie a rounding before its time.
        let seen: Vec<_> = all.iter().filter(|node| scene.is_seen(node, time + 1e-6)).collect();
        let [node] = seen[..] else { panic!("{} are seen at {time} s", seen.len()) };
        assert!(off(&scene, node, time, &recorded(&fixture, k * EVERY).places) < 2e-7);
        // Just before its time it is as good as there.
        let seen: Vec<_> = all.iter().filter(|node| scene.is_seen(node, time - 1e-4)).collect();
        let near = off(&scene, seen[0], time - 1e-4, &recorded(&fixture, k * EVERY).places);
        assert!(near < 2e-3, "{near} m at {time} s");
    }
}

#[test]
fn of_a_very_long_one_a_page_has_only_some_frames() {
    let scene = GlbScene::of_page(&page_glb(&long(1500).recording).expect("a page"));
    let node = named(&scene, "towel_surface_1_from_16");
    let part = node.mesh().expect("a mesh").primitives().next().expect("faces");
    // Of sixteen frames every second, and the last, which the next mesh begins with.
    assert_eq!(part.morph_targets().count(), 8);
}

#[test]
fn one_moment_has_it_as_it_is_then() {
    let fixture = waving();
    for (time, steps, share) in [(0.2, [24, 28], 0.0), (0.21, [24, 28], 0.3), (0.9, [108; 2], 0.0)]
    {
        let moments = Moments::At(time);
        let scene = fixture.glb(&ExportOptions { moments, ..ExportOptions::default() });
        let due = way(&fixture, steps, share);
        assert!(off(&scene, &named(&scene, "towel"), 0.0, &due) < 2e-7, "{time} s");
        assert_eq!(scene.document.animations().count(), 0);
    }
}

#[test]
fn a_part_of_the_run_begins_and_ends_between_frames() {
    let fixture = waving();
    let (start, end) = (9.5 * STEP, 30.5 * STEP);
    let scene = fixture.glb(&ExportOptions { start: Some(start), end: Some(end), ..before() });
    let node = named(&scene, "towel");
    assert!(scene.is_seen(&node, 0.0));
    for (time, steps, share) in
        [(start, [8, 12], 0.375), (12.0 * STEP, [12; 2], 0.0), (end, [28, 32], 0.625)]
    {
        let off = off(&scene, &node, time - start, &way(&fixture, steps, share));
        assert!(off < 2e-7, "{time} s: {off} m");
    }
    // One mesh of frames 9.5, 12, 16, 20, 24, 28 and 30.5.
    let part = node.mesh().expect("a mesh").primitives().next().expect("faces");
    assert_eq!(part.morph_targets().count(), 6);
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
            let faces: Vec<Vec3> = triples(value).iter().map(|p| p + origin).collect();
            let due = recorded(&fixture, frame * EVERY).places;
            assert!(apart(&middle(&faces, due.len()).0, &due) < 2e-7);
        }
        for attribute in ["extent", "primvars:normals", "primvars:displayColor"] {
            assert_eq!(samples(mesh, attribute).len() as u64, frames.end - frames.start);
        }
        let warm = samples(mesh, "primvars:quantity").last().expect("samples").1;
        assert!(warm.matches(',').count() as u32 >= POINTS * POINTS - 1);
        for line in
            ["uniform bool doubleSided = 0", "rel material:binding = </World/Looks/towel_sheet>"]
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
    assert_eq!((&cell(first, "sheet")[..], &cell(first, "gap_m")[..]), ("towel", "0.00002"));
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
