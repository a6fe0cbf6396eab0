//! What parts of a broken body do: they fly off. How they touch is in the stability suite.

use crate::block;
use cullet_geometry::Vec3;
use cullet_peridynamics::PeridynamicLaw;

const SPACING: f64 = 1e-3;

/// F82: a point without bonds flies on by itself, however far and fast, and the others do not feel
/// it.
#[test]
fn f82_a_lone_point_becomes_debris() {
    let mut body =
        block([8, 8, 8], SPACING, 0.1, 3.015, PeridynamicLaw::elastic(2500.0, 70e9, 0.25));
    let corner = body.places[0];
    body.sever(|a, b| *a == corner || *b == corner);
    body.strain();
    let speed = Vec3::new(-1e30, 3e29, 0.0);
    body.velocities[0] = speed;
    let dt = body.stable_step();
    for _ in 0..200 {
        body.advance(dt, |_, v| v);
    }
    let sum = body.sums();
    let most = (1..body.places.len()).map(|p| body.velocities[p].norm()).fold(0.0, f64::max);
    println!("F82: {} debris, others move by {most:.1e} m/s", sum.debris);
    assert_eq!((sum.debris, sum.debris_mass), (1, body.mass(0)));
    assert_eq!(sum.debris_momentum, speed * body.mass(0));
    assert!(most < 1e-6, "{most} m/s");
}
