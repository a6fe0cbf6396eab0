//! A body goes, its fragments come: what is kept (R1, R3, R7, F41–F43, H3).

use crate::common;

use common::*;
use cullet_geometry::math::unit;
use cullet_geometry::{Quat, Vec3};
use cullet_world::{BodySpec, Breakage, Hit, ReplaceError, Tier, World, WorldSettings};

#[test]
fn pieces_that_get_nothing_keep_everything() {
    for n in [2, 4] {
        let mut world = World::new(weightless()).unwrap();
        let cube = body("cube", cuboid(CUBE), GLASS, Vec3::new(1.0, -2.0, 0.5));
        let cube = BodySpec {
            velocity: Vec3::new(3.0, 1.0, -2.0),
            spin: Vec3::new(4.0, -9.0, 1.0),
            ..cube
        };
        let cube = put(&mut world, cube);
        let before = world.totals();
        let report = world.replace(cube, &[], cells(CUBE, n, 0.3), 0.0).unwrap();
        let after = world.totals();
        let close =
            |what: &str, a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{what}: {a}, {b}");
        close("mass", after.mass, before.mass);
        close("energy", after.kinetic_energy, before.kinetic_energy);
        close("momentum", after.momentum.norm(), before.momentum.norm());
        let (a, b) = (after.angular_momentum, before.angular_momentum);
        assert!((a - b).norm() < 1e-12 * b.norm(), "{a} {b}");
        assert!((after.momentum - before.momentum).norm() < 1e-12 * before.momentum.norm());
        assert!(report.momentum_rel_error < 1e-12 && report.mass_rel_error < 1e-12);
        assert_eq!(world.len(), n * n * n);
        assert!(world.body(cube).is_none());
    }
}

#[test]
fn the_inertia_of_the_pieces_is_that_of_the_body() {
    let mut world = World::new(weightless()).unwrap();
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
    let mass = world.body(cube).unwrap().mass;
    // Spinning as one, L = I ω: the pieces' L about each axis is the body's inertia.
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        let mut world = World::new(weightless()).unwrap();
        let cube = body("cube", cuboid(CUBE), GLASS, Vec3::zeros());
        let cube = put(&mut world, BodySpec { spin: axis, ..cube });
        world.replace(cube, &[], cells(CUBE, 4, 0.3), 0.0).unwrap();
        let want = mass * 0.2 * 0.2 / 6.0;
        let got = world.totals().angular_momentum;
        assert!((got - axis * want).norm() < 1e-12 * want, "{got} is not {want}");
    }
}

#[test]
fn whatever_the_solver_gives_momentum_stays_and_energy_never_grows() {
    let mut dear = 0;
    for case in 0..40 {
        let (mut world, cube, _, hits) = strike(case);
        let mut pieces = cells(CUBE, 3, 0.3);
        let mass = world.body(cube).unwrap().mass;
        let strength = unit(3, case, 0) * 2.5;
        let wild = if case % 3 == 0 { 0.0 } else { 3.0 * unit(3, case, 1) };
        shove(
            &mut pieces,
            case,
            &hits[0].impact.normal,
            hits[0].impact.impulse * strength,
            mass,
            wild,
        );
        let cost = hits[0].impact.energy * unit(3, case, 2) * 0.5;
        for _ in 0..case % 4 {
            world.step().unwrap();
        }
        let before = world.totals();
        match world.replace(cube, &hits, pieces, cost) {
            Ok(r) => {
                let after = world.totals();
                let scale = before.mass * 15.0;
                let linear = (after.momentum - before.momentum).norm() / scale;
                let angular =
                    (after.angular_momentum - before.angular_momentum).norm() / (scale * 3.0);
                assert!(linear < 1e-12 && angular < 1e-12, "case {case}: {linear} {angular}");
                assert!(
                    r.momentum_rel_error < 1e-9 && r.angular_momentum_rel_error < 1e-9,
                    "{r:?}"
                );
                assert!(r.energy_gain_rel < 1e-9, "case {case}: {r:?}");
                assert!(
                    r.energy_after + cost <= r.energy_before * (1.0 + 1e-9),
                    "case {case}: {r:?}"
                );
                assert!(
                    (0.0..=1.0).contains(&r.momentum_scale)
                        && (0.0..=1.0).contains(&r.spread_scale)
                );
            }
            Err(ReplaceError::Unaffordable { available, payable, fracture_energy }) => {
                dear += 1;
                assert!(payable < fracture_energy && fracture_energy <= available, "case {case}");
                assert!(world.body(cube).is_some());
                assert_eq!(world.totals(), before, "case {case}: nothing may change");
            }
            Err(error) => panic!("case {case}: {error}"),
        }
    }
    assert!(dear < 30, "{dear} of 40 unaffordable");
}

