//! How bodies lie, slide and roll: nothing that moves is stopped, and what is stopped is booked.

use crate::common;

use common::*;
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_world::{
    BodyId, BodySpec, GlueBodies, GlueLimit, GlueSpec, Keyframe, KeyframedPath, PathInterpolation,
    World, WorldSettings,
};
use std::sync::Arc;

fn place(world: &World, id: BodyId) -> Vec3 {
    world.body(id).expect("it is there").pose.translation.vector
}

/// Steps for so long \[s\], and hands back the heights that a body had.
fn heights(world: &mut World, id: BodyId, time: f64) -> Vec<f64> {
    let count = (time / WorldSettings::default().step).round() as u32;
    let look = |_| {
        world.step().expect("the step is sound");
        place(world, id).z
    };
    (0..count).map(look).collect()
}

/// The difference of the greatest and the least.
fn range(of: &[f64]) -> f64 {
    of.iter().fold(f64::MIN, |a, b| a.max(*b)) - of.iter().fold(f64::MAX, |a, b| a.min(*b))
}

#[test]
fn what_drifts_slowly_where_nothing_pulls_goes_on() {
    for speed in [1e-4, 5e-3, 3e-2] {
        let mut world = World::new(weightless()).unwrap();
        let cube = body("cube", cuboid(CUBE), GLASS, Vec3::zeros());
        let spin = Vec3::new(0.0, speed, 0.0);
        let cube = put(&mut world, BodySpec { velocity: Vec3::x() * speed, spin, ..cube });
        steps(&mut world, 1200);
        let view = world.body(cube).unwrap();
        assert!((place(&world, cube).x / (speed * 5.0) - 1.0).abs() < 1e-6, "{speed} m/s");
        assert!(!view.sleeping && (view.spin.y / speed - 1.0).abs() < 1e-6, "{speed} rad/s");
        assert_eq!(world.totals().slept_energy, 0.0);
    }
}

/// A slab on its edge, a tenth of a degree past its balance: it lies after about four seconds.
#[test]
fn what_is_past_its_balance_falls() {
    let size = Vec3::new(0.1, 0.2, 0.5);
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let angle = (size.x / size.z).atan() + 0.1_f64.to_radians();
    let turn = Quat::from_euler_angles(0.0, angle, 0.0);
    let lowest = (0..8).map(|n| {
        let corner = |i: usize| if n >> i & 1 == 1 { 0.5 * size[i] } else { -0.5 * size[i] };
        (turn * Vec3::new(corner(0), corner(1), corner(2))).z
    });
    let height = -lowest.fold(f64::INFINITY, f64::min);
    let mut slab = body("slab", cuboid(size), GLASS, Vec3::new(0.0, 0.0, height));
    slab.pose.rotation = turn;
    let slab = put(&mut world, slab);
    heights(&mut world, slab, 8.0);
    let lies = place(&world, slab).z;
    assert!((lies - 0.05).abs() < 2e-3, "its centre is {lies} m high");
}

#[test]
fn what_lies_sleeps_and_what_that_takes_is_booked() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let cube = body("cube", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, 0.11));
    let cube = put(&mut world, BodySpec { breakable: false, ..cube });
    let mut before = world.totals();
    for _ in 0..1200 {
        world.step().expect("the step is sound");
        if world.body(cube).unwrap().sleeping {
            break;
        }
        before = world.totals();
    }
    let after = world.totals();
    assert!(world.at_rest() && after.kinetic_energy == 0.0);
    assert!((after.slept_energy - before.kinetic_energy).abs() <= 1e-12 * before.kinetic_energy);
    assert!((after.slept_momentum - before.momentum).norm() <= 1e-12 * before.momentum.norm());
    assert!(before.kinetic_energy < 1e-4, "{} J", before.kinetic_energy);
    steps(&mut world, 60);
    assert_eq!(world.totals().slept_energy, after.slept_energy, "it is booked once");
}

