//! What a struck body rests on: told to the solver, and answered for in the books.

use crate::common;

use common::*;
use cullet_geometry::math::unit;
use cullet_geometry::{Pose, Vec3};
use cullet_world::{BodyId, BodySpec, Breakage, HeldContact, Hit, Reaction, ReplaceError, World};

fn ball(at: Vec3, velocity: Vec3) -> BodySpec {
    BodySpec { velocity, breakable: false, ..body("ball", sphere(0.03, 6), STEEL, at) }
}

/// What a cube stands on.
#[derive(Clone, Copy)]
enum Under {
    Floor,
    /// A slab that lies on the floor.
    Slab,
    /// A slab that nothing holds, where nothing weighs.
    Nothing,
}

/// A cube that lies on the floor, hit from above by balls at these places, all at once.
fn lying(places: &[(f64, f64)]) -> (World, BodyId, Vec<Hit>) {
    standing(Under::Floor, places)
}

/// A cube, its bottom at a height of zero, hit from above by balls at these places, all at once.
fn standing(under: Under, places: &[(f64, f64)]) -> (World, BodyId, Vec<Hit>) {
    let loose = matches!(under, Under::Nothing);
    let mut world = World::new(if loose { weightless() } else { settings() }).unwrap();
    let slab = body("slab", cuboid(Vec3::new(0.4, 0.4, 0.1)), GLASS, Vec3::new(0.0, 0.0, -0.05));
    let spec = floor();
    match under {
        Under::Floor => drop(put(&mut world, spec)),
        Under::Slab => {
            let pose = Pose::translation(0.0, 0.0, -1.1);
            put(&mut world, BodySpec { pose, ..spec });
            put(&mut world, slab);
        }
        Under::Nothing => drop(put(&mut world, slab)),
    }
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, 0.1)));
    steps(&mut world, 40);
    for (k, &(x, y)) in places.iter().enumerate() {
        let name = format!("ball {k}");
        let spec = ball(Vec3::new(x, y, 0.331), -Vec3::z() * 8.0);
        put(&mut world, BodySpec { name, ..spec });
    }
    let hits = until_hit(&mut world, 60);
    let hits: Vec<Hit> = hits.into_iter().filter(|hit| hit.body == cube).collect();
    (world, cube, hits)
}

/// Shares an impulse \[N·s\] out to supports.
fn reactions(supports: Vec<HeldContact>, impulse: f64) -> Vec<Reaction> {
    let each = impulse / supports.len() as f64;
    supports.into_iter().map(|support| Reaction { support, impulse: each }).collect()
}

#[test]
fn a_body_that_lies_is_held_from_below_where_it_touches() {
    let (world, cube, hits) = lying(&[(0.02, 0.01)]);
    let supports = world.supports(cube, &hits);
    assert!(!supports.is_empty());
    for support in &supports {
        assert!((support.held.normal - Vec3::z()).norm() < 1e-3, "{}", support.held.normal);
        assert!((support.held.point.z + 0.1).abs() < 2e-3, "{}", support.held.point);
    }
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    for corner in corners.map(|(x, y)| Vec3::new(0.099 * x, 0.099 * y, -0.1)) {
        let held = |s: &HeldContact| (s.held.point - corner).norm() < s.held.radius + 2e-3;
        assert!(supports.iter().any(held), "the corner at {corner} is free");
    }
    let engine: Vec3 = supports.iter().map(|s| s.exchanged.linear).sum();
    let hit = hits[0].impact.impulse;
    assert!(engine.z > 0.3 * hit, "the floor answered {} of {hit}", engine.z);
    // Beside its weight, the cube got what the ball and the floor gave it.
    let view = world.body(cube).unwrap();
    let gained = view.velocity * view.mass - hits[0].exchanged.linear - engine;
    let weight = 9.81 * view.mass / 240.0;
    assert!(gained.norm() < 0.05 * weight, "{gained} of {weight}");
    // A body in the air rests on nothing.
    let (world, cube, _, hits) = strike(3);
    assert!(world.supports(cube, &hits).is_empty());
}

#[test]
fn ledges_hold_only_where_they_are() {
    let mut world = World::new(settings()).unwrap();
    for side in [-1.0, 1.0] {
        let ledge = cuboid(Vec3::new(0.02, 0.4, 0.1));
        let spec = body("ledge", ledge, STEEL, Vec3::new(0.19 * side, 0.0, -0.05));
        put(&mut world, BodySpec { fixed: true, breakable: false, ..spec });
    }
    let pane = cuboid(Vec3::new(0.4, 0.4, 0.008));
    let pane = put(&mut world, body("pane", pane, GLASS, Vec3::new(0.0, 0.0, 0.004)));
    steps(&mut world, 30);
    put(&mut world, ball(Vec3::new(0.0, 0.0, 0.2), -Vec3::z() * 8.0));
    let hits = until_hit(&mut world, 60);
    let supports = world.supports(pane, &hits);
    assert!((8..=64).contains(&supports.len()), "{}", supports.len());
    for s in &supports {
        assert!((s.held.point.x.abs() - 0.19).abs() < 0.011 && s.held.radius < 0.03, "{s:?}");
    }
    let reach = supports.iter().map(|s| s.held.point.y.abs() + s.held.radius).fold(0.0, f64::max);
    assert!(reach > 0.19, "the ends of the ledges hold too: {reach}");
}

