//! The rigid world: F34, F36 to F43, F74.

use crate::bodies::{
    CUBE, GLASS, STEEL, body, cells, cuboid, floor, put, settings, shove, sphere, steps, strike,
    until_hit, weightless,
};
use cullet_geometry::{Quat, Vec3};
use cullet_model::Material;
use cullet_world::{
    BodyId, BodySpec, ContactMaterial, Hit, ReplaceError, Tier, World, WorldError, WorldSettings,
};

/// Two cubes that meet at `at`, and the hits of their meeting.
fn meeting(at: Vec3, density: f64) -> (World, [BodyId; 2], Vec<Hit>) {
    let mut world =
        World::new(WorldSettings { impulse_threshold: 1e-9, ..weightless() }).expect("settings");
    let left = body("left", cuboid(CUBE), GLASS, at - 0.25 * Vec3::x());
    let light = ContactMaterial { solid: Material { density, ..GLASS.solid }, ..GLASS };
    let mut right = body("right", cuboid(CUBE / 2.0), light, at + 0.013 * Vec3::y());
    // A corner first: where faces meet, rounding decides which of their points touch.
    right.pose.rotation = Quat::from_euler_angles(0.6, 0.7, 0.3);
    let left = BodySpec { velocity: 5.0 * Vec3::x(), ..left };
    let ids = [left, right].map(|spec| put(&mut world, spec));
    let hits = steps(&mut world, 60);
    (world, ids, hits)
}

/// F36: bodies a million times as heavy as what they hit throw it off, keep their momentum and
/// make no energy.
#[test]
fn f36_extreme_masses_keep_momentum_and_make_no_energy() {
    for density in [0.02, 1.0, 2500.0, 9e5] {
        let (world, [left, _], hits) = meeting(Vec3::zeros(), density);
        assert!(!hits.is_empty(), "{density} kg/m³: they met");
        let mass = world.body(left).expect("there").mass;
        let after = world.totals();
        let error = (after.momentum - 5.0 * mass * Vec3::x()).norm();
        assert!(error < 1e-9 * mass, "{density} kg/m³: {error}");
        let before = 0.5 * mass * 25.0;
        assert!(after.kinetic_energy <= before * (1.0 + 1e-9), "{density} kg/m³");
        for body in world.bodies() {
            assert!(body.velocity.norm() < 11.0, "{density} kg/m³: {}", body.velocity);
        }
    }
}

/// How far a block of 0.2 m that weighs so many times the slice beneath it sinks in 2 s, and what
/// the world says of it.
fn sink_of_block_on_slice(ratio: f64) -> (f64, Vec<String>) {
    let mut world = World::new(settings()).expect("settings");
    put(&mut world, floor());
    let density = 1e4 / ratio;
    let slice = ContactMaterial { solid: Material { density, ..GLASS.solid }, ..GLASS };
    let thin = cuboid(Vec3::new(0.2, 0.2, 0.05));
    put(&mut world, body("thin", thin, slice, Vec3::new(0.0, 0.0, 0.025)));
    let block = body("block", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, 0.15));
    let top = put(&mut world, block);
    steps(&mut world, 480);
    let now = world.body(top).expect("there").pose.translation.vector.z;
    (0.15 - now, world.sunk())
}

/// F36: the engine carries 200 times a slice's mass (R6 asks for 10⁴); what is beyond, and sinks
/// in, is told with its ratio.
#[test]
fn f36_a_light_slice_survives_under_a_heavy_block() {
    let (sink, told) = sink_of_block_on_slice(200.0);
    assert!(sink.abs() < 0.01 * 0.2 && told.is_empty(), "sank by {sink}: {told:?}");
    let (sink, told) = sink_of_block_on_slice(2000.0);
    assert!(sink > 0.01 && told.len() == 1 && told[0].contains("2000 times its mass"), "{told:?}");
}

