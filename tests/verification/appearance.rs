//! The artist's mesh survives fracture: on the skin of every fragment the texture coordinates,
//! materials and names are those of the file, at every corner.

use crate::common;

use common::unique;
use cullet::geometry::attributes::{AttributeTransfer, SkinTriangle};
use cullet::messages::JobReport;
use cullet::record::skin_of;
use cullet::{LocalWorkers, Quat, Recording, RunOptions, Scene, Vec3};
use glb::{Node, Primitive, glb};
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

#[path = "../common/glb.rs"]
mod glb;

/// Quads along an edge of the cube.
const QUADS: u8 = 4;
/// What the file is scaled by \[1\]; the cube in it has edge 1.
const SCALE: f64 = 0.2;
/// Where the file's origin is in the world \[m\].
const POSITION: [f64; 3] = [-0.3, -0.2, 0.1];
/// A corner of the cube in the file.
const CORNER: [f64; 3] = [2.0, 1.0, -1.0];
const MATERIALS: [&str; 2] = ["glaze", "clay"];

/// A triangle of the cube in the file, with its texture coordinates (v upward) and its material.
struct Triangle {
    corners: [[f64; 3]; 3],
    uv: [[f64; 2]; 3],
    slot: usize,
}

/// The texture coordinates of a place on the face of the cube that looks along an axis: each face
/// has its own place in an atlas and its own slopes, so there is a seam along every edge.
fn atlas(at: [f64; 3], axis: usize, high: bool) -> [f64; 2] {
    let [s, t] = [1, 2].map(|k| at[(axis + k) % 3] - CORNER[(axis + k) % 3]);
    let (column, row) = (axis as f64 / 4.0, if high { 0.5 } else { 0.0 });
    [s / (4.0 + axis as f64) + column, t / 2.5 + row]
}

/// The cube: a chess board of two materials over all faces, so that squares of one plane differ.
fn cube() -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let step = |k: u8| f64::from(k) / f64::from(QUADS);
    for (axis, high) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
        for (a, b) in (0..QUADS).flat_map(|a| (0..QUADS).map(move |b| (a, b))) {
            let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[da, db]: [u8; 2]| {
                let mut at = CORNER;
                at[axis] += if high { 1.0 } else { 0.0 };
                at[(axis + 1) % 3] += step(a + da);
                at[(axis + 2) % 3] += step(b + db);
                at
            });
            if !high {
                quad.reverse();
            }
            for corners in [[0, 1, 2], [0, 2, 3]].map(|three| three.map(|k: usize| quad[k])) {
                let uv = corners.map(|at| atlas(at, axis, high));
                triangles.push(Triangle { corners, uv, slot: usize::from((a + b) % 2) });
            }
        }
    }
    triangles
}

