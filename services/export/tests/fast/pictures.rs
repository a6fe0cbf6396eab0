//! The pictures of an artist's materials are in what is exported, or it is said that they are not.

use super::common::{Fixture, GlbScene};
use cullet_export::{ExportOptions, Moments, export, export_pieces};
use cullet_geometry::Vec3;
use cullet_geometry::attributes::{
    SurfaceAttributes, SurfaceMaterial, SurfaceTexture, TextureMapping, TextureWrap,
};
use cullet_record::{Recording, synthetic};
use std::path::Path;

/// Two by two pixels: red and green above blue and yellow.
const PNG: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 2, 0, 0, 0, 2, 8, 2, 0,
    0, 0, 253, 212, 154, 115, 0, 0, 0, 20, 73, 68, 65, 84, 120, 156, 99, 248, 207, 192, 192, 0,
    194, 12, 255, 255, 255, 103, 0, 0, 30, 239, 4, 252, 163, 200, 180, 247, 0, 0, 0, 0, 73, 69, 78,
    68, 174, 66, 96, 130,
];

/// The same with something behind its end.
fn other() -> Vec<u8> {
    [PNG, b"other"].concat()
}

const MAPPING: TextureMapping = TextureMapping {
    offset: [0.25, 0.5],
    rotation: 0.5,
    scale: [2.0, 3.0],
    wrap: [TextureWrap::Clamp, TextureWrap::Mirror],
};

/// Materials: of a picture within the mesh file, of one beside it, of one that is not there, of one
/// that is no picture, and of a copy of the second.
fn surface() -> SurfaceAttributes {
    let within = SurfaceTexture {
        name: "red & blue".to_owned(),
        offset: 4,
        length: PNG.len() as u64,
        mapping: MAPPING,
        ..SurfaceTexture::default()
    };
    let named = |name: &str| SurfaceTexture { name: name.to_owned(), ..SurfaceTexture::default() };
    let names = ["wood.png", "lost.png", "box.glb", "copy.jpg"];
    let textures = std::iter::once(within).chain(names.map(named));
    let material = |(name, texture): (&str, _)| SurfaceMaterial {
        base_colour: [0.5, 0.25, 1.0, 1.0],
        metallic: 0.75,
        texture: Some(texture),
        ..SurfaceMaterial::named(name)
    };
    let materials = ["clay", "wood", "tin", "wax", "oak"].into_iter().zip(textures).map(material);
    let mesh = synthetic::block(Vec3::repeat(2.0 * synthetic::half().x), 0.0).mesh;
    let plane = |t: usize| mesh.corners(t).map(|p| [p.x as f32, p.y as f32]);
    SurfaceAttributes {
        uv: (0..mesh.triangles.len()).map(plane).collect(),
        slots: (0..mesh.triangles.len()).map(|t| t as u32 / 2 % 5).collect(),
        materials: materials.collect(),
        mesh,
        ..SurfaceAttributes::default()
    }
}

/// The synthetic run, whose cube looks so.
fn painted() -> Fixture {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let mut meta = synthetic::meta();
    meta.files.push(("scene/box.glb".to_owned(), [b"head", PNG].concat()));
    meta.files.push(("scene/wood.png".to_owned(), other()));
    meta.files.push(("scene/copy.jpg".to_owned(), other()));
    let mut recorder = synthetic::begin(&path, &meta).expect("begins");
    recorder.appearance(vec![1], "scene/box.glb", &surface()).expect("is recorded");
    for k in 0..=synthetic::STEPS {
        synthetic::step(&mut recorder, k).expect("a step");
    }
    let end = synthetic::STEPS as f64 * synthetic::STEP;
    recorder.finish(synthetic::STEPS, end).expect("ends");
    let recording = Recording::open(&path).expect("it reads");
    Fixture { folder, recording }
}

/// The pictures of a GLB.
fn images(scene: &GlbScene) -> Vec<&[u8]> {
    let bytes = |image: gltf::Image<'_>| match image.source() {
        gltf::image::Source::View { view, mime_type } => {
            assert_eq!(mime_type, "image/png");
            view.offset()..view.offset() + view.length()
        }
        gltf::image::Source::Uri { uri, .. } => panic!("a picture elsewhere: {uri}"),
    };
    scene.document.images().map(|image| &scene.blob[bytes(image)]).collect()
}

fn material<'a>(scene: &'a GlbScene, name: &str) -> gltf::material::PbrMetallicRoughness<'a> {
    let found = scene.document.materials().find(|it| it.name() == Some(name));
    found.expect("is there").pbr_metallic_roughness()
}

fn complaints() -> [String; 2] {
    [
        "the picture \"box.glb\" of the material \"wax\" is neither PNG nor JPEG".to_owned(),
        "the picture \"lost.png\" of the material \"tin\" is not in the recording".to_owned(),
    ]
}

