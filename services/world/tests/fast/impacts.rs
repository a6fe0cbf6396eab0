//! What counts as a hit, and what a hit says (F37–F40, R4, R5, H1).

use crate::common;

use common::*;
use cullet_geometry::{Quat, Vec3};
use cullet_model::SurfaceLaw;
use cullet_world::{
    BodySpec, ContactMaterial, Elastic, World, WorldSettings, effective_modulus, hertz,
};

fn drop_ball(step: f64, height: f64, material: ContactMaterial) -> (World, Vec<cullet_world::Hit>) {
    let mut world = World::new(WorldSettings { step, ..settings() }).unwrap();
    put(&mut world, floor());
    put(&mut world, body("ball", sphere(0.05, 8), material, Vec3::new(0.0, 0.0, 0.05 + height)));
    let hits = until_hit(&mut world, (2.0 / step) as u32);
    (world, hits)
}

#[test]
fn an_impulse_is_mass_times_change_of_speed() {
    for restitution in [0.0, 0.3, 0.8] {
        let mut world = World::new(weightless()).unwrap();
        put(&mut world, floor());
        let ball = body(
            "ball",
            sphere(0.05, 8),
            ContactMaterial { restitution, ..GLASS },
            Vec3::new(0.0, 0.0, 0.2),
        );
        let floor_e = STEEL.restitution;
        let id = put(&mut world, BodySpec { velocity: Vec3::new(0.0, 0.0, -3.0), ..ball });
        let hit = until_hit(&mut world, 100).remove(0);
        let mass = world.body(id).unwrap().mass;
        let want = mass * 3.0 * (1.0 + (restitution + floor_e) / 2.0);
        let got = hit.impact.impulse;
        assert!((got / want - 1.0).abs() < 2e-3, "e = {restitution}: {got} N·s, not {want}");
        let change = mass * (world.body(id).unwrap().velocity.z + 3.0);
        assert!((got / change - 1.0).abs() < 1e-3, "{got} N·s, but m Δv is {change}");
        assert!(
            (hit.impact.closing_speed - 3.0).abs() < 1e-9,
            "closing at {}",
            hit.impact.closing_speed
        );
        let energy = hit.impact.energy / (0.5 * mass * 9.0);
        assert!((energy - 1.0).abs() < 3e-2, "{energy} of the energy");
    }
}

#[test]
fn the_step_does_not_decide() {
    let speed = (2.0f64 * 9.81 * 0.5).sqrt();
    for rate in [60.0, 120.0, 240.0, 480.0, 960.0] {
        let (world, hits) = drop_ball(1.0 / rate, 0.5, GLASS);
        assert_eq!(hits.len(), 1, "one hit at {rate} Hz");
        let mass = world.body(hits[0].body).unwrap().mass;
        let off = hits[0].impact.impulse / (mass * speed * 1.3) - 1.0;
        // One step of free fall, g dt / v, and two per cent.
        let most = 0.02 + 9.81 / rate / speed;
        assert!(off.abs() < most, "{rate} Hz: impulse off by {off}");
    }
}

#[test]
fn a_hit_says_what_hertz_says() {
    let (world, hits) = drop_ball(1.0 / 960.0, 0.5, GLASS);
    let hit = &hits[0];
    let modulus = effective_modulus(
        Elastic { young: 70e9, poisson: 0.22 },
        Elastic { young: 210e9, poisson: 0.3 },
    );
    let mass = world.body(hit.body).unwrap().mass;
    let want = hertz(mass, modulus, 0.05, hit.impact.closing_speed);
    // The radius of curvature is read off a faceted ball: a seventh is what that allows.
    let pairs = [
        (hit.impact.duration, want.duration),
        (hit.impact.radius, want.radius),
        (hit.peak_force, want.force),
        (hit.effective_mass, mass),
    ];
    for (got, want) in pairs {
        assert!((got / want - 1.0).abs() < 0.15, "{got} is not {want}: {hit:?}");
    }
    assert!((hit.impact.normal - Vec3::z()).norm() < 1e-2, "normal {}", hit.impact.normal);
    assert!((hit.impact.point + Vec3::z() * 0.05).norm() < 0.01, "point {}", hit.impact.point);
    assert!(hit.fixed_other);
}

#[test]
fn a_stack_stands_still_and_silent() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let mut ids = Vec::new();
    for k in 0..10 {
        let block = cuboid(Vec3::new(0.1, 0.1, 0.1));
        let at = Vec3::new(0.0, 0.0, 0.05 + 0.1 * f64::from(k));
        ids.push(put(&mut world, body("block", block, GLASS, at)));
    }
    assert!(world.overlaps().is_empty(), "{:?}", world.overlaps());
    let hits = steps(&mut world, 240 * 5);
    assert!(hits.is_empty(), "{hits:?}");
    for (k, id) in ids.iter().enumerate() {
        let at = world.body(*id).unwrap().pose.translation.vector;
        let want = Vec3::new(0.0, 0.0, 0.05 + 0.1 * k as f64);
        let sink = want.z - at.z;
        assert!((at.xy() - want.xy()).norm() < 1e-3, "block {k} drifted to {at}");
        assert!((-1e-4..1e-3).contains(&sink), "block {k} sank by {sink}");
    }
}

