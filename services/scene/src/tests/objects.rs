//! A mesh file of several objects: one body, one object of it, or a body of each.

use super::super::{Scene, load_bundle};
use cullet_document::files::{Bundle, SceneFile};
use cullet_geometry::Vec3;
use std::sync::Arc;

/// Two boxes, two apart along x, with a material and texture coordinates each; z up.
fn shelf() -> String {
    let mut text = String::from("vt 0 0\nvt 1 0\nvt 1 1\n");
    let boxes = [("cup", 0.0, 1.0), ("big jug/1", 3.0, 2.0)];
    for (k, (name, x, size)) in boxes.into_iter().enumerate() {
        text += &format!("o {name}\nusemtl m{k}\n");
        for i in 0..8 {
            let at = |bit: usize| if i & bit == 0 { 0.0 } else { size };
            text += &format!("v {} {} {}\n", x + at(1), at(2), at(4));
        }
        let quads =
            [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
        for [a, b, c, d] in quads.map(|quad| quad.map(|i| i + 8 * k)) {
            text += &format!("f {a}/1 {b}/2 {c}/3\nf {a}/1 {c}/3 {d}/2\n");
        }
    }
    text
}

fn scene(body: &str) -> Result<Scene, String> {
    scene_with(body, &[])
}

/// The same, with more files.
fn scene_with(body: &str, more: &[(&str, String)]) -> Result<Scene, String> {
    let text = format!("{body}\nmaterial = \"granite\"\n");
    let file = |key: &str, text: String| SceneFile {
        key: format!("scene/{key}"),
        bytes: Arc::new(text.into_bytes()),
    };
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
               property float z\nelement face 4\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    let library = "newmtl m0\nKd 0.5 0 0\nmap_Kd wood.PNG\n".to_owned();
    let shelf = format!("mtllib shelf.mtl\nmtllib ../up.mtl\n{}", shelf());
    let mut files = vec![
        file("scene.toml", text),
        file("shelf.obj", shelf),
        file("shelf.mtl", library),
        file("wood.PNG", "a picture".to_owned()),
        file("t.ply", ply.to_owned()),
    ];
    files.extend(more.iter().map(|(key, text)| file(key, text.clone())));
    let (name, main) = ("test".to_owned(), "scene/scene.toml".to_owned());
    load_bundle(&Bundle { name, main, overrides: Vec::new(), files })
        .map_err(|errors| errors.to_string())
}

const SHELF: &str = "[[body]]\nname = \"shelf\"\nmesh = \"shelf.obj\"\n";

/// Corners of the box around a body in the world \[m\].
fn bounds(scene: &Scene, name: &str) -> (Vec3, Vec3) {
    let body = scene.bodies.iter().find(|body| body.name == name).expect("is there");
    body.solid.transformed(&body.pose).mesh.bounds().expect("has corners")
}

fn near(a: (Vec3, Vec3), low: [f64; 3], high: [f64; 3]) {
    let off = (a.0 - Vec3::from(low)).norm() + (a.1 - Vec3::from(high)).norm();
    assert!(off < 1e-9, "{a:?}, not {low:?} to {high:?}");
}

#[test]
fn by_default_they_are_shapes_of_one_body() {
    let scene = scene(&format!("{SHELF}scale = 0.1")).expect("loads");
    assert_eq!(scene.bodies.len(), 1);
    near(bounds(&scene, "shelf"), [0.0; 3], [0.5, 0.2, 0.2]);
    let surface = scene.bodies[0].surface.as_ref().expect("has attributes");
    assert_eq!(surface.object_names, ["cup", "big jug/1"]);
    assert_eq!((surface.slots[0], surface.slots[12]), (0, 1));
    assert_eq!(surface.materials[0].base_colour, [0.5, 0.0, 0.0, 1.0]);
    assert_eq!(scene.bodies[0].mesh_file.as_deref(), Some("scene/shelf.obj"));
    let taken = scene.files.iter().find(|file| file.key == "scene/wood.PNG");
    assert_eq!(taken.map(|file| &file.bytes[..]), Some(&b"a picture"[..]));
    // The mesh that was read and the body that was made of it lie on each other.
    let distance = |a: &Vec3| {
        let corners = scene.bodies[0].solid.mesh.vertices.iter();
        corners.map(|b| (a - b).norm()).fold(f64::INFINITY, f64::min)
    };
    let farthest = surface.mesh.vertices.iter().map(distance).fold(0.0, f64::max);
    assert!(farthest < 1e-12, "{farthest:e} m");
}

#[test]
fn each_can_be_a_body_of_its_own() {
    let keys = "objects = \"bodies\"\nfit = 0.5\nposition = [1, 0, 0]\nvelocity = [0, 0, 1]";
    let scene = scene(&format!("{SHELF}{keys}")).expect("loads");
    let names: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["shelf-cup", "shelf-big jug_1"]);
    near(bounds(&scene, "shelf-cup"), [1.0, 0.0, 0.0], [1.1, 0.1, 0.1]);
    near(bounds(&scene, "shelf-big jug_1"), [1.3, 0.0, 0.0], [1.5, 0.2, 0.2]);
    for body in &scene.bodies {
        assert_eq!(body.generator.as_deref(), Some("shelf"));
        assert_eq!(body.velocity, Vec3::z());
        let surface = body.surface.as_ref().expect("has attributes");
        assert_eq!(body.mesh_object.as_ref(), surface.object_names.first());
        assert_eq!(surface.mesh.triangles.len(), 12);
    }
}

