//! glTF files as exporters arrange them: bones, shape keys, instances, strips, whole numbers, and
//! buffers that lie elsewhere. What is read has the volume that the file shows.

use super::super::{MeshFileError, read, read_surface};
use super::volume;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use std::sync::Arc;

/// The cube of side 1, its faces as quads.
const QUADS: [[u16; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn cube() -> [[f32; 3]; 8] {
    let ring = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    std::array::from_fn(|k| [ring[k % 4][0], ring[k % 4][1], (k / 4) as f32])
}

const FLOATS: u32 = 5126;
const SHORTS: u32 = 5123;
const BYTES: u32 = 5121;

/// A document that grows: one buffer, and a view for each accessor.
#[derive(Default)]
struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    primitives: Vec<Value>,
    /// Members of the document, of its only mesh, and its nodes, of which the first is shown.
    more: Value,
    mesh: Value,
    nodes: Vec<Value>,
}

impl Document {
    fn add(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        let view = self.views.len() - 1;
        let mut accessor = json!(
            {"bufferView": view, "componentType": component, "count": count, "type": kind});
        if kind == "VEC3" {
            (accessor["min"], accessor["max"]) = (json!([0, 0, 0]), json!([1, 1, 1]));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn add_floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.add(kind, FLOATS, values.len(), &bytes)
    }

    fn add_indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.add("SCALAR", SHORTS, indices.len(), &bytes)
    }

    /// The cube as triangles, in one primitive with these further members and attributes.
    fn with_cube(members: &Value) -> Self {
        let mut document = Self::default();
        let position = document.add_floats("VEC3", &cube());
        let triangles = QUADS.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
        let indices = document.add_indices(&triangles.collect::<Vec<u16>>());
        let mut primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        merge(&mut primitive, members);
        document.primitives.push(primitive);
        document
    }

    fn text(&self, uri: &str) -> Vec<u8> {
        let nodes =
            if self.nodes.is_empty() { vec![json!({"mesh": 0})] } else { self.nodes.clone() };
        let mut mesh = json!({"primitives": self.primitives});
        merge(&mut mesh, &self.mesh);
        let mut all = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": nodes, "meshes": [mesh],
            "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": self.bytes.len(), "uri": uri}]});
        merge(&mut all, &self.more);
        all.to_string().into_bytes()
    }

    /// With its buffer inside.
    fn whole(&self) -> Vec<u8> {
        let coded = BASE64_STANDARD.encode(&self.bytes);
        self.text(&format!("data:application/octet-stream;base64,{coded}"))
    }

    fn volume(&self) -> f64 {
        volume(&read("t.gltf", &self.whole()).expect("reads"))
    }
}

fn merge(value: &mut Value, members: &Value) {
    for (name, member) in members.as_object().into_iter().flatten() {
        match value.get_mut(name) {
            Some(own) if own.is_object() => merge(own, member),
            _ => value[name] = member.clone(),
        }
    }
}

fn assert_close(volume: f64, right: f64, what: &str) {
    assert!((volume - right).abs() < 1e-6 * right, "{what}: {volume}, not {right}");
}

#[test]
fn buffers_lie_inside_or_beside() {
    let document = Document::with_cube(&Value::Null);
    assert_close(document.volume(), 1.0, "inside");
    let text = document.text("the%20cube.bin");
    let mut asked = Vec::new();
    let mut beside = |name: &str| {
        asked.push(name.to_owned());
        Some(Arc::new(document.bytes.clone()))
    };
    let file = read_surface("t.gltf", &text, &mut beside).expect("reads");
    assert_close(volume(&file.surface.mesh), 1.0, "beside");
    assert_eq!(asked, ["the cube.bin"]);
    let missing = read("t.gltf", &text).expect_err("there is no such file");
    assert!(matches!(&missing, MeshFileError::Beside { name } if name == "the cube.bin"));
    let short = read_surface("t.gltf", &text, &mut |_| Some(Arc::new(vec![0; 9])));
    assert!(matches!(short, Err(MeshFileError::Truncated { have: 9, .. })), "{short:?}");
}