/// F37: 7.8 t at rest press with 319 N·s in a step of 1/240 s, and hit nothing; let fall from a
/// centimetre they do.
#[test]
fn f37_weight_at_rest_never_hits() {
    let hits = |rate: f64, height: f64| {
        let step = 1.0 / rate;
        let mut world = World::new(WorldSettings { step, impulse_threshold: 0.01, ..settings() })
            .expect("settings");
        put(&mut world, floor());
        let block = cuboid(Vec3::new(1.0, 1.0, 1.0));
        put(&mut world, body("block", block, STEEL, Vec3::new(0.0, 0.0, 0.5 + height)));
        steps(&mut world, (2.0 * rate) as u32)
    };
    for rate in [60.0, 240.0] {
        assert_eq!(hits(rate, 0.0), Vec::new(), "{rate} Hz");
        let fallen = hits(rate, 0.01);
        assert!(fallen.len() == 1 && fallen[0].impact.closing_speed > 0.3, "{fallen:?}");
    }
}

/// F38: a block that falls on a slice of a 320th of its mass presses it against the floor for many
/// steps: one hit, with at least four fifths of its momentum. What a single step passes on halves
/// with the step.
#[test]
fn f38_a_blow_of_many_steps_is_one_hit() {
    let blow = |rate: f64| {
        let mut world = World::new(WorldSettings { step: 1.0 / rate, ..settings() }).expect("it");
        put(&mut world, floor());
        let thin = cuboid(Vec3::new(0.2, 0.2, 0.05));
        let thin = put(&mut world, body("thin", thin, GLASS, Vec3::new(0.0, 0.0, 0.025)));
        // Four times the volume.
        let density = 80.0 * GLASS.solid.density;
        let heavy = ContactMaterial { solid: Material { density, ..GLASS.solid }, ..GLASS };
        let block = body("block", cuboid(CUBE), heavy, Vec3::new(0.0, 0.0, 0.25));
        let block = BodySpec { velocity: Vec3::new(0.0, 0.0, -2.0), ..block };
        let block = put(&mut world, block);
        let speed = |world: &World| world.body(block).expect("there").velocity.z;
        let momentum = (4.0_f64 + 2.0 * 9.81 * 0.1).sqrt();
        let mass = world.body(block).expect("there").mass;
        let (mut below, mut most, mut before) = (Vec::new(), 0.0_f64, speed(&world));
        for _ in 0..(0.15 * rate) as u32 {
            let hits = world.step().expect("a step");
            let on_floor = hits.iter().filter(|hit| hit.body == thin && hit.fixed_other);
            below.extend(on_floor.map(|hit| hit.impact.impulse / (mass * momentum)));
            most = most.max((speed(&world) - before) / momentum);
            before = speed(&world);
        }
        (below, most)
    };
    let all = [240.0, 960.0].map(blow);
    for (below, _) in &all {
        assert!(below.len() == 1 && (0.8..1.0).contains(&below[0]), "{below:?}");
    }
    let [coarse, fine] = [all[0].1, all[1].1];
    assert!(coarse > 1.5 * fine, "{coarse} and {fine} of the momentum in a step");
}

/// F39: a brick that lands on four corners is one hit with all of its impulse; no corner alone
/// would have reached the threshold.
#[test]
fn f39_four_corners_are_one_hit_with_the_whole_impulse() {
    let flat = ContactMaterial { restitution: 0.0, ..GLASS };
    let size = Vec3::new(0.2, 0.1, 0.06);
    let whole = GLASS.solid.density * size.product() * 2.0;
    let mut world = World::new(WorldSettings { impulse_threshold: 0.6 * whole, ..weightless() })
        .expect("settings");
    put(&mut world, floor());
    let brick = body("brick", cuboid(size), flat, Vec3::new(0.3, 0.1, 0.2));
    let id = put(&mut world, BodySpec { velocity: Vec3::new(0.0, 0.0, -2.0), ..brick });
    let hits = steps(&mut world, 60);
    assert_eq!(hits.len(), 1, "{hits:#?}");
    let brick = world.body(id).expect("there");
    let want = brick.mass * (2.0 + brick.velocity.z);
    let got = hits[0].impact.impulse;
    assert!((got / want - 1.0).abs() < 0.01, "{got} N·s, not {want}");
    let off = hits[0].impact.point - Vec3::new(0.0, 0.0, -0.03);
    assert!(off.norm() < 0.005, "in the middle of the face, not {off} off");
}

