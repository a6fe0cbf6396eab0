//! Volumes against closed forms; every shape closed, outward and accepted by the boolean kernel.

use super::*;
use crate::boolean::Exact;
use crate::mesh::Solid;
use std::f64::consts::PI;

const DETAIL: Detail = Detail { segments: 37, edge: None };

/// Share of a body of revolution's volume that its inscribed n-gon has.
fn inscribed(segments: u32) -> f64 {
    let a = TAU / f64::from(segments);
    a.sin() / a
}

fn assert_sound(name: &str, mesh: &TriMesh) {
    assert!(mesh.is_closed(), "{name} is open");
    assert!(mesh.signed_volume() > 0.0, "{name} is inside out");
    let exact = Exact::new(&Solid::outer(mesh.clone())).expect(name);
    assert!(!exact.crosses_itself().unwrap(), "{name} crosses itself");
    assert!((exact.volume() / mesh.signed_volume() - 1.0).abs() < 1e-12, "{name}");
}

fn assert_volume(name: &str, mesh: &TriMesh, volume: f64) {
    assert_sound(name, mesh);
    let error = mesh.signed_volume() / volume - 1.0;
    assert!(error.abs() < 1e-12, "{name}: relative volume error {error:e}");
}

#[test]
fn bodies_of_revolution_have_the_volume_of_their_inscribed_prism() {
    let k = inscribed(DETAIL.segments);
    assert_volume("cylinder", &cylinder(0.3, 2.0, DETAIL).unwrap(), k * PI * 0.09 * 2.0);
    assert_volume("cone", &cone(0.3, 0.0, 2.0, DETAIL).unwrap(), k * PI * 0.09 * 2.0 / 3.0);
    assert_volume("cone down", &cone(0.0, 0.3, 2.0, DETAIL).unwrap(), k * PI * 0.09 * 2.0 / 3.0);
    let frustum = k * PI / 3.0 * 2.0 * (0.09 + 0.03 + 0.01);
    assert_volume("frustum", &cone(0.3, 0.1, 2.0, DETAIL).unwrap(), frustum);
    let torus = torus(1.0, 0.25, DETAIL).unwrap();
    // Pappus: the tube's own polygon (10 segments here), times the way of its centre.
    let tube = 0.0625 * PI * inscribed(10);
    assert_volume("torus", &torus, k * TAU * tube);
    let goblet =
        [[0.0, 0.0], [3.0, 0.0], [0.4, 0.5], [0.4, 5.0], [3.5, 9.0], [3.2, 9.0], [0.0, 5.5]];
    let pappus = |r0: f64, r1: f64, h: f64| PI / 3.0 * h * (r0 * r0 + r0 * r1 + r1 * r1);
    let volume = pappus(3.0, 0.4, 0.5) + pappus(0.4, 0.4, 4.5) + pappus(0.4, 3.5, 4.0)
        - pappus(0.0, 3.2, 3.5);
    assert_volume("goblet", &lathe_solid(&goblet, DETAIL).unwrap(), k * volume);
    let upside_down: Vec<_> = goblet.iter().rev().copied().collect();
    assert_volume("goblet", &lathe_solid(&upside_down, DETAIL).unwrap(), k * volume);
    let off_axis = lathe_solid(&[[1.0, 0.0], [1.0, 2.0]], DETAIL).unwrap();
    assert_volume("disc-closed", &off_axis, k * TAU);
}