#[test]
fn a_weak_push_is_handed_over_whole_and_the_motion_before_the_hit_comes_back() {
    let (mut world, cube, ball, hits) = strike(5);
    let mut pieces = cells(CUBE, 2, 0.0);
    let mass = world.body(cube).unwrap().mass;
    let impulse = 0.1 * hits[0].impact.impulse;
    shove(&mut pieces, 5, &hits[0].impact.normal, impulse, mass, 0.0);
    let report = world.replace(cube, &hits, pieces, 0.0).unwrap();
    let scales = (report.momentum_scale, report.spread_scale);
    assert_eq!(scales, (1.0, 1.0), "{report:?}");
    let fragments = report.fragments.iter().map(|id| world.body(*id).unwrap());
    let sum: Vec3 = fragments.map(|b| b.velocity * b.mass).sum();
    // Before the hit the cube flew at any3(5, 6); now it has that and the push.
    let gained = sum - any3(5, 6) * mass;
    assert!((gained.norm() / impulse - 1.0).abs() < 1e-6, "{} is not {impulse}", gained.norm());
    let ball = world.body(ball).unwrap();
    let lost = (ball.velocity - (any3(5, 6) - aim(5) * 12.0 + any3(5, 20))) * ball.mass;
    assert!((lost + gained).norm() < 1e-6 * impulse, "lost {lost}, gained {gained}");
}

#[test]
fn a_bullet_that_breaks_its_target_flies_on() {
    let mut last = 0.0;
    for speed in [50.0, 100.0, 200.0] {
        let mut world = World::new(weightless()).unwrap();
        let size = Vec3::new(0.01, 0.2, 0.2);
        let wall = put(&mut world, body("wall", cuboid(size), GLASS, Vec3::zeros()));
        let ball = body("ball", sphere(0.005, 6), STEEL, Vec3::new(-0.7, 0.01, 0.02));
        let ball = put(&mut world, BodySpec { velocity: Vec3::new(speed, 0.0, 0.0), ..ball });
        let hits = until_hit(&mut world, 20);
        let mut pieces = cells(size, 4, 0.0);
        // The plug in front takes what the wall's strength gives back: the same for every speed.
        let impulse = 0.1;
        let mass = world.body(wall).unwrap().mass;
        shove(&mut pieces, 1, &Vec3::x(), impulse, mass, 0.0);
        let report = world.replace(wall, &hits[..1], pieces, 0.3).unwrap();
        assert_eq!(report.momentum_scale, 1.0, "{report:?}");
        let rest = world.body(ball).unwrap();
        let want = speed - impulse / rest.mass;
        assert!(
            (rest.velocity.x - want).abs() < 0.03 * speed,
            "{} is not {want} m/s",
            rest.velocity.x
        );
        assert!(rest.velocity.x > last, "monotone");
        last = rest.velocity.x;
        assert!(report.momentum_rel_error < 1e-9 && report.angular_momentum_rel_error < 1e-9);
    }
}

#[test]
fn both_bodies_of_a_pair_may_break_and_the_books_still_close() {
    let mut world = World::new(WorldSettings { debris_damping: 0.0, ..weightless() }).unwrap();
    let left = body("left", cuboid(CUBE), GLASS, Vec3::new(-0.3, 0.02, 0.03));
    let left = put(&mut world, BodySpec { velocity: Vec3::new(4.0, 0.0, 0.0), ..left });
    let right = body("right", cuboid(CUBE), GLASS, Vec3::new(0.3, 0.0, 0.0));
    let right = put(&mut world, BodySpec { velocity: Vec3::new(-4.0, 0.0, 0.0), ..right });
    let start = world.totals();
    let hits = until_hit(&mut world, 60);
    assert_eq!(hits.len(), 2);
    for (id, hit) in [(left, &hits[0]), (right, &hits[1])] {
        let mut pieces = cells(CUBE, 2, 0.2);
        let mass = world.body(id).unwrap().mass;
        shove(&mut pieces, 2, &hit.impact.normal, 0.6 * hit.impact.impulse, mass, 0.3);
        let report = world.replace(id, std::slice::from_ref(hit), pieces, 1.0).unwrap();
        assert!(report.momentum_rel_error < 1e-9 && report.angular_momentum_rel_error < 1e-9);
        assert!(report.energy_gain_rel < 1e-9 && report.momentum_scale > 0.0, "{report:?}");
        world.step().unwrap();
    }
    let end = world.totals();
    assert!((end.momentum - start.momentum).norm() < 1e-6, "{} {}", end.momentum, start.momentum);
    assert!(
        end.kinetic_energy < start.kinetic_energy,
        "{} of {}",
        end.kinetic_energy,
        start.kinetic_energy
    );
    // Each side ends with its own push only, not with twice the exchange.
    let speeds: Vec<f64> = world.bodies().map(|b| b.velocity.x).collect();
    assert!(speeds.iter().all(|v| v.abs() < 4.5), "{speeds:?}");
}