/// F40: on a plate a ball's contact is as wide near its rim as in its middle, and narrow on a
/// corner of it: the surface there counts, not the way to the centre.
#[test]
fn f40_the_radius_is_that_of_the_surface() {
    let contact = |at: f64, turn: Quat| {
        let mut world = World::new(weightless()).expect("settings");
        let plate = body("plate", cuboid(Vec3::new(0.6, 0.6, 0.1)), GLASS, Vec3::zeros());
        let mut plate = BodySpec { fixed: true, breakable: false, ..plate };
        plate.pose.rotation = turn;
        put(&mut world, plate);
        let ball = body("ball", sphere(0.05, 8), STEEL, Vec3::new(at, 0.0, 0.6));
        put(&mut world, BodySpec { velocity: -8.0 * Vec3::z(), ..ball });
        until_hit(&mut world, 60)[0].impact.radius
    };
    let flat = Quat::identity();
    let (middle, rim) = (contact(0.0, flat), contact(0.2, flat));
    // On its longest diagonal.
    let up = Vec3::new(0.3, 0.3, 0.05);
    let edge = Quat::rotation_between(&up, &Vec3::z()).expect("a turn");
    let corner = contact(0.0, edge);
    println!("{middle} m in the middle, {rim} m near the rim, {corner} m on a corner");
    assert!((rim / middle - 1.0).abs() < 0.05, "{rim} and {middle} m");
    assert!(corner < 0.9 * middle, "{corner} and {middle} m");
}

/// F41: whatever a solver gives its fragments, momentum stays and energy does not grow: fragments
/// that would fly faster than the striker paid for are slowed; a crack dearer than what there is
/// stays closed, with a reason.
#[test]
fn f41_fragments_have_no_free_energy() {
    let mut paid = 0;
    for case in 0..8 {
        let (mut world, cube, _, hits) = strike(case);
        let mut pieces = cells(CUBE, 2, 0.2);
        let (mass, before) = (world.body(cube).expect("there").mass, world.totals());
        let impact = hits[0].impact;
        shove(&mut pieces, case, &impact.normal, 0.8 * impact.impulse, mass, 6.0);
        let flung = pieces.iter().map(|piece| piece.velocity.norm_squared());
        let asked = 0.5 * mass / 8.0 * flung.sum::<f64>();
        assert!(asked > impact.energy, "case {case}: it is free energy");
        let cost = 0.02 * impact.energy;
        let dear = world.replace(cube, &hits, pieces.clone(), 1e3 * before.kinetic_energy);
        assert!(matches!(dear, Err(ReplaceError::Unaffordable { .. })), "case {case}: {dear:?}");
        assert_eq!(world.totals(), before, "case {case}: nothing may change");
        let report = match world.replace(cube, &hits, pieces, cost) {
            Ok(report) => report,
            Err(ReplaceError::Unaffordable { payable, fracture_energy, .. }) => {
                assert!(payable < fracture_energy && world.totals() == before, "case {case}");
                continue;
            }
            Err(error) => panic!("case {case}: {error}"),
        };
        paid += 1;
        let after = world.totals();
        let (mass, arm) = (before.mass * 15.0, before.mass * 45.0);
        assert!((after.momentum - before.momentum).norm() < 1e-12 * mass, "case {case}");
        let turned = (after.angular_momentum - before.angular_momentum).norm();
        assert!(turned < 1e-12 * arm, "case {case}");
        assert!(report.energy_gain_rel < 1e-9 && report.spread_scale < 1.0, "{report:?}");
        assert!(report.energy_after + cost <= report.energy_before * (1.0 + 1e-9), "{report:?}");
    }
    assert!(paid > 1, "{paid} of 8 could be paid");
}

