//! What OBJ and GLB files have beside a shape is read, corner by corner.

use super::super::read_surface;
use super::{CORNERS, FACES, files};
use cullet_geometry::attributes::{SurfaceAttributes, TextureMapping, TextureWrap};
use glb::{Node, Primitive, glb};
use std::sync::Arc;

#[path = "../../../../tests/common/glb.rs"]
mod glb;

fn surface(name: &str, bytes: &[u8]) -> SurfaceAttributes {
    let surface = read_surface(name, bytes, &mut |_| None).expect("reads").surface;
    surface.validate().expect("is sound");
    surface
}

/// Each corner of the tetrahedron has texture coordinates by its place and its face.
fn uv(face: usize, corner: u32) -> [f32; 2] {
    let [x, y, z] = CORNERS[corner as usize];
    [0.25 * face as f32 + 0.125 * x, 0.5 * y + 0.25 * z]
}

/// Two materials and a face without; two objects; normals only in the first.
const OBJ: &str = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
    vn 0 0 -2\n\
    vt 0 0\nvt 0 0.5\nvt 0.125 0\nvt 0.25 0\nvt 0.375 0\nvt 0.25 0.25\n\
    o base\nf 1/1/1 3/2/1 2/3/1\nusemtl oak\nf 1/4 2/5 4/6\n\
    o rest\nusemtl tin can\nf 2 3 4\nf 3 1 4\n";

#[test]
fn an_obj_has_texture_coordinates_normals_materials_and_objects() {
    let library = "newmtl oak\nKd 0.5 0.25 0.125\nd 0.75\nPr 0.25\nPm 0.5\nmap_Kd oak.png\n";
    let mut asked = Vec::new();
    let mut beside = |name: &str| {
        asked.push(name.to_owned());
        Some(Arc::new(library.as_bytes().to_vec()))
    };
    let read = read_surface("t.obj", OBJ.as_bytes(), &mut beside).expect("reads").surface;
    read.validate().expect("is sound");
    assert_eq!(asked, ["t.mtl"]);
    assert_eq!(read.mesh, super::super::read("t.obj", OBJ.as_bytes()).expect("reads"));
    assert_eq!(read.uv[0], [uv(0, 0), uv(0, 2), uv(0, 1)]);
    assert_eq!(read.uv[1], [uv(1, 0), uv(1, 1), uv(1, 3)]);
    assert_eq!(read.normals[0], [[0.0, 0.0, -1.0]; 3]);
    let names: Vec<&str> = read.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!((names, &read.slots[..]), (vec!["oak", "tin can", ""], &[2, 0, 1, 1][..]));
    assert_eq!(read.object_names, ["base", "rest"]);
    assert_eq!(read.objects, [0, 0, 1, 1]);
    let oak = &read.materials[0];
    assert_eq!(oak.base_colour, [0.5, 0.25, 0.125, 0.75]);
    assert_eq!((oak.metallic, oak.roughness), (0.5, 0.25));
    assert_eq!(oak.texture.as_ref().map(|it| (it.name.as_str(), it.length)), Some(("oak.png", 0)));
    let alone = surface("t.obj", OBJ.as_bytes());
    assert_eq!((&alone.uv, &alone.slots), (&read.uv, &read.slots));
    assert_eq!(alone.materials[0].base_colour, [1.0; 4], "without its library");
}

/// A library is anybody's file: nothing in it makes the mesh wrong.
#[test]
fn a_broken_material_library_leaves_the_names() {
    for library in ["newmtl oak\nKd 0.5\n", "newmtl \n", "Kd x y z\n", "\u{0}\u{1}"] {
        let mut beside = |_: &str| Some(Arc::new(library.as_bytes().to_vec()));
        let read = read_surface("t.obj", OBJ.as_bytes(), &mut beside).expect("reads").surface;
        assert_eq!(read.materials[0].name, "oak", "{library:?}");
    }
}

/// Faces may name corners below them.
#[test]
fn faces_above_their_corners_are_read() {
    let text = "usemtl a\nf 1 3 2\nf 1 2 4\nusemtl b\nf 2 3 4\nf 3 1 4\n\
                v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let read = surface("t.obj", text.as_bytes());
    assert_eq!((read.mesh.triangles.len(), read.materials.len()), (4, 2));
}