#[test]
fn a_vessel_is_its_wall() {
    let k = inscribed(DETAIL.segments);
    let pot = lathe_shell(&[[0.0, 0.0], [0.5, 0.0], [0.5, 1.0]], 0.1, DETAIL).unwrap();
    assert_volume("pot", &pot, k * PI * (0.25 - 0.16 * 0.9));
    let pipe = lathe_shell(&[[0.5, 0.0], [0.5, 1.0]], 0.1, DETAIL).unwrap();
    assert_volume("pipe", &pipe, k * PI * (0.25 - 0.16));
    let inside = crate::inside::Inside::new(&pot);
    assert!(
        !inside.contains(Vec3::new(0.0, 0.0, 0.5)) && inside.contains(Vec3::new(0.0, 0.0, 0.05))
    );

    let belly: Vec<[f64; 2]> = (0..=40)
        .map(|i| f64::from(i) / 40.0)
        .map(|s| [0.08 * (1.2 * (0.15 + s)).sin() * 1.4, 0.25 * s])
        .collect();
    let mut vase = vec![[0.0, 0.0]];
    vase.extend(belly);
    assert_sound("vase", &lathe_shell(&vase, 0.006, DETAIL).unwrap());
    vase.reverse();
    assert_sound("vase", &lathe_shell(&vase, 0.006, DETAIL).unwrap());
    let stem = [
        [0.0, 0.0],
        [0.03, 0.0],
        [0.03, 0.004],
        [0.004, 0.01],
        [0.004, 0.07],
        [0.03, 0.09],
        [0.035, 0.15],
    ];
    assert_sound("wine glass", &lathe_shell(&stem, 0.0045, DETAIL).unwrap());
    let bowl: Vec<[f64; 2]> = (0..=24)
        .map(|i| PI / 2.0 * f64::from(i) / 24.0)
        .map(|a| [if a == 0.0 { 0.0 } else { a.sin() }, -a.cos()])
        .collect();
    let bowl = lathe_shell(&bowl, 0.05, DETAIL).unwrap();
    assert_sound("bowl", &bowl);
    let volume = 2.0 * PI / 3.0 * (1.0 - 0.95_f64.powi(3));
    assert!((bowl.signed_volume() / volume - 1.0).abs() < 0.02);
}

