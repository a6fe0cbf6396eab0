//! GLB: bodies, poses and visibility are those of the recording.

use super::common::{apart, fixture, random};
use cullet_export::ExportOptions;
use cullet_geometry::{Pose, Solid, Vec3};
use cullet_record::synthetic::{BREAK, STEP, STEPS};
use std::collections::BTreeSet;

const WHOLE: f64 = STEPS as f64 * STEP;

#[test]
fn every_body_is_a_node_with_its_name_and_facts() {
    let fixture = fixture();
    let scene = fixture.glb(&ExportOptions::default());
    let bodies = scene.bodies();
    let ids: BTreeSet<u64> = fixture.recording.bodies.iter().map(|body| body.id).collect();
    assert_eq!(bodies.keys().copied().collect::<BTreeSet<_>>(), ids);
    let names: Vec<_> = bodies.values().map(|node| node.name().unwrap_or_default()).collect();
    assert_eq!(names, ["slab", "cube", "cube_2", "cube_3"]);
    for (id, node) in &bodies {
        let (body, facts) = (fixture.recording.body(*id).expect("it is there"), scene.facts(node));
        // The reader of JSON may round the last bit.
        let mass = facts["mass_kg"].as_f64().expect("a mass");
        assert!((mass / body.mass - 1.0).abs() < 1e-15, "{mass} kg");
        assert_eq!(facts["parent"].as_u64(), body.parent);
        let birth = body.birth_step as f64 * STEP;
        assert!((facts["birth_s"].as_f64().expect("a time") - birth).abs() < 1e-12);
        let damage = facts["damage_time_max_s"].as_f64();
        assert_eq!(damage.map(|time| (time * 1e9).round()), body.parent.map(|_| 2e4));
    }
    let grains = scene.document.nodes().filter(|node| scene.facts(node)["grain"].is_u64());
    assert_eq!(grains.count(), 2);
    let without = fixture.glb(&ExportOptions { grains: false, ..ExportOptions::default() });
    // Four bodies, and a crack that ends inside one.
    assert_eq!(without.document.nodes().count(), 5);
}

#[test]
fn the_scene_has_a_name_that_no_node_has() {
    let mut fixture = fixture();
    fixture.recording.meta.insert("scene".to_owned(), "cube".to_owned());
    let scene = fixture.glb(&ExportOptions::default());
    let own = scene.document.default_scene().expect("a scene");
    assert_eq!(own.name(), Some("cube-scene"));
    let names: Vec<_> = scene.document.nodes().filter_map(|node| node.name()).collect();
    assert!(names.iter().all(|name| !name.contains('-')), "{names:?}");
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{names:?}");
}

#[test]
fn poses_at_frames_and_who_is_seen_at_any_time_are_as_recorded() {
    let fixture = fixture();
    let scene = fixture.glb(&ExportOptions::default());
    let bodies = scene.bodies();
    for share in random(40) {
        let time = share * WHOLE;
        let there: BTreeSet<u64> =
            fixture.recording.poses_at(time).iter().map(|row| row.id).collect();
        let seen = bodies.iter().filter(|(_, node)| scene.is_seen(node, time));
        assert_eq!(seen.map(|(id, _)| *id).collect::<BTreeSet<_>>(), there, "at {time} s");
        // A frame of 1/24 s is five steps.
        let frame = (time * 24.0).round() / 24.0;
        for row in fixture.recording.poses_at(frame + 1e-9) {
            let off = apart(&scene.pose(&bodies[&row.id], frame), &row.pose);
            assert!(off < 1e-5, "body {} at {frame} s: {off}", row.id);
        }
    }
}

#[test]
fn what_rests_has_no_keys() {
    let fixture = fixture();
    let scene = fixture.glb(&ExportOptions::default());
    let slab = scene.bodies()[&0].index();
    let channels = scene.document.animations().flat_map(|animation| {
        animation.channels().map(|channel| channel.target().node().index()).collect::<Vec<_>>()
    });
    assert!(channels.into_iter().all(|node| node != slab));
    // The parts move evenly for 0.3 s: a handful of keys of 15 frames.
    let input = scene.document.accessors().map(|accessor| accessor.count()).collect::<Vec<_>>();
    assert!(input.len() < 60, "{}", input.len());
}

