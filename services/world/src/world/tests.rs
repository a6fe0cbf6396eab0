//! Motions that are no numbers, bodies that do not follow their velocities, a free fall.

use super::*;
use crate::ContactMaterial;
use cullet_geometry::{Pose, Solid, TriMesh};
use cullet_model::{Material, SurfaceLaw};
use std::sync::Arc;

/// A tetrahedron around the origin.
fn spec() -> BodySpec {
    let corner = |x, y, z| Vec3::new(x, y, z) * 0.1;
    let vertices = vec![
        corner(1.0, 1.0, 1.0),
        corner(1.0, -1.0, -1.0),
        corner(-1.0, 1.0, -1.0),
        corner(-1.0, -1.0, 1.0),
    ];
    let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    BodySpec {
        name: "tetrahedron".into(),
        density: None,
        hulls: vec![vertices.clone()],
        solid: Arc::new(Solid::outer(TriMesh { vertices, triangles })),
        material: ContactMaterial {
            solid: Material {
                density: 1000.0,
                young: 1e9,
                poisson: 0.2,
                failure_stress: 1e6,
                fracture_energy: 10.0,
            },
            restitution: 0.2,
            friction: 0.5,
            surface: SurfaceLaw { hardness: 3e7, friction: 0.85 },
            flows: false,
        },
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        fixed: false,
        driven: None,
        breakable: true,
        weakest: 1.0,
        threshold: None,
        parent: None,
        generation: 0,
        original_volume: None,
    }
}

#[test]
fn a_motion_that_is_no_number_ends_the_run_by_name() {
    let mut world = World::new(WorldSettings::default()).unwrap();
    let id = world.insert(spec()).unwrap();
    world.step().unwrap();
    world.state.rigid.set_velocity(id.0, &Vec3::new(f64::NAN, 0.0, 0.0), &Vec3::zeros());
    let error = world.step().unwrap_err();
    assert_eq!(error, WorldError::NotFinite { name: "tetrahedron".into(), step: 2 });
}

#[test]
fn a_body_that_does_not_follow_its_velocity_ends_the_run_by_name() {
    let free = WorldSettings { gravity: Vec3::zeros(), ..WorldSettings::default() };
    let mut world = World::new(free).unwrap();
    let velocity = Vec3::new(3.0, 0.0, -4.0);
    let held = world.insert(BodySpec { velocity, ..spec() }).unwrap();
    world.step().unwrap();
    world.state.rigid.held = Some(held.0);
    (0..4).for_each(|_| assert!(world.step().unwrap().is_empty()));
    let error = world.step().unwrap_err();
    let (name, due) = ("tetrahedron".into(), 5.0 * 5.0 / 240.0);
    let WorldError::Frozen { due: found, .. } = error else { panic!("{error}") };
    assert!((found - due).abs() < 1e-12, "{found} of {due} m");
    let wanted = WorldError::Frozen { name, step: 6, velocity, moved: 0.0, due: found };
    assert_eq!(error, wanted);
    let text = error.to_string();
    for word in ["\"tetrahedron\"", "step 6", "(3.000, 0.000, -4.000) m/s", "1.042e-1 m"] {
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn a_free_fall_is_a_free_fall() {
    let mut world = World::new(WorldSettings::default()).unwrap();
    let id = world.insert(spec()).unwrap();
    (0..240).for_each(|_| assert!(world.step().unwrap().is_empty()));
    let body = world.body(id).unwrap();
    assert!((body.velocity.z + 9.81).abs() < 1e-9, "{}", body.velocity);
    // Semi-implicit Euler with 8 substeps falls too far by g t dt / 2 / 8.
    assert!((body.pose.translation.z + 4.905).abs() < 5e-3, "{}", body.pose.translation);
    assert!((world.time() - 1.0).abs() < 1e-12 && world.step_count() == 240);
}

/// What a window hands over: momentum to the last bit but rounding, and the window's place, unless
/// the body touches another of the rigid world.
#[test]
fn a_body_takes_what_a_window_gave_it() {
    let mut world = World::new(WorldSettings::default()).unwrap();
    let id = world.insert(spec()).unwrap();
    let before = world.totals();
    let given =
        Exchange { linear: Vec3::new(0.3, -0.1, 0.2), torque: Vec3::new(0.01, 0.02, -0.01) };
    assert!(world.push(id, &given));
    let after = world.totals();
    let gained = after.momentum - before.momentum;
    assert!((gained - given.linear).norm() < 1e-14, "{gained}");
    let turned = after.angular_momentum - before.angular_momentum;
    let centre = world.body(id).unwrap().pose.translation.vector;
    let due = given.torque + centre.cross(&given.linear);
    assert!((turned - due).norm() < 1e-12 * due.norm(), "{turned} {due}");
    world.step().unwrap();
    let place = Pose::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.1, 0.0, 0.4));
    let momentum = world.totals().momentum;
    assert!(world.lead(id, &place));
    assert_eq!(world.body(id).unwrap().pose, place);
    assert_eq!(world.totals().momentum, momentum);
    let parts = world.body_for_window(id).unwrap().parts;
    assert_eq!((parts.len(), parts[0].len()), (1, 4));
    // On a floor it stays where the rigid world has it, and a floor takes nothing.
    let mut floor = spec();
    floor.fixed = true;
    floor.pose = Pose::new(Vec3::new(1.0, 2.0, 2.95), Vec3::zeros());
    let floor = world.insert(floor).unwrap();
    world.step().unwrap();
    assert!(!world.lead(id, &Pose::identity()));
    assert!(!world.push(floor, &given) && !world.lead(floor, &place));
    assert_eq!(world.body_for_window(floor).unwrap().inertia, None);
}
