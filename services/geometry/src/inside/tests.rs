//! Parity and distance against bodies whose answers are known.

use super::*;
use crate::math::unit;
use crate::shapes::{Detail, cuboid, sphere, torus};

fn random_points(count: u64, reach: f64) -> impl Iterator<Item = Vec3> {
    let at = move |stream, i| reach * (2.0 * unit(11, stream, i) - 1.0);
    (0..count).map(move |i| Vec3::new(at(0, i), at(1, i), at(2, i)))
}

#[test]
fn agrees_with_the_equations_of_ball_and_ring() {
    let detail = Detail { segments: 200, edge: None };
    let ball = Inside::new(&sphere(1.0, detail).unwrap());
    let ring = Inside::new(&torus(1.0, 0.4, detail).unwrap());
    let mut hits = 0;
    for p in random_points(40_000, 1.5) {
        // Points in the sliver between the polyhedron and the true surface may go either way.
        if (p.norm() - 1.0).abs() > 1e-3 {
            assert_eq!(ball.contains(p), p.norm() < 1.0, "{p}");
        }
        let tube = ((p.x * p.x + p.y * p.y).sqrt() - 1.0).hypot(p.z);
        if (tube - 0.4).abs() > 4e-3 {
            assert_eq!(ring.contains(p), tube < 0.4, "{p}");
            hits += usize::from(tube < 0.4);
        }
    }
    assert!(hits > 3000);
}

#[test]
fn rays_through_edges_and_corners_count_once() {
    let cube = cuboid(Vec3::repeat(2.0), Detail { segments: 3, edge: Some(0.25) }).unwrap();
    let inside = Inside::new(&cube);
    // Every ray of this lattice runs along edges and through corners of the grid.
    for (i, j, k) in
        (-9..=9).flat_map(|i| (-9..=9).flat_map(move |j| (-9..=9).map(move |k| (i, j, k))))
    {
        let p = Vec3::new(f64::from(i), f64::from(j), f64::from(k)) * 0.125 + Vec3::repeat(1e-3);
        let expected = p.iter().all(|c| c.abs() < 1.0);
        assert_eq!(inside.contains(p), expected, "{p}");
        let q = Vec3::new(p.x - 1e-3, p.y - 1e-3, p.z);
        if q.x.abs() != 1.0 && q.y.abs() != 1.0 {
            assert_eq!(inside.contains(q), q.iter().all(|c| c.abs() < 1.0), "{q}");
        }
    }
    assert!(!Inside::new(&TriMesh::default()).contains(Vec3::zeros()));
}

#[test]
fn distance_matches_brute_force_and_the_closed_form() {
    let cube = cuboid(Vec3::new(2.0, 1.0, 0.5), Detail { segments: 3, edge: Some(0.2) }).unwrap();
    let tree = Nearest::new(&cube);
    for p in random_points(2000, 2.0) {
        let naive = (0..cube.triangles.len())
            .map(|t| (nearest::closest_on_triangle(p, cube.corners(t)) - p).norm())
            .fold(f64::INFINITY, f64::min);
        assert_eq!(tree.distance(p), naive);
        let beyond = (p.abs() - Vec3::new(1.0, 0.5, 0.25)).sup(&Vec3::zeros());
        if beyond.norm() > 0.0 {
            assert!((naive - beyond.norm()).abs() < 1e-13);
        }
    }
    assert!((tree.distance(Vec3::zeros()) - 0.25).abs() < 1e-15);
    assert_eq!(Nearest::new(&TriMesh::default()).distance(Vec3::zeros()), f64::INFINITY);
}

#[test]
fn a_ray_meets_the_nearest_wall_that_counts() {
    let mut walls = sphere(1.0, Detail { segments: 100, edge: None }).unwrap();
    let inner = walls.triangles.len();
    walls.append(&sphere(2.0, Detail { segments: 100, edge: None }).unwrap());
    let nearest = Nearest::new(&walls);
    for p in random_points(2_000, 1.0) {
        let way = p.normalize();
        let (near, t) = nearest.first_hit(Vec3::zeros(), way, |_| true).unwrap();
        assert!((near - 1.0).abs() < 2e-3 && t < inner, "{near} at {t}");
        let (far, t) = nearest.first_hit(Vec3::zeros(), way, |t| t >= inner).unwrap();
        assert!((far - 2.0).abs() < 4e-3 && t >= inner, "{far} at {t}");
    }
    // Along an axis, in faces of the boxes of the tree.
    let cube =
        Nearest::new(&cuboid(Vec3::repeat(2.0), Detail { segments: 8, edge: Some(0.5) }).unwrap());
    let hit = cube.first_hit(Vec3::new(0.0, 0.25, -3.0), Vec3::z(), |_| true).unwrap();
    assert!((hit.0 - 2.0).abs() < 1e-12);
    assert_eq!(cube.first_hit(Vec3::new(0.0, 2.0, -3.0), Vec3::z(), |_| true), None);
}

#[test]
fn a_reach_bounds_the_search() {
    let ball = Nearest::new(&sphere(1.0, Detail::default()).unwrap());
    for p in random_points(500, 1.5) {
        let (_, distance, t) = ball.closest(p).unwrap();
        let found = ball.closest_within(p, distance * 1.001, |_| true).unwrap();
        assert_eq!((found.1, found.2), (distance, t));
        assert_eq!(ball.closest_within(p, distance * 0.999, |_| true), None);
    }
}
