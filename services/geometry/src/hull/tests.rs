//! Hulls against known polyhedra; parts of hollow bodies follow the wall.

use super::*;
use crate::math::{Pose, Quat, unit};
use crate::mesh::TriMesh;
use crate::shapes::{Detail, cuboid, extrude, lathe_shell, sphere, torus};
use std::f64::consts::PI;

fn contains(corners: &[Vec3], p: Vec3) -> bool {
    Hull::of(corners, usize::MAX).unwrap().depth(p) >= 0.0
}

fn total(parts: &[Vec<Vec3>]) -> f64 {
    parts.iter().map(|p| hull_volume(p)).sum()
}

fn bowl(thickness: f64) -> TriMesh {
    let profile: Vec<[f64; 2]> = (0..=24)
        .map(|i| PI / 2.0 * f64::from(i) / 24.0)
        .map(|a| [if a == 0.0 { 0.0 } else { a.sin() }, -a.cos()])
        .collect();
    lathe_shell(&profile, thickness, Detail { segments: 64, edge: None }).unwrap()
}

#[test]
fn the_hull_of_a_lattice_is_its_box() {
    let lattice: Vec<Vec3> = (0..125)
        .map(|i| Vec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)))
        .collect();
    let hull = Hull::of(&lattice, usize::MAX).unwrap();
    assert!((hull.volume() - 64.0).abs() < 1e-12);
    assert!((hull.centroid() - Vec3::repeat(2.0)).norm() < 1e-13);
    let ball = sphere(1.0, Detail { segments: 30, edge: None }).unwrap();
    assert!((hull_volume(&ball.vertices) / ball.signed_volume() - 1.0).abs() < 1e-12);
    assert!(Hull::of(&lattice[..25], usize::MAX).is_none(), "a plane has no hull");
    assert!(Hull::of(&[Vec3::repeat(f64::NAN); 9], 9).is_none());
}

#[test]
fn a_reduced_hull_stays_inside_and_keeps_most_of_the_volume() {
    let cloud: Vec<Vec3> = (0..3000)
        .map(|i| Vec3::new(unit(1, 0, i), unit(1, 1, i), unit(1, 2, i)) * 2.0 - Vec3::repeat(1.0))
        .filter(|p| p.norm() < 1.0)
        .collect();
    let whole = hull_volume(&cloud);
    for (corners, share) in [(8, 0.35), (16, 0.6), (42, 0.85)] {
        let hull = Hull::of(&cloud, corners).unwrap();
        assert!(hull.vertices().len() <= corners);
        assert!(
            hull.volume() <= whole && hull.volume() > share * whole,
            "{}",
            hull.volume() / whole
        );
    }
}

#[test]
fn a_convex_body_is_one_part() {
    let detail = Detail { segments: 40, edge: None };
    for mesh in [cuboid(Vec3::new(1.0, 2.0, 0.1), detail).unwrap(), sphere(0.3, detail).unwrap()] {
        let volume = mesh.signed_volume();
        let parts = convex_parts(&Solid::outer(mesh), HullSettings::default());
        assert_eq!(parts.len(), 1);
        let ratio = total(&parts) / volume;
        assert!(ratio > 0.6 && ratio < 1.0 - 0.014, "{ratio}");
    }
}

#[test]
fn parts_of_a_bowl_follow_its_wall() {
    let mesh = bowl(0.08);
    let volume = mesh.signed_volume();
    let settings = HullSettings { max_parts: 32, ..HullSettings::default() };
    let parts = convex_parts(&Solid::outer(mesh), settings);
    assert!(parts.len() > 8 && parts.len() <= 32);
    assert!(total(&parts) <= 1.6 * volume, "{}", total(&parts) / volume);
    assert!(total(&parts) >= 0.8 * volume);
    for p in &parts {
        assert!(p.len() >= 4 && p.len() <= 16);
        assert!(!contains(p, Vec3::zeros()), "a part fills the middle");
        assert!(!contains(p, Vec3::new(0.1, -0.2, -0.4)), "a part fills the hollow");
        assert!(p.iter().all(|c| c.norm() < 1.0 + 1e-9 && c.z < 0.01), "a part pokes out");
    }
}

