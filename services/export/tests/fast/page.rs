//! The GLB of a page is smaller, and shows the same.

use super::common::{GlbScene, apart, fixture, random};
use cullet_export::{ExportOptions, page_glb};
use cullet_geometry::Vec3;
use cullet_record::synthetic::{STEP, STEPS};
use gltf::Semantic;
use gltf::accessor::DataType;
use std::collections::BTreeSet;

#[test]
fn a_page_has_bodies_and_motion_as_recorded_in_fewer_bytes() {
    let fixture = fixture();
    let bytes = page_glb(&fixture.recording).expect("exports");
    let whole = fixture.glb(&ExportOptions::default());
    let page = GlbScene::of_page(&bytes);
    assert!(page.blob.len() < whole.blob.len() * 3 / 4, "{} bytes", page.blob.len());
    let bodies = page.bodies();
    for time in random(20).map(|share| share * STEPS as f64 * STEP) {
        let rows = fixture.recording.poses_at(time);
        let there: BTreeSet<u64> = rows.iter().map(|row| row.id).collect();
        let seen = bodies.iter().filter(|(_, node)| page.is_seen(node, time));
        assert_eq!(seen.map(|(id, _)| *id).collect::<BTreeSet<_>>(), there, "at {time} s");
    }
    for frame in 0..24 {
        let time = f64::from(frame) / 24.0;
        for row in fixture.recording.poses_at(time + 1e-9) {
            let off = apart(&page.pose(&bodies[&row.id], time), &row.pose);
            assert!(off < 2e-3, "body {} at {time} s: {off}", row.id);
        }
    }
    assert!(page.document.extensions_required().eq(["KHR_mesh_quantization"]));
    assert!(!page.document.nodes().any(|it| it.name().is_some_and(|it| it.contains("open_crack"))));
}

#[test]
fn a_page_has_normals_of_bytes_and_no_coordinates_on_cracks() {
    let fixture = fixture();
    let page = GlbScene::of_page(&page_glb(&fixture.recording).expect("exports"));
    let mut cracks = 0;
    for part in page.document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        let normals = part.get(&Semantic::Normals).expect("normals");
        assert_eq!((normals.data_type(), normals.normalized()), (DataType::I8, true));
        assert!(part.get(&Semantic::TexCoords(0)).is_none());
        let marks = part.get(&Semantic::Extras("DAMAGE_TIME".to_owned()));
        cracks += usize::from(marks.is_some());
        // The first triangle of each part, whose normal is known from its corners.
        let reader = part.reader(|_| Some(&page.blob));
        let places: Vec<[f32; 3]> = reader.read_positions().expect("places").collect();
        let face: Vec<u32> = reader.read_indices().expect("indices").into_u32().take(3).collect();
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(places[face[k] as usize].map(f64::from)));
        let flat = (b - a).cross(&(c - a)).normalize();
        let view = normals.view().expect("a view");
        let at = view.offset() + normals.offset() + 4 * face[0] as usize;
        let byte = |k: usize| f64::from(page.blob[at + k] as i8) / 127.0;
        // A ball is rounded, a box is not.
        let normal = Vec3::new(byte(0), byte(1), byte(2));
        assert!(normal.dot(&flat) > 0.7 && (normal.norm() - 1.0).abs() < 0.02, "{normal} {flat}");
    }
    assert_eq!(cracks, 2);
}