/// F43: fragments of the last generation do not break again, nor do small ones, and none is hit
/// before it is as old as the grace says.
#[test]
fn f43_generations_sizes_and_ages_end_the_cascade() {
    let broken = |max_generation, parts| {
        let limits = WorldSettings { max_generation, ..weightless() };
        let mut world = World::new(limits).expect("settings");
        let id = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
        let report = world.replace(id, &[], cells(CUBE, parts, 0.0), 0.0).expect("it breaks");
        (report.tiers[0], world.body(report.fragments[0]).expect("there").breakable)
    };
    assert_eq!(broken(2, 2), (Tier::Large, true));
    assert_eq!(broken(1, 2), (Tier::Large, false), "of the last generation");
    assert_eq!(broken(2, 4), (Tier::Small, false), "too small");
    let hits = |grace: f64| {
        let limits = WorldSettings { birth_grace: grace, ..weightless() };
        let mut world = World::new(limits).expect("settings");
        put(&mut world, floor());
        let cube = body("cube", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, 0.105));
        let cube = put(&mut world, BodySpec { velocity: -2.0 * Vec3::z(), ..cube });
        world.replace(cube, &[], cells(CUBE, 2, 0.0), 0.0).expect("it breaks");
        steps(&mut world, 12).len()
    };
    assert!(hits(0.0) > 0, "they land at once");
    assert_eq!(hits(1.0), 0);
}

/// F34: fragments come into the world without a start, though their jagged sides lie in each other
/// as far as the engine can tell; bodies that a scene has put into each other are told, and parted
/// slowly and all the way.
#[test]
fn f34_birth_is_quiet_and_overlaps_part_slowly() {
    for parts in [2, 4] {
        let mut world = World::new(weightless()).expect("settings");
        let id = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
        world.replace(id, &[], cells(CUBE, parts, 0.45), 0.0).expect("it breaks");
        let mut fastest = 0.0_f64;
        for _ in 0..60 {
            world.step().expect("a step");
            fastest = world.bodies().map(|b| b.velocity.norm()).fold(fastest, f64::max);
        }
        let energy = world.totals().kinetic_energy / world.totals().mass;
        assert!(fastest < 0.05 && energy < 5e-4, "{parts}: {fastest} m/s, {energy} J/kg");
    }
    let mut world = World::new(weightless()).expect("settings");
    let ids = [0.0, 0.08].map(|x| {
        let cube = body("cube", cuboid(CUBE / 2.0), GLASS, Vec3::x() * x);
        put(&mut world, cube)
    });
    assert_eq!(world.overlaps().len(), 1, "told");
    let (mut apart, mut fastest) = (0.08, 0.0_f64);
    for _ in 0..60 {
        world.step().expect("a step");
        let [one, two] = ids.map(|id| world.body(id).expect("there").pose.translation.vector);
        let now = (two - one).norm();
        fastest = fastest.max((now - apart) / world.settings().step);
        apart = now;
    }
    assert!(fastest < 0.25 && world.overlaps().is_empty(), "{fastest} m/s");
}

/// F32: a body whose mass is a sliver's, with a volume but no inertia, is refused by name.
#[test]
fn f32_a_body_without_inertia_is_refused() {
    let mut world = World::new(weightless()).expect("settings");
    let mut spec = body("sliver", cuboid(CUBE), GLASS, Vec3::zeros());
    let (hole, _) = cuboid(CUBE / 4.0);
    // More is missing far out than there is within.
    let mesh = &mut std::sync::Arc::make_mut(&mut spec.solid).mesh;
    for x in [-5.0, 5.0] {
        mesh.append(&hole.mesh.flipped().translated(Vec3::x() * x));
    }
    let error = world.insert(spec).expect_err("refused");
    assert!(matches!(error, WorldError::OutOfRange { .. }), "{error}");
    assert!(error.to_string().contains("inertia"), "{error}");
}

/// F74: a hit ten kilometres out is the hit at the origin: all that a solve is told is in the
/// body's own frame, and poses are f64.
#[test]
fn f74_a_hit_far_out_is_the_hit_at_the_origin() {
    let near = meeting(Vec3::zeros(), 2500.0).2;
    let far = meeting(Vec3::new(1e4, -1e4, 1e4), 2500.0).2;
    assert_eq!(near.len(), far.len());
    assert!(!near.is_empty());
    for (a, b) in near.iter().zip(&far) {
        let (a, b) = (a.impact, b.impact);
        assert!((a.point - b.point).norm() < 1e-6, "{} and {}", a.point, b.point);
        let pairs = [
            (a.impulse, b.impulse),
            (a.duration, b.duration),
            (a.radius, b.radius),
            (a.energy, b.energy),
            (a.closing_speed, b.closing_speed),
        ];
        for (a, b) in pairs {
            assert!((a / b - 1.0).abs() < 1e-6, "{a} and {b}");
        }
    }
}
