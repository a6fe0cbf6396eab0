//! Mass properties against closed forms, and the edge tables of good and bad meshes.

use super::{Solid, Surface, TriMesh};
use crate::math::{Mat3, Vec3};

/// A box from corner to corner, 12 triangles.
fn cuboid(low: Vec3, high: Vec3) -> TriMesh {
    let corner = |i: u32| {
        let pick = |bit: u32, a: f64, b: f64| if i >> bit & 1 == 1 { b } else { a };
        Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// I about `at` of a body with inertia `inertia` about its own centroid, unit density.
fn steiner(inertia: Mat3, volume: f64, arm: Vec3) -> Mat3 {
    inertia + volume * (Mat3::identity() * arm.norm_squared() - arm * arm.transpose())
}

#[test]
fn a_box_far_from_the_origin_has_the_textbook_inertia() {
    let at = Vec3::new(2.0e3, -7.0e2, 40.0);
    let size = Vec3::new(0.3, 0.2, 0.7);
    let m = cuboid(at - size / 2.0, at + size / 2.0).mass_properties();
    let v = size.x * size.y * size.z;
    let s = size.component_mul(&size);
    let textbook = v / 12.0 * Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y);
    assert!((m.volume / v - 1.0).abs() < 1e-10, "{}", m.volume / v - 1.0);
    assert!((m.centroid - at).norm() < 1e-9);
    assert!((m.inertia - Mat3::from_diagonal(&textbook)).norm() < 1e-10 * textbook.norm());
}

#[test]
fn eight_octants_make_the_cube() {
    let whole = cuboid(Vec3::repeat(-0.5), Vec3::new(0.7, 0.6, 0.5));
    let parent = whole.mass_properties();
    let cut = Vec3::new(0.13, -0.21, 0.08);
    let (mut volume, mut inertia, mut moment) = (0.0, Mat3::zeros(), Vec3::zeros());
    for i in 0..8 {
        let end = whole.vertices[i];
        let m = cuboid(cut.inf(&end), cut.sup(&end)).mass_properties();
        volume += m.volume;
        moment += m.volume * m.centroid;
        inertia += steiner(m.inertia, m.volume, m.centroid - parent.centroid);
    }
    assert!((volume / parent.volume - 1.0).abs() < 1e-12);
    assert!((moment / volume - parent.centroid).norm() < 1e-12);
    assert!((inertia - parent.inertia).norm() < 1e-12 * parent.inertia.norm());
}

#[test]
fn edge_tables_tell_open_from_crowded_from_closed() {
    let whole = cuboid(Vec3::zeros(), Vec3::repeat(1.0));
    assert!(whole.is_closed() && whole.open_edges().is_empty());
    assert_eq!(whole.edges().len(), 18);
    assert!((whole.area() - 6.0).abs() < 1e-15 && (whole.signed_volume() - 1.0).abs() < 1e-15);
    assert_eq!(whole.flipped().signed_volume(), -whole.signed_volume());

    let mut holed = whole.clone();
    holed.triangles.pop();
    assert!(!holed.is_closed());
    assert_eq!(holed.open_edges().len(), 3);

    let mut crowded = whole.clone();
    crowded.triangles.push(whole.triangles[0]);
    assert!(!crowded.is_closed() && crowded.open_edges().is_empty());
    assert_eq!(crowded.non_manifold_edges().len(), 3);

    let mut two = whole.clone();
    two.append(&whole.translated(Vec3::new(3.0, 0.0, 0.0)));
    assert_eq!(two.components().iter().map(Vec::len).collect::<Vec<_>>(), [12, 12]);
    let second = two.submesh(&two.components()[1]);
    assert_eq!((second.vertices.len(), second.is_closed()), (8, true));
    assert!(!TriMesh::default().is_closed());
}

#[test]
fn validation_names_the_place() {
    let mut solid = Solid::outer(cuboid(Vec3::zeros(), Vec3::repeat(1.0)));
    assert_eq!(solid.validate(), Ok(()));
    solid.surface[3] = Surface::crack(-1.0);
    assert!(solid.validate().unwrap_err().to_string().contains("triangle 3"));
    solid.surface.pop();
    assert!(solid.validate().unwrap_err().to_string().contains("11 surface entries"));
    solid.mesh.triangles[5][1] = 8;
    assert!(solid.validate().unwrap_err().to_string().contains("triangle 5 uses vertex 8"));
    solid.mesh.vertices[2].y = f64::NAN;
    assert!(solid.validate().unwrap_err().to_string().contains("vertex 2 is not finite"));
}