/// The cube in the file, y up.
fn as_glb(name: &'static str) -> Vec<u8> {
    let mut primitives =
        [0, 1].map(|slot| Primitive { material: Some(slot), ..Primitive::default() });
    for Triangle { corners, uv, slot } in cube() {
        let of = &mut primitives[slot];
        of.positions.extend(corners.map(|at| at.map(|x| x as f32)));
        of.uv.extend(uv.map(|[u, v]| [u as f32, 1.0 - v as f32]));
    }
    let materials = MATERIALS.map(|name| format!(r#"{{"name":"{name}"}}"#)).join(",");
    let node = Node { name, place: "", primitives: primitives.to_vec() };
    glb(&[node], &format!(r#""materials":[{materials}]"#), b"")
}

/// The same in an OBJ file.
fn as_obj(name: &str) -> Vec<u8> {
    let mut text = format!("o {name}\n");
    for (k, Triangle { corners, uv, slot }) in cube().iter().enumerate() {
        for ([x, y, z], [u, v]) in corners.iter().zip(uv) {
            let _ = writeln!(text, "v {x:?} {y:?} {z:?}\nvt {:?} {:?}", *u as f32, *v as f32);
        }
        let [a, b, c] = [1, 2, 3].map(|i| 3 * k + i);
        let _ = writeln!(text, "usemtl {}\nf {a}/{a} {b}/{b} {c}/{c}", MATERIALS[*slot]);
    }
    text.into_bytes()
}

const SCENE: &str = r#"
[world]
duration = "20 ms"
step = "1/1000 s"
gravity = [0, 0, 0]

[fracture]
max_particles = 4000

[[body]]
name = "pot"
mesh = "FILE"
up = "y"
scale = 0.2
position = [-0.3, -0.2, 0.1]
rotation = { axis = [1, 2, 3], degrees = 40 }
material = "plaster"

[[body]]
name = "ball"
shape = { kind = "sphere", radius = "40 mm", segments = 16 }
position = PLACE
velocity = WAY
material = "steel"
"#;

/// A place in the file to the world.
fn placed(at: [f64; 3]) -> Vec3 {
    let axis = Vec3::new(1.0, 2.0, 3.0).normalize();
    let turn = Quat::from_scaled_axis(axis * 40_f64.to_radians());
    let upright = Vec3::new(at[0], -at[2], at[1]);
    Vec3::from(POSITION) + turn * (SCALE * upright)
}

/// Runs the cube of this file with this family.
fn broken(file: &str, bytes: &[u8], family: &str) -> Recording {
    let out = unique("appearance");
    std::fs::create_dir_all(&out).expect("a folder");
    std::fs::write(out.join(file), bytes).expect("writes");
    let middle = placed(CORNER.map(|x| x + 0.5));
    let face = placed([CORNER[0] + 0.4, CORNER[1] + 1.0, CORNER[2] + 0.6]);
    let outward = (face - middle).normalize();
    let (place, way) = (face + 0.043 * outward, -25.0 * outward);
    let list = |v: Vec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
    let text = SCENE.replace("FILE", file).replace("PLACE", &list(place));
    std::fs::write(out.join("scene.toml"), text.replace("WAY", &list(way))).expect("writes");
    let scene = Scene::load(&out, &[format!("fracture.solver={family}")]).expect("a scene");
    let (folder, stop) = (out.join("run"), AtomicBool::new(false));
    let options = RunOptions::new(&folder, &stop);
    let outcome = cullet::run(&scene, &LocalWorkers::default(), &options, &mut |_| {});
    let recording = Recording::open(&outcome.expect("runs").recording).expect("opens");
    std::fs::remove_dir_all(&out).ok();
    let solved = |report: &JobReport| report.solver == family && report.fragments > 1;
    assert!(recording.reports.iter().any(solved), "{family} broke nothing");
    recording
}

/// The skin of every fragment of the pot, in the frame that the pot had.
fn skin(recording: &Recording) -> Vec<SkinTriangle> {
    let pot = recording.bodies.iter().find(|body| body.name == "pot").expect("the pot").id;
    let surface = recording.appearance_of(pot).expect("is sound").expect("has an appearance");
    let transfer = AttributeTransfer::new(&surface);
    let gone: Vec<u64> = recording
        .events
        .iter()
        .filter(|event| !event.fragments.is_empty())
        .filter_map(|event| event.body)
        .collect();
    let mut skin = Vec::new();
    let mut fragments = 0;
    let places = recording.rest_places();
    for body in recording.bodies.iter().filter(|body| !gone.contains(&body.id)) {
        let place = places[&body.id];
        if place.root != pot {
            continue;
        }
        fragments += 1;
        let solid = recording.mesh(body).expect("a mesh");
        let own = skin_of(&transfer, &solid, place.origin);
        skin.extend(
            own.into_iter()
                .map(|it| SkinTriangle { corners: it.corners.map(|p| p + place.origin), ..it }),
        );
    }
    assert!(fragments > 3, "{fragments} fragments");
    assert_eq!(surface.object_names, ["vessel"]);
    let names: Vec<&str> = surface.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, MATERIALS);
    skin
}

fn area(&[a, b, c]: &[Vec3; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// Each corner of the skin has the texture coordinates of the atlas at its place in the file, each
/// triangle the material of its square, and each material the area that it has in the file.
fn holds(file: &str, bytes: &[u8], family: &str) {
    let recording = broken(file, bytes, family);
    let whole = recording.bodies.iter().find(|body| body.name == "pot").expect("the pot");
    let row = recording.poses_at(0.0).into_iter().find(|row| row.id == whole.id).expect("a pose");
    // From the pot's frame back into the file, by what the scene says and the recorded pose.
    let zero = placed([0.0; 3]);
    let axes = [0, 1, 2].map(|k| {
        let mut at = [0.0; 3];
        at[k] = 1.0;
        placed(at) - zero
    });
    let back = |p: Vec3| {
        let away = row.pose.rotation * p + row.pose.translation.vector - zero;
        axes.map(|axis| axis.dot(&away) / axis.norm_squared())
    };
    let mut areas = [0.0; 2];
    let (mut worst, mut count) = (0.0_f64, 0);
    for triangle in skin(&recording) {
        let at = triangle.corners.map(back);
        let middle: [f64; 3] = std::array::from_fn(|k| (at[0][k] + at[1][k] + at[2][k]) / 3.0);
        let local = [0, 1, 2].map(|k| middle[k] - CORNER[k]);
        let depth = |k: usize| local[k].abs().min((local[k] - 1.0).abs());
        let axis = (0..3).min_by(|a, b| depth(*a).total_cmp(&depth(*b))).expect("three");
        assert!(depth(axis) < 1e-9, "{middle:?} is not on the cube");
        let high = local[axis] > 0.5;
        for (at, uv) in at.iter().zip(triangle.uv) {
            for (x, right) in uv.iter().zip(atlas(*at, axis, high)) {
                worst = worst.max((f64::from(*x) - right).abs());
            }
        }
        let quad = |k: usize| (local[(axis + k) % 3] * f64::from(QUADS)).floor() as i64;
        let slivers = 1e-9 * SCALE * SCALE;
        if area(&triangle.corners) > slivers {
            assert_eq!(i64::from(triangle.slot), (quad(1) + quad(2)) % 2, "{middle:?}");
        }
        areas[triangle.slot as usize] += area(&triangle.corners);
        count += 1;
    }
    println!("{file}, {family}: {count} triangles, {worst:.2e} off, {areas:?} m²");
    assert!(worst < 5e-6, "{file}, {family}: texture coordinates are {worst:e} off");
    for area in areas {
        let right = 3.0 * SCALE * SCALE;
        assert!((area / right - 1.0).abs() < 1e-9, "{file}, {family}: {area} m² of {right}");
    }
}

#[test]
fn a_glb_survives_sampled_fragments() {
    holds("pot.glb", &as_glb("vessel"), "geometric");
}

#[test]
fn an_obj_survives_sampled_fragments() {
    holds("pot.obj", &as_obj("vessel"), "geometric");
}

#[test]
fn a_glb_survives_solved_fragments() {
    holds("pot.glb", &as_glb("vessel"), "brittle");
}

#[test]
fn an_obj_survives_solved_fragments() {
    holds("pot.obj", &as_obj("vessel"), "brittle");
}

/// What a recording says beside: the materials with their units, and who looks how.
/// A number list of a GLB: the rows of an accessor.
fn rows(json: &serde_json::Value, binary: &[u8], accessor: &serde_json::Value) -> Vec<Vec<f64>> {
    let whole = |value: &serde_json::Value| value.as_u64().unwrap_or(0) as usize;
    let of = &json["accessors"][whole(accessor)];
    let view = &json["bufferViews"][whole(&of["bufferView"])];
    let width = match of["type"].as_str() {
        Some("SCALAR") => 1,
        Some("VEC2") => 2,
        _ => 3,
    };
    let size = if of["componentType"] == 5123 { 2 } else { 4 };
    let start = whole(&view["byteOffset"]) + whole(&of["byteOffset"]);
    let number = |bytes: &[u8]| match (of["componentType"].as_u64(), bytes) {
        (Some(5126), &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (Some(5125), &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (_, bytes) => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
    };
    let row = |k: usize| {
        let at = start + k * width * size;
        binary[at..at + width * size].chunks(size).map(number).collect()
    };
    (0..whole(&of["count"])).map(row).collect()
}

/// The export has the materials of the file as primitives of their own, and on them the area and
/// the area of the atlas that they have in the file.
#[test]
fn an_export_has_the_surface_of_the_artist() {
    let recording = broken("cube.glb", &as_glb("vessel"), "geometric");
    let out = unique("appearance-export");
    std::fs::create_dir_all(&out).expect("a folder");
    let moments = cullet::Moments::At(recording.summary().sim_seconds);
    let options = cullet::ExportOptions { moments, grains: false, ..Default::default() };
    let file = out.join("last.glb");
    cullet::export(&recording, &options, &file).expect("exports");
    let bytes = std::fs::read(&file).expect("reads");
    std::fs::remove_dir_all(&out).ok();
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4")) as usize;
    let text = &bytes[20..20 + length(12)];
    let json: serde_json::Value = serde_json::from_slice(text).expect("JSON");
    let binary = &bytes[28 + length(12)..];
    let mut found = [[0.0; 2]; 2];
    for node in json["nodes"].as_array().expect("nodes") {
        let Some(mesh) = node["mesh"].as_u64().filter(|_| node["extras"]["object"] == "pot") else {
            continue;
        };
        for part in json["meshes"][mesh as usize]["primitives"].as_array().expect("primitives") {
            let material = &json["materials"][part["material"].as_u64().expect("one") as usize];
            let name = material["name"].as_str().expect("a name");
            let Some(slot) = MATERIALS.iter().position(|it| name == format!("pot {it}")) else {
                assert_eq!(name, "pot crack");
                continue;
            };
            let attributes = &part["attributes"];
            let places = rows(&json, binary, &attributes["POSITION"]);
            let atlas = rows(&json, binary, &attributes["TEXCOORD_0"]);
            let indices = rows(&json, binary, &part["indices"]);
            for three in indices.chunks(3) {
                let at = [0, 1, 2].map(|k| three[k][0] as usize);
                let corner = |k: usize| Vec3::from_column_slice(&places[at[k]]);
                found[slot][0] += area(&[corner(0), corner(1), corner(2)]);
                let flat = |k: usize| Vec3::new(atlas[at[k]][0], atlas[at[k]][1], 0.0);
                found[slot][1] += area(&[flat(0), flat(1), flat(2)]);
            }
        }
    }
    // Each axis has two faces, half of each of either material.
    let charted: f64 = (0..3).map(|axis| 1.0 / ((4.0 + f64::from(axis)) * 2.5)).sum();
    for [area, atlas] in found {
        assert!((area / (3.0 * SCALE * SCALE) - 1.0).abs() < 1e-4, "{area} m²");
        assert!((atlas / charted - 1.0).abs() < 1e-4, "{atlas} of {charted}");
    }
}

#[test]
fn a_recording_has_its_materials_as_json() {
    let recording = broken("pot.obj", &as_obj("vessel"), "geometric");
    let told = recording.attachments.get("materials.json").expect("is attached");
    let told: serde_json::Value = serde_json::from_slice(told).expect("is JSON");
    let strength = serde_json::json!({"value": 2.5e6, "unit": "Pa"});
    assert_eq!(told["plaster"]["strength"], strength);
    assert_eq!(told["steel"]["density"]["unit"], "kg/m³");
    let ball = recording.bodies.iter().find(|body| body.name == "ball").expect("the ball").id;
    assert_eq!(recording.appearance_of(ball).expect("is sound"), None);
    let [look] = &recording.appearances[..] else { panic!("one mesh has an appearance") };
    assert!(Path::new(&look.file).ends_with("pot.obj"), "{}", look.file);
    assert!(recording.attachments.contains_key(&look.file));
}