/// What anchors and turns one body anchors and turns them all as one.
#[test]
fn their_anchor_is_that_of_all_together() {
    let keys = "scale = 0.1\nanchor = \"base\"\nrotation = { axis = [0, 0, 1], degrees = 90 }";
    let one = scene(&format!("{SHELF}{keys}")).expect("loads");
    let apart = scene(&format!("{SHELF}{keys}\nobjects = \"bodies\"")).expect("loads");
    let (low, high) = bounds(&one, "shelf");
    near((low, high), [-0.1, -0.25, 0.0], [0.1, 0.25, 0.2]);
    let (cup, jug) = (bounds(&apart, "shelf-cup"), bounds(&apart, "shelf-big jug_1"));
    let all = (cup.0.inf(&jug.0), cup.1.sup(&jug.1));
    near(all, low.into(), high.into());
    near(cup, [0.0, -0.25, 0.0], [0.1, -0.15, 0.1]);
}

#[test]
fn one_can_be_picked_and_is_then_the_whole() {
    let scene = scene(&format!("{SHELF}object = \"cup\"\nfit = 0.5")).expect("loads");
    assert_eq!(scene.bodies.len(), 1);
    near(bounds(&scene, "shelf"), [0.0; 3], [0.5; 3]);
}

#[test]
fn what_is_wrong_with_objects_is_reported_at_its_key() {
    let long = format!("[[body]]\nname = \"{}\"\nmesh = \"shelf.obj\"\n", "x".repeat(75));
    let template = "[[grid]]\nname = \"g\"\ncount = [1, 1, 1]\nspacing = [1, 1, 1]\n[grid.body]\n";
    let cases = [
        (
            format!("{SHELF}object = \"cub\""),
            "body.shelf.object: there is no object \"cub\" in scene/shelf.obj, which has \"cup\", \
             \"big jug/1\": did you mean \"cup\"?",
        ),
        (
            format!("{SHELF}object = \"cup\"\nobjects = \"bodies\""),
            "body.shelf.object: picks one object; `objects = \"bodies\"` makes a body of each",
        ),
        (format!("{SHELF}objects = \"many\""), "body.shelf.objects"),
        (
            format!("{long}objects = \"bodies\""),
            "would have a name of 85 bytes; at most 80 are taken",
        ),
        (
            "[[body]]\nname = \"t\"\nmesh = \"t.ply\"\nobjects = \"bodies\"".to_owned(),
            "body.t.objects: this file has no objects with names; it is one body",
        ),
        (
            "[[body]]\nname = \"t\"\nmesh = \"t.ply\"\nobject = \"a\"".to_owned(),
            "body.t.object: scene/t.ply has no objects with names",
        ),
        (
            "[[body]]\nname = \"t\"\nshape = { kind = \"sphere\", radius = 1 }\nobject = \"a\""
                .to_owned(),
            "body.t.object: is for a `mesh`",
        ),
        (
            format!("{template}mesh = \"shelf.obj\"\nobjects = \"bodies\""),
            "grid.g.body.objects: a template is one body",
        ),
        (
            format!("[world]\nmax_bodies = 1\n{SHELF}objects = \"bodies\""),
            "body.shelf.objects: the scene would have 2 bodies; world.max_bodies is 1",
        ),
        (
            format!("{SHELF}objects = \"bodies\"\nkeyframes = [{{ at = 0 }}, {{ at = 1 }}]"),
            "body.shelf.keyframes: only a body of one object is driven; its mesh file has 2",
        ),
    ];
    for (text, said) in cases {
        let told = scene(&text).expect_err(&text);
        assert!(told.contains(said), "{text}\n{told}\nnot: {said}");
    }
}

#[test]
fn materials_are_told_with_their_units() {
    let scene = scene(SHELF).expect("loads");
    let told: serde_json::Value = serde_json::from_str(&scene.materials_json()).expect("is JSON");
    let density = serde_json::json!({"value": 2640.0, "unit": "kg/m³"});
    assert_eq!(told["granite"]["density"], density);
    assert_eq!(told["granite"]["fracture_energy"]["unit"], "J/m²");
    assert_eq!(told.as_object().map(serde_json::Map::len), Some(1), "only what bodies are of");
}

/// A ball of a file keeps its corners, so that the world takes it for one, however far its numbers
/// are rounded.
#[test]
fn a_ball_of_a_file_is_a_ball() {
    let (rings, sides) = (16, 24);
    let mut text = String::from("v 0 0 0.05\nv 0 0 -0.05\n");
    for ring in 1..rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for side in 0..sides {
            let round = std::f64::consts::TAU * f64::from(side) / f64::from(sides);
            let (out, up) = (0.05 * polar.sin(), 0.05 * polar.cos());
            text += &format!("v {:.6} {:.6} {up:.6}\n", out * round.cos(), out * round.sin());
        }
    }
    let at = |ring: i32, side: i32| 3 + (ring - 1) * sides + side % sides;
    for side in 0..sides {
        text += &format!("f 1 {} {}\n", at(1, side), at(1, side + 1));
        text += &format!("f 2 {} {}\n", at(rings - 1, side + 1), at(rings - 1, side));
        for ring in 1..rings - 1 {
            let [a, b] = [at(ring, side), at(ring + 1, side)];
            let [c, d] = [at(ring + 1, side + 1), at(ring, side + 1)];
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    let body = "[[body]]\nname = \"ball\"\nmesh = \"ball.obj\"";
    let ball = scene_with(body, &[("ball.obj", text)]);
    let hulls = &ball.expect("a scene").bodies[0].hulls;
    assert_eq!((hulls.len(), hulls[0].len()), (1, (2 + (rings - 1) * sides) as usize));
}
