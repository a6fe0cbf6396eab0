//! Partition sums, provenance through generations, scale, and what is refused.

use super::*;
use crate::math::unit;
use crate::shapes::{Detail, cuboid, sphere, torus};

fn exact(mesh: &TriMesh) -> Exact {
    Exact::new(&Solid::outer(mesh.clone())).unwrap()
}

fn bumpy_ball(radius: f64) -> TriMesh {
    let mut ball = sphere(radius, Detail { segments: 60, edge: None }).unwrap();
    for p in &mut ball.vertices {
        let d = *p / radius;
        *p *= 1.0 + 0.08 * libm::sin(7.0 * d.x + 2.0 * d.y) * libm::cos(9.0 * d.z);
    }
    ball
}

/// Random planes take `body` apart into at most 2^cuts pieces.
fn shatter(body: &Exact, cuts: u64, seed: u64) -> Vec<Exact> {
    let (low, high) = body.bounds().unwrap();
    let mut pieces = vec![body.clone()];
    for cut in 0..cuts {
        let random = |stream| 2.0 * unit(seed, stream, cut) - 1.0;
        let normal = Vec3::new(random(0), random(1), random(2));
        let at = 0.5 * (low + high) + 0.2 * random(3) * (high - low);
        pieces = pieces
            .iter()
            .flat_map(|p| <[Exact; 2]>::from(p.split(normal, normal.dot(&at)).unwrap()))
            .filter(|p| !p.is_empty())
            .collect();
    }
    pieces
}

#[test]
fn pieces_sum_to_the_body_at_every_size() {
    for radius in [1e-6, 1e-3, 1.0, 100.0, 1e4] {
        let ball = bumpy_ball(radius);
        let pieces = shatter(&exact(&ball), 4, 5);
        assert!(pieces.len() >= 8, "{} pieces", pieces.len());
        let (mut sum, mut moment) = (0.0, Vec3::zeros());
        for piece in &pieces {
            let solid = piece.to_solid().unwrap();
            assert!(solid.mesh.is_closed() && solid.volume() > 0.0);
            let m = solid.mesh.mass_properties();
            sum += m.volume;
            moment += m.volume * m.centroid;
        }
        let whole = ball.mass_properties();
        assert!((sum / whole.volume - 1.0).abs() < 1e-12, "{:e}", sum / whole.volume - 1.0);
        assert!((moment / sum - whole.centroid).norm() < 1e-11 * radius);
    }
}

#[test]
fn cells_that_share_faces_with_the_body_lose_nothing() {
    // A box cut by a lattice of boxes, some faces of which lie in its own faces.
    let body = exact(&cuboid(Vec3::repeat(1.0), Detail::default()).unwrap());
    let cell = cuboid(Vec3::repeat(0.5), Detail::default()).unwrap();
    let mut sum = 0.0;
    for i in 0..8 {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 0.25 } else { -0.25 };
        let at = Vec3::new(sign(0), sign(1), sign(2));
        let part = body.intersect(&exact(&cell.translated(at))).unwrap();
        assert!((part.volume() - 0.125).abs() < 1e-13);
        sum += part.volume();
    }
    assert!((sum - 1.0).abs() < 1e-12);
}

