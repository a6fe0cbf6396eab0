//! Glued walls: a blow breaks what is near it, and fragments go on to stick.

use crate::common;

use common::*;
use cullet_geometry::Vec3;
use cullet_world::{
    BodyId, BodySpec, GlueBodies, GlueLimit, GlueSpec, JointBreak, JointId, JointKind, JointLimits,
    JointSpec, World, WorldSettings,
};

const BRICK: Vec3 = Vec3::new(0.2, 0.1, 0.08);

fn brick(at: Vec3) -> BodySpec {
    BodySpec { breakable: false, ..body("brick", cuboid(BRICK), GLASS, at) }
}

fn glue(world: &mut World, bodies: &[BodyId], limit: GlueLimit) -> Vec<JointId> {
    let spec = GlueSpec { bodies: GlueBodies::Group(bodies.to_vec()), limit, gap: 1e-4 };
    let report = world.glue(&spec).unwrap();
    assert!(report.alone.is_empty(), "{:?}", report.alone);
    report.joints
}

/// Tensile and shear strength of the glue \[Pa\].
const STRENGTH: f64 = 5e5;

/// A wall of 10 × 6 bricks in a running bond, in free flight, and a ball that flies at its middle.
fn wall(strength: f64) -> (World, Vec<BodyId>, Vec<JointId>) {
    let mut world = World::new(weightless()).unwrap();
    let mut bricks = Vec::new();
    for row in 0..6 {
        for column in 0..10 {
            let shift = if row % 2 == 0 { 0.0 } else { BRICK.x / 2.0 };
            let at = Vec3::new(
                BRICK.x * (f64::from(column) - 4.5) + shift,
                0.0,
                BRICK.z * (f64::from(row) - 2.5),
            );
            bricks.push(put(&mut world, brick(at)));
        }
    }
    let joints =
        glue(&mut world, &bricks, GlueLimit::Stress { tensile: strength, shear: strength });
    let ball = body("ball", sphere(0.06, 6), STEEL, Vec3::new(0.03, -0.2, 0.02));
    let velocity = Vec3::new(0.0, 12.0, 0.0);
    put(&mut world, BodySpec { velocity, breakable: false, ..ball });
    (world, bricks, joints)
}

fn run(world: &mut World, steps: u32) -> Vec<JointBreak> {
    let mut broken = Vec::new();
    for _ in 0..steps {
        world.step().unwrap();
        broken.extend(world.broken_joints().to_vec());
    }
    broken
}

#[test]
fn a_ball_breaks_the_glue_near_it_and_not_that_of_the_whole_wall() {
    let (mut world, bricks, joints) = wall(STRENGTH);
    let before = world.totals();
    let broken = run(&mut world, 60);
    let after = world.totals();
    println!("{} of {} joints broke; {:?}", broken.len(), joints.len(), world.joint_counts());
    assert!(!broken.is_empty() && 2 * broken.len() < joints.len());
    // What is far away is still glued.
    let far = |id: BodyId| world.body(id).unwrap().pose.translation.x.abs() > 0.7;
    let stuck = |id: BodyId| world.joints().any(|joint| joint.a == id || joint.b == Some(id));
    assert!(bricks.iter().filter(|&&id| far(id)).all(|&id| stuck(id)));
    let drift = (after.momentum - before.momentum).norm() / before.momentum.norm();
    assert!(drift < 1e-9, "momentum drifts by {drift}");
    assert!(after.kinetic_energy < before.kinetic_energy, "{}", after.kinetic_energy);
    // Without taking steps again, one blow breaks nearly all.
    let (mut hasty, _, _) = wall(STRENGTH);
    hasty.set_joint_retakes(0);
    let all = run(&mut hasty, 60);
    println!("{} without", all.len());
    assert!(2 * all.len() > joints.len(), "{} of {}", all.len(), joints.len());
}

#[test]
fn a_wall_breaks_the_same_way_each_time() {
    let once = || {
        let (mut world, _, _) = wall(STRENGTH);
        let broken = run(&mut world, 40);
        assert!(!broken.is_empty());
        (bits(&world), broken)
    };
    assert!(once() == once());
}

