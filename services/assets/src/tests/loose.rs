//! Files as programs write them: whatever is no surface is left out, whatever names nothing that
//! matters is passed over, and the volume is that of the file.

use super::super::{MeshFileError, read, read_surface};
use super::{ply, stl_binary, stl_text, volume};

/// A cube of side 1 whose faces are four corners each.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn volume_of(name: &str, bytes: &[u8]) -> f64 {
    volume(&read(name, bytes).unwrap_or_else(|error| panic!("{name}: {error}")))
}

fn assert_cube(text: &[u8], what: &str) {
    let volume = volume_of("c.obj", text);
    assert!((volume - 1.0).abs() < 1e-12, "{what}: {volume}");
}

#[test]
fn an_obj_is_read_however_its_text_is_written() {
    let marked = format!("\u{feff}{CUBE}");
    let wide: Vec<u8> = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let latin = [b"# f\xfcr\no S\xe4ule\nusemtl Stein \xe4\n", CUBE.as_bytes()].concat();
    let joined = CUBE.replace("f 1 4 3 2", "f 1 4 \\\n3 2 # C:\\");
    for (what, text) in [
        ("a mark", marked.into_bytes()),
        ("UTF-16", wide),
        ("Latin-1", latin),
        ("lines that go on", joined.into_bytes()),
        ("lines that end as on old systems", CUBE.replace('\n', "\r").into_bytes()),
        ("lines that end as on other systems", CUBE.replace('\n', "\r\n").into_bytes()),
        ("tabs and a weight", CUBE.replace("v 0 0 0", "\tv\t0.\t+0e-05\t.0\t1.0").into_bytes()),
    ] {
        assert_cube(&text, what);
    }
}

#[test]
fn attributes_of_an_obj_decide_nothing() {
    for (what, line) in [
        ("names without a name", "usemtl\nmtllib\no\ng\n"),
        ("a colour of some corners", "v 9 9 9 0.5 0.5 0.5\n"),
        ("half a colour", "v 9 9 9 0.5 0.5\n"),
        ("texture coordinates of one number, and of none", "vt 0.5\nvt\nvt x\n"),
        ("a normal of no length", "vn 0 0 0\nvn nan 0 0\nvn 1\n"),
        ("what nobody knows", "vp 1 2\ncstype bezier\ns off\nend\n"),
    ] {
        assert_cube(format!("{CUBE}{line}").as_bytes(), what);
    }
    let missing = CUBE.replace("f 1 4 3 2", "f 1/7/9 4/8/9 3//99 2/-50");
    assert_cube(missing.as_bytes(), "texture coordinates and normals that are not there");
}

#[test]
fn what_is_no_surface_is_left_out_and_counted() {
    let text = format!("{CUBE}l 1 2 3 4 7\nl 1 7\np 1 2\nf 1 2\ncurv 0 1 1 2\n");
    let file = read_surface("c.obj", text.as_bytes(), &mut |_| None).expect("reads");
    assert!((volume(&file.surface.mesh) - 1.0).abs() < 1e-12);
    let told = file.left_out.expect("is told");
    for part in ["2 lines", "1 point", "1 curve", "1 face of fewer than three corners"] {
        assert!(told.contains(part), "{told}");
    }
    let clean = read_surface("c.obj", CUBE.as_bytes(), &mut |_| None).expect("reads");
    assert_eq!(clean.left_out, None);
    let lines = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1\n";
    assert_eq!(read("l.obj", lines), Err(MeshFileError::Empty));
}

#[test]
fn survey_coordinates_keep_their_millimetres() {
    let far = CUBE.lines().map(|line| match line.strip_prefix("v ") {
        Some(place) => {
            let at: Vec<f64> = place.split(' ').map(|x| x.parse().expect("a number")).collect();
            format!("v {} {} {}\n", 692_000.125 + at[0], 5_335_000.25 + at[1], 512.0 + at[2])
        }
        None => format!("{line}\n"),
    });
    let mesh = read("far.obj", far.collect::<String>().as_bytes()).expect("reads");
    let sides = mesh.vertices.iter().map(|v| v - mesh.vertices[0]).map(|d| d.amax());
    assert_eq!(sides.fold(0.0, f64::max), 1.0);
}

#[test]
fn an_obj_that_cannot_be_read_says_why() {
    let told = |text: &str| read("t.obj", text.as_bytes()).expect_err("is refused").to_string();
    assert!(told("v 0,5 0 0\n").starts_with("line 1: \"0,5\" is no number: decimals"));
    assert!(told("v 0 0\n").contains("three coordinates"));
    assert!(told("v 0 0 0\nf 1 a 1\n").starts_with("line 2: \"a\" is no corner"));
    assert!(told("v 0 0 0\nf 1 2 3\n").contains("names corner 2, but there are 1"));
    assert!(told("v 0 0 0\nf 1 -2 1\n").contains("corner 0"));
}