#[test]
fn both_bodies_of_a_pair_get_their_hit() {
    let mut world = World::new(weightless()).unwrap();
    let at = |x: f64| Vec3::new(x, 0.0, 0.0);
    let left = body("left", sphere(0.05, 8), GLASS, at(-0.1));
    let right = body("right", sphere(0.03, 8), STEEL, at(0.1));
    let left = put(&mut world, BodySpec { velocity: at(2.0), ..left });
    let turned = nalgebra::Isometry3::from_parts(
        nalgebra::Translation3::from(at(0.1)),
        Quat::from_euler_angles(0.0, 0.0, 1.0),
    );
    let right = put(&mut world, BodySpec { velocity: at(-3.0), pose: turned, ..right });
    let hits = until_hit(&mut world, 100);
    assert_eq!(hits.iter().map(|h| h.body).collect::<Vec<_>>(), [left, right]);
    assert_eq!(hits[0].impact.impulse, hits[1].impact.impulse);
    assert_eq!(hits[0].episode, hits[1].episode);
    assert!(
        (hits[0].impact.closing_speed - 5.0).abs() < 0.02,
        "closing at {}",
        hits[0].impact.closing_speed
    );
    let (a, b) = (hits[0].impact.normal, turned.rotation * hits[1].impact.normal);
    assert!((a + b).norm() < 1e-9 && (a + Vec3::x()).norm() < 0.1, "{a} {b}");
    let sum = hits[0].exchanged.linear + hits[1].exchanged.linear;
    assert!(sum.norm() < 1e-9 * hits[0].impact.impulse, "{sum}");
}

/// R4: a ball that falls 1 m after a throw of 5 m/s arrives with √(v² + 2gd), whatever the step; a
/// step that ends at the touch, or after it, has given it more of gravity's pull.
#[test]
fn the_closing_speed_is_that_of_the_touch_whatever_the_step() {
    let (start, drop): (f64, f64) = (5.0, 1.0);
    let wanted = (start * start + 2.0 * 9.81 * drop).sqrt();
    for rate in [30.0, 47.0, 60.0, 120.0, 240.0, 1000.0] {
        let mut world = World::new(WorldSettings { step: 1.0 / rate, ..settings() }).unwrap();
        put(&mut world, floor());
        let ball = body("ball", sphere(0.05, 8), GLASS, Vec3::new(0.0, 0.0, 0.05 + drop));
        put(&mut world, BodySpec { velocity: Vec3::new(0.0, 0.0, -start), ..ball });
        let hits = until_hit(&mut world, 2000);
        let speed = hits[0].impact.closing_speed;
        assert!((speed / wanted - 1.0).abs() < 0.005, "1/{rate} s: {speed} of {wanted} m/s");
    }
}

#[test]
fn a_hard_landing_does_not_sink_in() {
    for k in 0..12 {
        let mut world = World::new(weightless()).unwrap();
        put(&mut world, floor());
        let height = 0.1 + 0.2 + 0.0023 * f64::from(k);
        let ball = body("ball", sphere(0.1, 6), GLASS, Vec3::new(0.0, 0.0, height));
        let ball = BodySpec { velocity: Vec3::new(0.0, 0.0, -6.0), ..ball };
        let ball = put(&mut world, ball);
        let plate =
            body("plate", cuboid(Vec3::new(0.1, 0.1, 0.1)), STEEL, Vec3::new(1.0, 0.0, 0.0));
        let plate = put(&mut world, plate);
        let bolt = body("bolt", sphere(0.05, 4), STEEL, Vec3::new(1.0, 0.0, height + 0.3));
        let bolt = BodySpec { velocity: Vec3::new(0.0, 0.0, -6.0), ..bolt };
        let bolt = put(&mut world, bolt);
        let z = |world: &World, id| world.body(id).unwrap().pose.translation.vector.z;
        let (mut low, mut near) = (1.0f64, 1.0f64);
        for _ in 0..60 {
            world.step().unwrap();
            low = low.min(z(&world, ball) - 0.1);
            near = near.min(z(&world, bolt) - z(&world, plate) - 0.1);
        }
        assert!(low > -1e-3, "from {height} m the ball sank by {low} m");
        assert!(near > -1e-3, "from {height} m the bolt sank by {near} m");
        assert!(low < 1e-3 && near < 1e-3, "they touched: {low} {near}");
    }
}

/// A contact yields where the softer of two does; what flows in its own solve has a contact that
/// yields where the other does.
#[test]
fn a_contact_yields_at_the_hardness_of_the_softer() {
    let floor = STEEL.surface.hardness;
    for (hardness, flows, yields) in
        [(2.0 * floor, false, floor), (0.4 * floor, false, 0.4 * floor), (0.4 * floor, true, floor)]
    {
        let surface = SurfaceLaw { hardness, ..GLASS.surface };
        let (_, hits) = drop_ball(0.01, 0.5, ContactMaterial { surface, flows, ..GLASS });
        assert_eq!(hits[0].impact.crushing_pressure, yields, "{hardness} Pa, flows: {flows}");
    }
}