/// A mesh with bones is where its bones are, whatever its node says (glTF 2.0, 3.7.3.3).
#[test]
fn bones_place_what_hangs_on_them() {
    let mut document = Document::with_cube(&Value::Null);
    // Below z = ½ all hangs on the first joint, above it on the second.
    let joints: Vec<u8> = (0..8).flat_map(|k| [u8::from(k >= 4), 0, 0, 0]).collect();
    let joints = document.add("VEC4", BYTES, 8, &joints);
    let weights = document.add_floats("VEC4", &[[1.0_f32, 0.0, 0.0, 0.0]; 8]);
    merge(
        &mut document.primitives[0]["attributes"],
        &json!({"JOINTS_0": joints, "WEIGHTS_0": weights}),
    );
    // The bind matrix takes the factor of 100 of a rig in centimetres out again.
    let inverse: [f32; 16] = std::array::from_fn(|k| {
        if k == 15 {
            1.0
        } else if k % 5 == 0 {
            0.01
        } else {
            0.0
        }
    });
    let inverse = document.add_floats("MAT4", &[inverse; 2]);
    document.nodes = vec![
        json!({"mesh": 0, "skin": 0, "scale": [7, 7, 7], "children": [1]}),
        json!({"scale": [100, 100, 100], "children": [2, 3]}),
        json!({}),
        json!({"translation": [0, 0, 2]}),
    ];
    document.nodes[1]["scale"] = json!([100.0 / 7.0, 100.0 / 7.0, 100.0 / 7.0]);
    document.more = json!({"skins": [{"joints": [2, 3], "inverseBindMatrices": inverse}]});
    // The upper face is lifted by 2 · 100.
    assert_close(document.volume(), 201.0, "two bones");
    merge(&mut document.nodes[3], &json!({"translation": [0, 0, 0]}));
    assert_close(document.volume(), 1.0, "two bones at rest");
    let half = document.add_floats("VEC4", &[[0.25_f32, 0.25, 0.0, 0.0]; 8]);
    let both: Vec<u8> = [0, 1, 0, 0].repeat(8);
    let both = document.add("VEC4", BYTES, 8, &both);
    merge(&mut document.nodes[3], &json!({"scale": [3, 3, 3]}));
    merge(&mut document.primitives[0]["attributes"], &json!({"JOINTS_0": both, "WEIGHTS_0": half}));
    assert_close(document.volume(), 8.0, "halfway between bones, weights of less than one in all");
}

#[test]
fn shape_keys_have_their_weights() {
    let mut document = Document::with_cube(&Value::Null);
    let moves = cube().map(|[x, ..]| [x, 0.0, 0.0]);
    let moves = document.add_floats("VEC3", &moves);
    document.primitives[0]["targets"] = json!([{"POSITION": moves}]);
    assert_close(document.volume(), 1.0, "a key without a weight");
    document.mesh = json!({"weights": [1.0]});
    assert_close(document.volume(), 2.0, "the weight of the mesh");
    document.nodes = vec![json!({"mesh": 0, "weights": [0.5]})];
    assert_close(document.volume(), 1.5, "the weight of the node");
}