#[test]
fn polygons_that_are_not_convex_have_their_own_area() {
    // A channel of height 1, whose ends begin at a corner that a fan would leave.
    let ends = [[2, 1], [1, 1], [1, 3], [0, 3], [0, 0], [3, 0], [3, 3], [2, 3]];
    let mut text = String::new();
    for z in 0..2 {
        ends.iter().for_each(|[x, y]| text += &format!("v {x} {y} {z}\n"));
    }
    // As listed they go round clockwise.
    text += "f 1 2 3 4 5 6 7 8\nf 16 15 14 13 12 11 10 9\n";
    let sides: String = (0..8)
        .map(|k| (k + 1, (k + 1) % 8 + 1))
        .map(|(a, b)| format!("f {b} {a} {} {}\n", a + 8, b + 8))
        .collect();
    let volume = volume_of("channel.obj", format!("{text}{sides}").as_bytes());
    assert!((volume.abs() - 7.0).abs() < 1e-12, "{volume}");
}

#[test]
fn an_stl_is_binary_by_its_length() {
    let mut named = stl_binary();
    named[..12].copy_from_slice(b"solid facet ");
    assert!((volume_of("t.stl", &named) - 1.0 / 6.0).abs() < 1e-12);
    named.extend([0; 7]);
    assert!((volume_of("t.stl", &named) - 1.0 / 6.0).abs() < 1e-12, "with more behind it");
    let mut unfinished = stl_binary();
    unfinished[80..84].fill(0);
    let told = read("t.stl", &unfinished).expect_err("is refused").to_string();
    assert!(told.contains("counts no triangles"), "{told}");
}

#[test]
fn an_stl_of_text_has_all_its_solids_in_any_letters() {
    let text = String::from_utf8(stl_text()).expect("text");
    let nameless = text.replace("solid t", "solid");
    let capitals = text.to_uppercase();
    let empty_first = format!("solid none\nendsolid none\n{text}");
    for one in [&nameless, &capitals, &empty_first] {
        assert!((volume_of("t.stl", one.as_bytes()) - 1.0 / 6.0).abs() < 1e-12, "{one}");
    }
    let moved = text.replace("vertex 0 ", "vertex 5 ").replace("vertex 1 ", "vertex 6 ");
    let two = format!("{text}{moved}");
    assert!((volume_of("t.stl", two.as_bytes()) - 1.0 / 3.0).abs() < 1e-12);
    let file = read_surface("t.stl", two.as_bytes(), &mut |_| None).expect("reads");
    assert_eq!(file.surface.object_names, ["t", "t-2"]);
    let cut = &text[..text.len() - 40];
    assert!(read("t.stl", cut.as_bytes()).is_err(), "within a facet");
}

#[test]
fn a_ply_has_strips_large_polygons_and_lines_that_nobody_knows() {
    let text = String::from_utf8(ply()).expect("text");
    let odd = text.replace("element vertex", "made by hand\nelement vertex");
    assert!((volume_of("t.ply", odd.as_bytes()) - 1.0 / 6.0).abs() < 1e-12);
    // The tetrahedron as one strip, 0 2 1 3 0 2: its triangles 0 2 1, 2 3 1, 1 3 0, 3 2 0.
    let (head, _) = text.split_once("3 0 2 1").expect("faces");
    let head = head.replace("element face 4", "element tristrips 1");
    let strip = format!("{head}7 0 2 1 3 0 2 -1\n");
    let strips = volume_of("t.ply", strip.as_bytes());
    assert!((strips.abs() - 1.0 / 6.0).abs() < 1e-12, "{strips}");
    let (count, mut large) = (2000, String::new());
    for k in 0..count {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(count)).sin_cos();
        large += &format!("{cos} {sin} 0\n");
    }
    large += &format!("0 0 1\n{count}");
    (0..count).rev().for_each(|k| large += &format!(" {k}"));
    large += "\n";
    (0..count).for_each(|k| large += &format!("3 {k} {} {count}\n", (k + 1) % count));
    let cone = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list int int vertex_indices\nend_header\n\
         {large}",
        count + 1,
        count + 1
    );
    // A pyramid over a regular polygon: n sin(2 pi/n) / 6.
    let n = f64::from(count);
    let wanted = n * (std::f64::consts::TAU / n).sin() / 6.0;
    assert!((volume_of("cone.ply", cone.as_bytes()) - wanted).abs() < 1e-9);
    let broken = text.replace("format ascii 1.0", "format strange 1.0");
    let told = read("t.ply", broken.as_bytes()).expect_err("is refused").to_string();
    assert!(told.starts_with("line 2: this is no PLY file") && !told.contains("Line"), "{told}");
}