/// A ball that begins without spin slides until it rolls: at 5/7 of its speed, whatever the
/// friction (10/7 of what it turns with). It keeps that and does not hop.
#[test]
fn a_ball_rolls() {
    for cells in [4, 6, 12] {
        let mut world = World::new(settings()).unwrap();
        put(&mut world, floor());
        let ball = body("ball", sphere(0.05, cells), STEEL, Vec3::new(-4.0, 0.0, 0.05));
        let velocity = Vec3::new(2.0, 0.0, 0.0);
        let ball = put(&mut world, BodySpec { velocity, breakable: false, ..ball });
        let heights = heights(&mut world, ball, 2.0);
        let view = world.body(ball).unwrap();
        let speed = view.velocity.x;
        assert!((speed / (2.0 * 5.0 / 7.0) - 1.0).abs() < 0.02, "{cells}: {speed} m/s");
        assert!((view.spin.y * 0.05 / speed - 1.0).abs() < 0.02, "{cells}: {}", view.spin);
        assert!(range(&heights) < 2e-4 && place(&world, ball).y.abs() < 1e-3, "{cells}");
    }
}

/// What slides over one plate and over the same as tiles: how far it comes, and how much its
/// height changes \[m\].
fn slide(tiles: usize, velocity: Vec3, turn: f64) -> (f64, f64) {
    let mut world = World::new(settings()).unwrap();
    let width = 6.0 / tiles as f64;
    for k in 0..tiles {
        let at = Vec3::new((k as f64 + 0.5) * width, 0.0, -0.05);
        let tile = body(&format!("tile-{k}"), cuboid(Vec3::new(width, 2.0, 0.1)), GLASS, at);
        put(&mut world, BodySpec { fixed: true, breakable: false, ..tile });
    }
    let size = Vec3::new(0.1, 0.1, 0.04);
    let mut slider = body("box", cuboid(size), GLASS, Vec3::new(0.2, 0.0, 0.02));
    slider.pose.rotation = Quat::from_euler_angles(0.0, 0.0, turn);
    let slider = put(&mut world, BodySpec { velocity, breakable: false, ..slider });
    let heights = heights(&mut world, slider, 2.0);
    (place(&world, slider).x, range(&heights))
}

#[test]
fn seams_are_not_felt() {
    for (speed, turn) in [(3.0, 0.0), (3.0, 0.3), (1.0, 0.0), (6.0, 0.785)] {
        let velocity = Vec3::new(speed, 0.0, 0.0);
        let ((plate, _), (tiles, rise)) = (slide(1, velocity, turn), slide(30, velocity, turn));
        assert!(rise < 1e-3, "{speed} m/s, turned by {turn}: {rise} m up");
        assert!((tiles - plate).abs() < 0.02 * plate, "{speed} m/s: {tiles} m, not {plate} m");
    }
}

/// A ball that rolls over tiles goes on as over one plate, at any speed, and leaves the last one.
#[test]
fn a_ball_does_not_feel_seams() {
    for (speed, length_unit) in [(0.2, 0.1), (2.0, 0.1), (2.0, 0.016), (8.0, 0.01)] {
        let mut world = World::new(WorldSettings { length_unit, ..settings() }).unwrap();
        for k in 0..60 {
            let at = Vec3::new(0.1 + 0.2 * f64::from(k), 0.0, -0.05);
            let tile = body(&format!("tile-{k}"), cuboid(Vec3::new(0.2, 2.0, 0.1)), GLASS, at);
            put(&mut world, BodySpec { fixed: true, breakable: false, ..tile });
        }
        let ball = body("ball", sphere(0.05, 6), STEEL, Vec3::new(0.2, 0.0, 0.05));
        let (velocity, spin) = (Vec3::new(speed, 0.0, 0.0), Vec3::new(0.0, speed / 0.05, 0.0));
        let ball = put(&mut world, BodySpec { velocity, spin, breakable: false, ..ball });
        let heights = heights(&mut world, ball, 1.0);
        let found = world.body(ball).unwrap().velocity.x;
        assert!((found / speed - 1.0).abs() < 0.01, "{found} m/s, not {speed}");
        assert!(range(&heights) < 1e-3, "{speed} m/s: {} m up and down", range(&heights));
    }
}

