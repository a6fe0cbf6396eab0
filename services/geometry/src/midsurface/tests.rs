//! Midsurfaces of bodies with known middles, and of bodies that have none.

mod bodies;

use super::*;
use crate::boolean::Exact;
use crate::remesh::SurfaceError;
use crate::remesh::tests::MeshQuality;
use crate::shapes::{Detail, cuboid, lathe_midline, lathe_shell, sphere};
use bodies::*;
use std::f64::consts::PI;

/// Asserts the bounds that a shell solver relies on.
fn assert_even(name: &str, surface: &WallSurface, spacing: f64) {
    let mesh = surface.mesh();
    assert_eq!(crate::remesh::check_surface(&mesh, &surface.thickness), Ok(()), "{name}");
    let q = MeshQuality::of(&mesh, spacing);
    assert!(q.edges[0] > 0.6 && q.edges[1] < 1.5, "{name}: {q:?}");
    assert!(q.angle > 25.0, "{name}: {q:?}");
    assert!(q.inside[0] >= 5 && q.inside[1] <= 7 && q.sum <= 22, "{name}: {q:?}");
    assert!(q.border[1] == 0 || (q.border[0] >= 3 && q.border[1] <= 5), "{name}: {q:?}");
}

/// Asserts that 95 % of the vertices are within a tenth of the thickness of the true middle, whose
/// distance `off` gives, and of the thickness itself within 2 %.
fn assert_middle(name: &str, surface: &WallSurface, thickness: f64, off: impl Fn(Vec3) -> f64) {
    let far = surface.vertices.iter().filter(|&&p| off(p).abs() > 0.1 * thickness).count();
    assert!(20 * far <= surface.vertices.len(), "{name}: {far} of {}", surface.vertices.len());
    let wrong = surface.thickness.iter().filter(|&&t| (t / thickness - 1.0).abs() > 0.02).count();
    assert!(20 * wrong <= surface.vertices.len(), "{name}: thickness wrong at {wrong}");
}

#[test]
fn a_hollow_ball_has_a_closed_middle() {
    for (segments, spacing) in [(48, 0.006), (24, 0.008)] {
        let surface = WallSurface::of_mesh(&hollow_ball(segments), spacing).unwrap();
        assert_even("ball", &surface, spacing);
        assert_middle("ball", &surface, 0.003, |p| p.norm() - 0.0485);
        assert_eq!(surface.boundary().len(), 0);
        assert!((surface.area() / (4.0 * PI * 0.0485 * 0.0485) - 1.0).abs() < 0.02);
        assert!(surface.mesh().signed_volume() > 0.0, "normals point outward");
    }
}

#[test]
fn an_egg_has_a_closed_middle() {
    let egg = egg_midline();
    let mesh = lathe_midline(&egg, 0.0004, Detail { segments: 48, edge: None }).unwrap();
    let surface = WallSurface::of_mesh(&mesh, 0.002).unwrap();
    assert_even("egg", &surface, 0.002);
    assert_middle("egg", &surface, 0.0004, |p| distance_to_profile(p, &egg));
    assert!((surface.volume() / mesh.signed_volume() - 1.0).abs() < 0.01);
}

#[test]
fn a_bowl_ends_at_its_rim_flat_or_round() {
    for (is_round, spacing) in [(false, 0.006), (true, 0.006), (false, 0.01)] {
        let surface = WallSurface::of_mesh(&bowl(is_round, 64), spacing).unwrap();
        assert_even("bowl", &surface, spacing);
        let rim = surface.boundary();
        assert_eq!(rim.len(), 1);
        let top = if is_round { 0.002 } else { 0.0 };
        for &v in &rim[0] {
            let p = surface.vertices[v as usize];
            assert!((p.z - top).abs() < 0.25 * spacing, "the rim is at {}", p.z);
            assert!((p.xy().norm() - 0.078).abs() < 0.0004, "{p}");
        }
        let off = |p: Vec3| if p.z > 0.0 { p.xy().norm() - 0.078 } else { p.norm() - 0.078 };
        assert_middle("bowl", &surface, 0.004, off);
        let area = 2.0 * PI * 0.078 * (0.078 + top);
        assert!((surface.area() / area - 1.0).abs() < 0.01, "{}", surface.area() / area);
    }
}

#[test]
fn a_bottle_has_a_smooth_even_middle() {
    let (mesh, spacing) = (bottle(64), 0.006);
    let surface = WallSurface::of_mesh(&mesh, spacing).unwrap();
    assert_even("bottle", &surface, spacing);
    assert_eq!(surface.boundary().len(), 1);
    assert!(surface.boundary()[0].iter().all(|&v| surface.vertices[v as usize].z > 0.1995));
    let middle = bottle_midline();
    assert_middle("bottle", &surface, 0.003, |p| distance_to_profile(p, &middle));
    assert!((surface.volume() / mesh.signed_volume() - 1.0).abs() < 0.01);
    // The same bits again.
    assert_eq!(surface, WallSurface::of_mesh(&mesh, spacing).unwrap());
}

#[test]
fn a_bent_pane_keeps_its_corners() {
    let mesh = windscreen();
    let surface = WallSurface::of_mesh(&mesh, 0.015).unwrap();
    assert_even("pane", &surface, 0.015);
    assert_middle("pane", &surface, 0.005, |p| p.xy().norm() - 1.5);
    let area = 1.5 * 0.4 * 0.4;
    assert!((surface.area() / area - 1.0).abs() < 2e-3, "{}", surface.area() / area);
    let (low, high) = surface.mesh().bounds().unwrap();
    for x in [low.x, high.x] {
        for z in [-0.2, 0.2] {
            let corner = Vec3::new(x, 1.5 * libm::cos(0.2), z);
            let least = surface.vertices.iter().map(|p| (p - corner).norm());
            assert!(least.fold(f64::MAX, f64::min) < 0.001, "no corner at {corner}");
        }
    }
}