#[test]
fn a_fixed_striker_swallows_what_it_must_and_the_ledger_knows() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let cube = body("cube", cuboid(CUBE), GLASS, Vec3::new(0.4, 0.1, 0.25));
    let cube = put(&mut world, BodySpec { velocity: Vec3::new(0.5, 0.0, -5.0), ..cube });
    let hits = until_hit(&mut world, 60);
    let before = world.totals();
    let mass = world.body(cube).unwrap().mass;
    let mut pieces = cells(CUBE, 3, 0.3);
    shove(&mut pieces, 3, &Vec3::z(), hits[0].impact.impulse, mass, 0.5);
    let report = world.replace(cube, &hits, pieces, 2.0).unwrap();
    let after = world.totals();
    let sum = after.momentum + after.given_to_fixed - before.momentum;
    assert!(sum.norm() < 1e-9 * before.mass, "{sum}");
    let sum = after.angular_momentum + after.angular_given_to_fixed - before.angular_momentum;
    assert!(sum.norm() < 1e-9 * before.mass, "{sum}");
    assert!(
        report.energy_gain_rel < 1e-9 && report.energy_after < report.energy_before - 2.0 + 1e-9
    );
    let hits = steps(&mut world, 480);
    assert!(
        world.bodies().all(|b| b.fixed || b.pose.translation.vector.z > -0.01),
        "none falls through"
    );
    assert!(hits.iter().all(|hit| hit.body != cube), "the dead are not hit");
}

#[test]
fn tiers_and_generations_end_the_cascade() {
    let mut world = World::new(WorldSettings { max_generation: 2, ..weightless() }).unwrap();
    let id = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
    let report = world.replace(id, &[], cells(CUBE, 2, 0.0), 0.0).unwrap();
    assert!(report.tiers.iter().all(|t| *t == Tier::Large), "{:?}", report.tiers);
    let first = world.body(report.fragments[0]).unwrap();
    assert!(first.breakable && first.generation == 1 && first.parent == Some(id));
    assert!((first.volume_ratio - 0.125).abs() < 1e-12);
    let report = world.replace(report.fragments[0], &[], cells(CUBE / 2.0, 2, 0.0), 0.0).unwrap();
    assert!(
        report.tiers.iter().all(|t| *t == Tier::Small),
        "1/64 of the original: {:?}",
        report.tiers
    );
    let small = world.body(report.fragments[0]).unwrap();
    assert!(!small.breakable && small.generation == 2);
    let report = world.replace(report.fragments[1], &[], cells(CUBE / 4.0, 2, 0.0), 0.0).unwrap();
    assert!(
        report.tiers.iter().all(|t| *t == Tier::Tiny),
        "1/512 of the original: {:?}",
        report.tiers
    );
    // Either bound alone ends it.
    let breaks = |max_generation, parts| {
        let mut world = World::new(WorldSettings { max_generation, ..weightless() }).unwrap();
        let id = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
        let report = world.replace(id, &[], cells(CUBE, parts, 0.0), 0.0).unwrap();
        world.body(report.fragments[0]).unwrap().breakable
    };
    assert!(breaks(2, 2));
    assert!(!breaks(1, 2), "of the last generation");
    assert!(!breaks(2, 4), "too small");
}

#[test]
fn two_strikers_share_what_the_pieces_got() {
    let mut world = World::new(weightless()).unwrap();
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
    let mut balls = Vec::new();
    for (at, radius) in [(Vec3::new(-0.3, 0.02, 0.0), 0.03), (Vec3::new(0.01, -0.3, 0.03), 0.03)] {
        let ball = body("ball", sphere(radius, 6), STEEL, at);
        let velocity = -at.normalize() * 10.0;
        balls.push(put(&mut world, BodySpec { velocity, ..ball }));
    }
    let mut hits = Vec::new();
    for _ in 0..12 {
        hits.extend(world.step().unwrap().into_iter().filter(|hit| hit.body == cube));
    }
    assert_eq!(hits.len(), 2, "{hits:?}");
    let before = world.totals();
    let mass = world.body(cube).unwrap().mass;
    let push = hits[0].impact.normal * hits[0].impact.impulse
        + hits[1].impact.normal * hits[1].impact.impulse;
    let mut pieces = cells(CUBE, 3, 0.2);
    shove(&mut pieces, 4, &push.normalize(), 0.5 * push.norm(), mass, 0.4);
    let report = world.replace(cube, &hits, pieces, 1.0).unwrap();
    let after = world.totals();
    assert!(report.momentum_rel_error < 1e-9 && report.angular_momentum_rel_error < 1e-9);
    assert!((after.momentum - before.momentum).norm() < 1e-12 * mass * 10.0);
    assert!((after.angular_momentum - before.angular_momentum).norm() < 1e-12 * mass * 10.0);
    assert!(report.energy_gain_rel < 1e-9, "{report:?}");
    assert!(
        (report.energy_before / (2.0 * 0.5 * 100.0 * world.body(balls[0]).unwrap().mass) - 1.0)
            .abs()
            < 0.02
    );
}