/// A brick glued to a block that never moves breaks into eight: those at the block stay, with a
/// quarter of the glue each, and the others fall.
#[test]
fn fragments_at_the_glue_stay_and_others_fall() {
    let mut world = World::new(WorldSettings::default()).unwrap();
    let block = put(&mut world, BodySpec { fixed: true, ..brick(Vec3::zeros()) });
    let held = body("held", cuboid(BRICK), GLASS, Vec3::new(BRICK.x, 0.0, 0.0));
    let held = put(&mut world, held);
    let limit = GlueLimit::EachPair { force: Some(8e3), torque: Some(8e3) };
    let old = glue(&mut world, &[block, held], limit);
    steps(&mut world, 20);
    let report = world.replace(held, &[], cells(BRICK, 2, 0.0), 0.0).unwrap();
    assert_eq!((report.joints_kept, report.joints_lost), (4, 0));
    assert!(world.joint(old[0]).is_none());
    let joints: Vec<_> = world.joints().collect();
    assert_eq!(joints.len(), 4);
    for joint in &joints {
        assert!((joint.area - BRICK.y * BRICK.z / 4.0).abs() < 1e-12, "{}", joint.area);
        let cullet_world::JointLimit::Pull(limits) = joint.limit else { panic!("{joint:?}") };
        assert!((limits.force.unwrap() - 2e3).abs() < 1e-6, "{limits:?}");
    }
    steps(&mut world, 60);
    for id in report.fragments {
        let fragment = world.body(id).unwrap();
        let near = fragment.pose.translation.x < BRICK.x;
        let fell = fragment.pose.translation.z < -0.1;
        assert_eq!(near, !fell, "{} {}", fragment.name, fragment.pose.translation);
    }
}

/// What an anchor holds goes over to the fragment that has it.
#[test]
fn the_fragment_with_the_anchor_hangs_on() {
    let mut world = World::new(WorldSettings::default()).unwrap();
    let held = put(&mut world, body("held", cuboid(BRICK), GLASS, Vec3::zeros()));
    let anchor = Vec3::new(0.08, 0.02, 0.03);
    let spec = JointSpec {
        a: held,
        b: None,
        kind: JointKind::Ball,
        anchor,
        anchor_b: None,
        limits: JointLimits::default(),
        area: None,
        collide: false,
    };
    world.join(&spec).unwrap();
    let report = world.replace(held, &[], cells(BRICK, 2, 0.0), 0.0).unwrap();
    assert_eq!((report.joints_kept, report.joints_lost), (1, 0));
    steps(&mut world, 120);
    let up = |id: &&BodyId| world.body(**id).unwrap().pose.translation.z > -0.3;
    let hanging: Vec<&BodyId> = report.fragments.iter().filter(up).collect();
    assert_eq!(hanging.len(), 1);
    let joint = world.joints().next().unwrap();
    assert_eq!(joint.a, *hanging[0]);
    assert!((joint.point - anchor).norm() < 2e-3, "{}", joint.point);
}

/// Eighteen bricks glued to a block, dropped on the floor: it stays whole and comes to rest, and
/// energy never grows but by what the step makes of a landing.
#[test]
fn a_glued_block_lands_as_one() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let mut bricks = Vec::new();
    for k in 0..18 {
        let at = Vec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9));
        let at = at.component_mul(&BRICK) + Vec3::new(0.0, 0.0, 0.3);
        bricks.push(put(&mut world, brick(at)));
    }
    let limit = GlueLimit::EachPair { force: None, torque: None };
    glue(&mut world, &bricks, limit);
    let energy = |world: &World| world.totals().kinetic_energy + world.totals().potential_energy;
    let place = |world: &World, id: BodyId| world.body(id).unwrap().pose.translation.vector;
    let span = |world: &World| (place(world, bricks[17]) - place(world, bricks[0])).norm();
    let (start, whole) = (energy(&world), span(&world));
    let mut last = start;
    let (mut widest, mut lowest) = (0.0f64, f64::INFINITY);
    for _ in 0..960 {
        world.step().unwrap();
        let now = energy(&world);
        // A body stopped where it touches keeps the speed of the whole step: m g v dt.
        let most = world.totals().mass * 9.81 * 2.5 / 240.0;
        assert!(now < last + most, "energy grew from {last} to {now} J");
        widest = widest.max((span(&world) - whole).abs());
        let low = bricks.iter().map(|&id| place(&world, id).z - BRICK.z / 2.0);
        lowest = low.fold(lowest, f64::min);
        last = now;
    }
    println!("lowest {lowest} m");
    assert!(widest < 1e-4, "{widest}");
    // It is set back as one to where it touches.
    assert!(lowest > -1e-3, "{lowest}");
    assert!(world.at_rest() && last < start);
}