#[test]
fn instances_are_objects_each() {
    let mut document = Document::with_cube(&Value::Null);
    let places: Vec<[f32; 3]> = (0..5).map(|k| [3.0 * k as f32, 0.0, 0.0]).collect();
    let places = document.add_floats("VEC3", &places);
    let scales = document.add_floats("VEC3", &[[2.0_f32, 1.0, -1.0]; 5]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = document.add_floats("VEC4", &[[0.0, 0.0, half, half]; 5]);
    let attributes = json!({"TRANSLATION": places, "SCALE": scales, "ROTATION": turns});
    let name = "EXT_mesh_gpu_instancing";
    document.nodes = vec![json!({"mesh": 0, "name": "brick",
        "extensions": {name: {"attributes": attributes}}})];
    document.more = json!({"extensionsUsed": [name], "extensionsRequired": [name]});
    let file = read_surface("t.gltf", &document.whole(), &mut |_| None).expect("reads");
    assert_close(volume(&file.surface.mesh), 10.0, "five mirrored bricks");
    assert_eq!(file.surface.object_names.len(), 5);
    let width = |axis: usize| {
        let all = file.surface.mesh.vertices.iter().map(|p| p[axis]);
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    };
    assert!((width(0) - 13.0).abs() < 1e-5 && (width(1) - 2.0).abs() < 1e-5, "turned by 90°");
    document.nodes[0]["extensions"][name]["attributes"] = json!({"TRANSLATION": 99});
    assert!(read("t.gltf", &document.whole()).is_err(), "an accessor that is not there");
}

#[test]
fn strips_and_fans_are_triangles_and_lines_are_none() {
    for (mode, order) in [(5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])] {
        let mut document = Document::default();
        let position = document.add_floats("VEC3", &cube());
        for quad in QUADS {
            let indices = document.add_indices(&order.map(|k: usize| quad[k]));
            document.primitives.push(
                json!({"attributes": {"POSITION": position}, "indices": indices, "mode": mode}),
            );
        }
        assert_close(document.volume(), 1.0, "a primitive a face");
        for mode in [0, 1, 2, 3] {
            document.primitives.push(json!({"attributes": {"POSITION": position}, "mode": mode}));
        }
        let file = read_surface("t.gltf", &document.whole(), &mut |_| None).expect("reads");
        assert_close(volume(&file.surface.mesh), 1.0, "with lines and points");
        let told = file.left_out.expect("is told");
        assert!(told.contains("1 point cloud") && told.contains("3 sets of lines"), "{told}");
    }
}

#[test]
fn whole_numbers_are_shares_where_the_file_says_so() {
    let mut document = Document::with_cube(&Value::Null);
    let bytes: Vec<u8> =
        cube().iter().flat_map(|[x, y, z]| [*x, *y, *z, 0.0].map(|v| v as u8 * 255)).collect();
    let position = document.add("VEC3", BYTES, 8, &bytes);
    document.views.last_mut().expect("a view")["byteStride"] = json!(4);
    document.accessors[position]["normalized"] = json!(true);
    document.primitives[0]["attributes"]["POSITION"] = json!(position);
    document.more = json!({"extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"]});
    assert_close(document.volume(), 1.0, "shares of 255");
    document.accessors[position]["normalized"] = json!(false);
    assert_close(document.volume(), 255.0_f64.powi(3), "the numbers themselves");
}

#[test]
fn what_is_packed_is_refused_with_a_way_out() {
    let mut document = Document::with_cube(&Value::Null);
    document.more = json!({"extensionsUsed": ["KHR_draco_mesh_compression"],
        "extensionsRequired": ["KHR_draco_mesh_compression"]});
    let why = read("t.gltf", &document.whole()).expect_err("is refused").to_string();
    assert!(why.contains("KHR_draco_mesh_compression") && why.contains("without compression"));
}

/// Few bytes name many corners: what they would become is bounded before it is made.
#[test]
fn corners_are_bounded_over_all_instances() {
    let mut document = Document::with_cube(&Value::Null);
    let bare = json!({"componentType": FLOATS, "count": 4_000_000, "type": "VEC3", "sparse": {
        "count": 1, "indices": {"bufferView": 1, "componentType": SHORTS},
        "values": {"bufferView": 0}}, "min": [0, 0, 0], "max": [1, 1, 1]});
    document.accessors.push(bare);
    document.primitives[0]["attributes"]["POSITION"] = json!(2);
    let places = document.add_floats("VEC3", &[[0.0_f32; 3]; 100]);
    let name = "EXT_mesh_gpu_instancing";
    document.nodes = vec![json!({"mesh": 0,
        "extensions": {name: {"attributes": {"TRANSLATION": places}}}})];
    document.more = json!({"extensionsUsed": [name]});
    let why = read("t.gltf", &document.whole()).expect_err("is refused").to_string();
    assert!(why.contains("400000000 corners; at most 12000000"), "{why}");
}