fn tetrahedron(material: Option<usize>, extras: bool) -> Primitive {
    let corners = || FACES.iter().flatten();
    let faces = FACES.iter().enumerate();
    let pairs = faces.flat_map(|(face, corners)| corners.map(|corner| uv(face, corner)));
    let place = corners().map(|&corner| CORNERS[corner as usize]);
    Primitive {
        positions: place.clone().collect(),
        normals: if extras { place.map(|_| [0.6, 0.0, 0.8]).collect() } else { Vec::new() },
        uv: if extras { pairs.map(|[u, v]| [u, 1.0 - v]).collect() } else { Vec::new() },
        material,
    }
}

const MATERIALS: &str = r#""materials":[
    {"name":"oak","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1],
    "metallicFactor":0.25,"roughnessFactor":0.75,"baseColorTexture":{"index":0,
    "extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],"rotation":0.5,"scale":[2,3]}}}}},
    {"name":"tin","pbrMetallicRoughness":{"baseColorTexture":{"index":1}}}],
    "textures":[{"source":0,"sampler":0},{"source":1}],"samplers":[{"wrapS":33071,"wrapT":33648}],
    "extensionsUsed":["KHR_texture_transform"],"extensionsRequired":["KHR_texture_transform"],
    "images":[{"name":"grain","bufferView":0,"mimeType":"image/png"},{"uri":"tin.jpg"}]"#;

#[test]
fn a_glb_has_texture_coordinates_normals_materials_and_objects() {
    let node = |name, place, primitives| Node { name, place, primitives };
    let nodes = [
        node("box", "", vec![tetrahedron(Some(0), true)]),
        node("lid", r#""scale":[-2,1,1]"#, vec![tetrahedron(Some(1), true)]),
        node("lid", r#""translation":[9,0,0]"#, vec![tetrahedron(None, false)]),
        node("", r#""translation":[0,9,0]"#, vec![tetrahedron(None, false)]),
    ];
    let picture = b"\x89PNG of a kind";
    let bytes = glb(&nodes, MATERIALS, picture);
    let read = surface("t.glb", &bytes);
    assert_eq!(read.object_names, ["box", "lid", "lid-2", "object"]);
    assert_eq!(read.objects, [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
    let names: Vec<&str> = read.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["oak", "tin", ""]);
    assert_eq!(read.slots[..12], [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]);
    for (face, corners) in FACES.iter().enumerate() {
        assert_eq!(read.uv[face], corners.map(|corner| uv(face, corner)), "v upward");
        // A mirrored node is turned over, with all that its corners have.
        let [a, b, c] = read.uv[4 + face];
        assert_eq!([a, c, b], corners.map(|corner| uv(face, corner)));
    }
    let close = |n: [f32; 3], m: [f32; 3]| n.iter().zip(m).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(read.normals[0][0], [0.6, 0.0, 0.8]));
    // The inverse transpose of the scale, and of length 1: (-0.3, 0, 0.8) over its length.
    assert!(close(read.normals[4][0], [-0.351_123_4, 0.0, 0.936_329_2]), "{:?}", read.normals[4]);
    let [a, b, c] = read.mesh.corners(8);
    let flat = (b - a).cross(&(c - a)).normalize();
    assert!(close(read.normals[8][1], [flat.x as f32, flat.y as f32, flat.z as f32]));
    let oak = &read.materials[0];
    assert_eq!((oak.base_colour, oak.metallic), ([0.5, 0.25, 0.125, 1.0], 0.25));
    let grain = oak.texture.clone().expect("a picture");
    assert_eq!((grain.name.as_str(), grain.media_type.as_str()), ("grain", "image/png"));
    let range = grain.offset as usize..(grain.offset + grain.length) as usize;
    assert_eq!(&bytes[range], picture);
    let wrap = [TextureWrap::Clamp, TextureWrap::Mirror];
    let moved = TextureMapping { offset: [0.5, 0.25], rotation: 0.5, scale: [2.0, 3.0], wrap };
    assert_eq!(grain.mapping, moved);
    let tin = read.materials[1].texture.clone().expect("a picture");
    assert_eq!((tin.name.as_str(), tin.length), ("tin.jpg", 0));
    assert_eq!(tin.mapping, TextureMapping::default());
}

#[test]
fn bare_files_are_plain() {
    for (name, bytes) in files() {
        let read = surface(name, &bytes);
        assert!(read.is_plain(), "{name}");
        assert_eq!(read.mesh, super::super::read(name, &bytes).expect("reads"), "{name}");
    }
}
