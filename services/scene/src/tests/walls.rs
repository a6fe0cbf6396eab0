//! Surfaces from files that are the middle of a thin wall: meshes, open or closed, and patches.

use super::super::{Scene, load_bundle};
use cullet_document::files::{Bundle, SceneFile};
use std::sync::Arc;

/// A sheet of 2 by 1 in the plane z = 0, of four triangles, two of which face the other way.
const SHEET: &str = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n\
                     f 1 2 5\nf 1 5 4\nf 2 5 6\nf 2 6 3\n";

/// The same with a slit of a hundredth between its halves.
const SLIT: &str = "v 0 0 0\nv 1 0 0\nv 1.01 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 1.01 1 0\n\
                    v 2 1 0\nv 1 2 0\nf 1 2 6\nf 1 6 5\nf 3 4 8\nf 3 8 7\nf 5 6 9\n\
                    f 7 8 9\nf 6 7 9\n";

/// A quarter of a cylinder of radius 1 and length 2, exactly, in two patches.
fn cylinder() -> String {
    let patch = |from: f64| {
        let share = std::f64::consts::FRAC_1_SQRT_2;
        let points = [from, from + 1.0].map(|z| format!("[1, 0, {z}], [1, 1, {z}], [0, 1, {z}]"));
        let middle = format!("[1, 0, {0}], [1, 1, {0}], [0, 1, {0}]", from + 0.5);
        let row = format!("1, {share}, 1");
        format!(
            "{{ \"degree_u\": 2, \"degree_v\": 2, \"size_u\": 3, \"size_v\": 3,
            \"knotvector_u\": [0, 0, 0, 1, 1, 1], \"knotvector_v\": [0, 0, 0, 1, 1, 1],
            \"control_points\": {{ \"points\": [{}, {middle}, {}],
            \"weights\": [{row}, {row}, {row}] }}, \"delta\": [0.05, 0.05] }}",
            points[0], points[1]
        )
    };
    let (one, two) = (patch(0.0), patch(1.0));
    format!("{{ \"shape\": {{ \"type\": \"surface\", \"count\": 2, \"data\": [{one}, {two}] }} }}")
}

fn scene(file: &str, text: &str, body: &str) -> Result<Scene, String> {
    let scene = format!(
        "[[body]]\nname = \"wall\"\nmaterial = \"soda-lime-glass\"\nmesh = \"{file}\"\n{body}\n"
    );
    let file = |key: &str, text: &str| SceneFile {
        key: format!("scene/{key}"),
        bytes: Arc::new(text.as_bytes().to_vec()),
    };
    let files = vec![file("scene.toml", &scene), file(file_name(&scene), text)];
    let (name, main) = ("test".to_owned(), "scene/scene.toml".to_owned());
    load_bundle(&Bundle { name, main, overrides: Vec::new(), files })
        .map_err(|errors| errors.to_string())
}

fn file_name(scene: &str) -> &str {
    scene.split("mesh = \"").nth(1).and_then(|rest| rest.split('"').next()).expect("a mesh")
}

fn volume(scene: &Scene) -> f64 {
    scene.bodies[0].solid.mesh.signed_volume()
}

#[test]
fn an_open_mesh_becomes_a_wall() {
    let sheet = scene("a.obj", SHEET, "thickness = \"20 mm\"").expect("a wall");
    assert!((volume(&sheet) / 0.04 - 1.0).abs() < 1e-9, "{}", volume(&sheet));
    assert!(sheet.bodies[0].solid.mesh.is_closed());
    let told: Vec<String> = sheet.warnings.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|line| line.contains("2 triangles turned over")), "{told:?}");
    // It is scaled, its thickness is not.
    let half = scene("a.obj", SHEET, "thickness = \"20 mm\"\nscale = 0.5").expect("a wall");
    assert!((volume(&half) / 0.01 - 1.0).abs() < 1e-9, "{}", volume(&half));
    let refused = scene("a.obj", SHEET, "thickness = \"20 mm\"\nrepair = \"refuse\"");
    let refused = refused.expect_err("it faces both ways");
    assert!(refused.contains("body.wall.mesh: ") && refused.contains("opposite ways"), "{refused}");
}

#[test]
fn patches_become_a_wall_of_their_exact_shape() {
    let wall = scene("a.json", &cylinder(), "thickness = \"10 mm\"").expect("a wall");
    // π r/2 times length and thickness, less what the edges of 3 degrees leave out.
    let wanted = std::f64::consts::PI * 0.01;
    assert!((volume(&wall) / wanted - 1.0).abs() < 1e-3, "{} of {wanted}", volume(&wall));
    let mesh = &wall.bodies[0].solid.mesh;
    assert!(mesh.is_closed() && mesh.components().len() == 1, "the patches are one wall");
}

#[test]
fn what_is_no_wall_is_refused_in_words() {
    let thick = "thickness = \"20 mm\"";
    let trimmed = cylinder().replacen("\"delta\"", "\"trims\": [], \"delta\"", 1);
    let cubic = cylinder().replacen("\"degree_u\": 2", "\"degree_u\": 3", 1);
    let short = cylinder().replacen("\"size_v\": 3", "\"size_v\": 4", 1);
    let apart = cylinder()
        .replace("[1, 0, 1], [1, 1, 1], [0, 1, 1]", "[1, 0, 1.004], [1, 1, 1.004], [0, 1, 1.004]");
    let apart =
        apart.replacen("1.004], [1, 1, 1.004], [0, 1, 1.004]", "1], [1, 1, 1], [0, 1, 1]", 1);
    let curve = cylinder().replace("\"type\": \"surface\"", "\"type\": \"curve\"");
    for (file, text, body, words) in [
        ("a.obj", SLIT, thick, "body.wall.mesh: two edges of the surface come within 0.01"),
        ("a.obj", SHEET, "thickness = 0", "body.wall.thickness: "),
        ("a.obj", SHEET, "", "body.wall.mesh: the mesh encloses no volume"),
        ("a.json", &trimmed, thick, "patch 0, which is trimmed, is not read here"),
        ("a.json", &cubic, thick, "patch 0: "),
        ("a.json", &short, thick, "patch 0: size_v is 4, but its knots ask for 3"),
        ("a.json", &apart, thick, "two edges of the surface come within 0.004"),
        ("a.json", &curve, thick, "a shape of type \"curve\" is not read here"),
        ("a.json", "{ \"shape\": 3 }", thick, "line 1: "),
    ] {
        let said = scene(file, text, body).err();
        let said = said.unwrap_or_else(|| panic!("{words:?}: it is taken"));
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
    let box_ = "shape = { kind = \"box\", size = [1, 1, 1] }\nthickness = \"1 mm\"";
    let text = format!("[[body]]\nname = \"wall\"\nmaterial = \"granite\"\n{box_}\n");
    let said = super::from_text(&text, &[]).expect_err("a shape has its measures").to_string();
    assert!(said.contains("body.wall.thickness: is for a `mesh`"), "{said}");
}
