//! The readers of mesh files, and the door behind them.

use super::bytes::{INPUT, damaged};
use super::timed;
use crate::kit::is_solid;
use cullet_geometry::door::{Repair, admit};
use cullet_geometry::{TriMesh, shapes};
use cullet_tests::{files, root};

/// Most triangles of a damaged mesh that is also repaired: exact arithmetic takes its time.
const REPAIRED: usize = 40;

/// One of so many is repaired.
const STRIDE: usize = 8;

fn stl(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        let corners = mesh.corners(t);
        let numbers = corners.iter().flat_map(|p| [p.x, p.y, p.z]);
        numbers.for_each(|x| bytes.extend((x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl_text(mesh: &TriMesh) -> Vec<u8> {
    let mut text = "solid t\n".to_owned();
    for t in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in mesh.corners(t) {
            text += &format!("vertex {} {} {}\n", p.x, p.y, p.z);
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid t\n").into_bytes()
}

fn ply_binary(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    let numbers = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]);
    numbers.for_each(|x| bytes.extend((x as f32).to_le_bytes()));
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    }
    bytes
}

fn glb(mesh: &TriMesh) -> Vec<u8> {
    let mut blob: Vec<u8> = Vec::new();
    let numbers = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]);
    numbers.for_each(|x| blob.extend((x as f32).to_le_bytes()));
    let points = blob.len();
    mesh.triangles.iter().flatten().for_each(|i| blob.extend(i.to_le_bytes()));
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"children":[1],"scale":[1,2,1]}},{{"translation":[5,0,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",
        "min":[-1,-1,-1],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{points}}},
        {{"buffer":0,"byteOffset":{points},"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}}"#,
        mesh.vertices.len(),
        3 * mesh.triangles.len(),
        blob.len() - points,
        blob.len()
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + blob.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(blob);
    bytes
}

/// Reads, and repairs what is small: what comes out is a solid or an error in words.
fn read(name: &str, bytes: &[u8], repair: bool) {
    match timed(name, || cullet_assets::read(name, bytes)) {
        Ok(mesh) => {
            assert_eq!(mesh.validate(), Ok(()), "{name}");
            if !repair || mesh.triangles.len() > REPAIRED {
                return;
            }
            match timed(&format!("the door, with {mesh:?},"), || admit(&mesh, Repair::Auto)) {
                Ok((solid, report)) => {
                    is_solid(&solid);
                    assert!(report.volume > 0.0 && !report.to_string().is_empty());
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Holds the readers of one format to edits of valid files.
fn hold(name: &str, seeds: &[Vec<u8>], iterations: usize) {
    let readable = seeds.iter().filter(|seed| cullet_assets::read(name, seed).is_ok()).count();
    assert!(2 * readable >= seeds.len(), "{readable} of {} seeds are read", seeds.len());
    bolero::check!().with_iterations(iterations).with_max_len(INPUT).for_each(|input: &[u8]| {
        read(name, &damaged(input, seeds).1, input.len() % STRIDE == 1);
    });
}

fn cube() -> TriMesh {
    shapes::cuboid(cullet_geometry::Vec3::repeat(1.0), shapes::Detail::default()).expect("a box")
}

fn corpus(ending: &str) -> Vec<Vec<u8>> {
    let paths = files(&root().join("tests/corpus/meshes"), &[ending]);
    paths.iter().map(|path| std::fs::read(path).expect("a mesh")).collect()
}

#[test]
fn obj() {
    hold("fuzz.obj", &corpus(".obj"), 600);
}

#[test]
fn ply() {
    let mut seeds = corpus(".ply");
    seeds.push(ply_binary(&cube()));
    hold("fuzz.ply", &seeds, 600);
}

#[test]
fn stl_files() {
    hold("fuzz.stl", &[stl(&cube()), stl_text(&cube())], 1500);
}

#[test]
fn glb_files() {
    hold("fuzz.glb", &[glb(&cube())], 10_000);
}