/// A cube that the engine spins up in the step of the hit, by more than a radian, still slows down
/// as the solver says: the momentum of the push does not turn with it.
#[test]
fn momentum_does_not_turn_with_a_body_that_was_spun_up() {
    let wide = WorldSettings { step: 1e-3, ..weightless() };
    let mut world = World::new(wide).unwrap();
    let wall = cuboid(Vec3::new(0.1, 1.0, 1.0));
    let wall = body("wall", wall, STEEL, Vec3::new(0.05, 0.0, 0.0));
    put(&mut world, BodySpec { fixed: true, breakable: false, ..wall });
    let size = Vec3::repeat(0.01);
    let cube = body("cube", cuboid(size), GLASS, Vec3::new(-0.02, 0.0, 0.0));
    // It comes on an edge, and slides along the wall.
    let mut pose = cube.pose;
    pose.rotation = Quat::from_axis_angle(&Vec3::y_axis(), 0.6);
    let velocity = Vec3::new(100.0, 0.0, 50.0);
    let cube = put(&mut world, BodySpec { velocity, pose, ..cube });
    let hits = until_hit(&mut world, 60);
    let view = world.body(cube).unwrap();
    let turned = hits[0].orientation.angle_to(&view.pose.rotation);
    assert!(turned > 1.0, "turned by {turned}");
    let mass = view.mass;
    let mut pieces = cells(size, 2, 0.0);
    // All of them lose half of the cube's approach, as the solver tells it: in the body's frame.
    let back = hits[0].orientation.inverse() * -Vec3::x() * 50.0;
    pieces.iter_mut().for_each(|piece| piece.velocity = back);
    let r = world.replace(cube, &hits, pieces, 1e-3).unwrap();
    assert!(r.momentum_rel_error < 1e-9 && r.energy_gain_rel < 1e-9, "{r:?}");
    let momentum: Vec3 =
        r.fragments.iter().map(|&id| world.body(id).unwrap()).map(|v| v.velocity * v.mass).sum();
    let left = momentum / mass - velocity;
    assert!((left + Vec3::x() * 50.0).norm() < 1e-6, "{left}");
}

/// A striker that goes on through what it broke meets the pieces at any age, and in the same blow;
/// any other hit is a new one.
#[test]
fn a_striker_that_goes_on_meets_the_pieces_at_once() {
    let struck = |meets_again| {
        let mut world = World::new(weightless()).unwrap();
        let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
        let ball = body("ball", sphere(0.03, 6), STEEL, Vec3::new(-0.2, 0.02, 0.0));
        let ball = put(&mut world, BodySpec { velocity: Vec3::x() * 10.0, ..ball });
        let hits: Vec<Hit> =
            until_hit(&mut world, 12).into_iter().filter(|hit| hit.body == cube).collect();
        let pieces = cells(CUBE, 2, 0.0);
        let breakage = Breakage { pieces, meets_again, ..Breakage::default() };
        let pieces = world.break_up(cube, &hits, breakage).unwrap().fragments;
        // Those that begin within the 10 ms that other pieces are left alone.
        let young = world.time() + world.settings().birth_grace;
        let mut again = steps(&mut world, 12);
        again.retain(|hit| hit.time < young);
        (world, again, ball, pieces)
    };
    let (world, again, ball, pieces) = struck(true);
    let second = again.iter().find(|hit| hit.other == ball).expect("it is hit again");
    assert!(pieces.contains(&second.body), "{second:?}");
    let second = second.clone();
    let before = |hits: &[Hit]| world.blows_before(second.body, hits);
    assert_eq!(before(std::slice::from_ref(&second)), Some(0), "the same blow");
    let late = Hit { time: 0.2, ..second.clone() };
    assert_eq!(before(std::slice::from_ref(&late)), Some(1), "long after");
    let other = Hit { other: second.body, ..second.clone() };
    assert_eq!(before(&[second.clone(), other]), Some(1), "another beside it");
    assert_eq!(before(&[]), Some(1));
    // What comes of the same blow counts as that.
    let mut world = world;
    let breakage = Breakage { pieces: cells(CUBE / 2.0, 2, 0.0), ..Breakage::default() };
    let third = world.break_up(second.body, &[second], breakage).unwrap().fragments;
    assert_eq!(world.blows_before(third[0], &[]), Some(1));
    assert_eq!(world.body(third[0]).unwrap().generation, 2);
    assert!(struck(false).1.iter().all(|hit| hit.other != ball));
}