/// A lip that is higher than rounding stops a box: only flush sides are no obstacle.
#[test]
fn a_step_is_felt() {
    for lip in [0.02, 0.002] {
        let mut world = World::new(settings()).unwrap();
        put(&mut world, floor());
        let at = Vec3::new(1.0, 0.0, lip - 0.01);
        let step = body("step", cuboid(Vec3::new(0.5, 2.0, 0.02)), GLASS, at);
        put(&mut world, BodySpec { fixed: true, breakable: false, ..step });
        let slider = cuboid(Vec3::new(0.1, 0.1, 0.04));
        let slider = body("box", slider, GLASS, Vec3::new(0.5, 0.0, 0.02));
        let velocity = Vec3::new(2.0, 0.0, 0.0);
        let slider = put(&mut world, BodySpec { velocity, breakable: false, ..slider });
        heights(&mut world, slider, 0.3);
        assert!(place(&world, slider).x < 0.72, "{lip} m: {}", place(&world, slider));
    }
}

/// A ball rolls on slowly for ever.
#[test]
fn what_rolls_slowly_goes_on() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let ball = body("ball", sphere(0.5, 6), STEEL, Vec3::new(0.0, 0.0, 0.5));
    let (velocity, spin) = (Vec3::new(0.02, 0.0, 0.0), Vec3::new(0.0, 0.04, 0.0));
    let ball = put(&mut world, BodySpec { velocity, spin, breakable: false, ..ball });
    steps(&mut world, 720);
    assert!((place(&world, ball).x / 0.06 - 1.0).abs() < 0.02, "{}", place(&world, ball));
}

/// To what deforms a ball is a ball too, and no box.
#[test]
fn a_ball_has_its_corners_for_windows() {
    let mut world = World::new(settings()).unwrap();
    let ball = put(&mut world, body("ball", sphere(0.5, 6), STEEL, Vec3::zeros()));
    let parts = world.body_for_window(ball).unwrap().parts;
    assert_eq!(parts.len(), 1);
    assert!(parts[0].len() > 100);
    let off = |corner: &Vec3| (corner.norm() / 0.5 - 1.0).abs();
    assert!(parts[0].iter().all(|corner| off(corner) < 1e-3));
}

/// A press that comes down on a ball on the floor is in it, and not in what is glued to it.
#[test]
fn what_a_press_goes_into_is_told() {
    let key = |time: f64, z: f64| Keyframe { time, pose: Pose::translation(0.0, 0.0, z) };
    let path = KeyframedPath::new(vec![key(0.0, 0.17), key(0.5, 0.12)], PathInterpolation::Linear);
    let path = Arc::new(path.unwrap());
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    put(&mut world, body("ball", sphere(0.05, 6), GLASS, Vec3::new(0.0, 0.0, 0.05)));
    let press = body("press", cuboid(CUBE), STEEL, Vec3::new(7.0, 7.0, 7.0));
    let press = put(&mut world, BodySpec { driven: Some(path), breakable: false, ..press });
    let handle = body("handle", cuboid(CUBE), STEEL, Vec3::new(0.15, 0.0, 0.17));
    let handle = put(&mut world, BodySpec { breakable: false, ..handle });
    let spec = GlueSpec {
        bodies: GlueBodies::Pairs(vec![(handle, press)]),
        limit: GlueLimit::EachPair { force: None, torque: None },
        gap: 0.06,
    };
    assert_eq!(world.glue(&spec).unwrap().joints.len(), 1);
    assert_eq!(world.pressed(), None);
    steps(&mut world, 180);
    let pressed = world.pressed().expect("it is in the ball");
    assert_eq!((pressed.body, pressed.by), ("ball", "press"));
    assert!(pressed.depth > 0.002 && pressed.share > 0.02, "{pressed:?}");
}