#[test]
fn skin_and_crack_faces_are_two_materials_and_close_the_solid() {
    let fixture = fixture();
    let scene = fixture.glb(&ExportOptions::default());
    for (id, node) in scene.bodies() {
        let body = fixture.recording.body(id).expect("it is there");
        let solid = fixture.recording.mesh(body).expect("its mesh");
        let mesh = node.mesh().expect("a mesh");
        let kinds: Vec<String> = mesh
            .primitives()
            .map(|primitive| primitive.material().name().unwrap_or_default().to_owned())
            .collect();
        let object = &body.object;
        let wanted = [format!("{object} skin"), format!("{object} crack")];
        assert_eq!(kinds, wanted[..if body.parent.is_some() { 2 } else { 1 }]);
        let mut volume = 0.0;
        let mut triangles = 0;
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| Some(&scene.blob));
            let places: Vec<Vec3> = reader
                .read_positions()
                .expect("places")
                .map(|p| Vec3::from(p.map(f64::from)))
                .collect();
            let normals: Vec<Vec3> = reader
                .read_normals()
                .expect("normals")
                .map(|n| Vec3::from(n.map(f64::from)))
                .collect();
            let crack = primitive.material().name().is_some_and(|name| name.ends_with("crack"));
            assert_eq!(reader.read_tex_coords(0).is_some(), crack);
            let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
            for face in indices.as_chunks::<3>().0 {
                let [a, b, c] = face.map(|i| places[i as usize]);
                volume += a.dot(&b.cross(&c)) / 6.0;
                let normal = (b - a).cross(&(c - a)).normalize();
                // A box has creases only.
                assert!(face.iter().all(|&i| (normals[i as usize] - normal).norm() < 1e-6));
                triangles += 1;
            }
        }
        assert_eq!(triangles, solid.mesh.triangles.len());
        assert!((volume / solid.volume() - 1.0).abs() < 1e-5, "body {id}: {volume} m³");
    }
}

#[test]
fn nodes_are_at_rest_in_the_whole_object() {
    let fixture = fixture();
    let scene = fixture.glb(&ExportOptions::default());
    let rest = fixture.recording.rest_poses();
    for (id, node) in scene.bodies() {
        let (place, turn, scale) = node.transform().decomposed();
        let bare = Vec3::new(place[0].into(), -f64::from(place[2]), place[1].into());
        assert!((bare - rest[&id].translation.vector).norm() < 1e-6, "body {id}");
        assert_eq!(turn, [0.0, 0.0, 0.0, 1.0]);
        // What is not there at first is not seen by who plays no animation.
        assert_eq!(scale[0], if id < 2 { 1.0 } else { 0.0 });
    }
}

#[test]
fn a_part_of_the_run_starts_at_zero() {
    let fixture = fixture();
    let (start, end) = (BREAK as f64 * STEP - 0.1, BREAK as f64 * STEP + 0.2);
    let options = ExportOptions { start: Some(start), end: Some(end), ..ExportOptions::default() };
    let scene = fixture.glb(&options);
    let bodies = scene.bodies();
    assert_eq!([0.09, 0.11].map(|time| scene.is_seen(&bodies[&1], time)), [true, false]);
    assert_eq!([0.09, 0.11].map(|time| scene.is_seen(&bodies[&2], time)), [false, true]);
    for row in fixture.recording.poses_at(end + 1e-9) {
        assert!(apart(&scene.pose(&bodies[&row.id], 0.3), &row.pose) < 1e-5, "body {}", row.id);
    }
}

#[test]
fn meshes_turn_with_the_axes() {
    let fixture = fixture();
    let scene = fixture.glb(&ExportOptions::default());
    let slab = scene.bodies()[&0].mesh().expect("a mesh");
    let bounds = slab.primitives().next().expect("faces").bounding_box();
    // The slab is thin along our z, which is y there.
    let size: Vec<f32> = (0..3).map(|k| bounds.max[k] - bounds.min[k]).collect();
    assert!((size[1] - 0.1).abs() < 1e-6 && size[0] > 2.9 && size[2] > 2.9, "{size:?}");
    let recorded = fixture.recording.body(0).expect("the slab");
    let solid: Solid = fixture.recording.mesh(recorded).expect("its mesh");
    let (low, high) = solid.transformed(&Pose::identity()).mesh.bounds().expect("bounds");
    assert!((high - low).z < 0.11);
}