#[test]
fn thickening_and_finding_again_is_the_identity() {
    let first = WallSurface::of_mesh(&bowl(false, 64), 0.008).unwrap();
    let solid = thicken(&first.vertices, &first.triangles, &first.thickness).unwrap();
    assert!(solid.is_closed());
    let again = WallSurface::of_mesh(&solid, 0.008).unwrap();
    assert!((again.area() / first.area() - 1.0).abs() < 0.02);
    assert_middle("again", &again, 0.004, |p| p.norm() - 0.078);
    let mean = again.volume() / again.area();
    assert!((mean / 0.004 - 1.0).abs() < 0.02, "{mean}");
}

#[test]
fn what_is_no_wall_is_refused_with_its_figure() {
    let refused = |mesh: &TriMesh, spacing: f64| WallSurface::of_mesh(mesh, spacing).unwrap_err();
    let ball = sphere(0.05, Detail::default()).unwrap();
    assert!(matches!(refused(&ball, 0.01), NotWall::Thick { ratio } if ratio > 0.9));
    let cube = cuboid(Vec3::repeat(0.1), Detail::default()).unwrap();
    assert!(matches!(refused(&cube, 0.02), NotWall::Thick { ratio } if ratio > 0.9));
    let rib = ribbed_plate();
    assert!(matches!(refused(&rib, 0.01), NotWall::Unpaired { share } if share < 0.9));
    assert!(refused(&rib, 0.01).to_string().contains("at least 0.9"));
    let mug = mug();
    assert!(mug.is_closed());
    assert!(matches!(refused(&mug, 0.005), NotWall::Unpaired { .. } | NotWall::Volume { .. }));
    let wedge = refused(&uneven_bowl(), 0.008);
    assert!(matches!(wedge, NotWall::Varies { ratio } if ratio > 2.0), "{wedge}");
    let mut open = bowl(false, 32);
    open.triangles.pop();
    assert_eq!(refused(&open, 0.01), NotWall::Open { edges: 3 });
    let spacing = refused(&bowl(false, 32), 1e-6);
    assert!(matches!(spacing, NotWall::Surface(SurfaceError::Spacing { .. })), "{spacing}");
    let tight = lathe_shell(&[[0.008, 0.0], [0.008, 0.2]], 0.003, Detail::default()).unwrap();
    let tight = refused(&tight, 0.002);
    assert!(matches!(tight, NotWall::Thick { .. } | NotWall::Sharp { .. }), "{tight}");
}

/// What a plan asks before there is a midsurface: how thick, and whether a hit goes through the
/// wall or lands on its rim.
#[test]
fn an_outline_tells_walls_from_rims() {
    let profile: Vec<[f64; 2]> = (0..=12)
        .map(|k| {
            let (sin, cos) = libm::sincos(f64::from(k) * 0.1);
            [if k == 0 { 0.0 } else { 0.08 * sin }, 0.08 - 0.08 * cos]
        })
        .collect();
    let mesh = lathe_midline(&profile, 0.004, Detail { segments: 48, edge: None }).unwrap();
    let wall = WallOutline::of_mesh(&mesh).unwrap();
    assert!((wall.thickness / 0.004 - 1.0).abs() < 0.05, "{}", wall.thickness);
    assert!((wall.width / wall.thickness) > 20.0);
    let across = |place: Vec3, way: Vec3| wall.across(&mesh, place, &way);
    let foot = Vec3::new(0.003, 0.001, -0.002);
    assert!(across(foot, Vec3::z()) > 0.95 && across(foot, Vec3::x()) < 0.3);
    let [r, z] = profile[12];
    let (sin, cos) = libm::sincos(1.2);
    let rim = Vec3::new(r, 0.0, z);
    assert!(across(rim, Vec3::new(cos, 0.0, sin)) < 0.1, "along the wall beside the rim");
    assert!(across(rim, Vec3::new(sin, 0.0, -cos)) > 0.95, "across it");
    assert!(WallOutline::of_mesh(&sphere(0.05, Detail::default()).unwrap()).is_err());
}

/// The crack faces of a shard are its rim, however narrow it is: its wall is what is left of the
/// body's.
#[test]
fn a_shard_of_a_bowl_is_a_wall_and_its_cracks_are_the_rim() {
    let bowl = Exact::new(&Solid::outer(bowl(false, 64))).unwrap();
    let cut = cuboid(Vec3::new(0.1, 0.02, 0.1), Detail::default()).unwrap();
    let cut = cut.translated(Vec3::new(0.05, 0.0, -0.05));
    let crack = Surface::Crack { damage_time: [0.0; 3], front_speed: [0.0; 3], parent: 0 };
    let surface = vec![crack; cut.triangles.len()];
    let cut = Exact::new(&Solid { surface, ..Solid::outer(cut) }).unwrap();
    let shard = bowl.intersect(&cut).unwrap().to_solid().unwrap();
    let wall = WallSurface::of_solid(&shard, 0.004).unwrap();
    let mean = wall.volume() / wall.area();
    assert!((mean / 0.004 - 1.0).abs() < 0.05, "{mean}");
    let whole = wall.volume() / shard.mesh.signed_volume();
    assert!((whole - 1.0).abs() < 0.1, "{whole}");
    assert!(WallOutline::of_solid(&shard).is_ok());
}