/// What stands on the floor is pressed by what is above; and it sleeps.
#[test]
fn a_glued_pillar_bears_what_is_above_and_sleeps() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let bricks: Vec<BodyId> = (0..4)
        .map(|k| put(&mut world, brick(Vec3::new(0.0, 0.0, BRICK.z * (f64::from(k) + 0.5)))))
        .collect();
    let joints = glue(&mut world, &bricks, GlueLimit::Stress { tensile: 1e3, shear: 1e3 });
    let broken = run(&mut world, 720);
    assert!(broken.is_empty(), "{broken:?}");
    assert!(world.at_rest());
    let weight = world.body(bricks[0]).unwrap().mass * 9.81;
    for (k, &id) in joints.iter().enumerate() {
        let (load, above) = (world.joint(id).unwrap().load, (3 - k) as f64 * weight);
        assert!((load.force - Vec3::z() * above).norm() < 0.03 * above, "{k}: {}", load.force);
        assert!(load.share < 0.5, "{k}: {}", load.share);
    }
}

/// A pillar on the floor and a ball that flies at it: whether the pillar sleeps when it is met
/// makes no difference to what breaks.
#[test]
fn what_sleeps_breaks_as_what_is_awake() {
    let struck = |waits: u32| {
        let mut world = World::new(settings()).unwrap();
        put(&mut world, floor());
        let bricks: Vec<BodyId> = (0..6)
            .map(|k| put(&mut world, brick(Vec3::new(0.0, 0.0, BRICK.z * (f64::from(k) + 0.5)))))
            .collect();
        glue(&mut world, &bricks, GlueLimit::Stress { tensile: 2e5, shear: 2e5 });
        assert!(run(&mut world, waits).is_empty());
        let asleep = world.at_rest();
        let ball = body("ball", sphere(0.04, 6), STEEL, Vec3::new(0.0, -0.12, 0.42));
        let velocity = Vec3::new(0.0, 4.0, 0.0);
        put(&mut world, BodySpec { velocity, breakable: false, ..ball });
        let broken = run(&mut world, 24);
        (asleep, broken.len(), world.joint_counts().retakes)
    };
    let (awake, slept) = (struck(5), struck(720));
    println!("awake {awake:?}, asleep {slept:?}");
    assert!(!awake.0 && slept.0);
    assert!(slept.2 > 0, "a step was taken again");
    assert!(awake.1 > 0 && awake.1 < 5 && slept.1 == awake.1, "{awake:?} {slept:?}");
}

/// A brick of a wall is hit and breaks: the books of its replacement close, its fragments hold on
/// to the neighbours, and nothing flies apart.
#[test]
fn a_brick_that_breaks_in_a_glued_wall_keeps_the_books() {
    let mut world = World::new(weightless()).unwrap();
    let mut bricks = Vec::new();
    for k in 0..9 {
        let at = Vec3::new(f64::from(k % 3) - 1.0, 0.0, f64::from(k / 3) - 1.0);
        let spec = brick(at.component_mul(&BRICK));
        bricks.push(put(&mut world, BodySpec { breakable: k == 4, ..spec }));
    }
    glue(&mut world, &bricks, GlueLimit::Stress { tensile: 2e6, shear: 2e6 });
    let ball = body("ball", sphere(0.03, 6), STEEL, Vec3::new(0.01, -0.15, 0.01));
    let velocity = Vec3::new(0.0, 8.0, 0.0);
    put(&mut world, BodySpec { velocity, breakable: false, ..ball });
    let start = world.totals();
    let hits = until_hit(&mut world, 60);
    assert!(hits.len() == 1 && hits[0].body == bricks[4]);
    let mass = world.body(bricks[4]).unwrap().mass;
    let mut pieces = cells(BRICK, 2, 0.2);
    shove(&mut pieces, 5, &hits[0].impact.normal, hits[0].impact.impulse, mass, 0.05);
    let report = world.replace(bricks[4], &hits, pieces, 0.05).unwrap();
    assert!(report.momentum_rel_error < 1e-9 && report.energy_gain_rel < 1e-9, "{report:?}");
    assert!(report.joints_kept >= 4, "{report:?}");
    steps(&mut world, 120);
    let end = world.totals();
    let drift = (end.momentum - start.momentum).norm() / start.momentum.norm();
    assert!(drift < 1e-9, "{drift}");
    assert!(end.kinetic_energy < start.kinetic_energy, "{} J", end.kinetic_energy);
}