#[test]
fn what_supports_give_is_in_the_books_and_energy_never_grows() {
    for case in 0..60 {
        let under = [Under::Floor, Under::Slab, Under::Nothing][case as usize / 20];
        let place = (0.08 * any(case, 1), 0.08 * any(case, 2));
        let (mut world, cube, hits) = standing(under, &[place]);
        let supports = world.supports(cube, &hits);
        for _ in 0..case % 3 {
            world.step().unwrap();
        }
        let hit = &hits[0].impact;
        let mass = world.body(cube).unwrap().mass;
        let taken = hit.impulse * unit(9, case, 3);
        let held = taken * 1.1 * unit(9, case, 4);
        let mut pieces = cells(CUBE, 3, 0.3);
        shove(&mut pieces, case, &-Vec3::z(), taken - held, mass, 0.3 * unit(9, case, 5));
        let reactions = reactions(supports, held);
        let before = world.totals();
        let breakage = Breakage { pieces, reactions, fracture_energy: 0.01, ..Breakage::default() };
        let r = world.break_up(cube, &hits, breakage).unwrap();
        let after = world.totals();
        assert!(r.momentum_rel_error < 1e-9 && r.angular_momentum_rel_error < 1e-9, "{case} {r:?}");
        assert!(r.energy_gain_rel < 1e-9, "{case}: {r:?}");
        let given = after.given_to_fixed - before.given_to_fixed;
        let drift = after.momentum + given - before.momentum;
        assert!(drift.norm() < 1e-9 * hit.impulse, "{case}: {drift}");
        let given = after.angular_given_to_fixed - before.angular_given_to_fixed;
        let drift = after.angular_momentum + given - before.angular_momentum;
        assert!(drift.norm() < 1e-9 * hit.impulse, "{case}: {drift}");
    }
}

#[test]
fn a_body_that_is_held_stays_where_it_is_and_the_ball_bounces() {
    let (mut world, cube, hits) = lying(&[(0.0, 0.0)]);
    let hit = hits[0].impact;
    let reactions = reactions(world.supports(cube, &hits), hit.impulse);
    // The push and what holds it cancel: the pieces get nothing.
    let pieces = cells(CUBE, 2, 0.0);
    let r = world.break_up(cube, &hits, Breakage { pieces, reactions, ..Breakage::default() });
    let r = r.unwrap();
    assert!((r.momentum_scale - 1.0).abs() < 1e-12, "{r:?}");
    for &id in &r.fragments {
        let speed = world.body(id).unwrap().velocity.norm();
        assert!(speed < 0.1, "a piece moves at {speed} m/s");
    }
    let ball = world.bodies().find(|view| view.name == "ball 0").unwrap();
    let slowed = (ball.velocity.z + 8.0) * ball.mass;
    assert!((slowed / hit.impulse - 1.0).abs() < 0.1, "the ball got {slowed}");
}

#[test]
fn two_balls_at_once_are_two_hits_of_one_step() {
    let (mut world, cube, hits) = lying(&[(-0.06, 0.0), (0.06, 0.02)]);
    assert_eq!(hits.len(), 2, "{hits:?}");
    assert_ne!(hits[0].other, hits[1].other);
    let supports = world.supports(cube, &hits);
    assert!(supports.iter().all(|s| hits.iter().all(|hit| hit.other != s.other)));
    let whole: f64 = hits.iter().map(|hit| hit.impact.impulse).sum();
    let breakage = Breakage {
        pieces: cells(CUBE, 2, 0.0),
        reactions: reactions(supports, whole),
        ..Breakage::default()
    };
    let r = world.break_up(cube, &hits, breakage).unwrap();
    assert!(r.momentum_rel_error < 1e-9 && r.energy_gain_rel < 1e-9, "{r:?}");
}

#[test]
fn a_support_does_not_pull() {
    let (mut world, cube, hits) = lying(&[(0.0, 0.0)]);
    let reactions = reactions(world.supports(cube, &hits), -1.0);
    let pieces = cells(CUBE, 2, 0.0);
    let refused =
        world.break_up(cube, &hits, Breakage { pieces, reactions, ..Breakage::default() });
    assert!(matches!(refused, Err(ReplaceError::Reaction { index: 0, value }) if value < 0.0));
    assert!(world.body(cube).is_some());
}