#[test]
fn a_wall_stands_half_on_each_side_of_its_midline() {
    let k = inscribed(DETAIL.segments);
    let pipe = lathe_midline(&[[0.5, 0.0], [0.5, 1.0]], 0.1, DETAIL).unwrap();
    assert_volume("pipe", &pipe, k * TAU * 0.5 * 0.1);
    let pot = [[0.0, 0.0], [0.5, 0.0], [0.5, 1.0]];
    let volume = k * PI * (0.55 * 0.55 * 1.05 - 0.45 * 0.45 * 0.95);
    assert_volume("pot", &lathe_midline(&pot, 0.1, DETAIL).unwrap(), volume);
    let down: Vec<_> = pot.iter().rev().copied().collect();
    assert_volume("pot", &lathe_midline(&down, 0.1, DETAIL).unwrap(), volume);
    // Two cones of 45°: the walls meet the axis √2 times half the thickness from the tips.
    let tops = [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let cones = |r: f64| k * PI / 3.0 * 2.0 * r * r * r;
    let off = 0.05 * 2.0_f64.sqrt();
    let hollow = lathe_midline(&tops, 0.1, DETAIL).unwrap();
    assert_eq!(hollow.components().len(), 2);
    assert!((hollow.signed_volume() / (cones(1.0 + off) - cones(1.0 - off)) - 1.0).abs() < 1e-12);
    let thick = lathe_midline(&[[0.1, 0.0], [0.1, 1.0]], 0.3, DETAIL);
    assert_eq!(thick, Err(ShapeError::Wall { thickness: 0.3 }));
}

#[test]
fn boxes_prisms_spheres_and_capsules() {
    let fine = Detail { segments: 40, edge: Some(0.13) };
    assert_volume("box", &cuboid(Vec3::new(1.0, 0.5, 0.1), DETAIL).unwrap(), 0.05);
    assert_volume("box", &cuboid(Vec3::new(1.0, 0.5, 0.1), fine).unwrap(), 0.05);
    assert_eq!(cuboid(Vec3::repeat(1.0), DETAIL).unwrap().triangles.len(), 12);

    let comb = [
        [0.0, 0.0],
        [5.0, 0.0],
        [5.0, 2.0],
        [4.0, 0.5],
        [3.0, 2.0],
        [2.0, 0.5],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let area = outline::signed_area(&comb);
    assert_volume("comb", &extrude(&comb, 0.3, DETAIL).unwrap(), 0.3 * area);
    let reversed: Vec<_> = comb.iter().rev().copied().collect();
    assert_volume("comb", &extrude(&reversed, 0.3, fine).unwrap(), 0.3 * area);
    let straight =
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
    assert_volume("points on edges", &extrude(&straight, 1.0, DETAIL).unwrap(), 4.0);

    let ball = sphere(2.0, Detail { segments: 100, edge: None }).unwrap();
    assert_sound("sphere", &ball);
    assert_eq!(ball.triangles.len(), 20 * 20 * 20);
    assert!(ball.vertices.iter().all(|p| (p.norm() - 2.0).abs() < 1e-14));
    assert!((ball.signed_volume() / (32.0 / 3.0 * PI) - 1.0).abs() < 4e-3);
    let pill = capsule(0.5, 1.0, Detail { segments: 96, edge: None }).unwrap();
    assert_sound("capsule", &pill);
    assert!((pill.signed_volume() / (PI * (0.25 + 0.5 / 3.0)) - 1.0).abs() < 3e-3);
}

#[test]
fn a_half_ball_has_its_centroid_at_three_eighths() {
    let m = {
        let half: Vec<[f64; 2]> = (0..=256)
            .map(|i| PI / 2.0 * f64::from(i) / 256.0)
            .map(|a| [if a == PI / 2.0 { 0.0 } else { a.cos() }, a.sin()])
            .collect();
        lathe_solid(&half, Detail { segments: 512, edge: None }).unwrap().mass_properties()
    };
    assert!((m.centroid - Vec3::new(0.0, 0.0, 0.375)).norm() < 1e-4, "{}", m.centroid);
    assert!((m.inertia[(2, 2)] / m.volume - 0.4).abs() < 1e-4);
    // 2/5 − (3/8)² = 83/320.
    assert!((m.inertia[(0, 0)] / m.volume - 83.0 / 320.0).abs() < 1e-4);
}

#[test]
fn division_keeps_the_surface_and_the_limit() {
    let coarse = cylinder(0.3, 2.0, DETAIL).unwrap();
    assert_volume("division alone", &refine(&coarse, 0.1).unwrap(), coarse.signed_volume());
    let fine = cylinder(0.3, 2.0, Detail { edge: Some(0.05), ..DETAIL }).unwrap();
    assert_volume("cylinder", &fine, coarse.signed_volume());
    assert!((fine.area() / coarse.area() - 1.0).abs() < 1e-12);
    let longest = (0..fine.triangles.len())
        .flat_map(|t| {
            let [a, b, c] = fine.corners(t);
            [(b - a).norm(), (c - b).norm(), (a - c).norm()]
        })
        .fold(0.0, f64::max);
    assert!(longest <= 0.05);
    assert!(fine.triangles.len() < 14_000, "{}", fine.triangles.len());
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let said = |r: Result<TriMesh, ShapeError>| r.unwrap_err().to_string();
    assert!(said(sphere(f64::NAN, DETAIL)).contains("sphere radius is NaN"));
    assert!(said(cylinder(-1.0, 1.0, DETAIL)).contains("[1e-6, 1e6]"));
    assert!(said(cone(0.0, 0.0, 1.0, DETAIL)).contains("cone bottom"));
    assert!(said(torus(1.0, 1.0, DETAIL)).contains("minor"));
    assert!(said(capsule(1.0, f64::INFINITY, DETAIL)).contains("capsule height"));
    assert!(said(sphere(1.0, Detail { segments: 2, edge: None })).contains("segments is 2"));
    let dust = Detail { segments: 64, edge: Some(1e-5) };
    assert!(matches!(sphere(1.0, dust), Err(ShapeError::TooFine { .. })));
    assert!(matches!(cuboid(Vec3::repeat(1.0), dust), Err(ShapeError::TooFine { .. })));
    assert!(matches!(cylinder(1.0, 1.0, dust), Err(ShapeError::TooFine { .. })));
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 2.0]];
    assert!(said(extrude(&bow, 1.0, DETAIL)).contains("crosses itself"));
    let spike = [[0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [2.0, 0.0], [1.0, 1.0]];
    assert!(said(extrude(&spike, 1.0, DETAIL)).contains("crosses itself"));
    assert!(said(extrude(&[[0.0, 0.0], [1.0, 0.0]], 1.0, DETAIL)).contains("2 distinct points"));
    let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
    assert_eq!(extrude(&line, 1.0, DETAIL), Err(ShapeError::Flat));
    let pinch = [[0.0, 0.0], [1.0, 0.5], [0.0, 1.0], [1.0, 1.5], [0.0, 2.0]];
    assert_eq!(lathe_solid(&pinch, DETAIL), Err(ShapeError::Pinched { point: 2 }));
    let thick = lathe_shell(&[[0.0, 0.0], [0.5, 0.0], [0.5, 1.0]], 0.6, DETAIL);
    assert_eq!(thick, Err(ShapeError::Wall { thickness: 0.6 }));
}