#[test]
fn a_glb_has_each_picture_once_on_its_material() {
    let fixture = painted();
    let path = fixture.folder.path().join("x.glb");
    let report = export(&fixture.recording, &ExportOptions::default(), &path).expect("exports");
    assert_eq!((report.pictures, &report.pictures_left_out[..]), (2, &complaints()[..]));
    let scene = GlbScene::read(&path);
    assert_eq!(images(&scene), [PNG, &other()]);
    let source = |name| {
        let info = material(&scene, name).base_color_texture().expect("a picture");
        info.texture().source().index()
    };
    assert_eq!((source("cube clay"), source("cube wood"), source("cube oak")), (0, 1, 1));
    let info = material(&scene, "cube clay").base_color_texture().expect("a picture");
    assert_eq!(material(&scene, "cube clay").base_color_factor(), [0.5, 0.25, 1.0, 1.0]);
    let moved = info.texture_transform().expect("is moved");
    assert_eq!(
        (moved.offset(), moved.rotation(), moved.scale()),
        (MAPPING.offset, MAPPING.rotation, MAPPING.scale)
    );
    let sampler = info.texture().sampler();
    let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| mode.as_gl_enum());
    assert_eq!(wrap, [33071, 33648]);
    assert_eq!(info.texture().source().name(), Some("red___blue"));
    let wood = material(&scene, "cube wood").base_color_texture().expect("a picture");
    assert!(wood.texture_transform().is_none());
    assert!(material(&scene, "cube tin").base_color_texture().is_none());
    let used: Vec<&str> = scene.document.extensions_used().collect();
    assert_eq!(used, ["KHR_texture_transform"]);
}

/// The text of the prim of a material.
fn looks<'a>(text: &'a str, name: &str) -> &'a str {
    let start = text.find(&format!("def Material \"{name}\"")).expect("a material");
    let end = text[start..].find("\n        }\n").expect("an end");
    &text[start..start + end]
}

#[test]
fn a_stage_reads_pictures_from_the_folder_beside_it() {
    let fixture = painted();
    let text = fixture.text("a@b.usda", &ExportOptions::default());
    let folder = fixture.folder.path().join("a_b_pictures");
    for (name, bytes) in [("red___blue.png", PNG), ("wood.png", &other())] {
        assert_eq!(std::fs::read(folder.join(name)).expect("a picture"), bytes);
    }
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 2);
    let clay = looks(&text, "cube_slot_0");
    for line in [
        "color3f inputs:diffuseColor.connect = </World/Looks/cube_slot_0/picture.outputs:rgb>",
        "float inputs:metallic = 0.75",
        "asset inputs:file = @./a_b_pictures/red___blue.png@",
        "float4 inputs:scale = (0.5, 0.25, 1, 1)",
        "token inputs:sourceColorSpace = \"sRGB\"",
        "token inputs:wrapS = \"clamp\"",
        "token inputs:wrapT = \"mirror\"",
        "string inputs:varname = \"st\"",
        "float2 inputs:st.connect = </World/Looks/cube_slot_0/transform.outputs:result>",
        "float2 inputs:scale = (2, 3)",
    ] {
        assert!(clay.lines().any(|one| one.trim() == line), "{line} in {clay}");
    }
    let wood = looks(&text, "cube_slot_1");
    assert!(wood.contains("cube_slot_1/coordinates.outputs:result>") && !wood.contains("2d"));
    let tin = looks(&text, "cube_slot_2");
    assert!(tin.contains("color3f inputs:diffuseColor = (0.5, 0.25, 1)"), "{tin}");
}

#[test]
fn a_sequence_has_its_pictures_once_and_pieces_each_their_own() {
    let fixture = painted();
    let path = fixture.folder.path().join("x.usda");
    let options = ExportOptions { moments: Moments::Every(0.5), ..ExportOptions::default() };
    let report = export(&fixture.recording, &options, &path).expect("exports");
    let pictures = |file: &&std::path::PathBuf| file.extension().is_some_and(|end| end == "png");
    assert_eq!(report.files.iter().filter(pictures).count(), 2, "{:?}", report.files);
    let text = std::fs::read_to_string(fixture.folder.path().join("x_0002.usda")).expect("a text");
    assert!(text.contains("@./x_pictures/wood.png@"));
    let pieces = fixture.folder.path().join("pieces");
    let report = export_pieces(&fixture.recording, &pieces).expect("exports");
    assert_eq!((report.pictures, report.pictures_left_out.len()), (2, 2));
    assert_eq!(images(&GlbScene::read(&pieces.join("pieces.glb"))).len(), 2);
}

#[test]
fn without_pictures_there_is_no_folder() {
    let fixture = super::common::fixture();
    fixture.text("x.usda", &ExportOptions::default());
    let folder: &Path = &fixture.folder.path().join("x_pictures");
    assert!(!folder.exists());
    let scene = fixture.glb(&ExportOptions::default());
    assert_eq!((scene.document.images().count(), scene.document.samplers().count()), (0, 0));
}