#[test]
fn faces_remember_where_they_came_from_for_two_generations() {
    let ball = bumpy_ball(1.0);
    let (upper, lower) = exact(&ball).split(Vec3::new(0.1, 0.2, 1.0), 0.05).unwrap();
    // First generation: give the caps a time, as a solver would.
    let timed = |part: &Exact, time: f32| {
        let mut solid = part.to_solid().unwrap();
        for s in solid.surface.iter_mut().filter(|s| s.is_crack()) {
            *s = Surface::crack(time);
        }
        solid
    };
    let first = timed(&upper, 1.25e-5);
    let caps = [first.crack_area(), lower.to_solid().unwrap().crack_area()];
    assert!((caps[0] / caps[1] - 1.0).abs() < 1e-12 && caps[0] > 2.0);
    // Second generation, across the old cap.
    let body = Exact::new(&first).unwrap();
    let (left, right) = body.split(Vec3::x(), 0.1).unwrap();
    let area = |solid: &Solid, wanted: Surface| -> f64 {
        let of = |t: usize| {
            let [a, b, c] = solid.mesh.corners(t);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        (0..solid.surface.len()).filter(|&t| solid.surface[t] == wanted).map(of).sum()
    };
    let [left, right] = [left.to_solid().unwrap(), right.to_solid().unwrap()];
    let old = Surface::crack(1.25e-5);
    let new = Surface::crack(0.0);
    assert!((area(&left, old) + area(&right, old) - caps[0]).abs() < 1e-11);
    assert!((area(&left, new) - area(&right, new)).abs() < 1e-11 && area(&left, new) > 0.5);
    let outer = area(&left, Surface::Outer) + area(&right, Surface::Outer);
    assert!((outer - area(&first, Surface::Outer)).abs() < 1e-10);
}

#[test]
fn parts_come_in_order_and_keep_their_cavities() {
    let small = sphere(0.4, Detail::default()).unwrap();
    let mut hollow = sphere(1.0, Detail::default()).unwrap();
    let shell = hollow.signed_volume() - small.signed_volume();
    hollow.append(&small.flipped());
    let mut scene = small.translated(Vec3::new(3.0, 0.0, 0.0));
    scene.append(&hollow);
    let parts = exact(&scene).components().unwrap();
    assert_eq!(parts.len(), 2);
    assert!((parts[0].volume() / shell - 1.0).abs() < 1e-12);
    assert!(parts[0].to_solid().unwrap().mesh.is_closed());
    assert!((parts[1].volume() / small.signed_volume() - 1.0).abs() < 1e-12);
    // A ring cut through its hole falls into two halves of one side each.
    let ring = exact(&torus(1.0, 0.2, Detail::default()).unwrap());
    let (a, b) = ring.split(Vec3::x(), 0.5).unwrap();
    assert_eq!((a.components().unwrap().len(), b.components().unwrap().len()), (1, 1));
    let (slab, _) = b.split(Vec3::x(), -0.5).unwrap();
    assert_eq!(slab.components().unwrap().len(), 2);
}

#[test]
fn planes_that_miss_or_graze_are_harmless() {
    let body = exact(&cuboid(Vec3::repeat(2.0), Detail::default()).unwrap());
    for (offset, above, below) in [(5.0, 0.0, 8.0), (-5.0, 8.0, 0.0), (1.0, 0.0, 8.0)] {
        let (a, b) = body.split(Vec3::z(), offset).unwrap();
        assert!((a.volume() - above).abs() < 1e-11 && (b.volume() - below).abs() < 1e-11);
    }
    // A sliver 1e-9 from the face, ten times over (F31).
    let mut rest = body.clone();
    let mut sum = 0.0;
    for i in 1..=10 {
        let (slice, left) = rest.split(Vec3::z(), 1.0 - 1e-9 * f64::from(i)).unwrap();
        assert!(slice.to_solid().is_ok());
        sum += slice.volume();
        rest = left;
    }
    assert!(((sum + rest.volume()) / 8.0 - 1.0).abs() < 1e-12);
    assert!((sum / 4e-8 - 1.0).abs() < 1e-6);
    assert!(matches!(body.split(Vec3::zeros(), 0.0), Err(BooleanError::Plane { .. })));
    assert!(matches!(body.split(Vec3::x(), f64::NAN), Err(BooleanError::Plane { .. })));
}

#[test]
fn what_is_not_a_solid_is_refused_by_name() {
    let whole = cuboid(Vec3::repeat(1.0), Detail::default()).unwrap();
    let try_new = |mesh: TriMesh| Exact::new(&Solid::outer(mesh)).unwrap_err();
    let mut open = whole.clone();
    open.triangles.pop();
    assert!(matches!(try_new(open), BooleanError::NotClosed { open: 3, crowded: 0, .. }));
    assert!(matches!(try_new(whole.flipped()), BooleanError::NotSolid { volume } if volume < 0.0));
    assert!(matches!(try_new(TriMesh::default()), BooleanError::Mesh(MeshError::Empty { .. })));
    assert!(matches!(try_new(whole.scaled(f64::NAN)), BooleanError::Mesh(_)));
    let flat = TriMesh {
        vertices: whole.vertices.clone(),
        triangles: vec![whole.triangles[0], whole.flipped().triangles[0]],
    };
    assert!(matches!(try_new(flat), BooleanError::NotSolid { .. }));
}

#[test]
fn the_result_does_not_depend_on_what_ran_before() {
    let run = || {
        let pieces = shatter(&exact(&bumpy_ball(1.0)), 3, 9);
        pieces.iter().map(|p| p.to_solid().unwrap()).collect::<Vec<_>>()
    };
    let first = run();
    // Uses up kernel ids in between.
    exact(&cuboid(Vec3::repeat(1.0), Detail::default()).unwrap());
    assert_eq!(first, run());
}
