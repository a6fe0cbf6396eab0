//! Each format gives the same solid, and no bytes make a reader panic.

mod arranged;
mod loose;
mod motion;
mod surface;

use super::{MeshFileError, corners, read};
use cullet_geometry::TriMesh;
use motion::animated_glb::packed;

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn obj() -> Vec<u8> {
    let corners = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = FACES.iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    corners.chain(faces).collect::<String>().into_bytes()
}

fn stl_binary() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for x in face.iter().flat_map(|&i| CORNERS[i as usize]) {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl_text() -> Vec<u8> {
    let mut text = "solid t\n".to_owned();
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in face.map(|i| CORNERS[i as usize]) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid t\n").into_bytes()
}

fn ply() -> Vec<u8> {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                    property float z\nelement face 4\nproperty list uchar int vertex_indices\n\
                    end_header\n"
        .to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in FACES {
        text += &format!("3 {a} {b} {c}\n");
    }
    text.into_bytes()
}

fn glb(scale: [f32; 3]) -> Vec<u8> {
    let mut blob: Vec<u8> = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    blob.extend(FACES.iter().flatten().flat_map(|i| i.to_le_bytes()));
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"scale":[{},{},{}],"translation":[5,0,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
        "min":[0,0,0],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5125,"count":12,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},
        {{"buffer":0,"byteOffset":48,"byteLength":48}}],
        "buffers":[{{"byteLength":{}}}]}}"#,
        scale[0],
        scale[1],
        scale[2],
        blob.len()
    );
    packed(json, blob)
}

fn files() -> [(&'static str, Vec<u8>); 5] {
    [
        ("t.obj", obj()),
        ("t.stl", stl_binary()),
        ("t.STL", stl_text()),
        ("t.ply", ply()),
        ("t.glb", glb([1.0; 3])),
    ]
}

fn volume(mesh: &TriMesh) -> f64 {
    mesh.mass_properties().volume
}

#[test]
fn each_format_gives_the_tetrahedron() {
    for (name, bytes) in files() {
        let mesh = read(name, &bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4), "{name}");
        assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-12, "{name}: {}", volume(&mesh));
    }
}

#[test]
fn places_of_nodes_are_applied_and_mirrors_stay_outward() {
    let mesh = read("t.glb", &glb([2.0, 1.0, 1.0])).expect("reads");
    assert!((volume(&mesh) - 1.0 / 3.0).abs() < 1e-12);
    assert!(mesh.vertices.iter().all(|v| v.x >= 5.0));
    let mirrored = read("t.glb", &glb([-1.0, 1.0, 1.0])).expect("reads");
    assert!((volume(&mirrored) - 1.0 / 6.0).abs() < 1e-12, "outward after a mirror");
}

#[test]
fn colours_of_corners_are_read() {
    let text = String::from_utf8(ply()).expect("text");
    let shade = "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n";
    let text = text.replace("property float z\n", shade);
    let text = text.replace("1 0 0\n", "1 0 0 255 51 0\n").replace("0 0 0\n", "0 0 0 0 0 0\n");
    let text = text.replace("\n0 1 0\n", "\n0 1 0 0 0 0\n").replace("\n0 0 1\n", "\n0 0 1 0 0 0\n");
    let read = corners("t.ply", text.as_bytes()).unwrap_or_else(|error| panic!("{error}:\n{text}"));
    assert_eq!((read.points.len(), read.colours.len()), (4, 4));
    assert_eq!(read.colours[1], [1.0, 0.2, 0.0]);
    // A corner that no face uses is still one of the file's.
    let lone = corners("t.obj", b"v 9 9 9 0 0 1\nv 0 0 0 1 0 0\n").expect("reads");
    assert_eq!((lone.points[0].x, lone.colours[0]), (9.0, [0.0, 0.0, 1.0]));
    assert!(corners("t.glb", &glb([1.0; 3])).expect("reads").colours.is_empty());
}

#[test]
fn polygons_become_triangles() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    assert_eq!(read("q.obj", text.as_bytes()).expect("reads").triangles.len(), 2);
}

#[test]
fn faults_have_a_place() {
    let bad = read("t.obj", b"v 0 0 0\nv 1 0 zero\n").expect_err("no number");
    assert!(matches!(bad, MeshFileError::Malformed { line: Some(2), .. }), "{bad}");
    let bad = read("t.stl", &stl_binary()[..200]).expect_err("short");
    assert_eq!(bad, MeshFileError::Truncated { have: 200, need: 284 });
    assert_eq!(read("t.obj", b"v 0 0 0\n"), Err(MeshFileError::Empty));
    let name = read("t.fbx", b"").expect_err("no format");
    assert_eq!(name, MeshFileError::UnknownFormat { name: "t.fbx".to_owned() });
    let text = String::from_utf8(ply()).expect("text").replace("3 0 2 1", "3 0 2 9");
    let bad = read("t.ply", text.as_bytes()).expect_err("no such corner");
    assert_eq!(bad, MeshFileError::IndexOutOfRange { face: 0, index: 9, count: 4 });
    let bad = read("t.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect_err("not a number");
    assert!(matches!(bad, MeshFileError::BadCoordinate { vertex: 0, .. }), "{bad}");
    // Faces that use corners in another order do not change which one it is.
    let bad = read("t.obj", b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 3 2\n").expect_err("not a number");
    assert!(matches!(bad, MeshFileError::BadCoordinate { vertex: 1, .. }), "{bad}");
    let lie = "ply\nformat binary_little_endian 1.0\nelement vertex 900000000000\nend_header\n";
    assert!(read("t.ply", lie.as_bytes()).is_err());
}

#[test]
fn cut_or_changed_bytes_never_panic() {
    for (name, bytes) in files() {
        for end in 0..bytes.len() {
            let _result = read(name, &bytes[..end]);
        }
        for at in 0..bytes.len() {
            for value in [0, 0x7f, 0xff] {
                let mut changed = bytes.clone();
                changed[at] = value;
                let _result = read(name, &changed);
            }
        }
    }
}

/// A GLB file whose indices are said to be floating-point numbers.
fn hostile() -> Vec<u8> {
    let (mut bytes, integer) = (glb([1.0; 3]), br#""componentType":5125"#);
    let at = bytes.windows(integer.len()).position(|window| window == integer);
    let end = at.expect("a kind of index") + integer.len();
    bytes[end - 1] = b'6';
    bytes
}

#[test]
fn a_reader_that_gives_up_is_not_heard_and_everything_else_is() {
    let exe = std::env::current_exe().expect("this test has a path");
    let helper = "tests::gives_up_and_panics_elsewhere";
    let args = ["--exact", helper, "--nocapture"];
    let said = std::process::Command::new(exe).args(args).output().expect("it starts");
    let stderr = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{stderr}");
    assert_eq!(stderr.matches("panicked at").count(), 2, "{stderr}");
    assert!(stderr.contains("beside it") && stderr.contains("after it"), "{stderr}");
}

/// Runs with the others, and once more in a process of its own for the test above.
#[test]
fn gives_up_and_panics_elsewhere() {
    let bytes = hostile();
    let read = super::hush::hushed(|| {
        assert!(std::thread::spawn(|| panic!("beside it")).join().is_err());
        read("t.glb", &bytes)
    });
    let Ok(Err(MeshFileError::Malformed { reason, .. })) = read else { panic!("{read:?}") };
    assert!(reason.contains("gave up"), "{reason}");
    assert!(std::panic::catch_unwind(|| panic!("after it")).is_err());
}
