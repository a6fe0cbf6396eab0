//! What is set down hits nothing; what falls, is thrown or is struck does.

use crate::common;

use common::*;
use cullet_geometry::{Quat, Vec3};
use cullet_world::{BodySpec, Hit, World};

/// A stool of 20 cm on four feet that are not level, as convex parts stand in for a statue's.
fn stool(name: &str, feet: f64, uneven: f64) -> BodySpec {
    let (solid, _) = cuboid(CUBE);
    let block = |low: Vec3, high: Vec3| -> Vec<Vec3> {
        let corner =
            |n: usize| Vec3::from_fn(|i, _| if n >> i & 1 == 1 { high[i] } else { low[i] });
        (0..8).map(corner).collect()
    };
    let foot = |x: f64, y: f64, longer: f64| {
        let (low, high) = (Vec3::new(x, y, -0.1 - longer), Vec3::new(x + 0.04, y + 0.04, 0.0));
        block(low, high)
    };
    let hulls = vec![
        block(Vec3::new(-0.1, -0.1, 0.0), Vec3::repeat(0.1)),
        foot(-0.1, -0.1, uneven),
        foot(0.06, -0.1, -uneven),
        foot(-0.1, 0.06, 0.0),
        foot(0.06, 0.06, 0.5 * uneven),
    ];
    body(name, (solid, hulls), GLASS, Vec3::new(0.0, 0.0, feet + 0.1))
}

/// The hits within a second and a half of a stool that begins so high above what it stands on,
/// alone and one upon the other.
fn set_down(gap: f64, uneven: f64) -> Vec<Hit> {
    let mut hits = Vec::new();
    for turn in [0.0, 0.6] {
        let mut world = World::new(settings()).unwrap();
        put(&mut world, floor());
        for (k, name) in ["one", "two"].into_iter().enumerate() {
            let mut spec = stool(name, gap + k as f64 * (0.2 + gap), uneven);
            spec.pose.rotation = Quat::from_euler_angles(0.0, 0.0, turn);
            put(&mut world, spec);
        }
        hits.extend(steps(&mut world, 360));
    }
    hits
}

#[test]
fn what_is_set_down_hits_nothing() {
    for gap in [-2e-3, -5e-4, 0.0, 1e-3, 1.5e-3] {
        for uneven in [0.0, 5e-4, 1.5e-3] {
            let hits = set_down(gap, uneven);
            let told: Vec<_> = hits.iter().map(|h| (h.time, h.impact.closing_speed)).collect();
            assert!(hits.is_empty(), "{gap} m above, {uneven} m uneven: {told:?}");
        }
    }
}

#[test]
fn a_fall_of_half_a_centimetre_hits() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    put(&mut world, stool("stool", 5e-3, 0.0));
    let hits = steps(&mut world, 60);
    assert!(!hits.is_empty(), "5 mm is a fall");
    let speed = hits[0].impact.closing_speed;
    assert!((speed / (2.0_f64 * 9.81 * 5e-3).sqrt() - 1.0).abs() < 0.2, "{speed}");
}

#[test]
fn a_slow_blow_on_what_has_just_been_set_down_hits() {
    for wait in [0, 4, 60] {
        let mut world = World::new(settings()).unwrap();
        put(&mut world, floor());
        let id = put(&mut world, stool("stool", 1e-3, 5e-4));
        steps(&mut world, wait);
        let ball = body("ball", sphere(0.03, 6), STEEL, Vec3::new(-0.14, 0.0, 0.15));
        let velocity = Vec3::new(0.2, 0.0, 0.2);
        put(&mut world, BodySpec { velocity, breakable: false, ..ball });
        let hits = steps(&mut world, 30);
        let struck = hits.iter().find(|hit| hit.body == id && !hit.fixed_other);
        let speed = struck.map(|hit| hit.impact.closing_speed);
        assert!(speed.is_some_and(|speed| speed > 0.1 && speed < 0.3), "after {wait}: {speed:?}");
    }
}