#[test]
fn a_slab_on_the_floor_passes_on_what_it_gets_and_a_loose_one_keeps_it() {
    let (world, cube, hits) = standing(Under::Slab, &[(0.0, 0.0)]);
    let slab = world.bodies().find(|view| view.name == "slab").unwrap();
    let mass = slab.mass;
    let supports = world.supports(cube, &hits);
    assert!(supports.iter().all(|s| s.other == slab.id));
    let engine: Vec3 = supports.iter().map(|s| s.exchanged.linear).sum();
    assert!(engine.z > 0.3 * hits[0].impact.impulse, "the slab answered {engine}");
    let opposite: Vec3 = supports.iter().map(|s| s.exchanged_other.linear).sum();
    assert!((engine + opposite).z.abs() < 1e-3 * engine.norm(), "{engine} {opposite}");
    assert!(supports.iter().all(|s| s.kept < 0.2 && s.held.mobility < 0.25 / mass), "{supports:?}");

    let (world, cube, hits) = standing(Under::Nothing, &[(0.0, 0.0)]);
    let supports = world.supports(cube, &hits);
    assert!(!supports.is_empty());
    let count = supports.len() as f64;
    for s in &supports {
        assert_eq!(s.kept, 1.0);
        // 1/m in the middle, at a corner with the arm's (r×n)·I⁻¹(r×n) on top.
        let least = 0.999 * count / mass;
        assert!(
            s.held.mobility > least && s.held.mobility < 8.0 * least,
            "{} of {least}",
            s.held.mobility
        );
    }
}

/// The pieces of a cube that nothing pushes through leave no motion behind in what it stood on,
/// however much of the blow the engine had let through.
#[test]
fn a_slab_that_was_not_pushed_does_not_move() {
    for under in [Under::Slab, Under::Nothing] {
        let (mut world, cube, hits) = standing(under, &[(0.0, 0.0)]);
        let reactions = reactions(world.supports(cube, &hits), 0.0);
        let pieces = cells(CUBE, 2, 0.0);
        let breakage = Breakage { pieces, reactions, ..Breakage::default() };
        let r = world.break_up(cube, &hits, breakage).unwrap();
        assert!(r.momentum_rel_error < 1e-9 && r.energy_gain_rel < 1e-9, "{r:?}");
        let slab = world.bodies().find(|view| view.name == "slab").unwrap();
        let bound = 0.02 * hits[0].impact.impulse / slab.mass;
        assert!(slab.velocity.norm() < bound, "{} of {bound}", slab.velocity);
        // Nor do they stay up on an answer of the ground that there was no call for.
        for &id in &r.fragments {
            let speed = world.body(id).unwrap().velocity.norm();
            assert!(speed < 0.1, "a piece moves at {speed} m/s");
        }
    }
}

/// A small cube that touches a wall, and a ram of steel that is sixty times as heavy and hits it
/// against that; what struck it.
fn squeezed(case: u64) -> (World, BodyId, Vec<Hit>) {
    let mut world = World::new(weightless()).unwrap();
    let wall = body("wall", cuboid(Vec3::new(0.4, 2.0, 2.0)), STEEL, Vec3::new(0.3001, 0.0, 0.0));
    put(&mut world, BodySpec { fixed: true, breakable: false, ..wall });
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
    let aside = Vec3::new(-0.45, 0.05 * any(case, 1), 0.05 * any(case, 2));
    let ram = body("ram", cuboid(Vec3::new(0.6, 0.5, 0.5)), STEEL, aside);
    let velocity = Vec3::x() * (6.0 + any(case, 3));
    put(&mut world, BodySpec { velocity, breakable: false, ..ram });
    let hits = until_hit(&mut world, 60);
    let hits = hits.into_iter().filter(|hit| hit.body == cube).collect();
    (world, cube, hits)
}

/// What presses a body against others gives it no more than it had to give, whatever the solver
/// knows of those.
#[test]
fn a_squeezed_body_makes_no_energy() {
    let (mut broken, mut worst, mut wrong) = (0, 0.0f64, 0.0f64);
    for case in 0..30 {
        let (mut world, cube, hits) = squeezed(case);
        let ram = world.bodies().find(|view| view.name == "ram").unwrap().mass;
        let start = 0.5 * ram * (6.0 + any(case, 3)).powi(2);
        let hit = hits.iter().find(|hit| !hit.fixed_other).unwrap().impact;
        let known = if case % 2 == 0 { world.supports(cube, &hits) } else { Vec::new() };
        let mut pieces = cells(CUBE, 3, 0.3);
        let mass = world.body(cube).unwrap().mass;
        let given = hit.impulse * unit(9, case, 4);
        shove(&mut pieces, case, &hit.normal, given, mass, 40.0 * unit(9, case, 5));
        let reactions = reactions(known, 0.5 * given);
        let breakage = Breakage { pieces, reactions, fracture_energy: 1.0, ..Breakage::default() };
        let r = match world.break_up(cube, &hits, breakage) {
            Ok(report) => report,
            Err(ReplaceError::Unaffordable { .. }) => continue,
            Err(error) => panic!("case {case}: {error}"),
        };
        broken += 1;
        assert!(r.momentum_rel_error < 1e-9 && r.angular_momentum_rel_error < 1e-9, "{case} {r:?}");
        worst = worst.max((world.totals().kinetic_energy + 1.0) / start);
        wrong = wrong.max(r.energy_before / start).max(1.0 + r.energy_gain_rel);
    }
    assert!(broken > 20, "{broken} of 30 broke");
    assert!(worst <= 1.0 + 1e-9, "{worst} of the energy that the ram had");
    assert!(wrong <= 1.0 + 1e-9, "the ledger takes {wrong} of it for what there was");
}