#[test]
fn eight_parts_leave_the_hole_of_a_ring_open() {
    let mesh = torus(1.0, 0.2, Detail { segments: 64, edge: None }).unwrap();
    let volume = mesh.signed_volume();
    let parts = convex_parts(&Solid::outer(mesh), HullSettings::default());
    assert_eq!(parts.len(), 8);
    assert!(parts.iter().all(|p| !contains(p, Vec3::zeros())));
    assert!(total(&parts) < 1.3 * volume, "{}", total(&parts) / volume);
}

#[test]
fn clipped_pieces_keep_the_volume() {
    let solid = Solid::outer(bowl(0.05));
    let whole = HullPiece::of(&solid).unwrap();
    let (a, b) = whole.split(Vec3::new(1.0, 2.0, 0.5).normalize(), 0.1);
    let (c, d) = a.split(Vec3::new(-0.3, 1.0, 1.0).normalize(), -0.2);
    let (e, f) = c.split(Vec3::y(), 0.3);
    let sum: f64 = [b, d, e, f].iter().map(HullPiece::volume).sum();
    assert!((sum / solid.volume() - 1.0).abs() < 1e-12);
    let exact = crate::boolean::Exact::new(&solid).unwrap();
    let (upper, _) = exact.split(Vec3::new(1.0, 2.0, 0.5), 0.1 * 5.25_f64.sqrt()).unwrap();
    assert!((a.volume() / upper.volume() - 1.0).abs() < 1e-10);
}

/// A T cut under its bar falls into two blocks, however it lies: the underside of the bar, in the
/// plane but for rounding, goes with the bar.
#[test]
fn a_face_in_the_plane_of_a_cut_goes_to_the_side_that_it_bounds() {
    let outline =
        [[-2.0, 0.0], [-0.5, 0.0], [-0.5, -3.0], [0.5, -3.0], [0.5, 0.0], [2.0, 0.0], [2.0, 1.0]];
    let outline: Vec<[f64; 2]> = outline.into_iter().chain([[-2.0, 1.0]]).collect();
    let mesh = extrude(&outline, 1.5, Detail::default()).unwrap();
    for k in 0..60 {
        let any = |i: u64| unit(9, i, k) * 2.0 - 1.0;
        let turn = Quat::from_scaled_axis(Vec3::new(any(0), any(1), any(2)) * f64::from(k > 0));
        let size = 10.0_f64.powi(k as i32 % 6 - 3);
        let mesh = mesh.transformed(&Pose::from_parts(Vec3::zeros().into(), turn)).scaled(size);
        // As a file would have it.
        let single = |c: f64| f64::from(c as f32);
        let vertices = mesh.vertices.iter().map(|p| p.map(single)).collect();
        let whole = HullPiece::of(&Solid::outer(TriMesh { vertices, ..mesh })).unwrap();
        // Up, and down: once the bar is above, once below.
        for up in [turn * Vec3::y(), turn * -Vec3::y()] {
            let (one, other) = whole.split(up, 0.0);
            let (bar, stem) = if turn.inverse_transform_vector(&up).y > 0.0 {
                (one, other)
            } else {
                (other, one)
            };
            for (piece, volume) in [(bar, 6.0), (stem, 4.5)] {
                let volume = volume * size * size * size;
                assert!((piece.volume() / volume - 1.0).abs() < 1e-5, "turn {k}");
                let hull = hull_volume(&piece.corners());
                assert!((hull / volume - 1.0).abs() < 1e-5, "turn {k}: {}", hull / volume);
            }
        }
    }
}

#[test]
fn what_has_no_hull_gets_a_box() {
    let flat = TriMesh {
        vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
    };
    for mesh in [flat, TriMesh::default()] {
        let parts = convex_parts(&Solid::outer(mesh), HullSettings::default());
        assert_eq!(parts.len(), 1);
        assert!(hull_volume(&parts[0]) > 0.0);
    }
    let mut broken = cuboid(Vec3::repeat(1.0), Detail::default()).unwrap();
    broken.vertices[0].x = f64::NAN;
    assert!(hull_volume(&convex_parts(&Solid::outer(broken), HullSettings::default())[0]) > 0.5);
}
