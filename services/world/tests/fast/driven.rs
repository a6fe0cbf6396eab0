//! Bodies on keyframed paths, fields, and bodies that are taken out.

use crate::common;

use common::*;
use cullet_geometry::{Pose, Vec3};
use cullet_world::{
    BodyId, BodySpec, GlueBodies, GlueLimit, GlueSpec, JointKind, JointLimits, JointSpec, Keyframe,
    KeyframedPath, PathInterpolation, ReplaceError, World, WorldError,
};
use std::sync::Arc;

const SPEED: f64 = 4.0;

/// From x = −1 at 0 s to x = 1, at an even speed.
fn straight() -> Arc<KeyframedPath> {
    let key = |time: f64, x: f64| Keyframe { time, pose: Pose::translation(x, 0.0, 0.0) };
    let keys = vec![key(0.0, -1.0), key(2.0 / SPEED, 1.0)];
    Arc::new(KeyframedPath::new(keys, PathInterpolation::Linear).unwrap())
}

fn ram(path: Arc<KeyframedPath>) -> BodySpec {
    let spec = body("ram", cuboid(CUBE), STEEL, Vec3::new(7.0, 7.0, 7.0));
    BodySpec { driven: Some(path), breakable: false, ..spec }
}

/// A ram that goes at 4 m/s at a glass cube at rest, until it has hit it.
fn rammed() -> (World, BodyId, BodyId, Vec<cullet_world::Hit>) {
    let mut world = World::new(weightless()).unwrap();
    let ram = put(&mut world, ram(straight()));
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
    let hits = until_hit(&mut world, 120);
    (world, ram, cube, hits)
}

#[test]
fn a_driven_body_follows_its_path_and_its_work_is_impulse_times_velocity() {
    let (mut world, ram, cube, hits) = rammed();
    assert_eq!(hits.len(), 1);
    let hit = &hits[0];
    assert!(hit.body == cube && hit.other == ram && hit.fixed_other);
    let at = hit.driven_at.unwrap();
    assert!((at - Vec3::x() * SPEED).norm() < 1e-9, "{at}");
    let mass = world.body(cube).unwrap().mass;
    // As from a wall that comes at it.
    assert!((hit.effective_mass / mass - 1.0).abs() < 0.01, "{}", hit.effective_mass);
    assert!((hit.impact.energy / (0.5 * mass * SPEED * SPEED) - 1.0).abs() < 0.01);
    steps(&mut world, 30);
    let now = world.body(ram).unwrap();
    assert!(now.driven && !now.fixed);
    let off = now.pose.translation.vector - straight().at(world.time()).translation.vector;
    assert!(off.norm() < 1e-12, "{off}");
    let pushed = world.body(cube).unwrap().velocity;
    // e = 0.3
    assert!((pushed.x / (1.3 * SPEED) - 1.0).abs() < 0.05, "{pushed}");
    let (work, due) = (world.driven_work(), mass * pushed.x * SPEED);
    assert!((work / due - 1.0).abs() < 1e-6, "{work} of {due} J");
    assert_eq!(world.driven_work_of(ram), Some(work));
    assert_eq!(world.driven_work_of(cube), None);
    assert_eq!(world.totals().driven_work, work);
    steps(&mut world, 120);
    assert!(!world.at_rest());
    assert_eq!(world.body(ram).unwrap().pose.translation.x, 1.0);
    assert_eq!(world.body(ram).unwrap().velocity, Vec3::zeros());
}

#[test]
fn what_a_driven_striker_breaks_is_paid_in_its_frame() {
    let (world, ..) = rammed();
    let mass = world.bodies().nth(1).unwrap().mass;
    let energy = 0.5 * mass * SPEED * SPEED;
    let broken = |cost: f64| {
        let (mut world, _, cube, hits) = rammed();
        let mut pieces = cells(CUBE, 2, 0.2);
        shove(&mut pieces, 3, &hits[0].impact.normal, hits[0].impact.impulse, mass, 0.0);
        world.replace(cube, &hits, pieces, cost).map(|report| (world, report))
    };
    let (world, report) = broken(0.5 * energy).unwrap();
    assert!((report.energy_before / energy - 1.0).abs() < 0.02, "{}", report.energy_before);
    assert!(report.energy_gain_rel < 1e-9, "{report:?}");
    assert!(report.momentum_rel_error < 1e-9, "{report:?}");
    // The driver gave the pieces their momentum.
    let (work, due) = (world.driven_work(), world.totals().momentum.x * SPEED);
    assert!((work / due - 1.0).abs() < 1e-6, "{work} of {due} J");
    let refused = broken(1.1 * energy);
    assert!(matches!(refused, Err(ReplaceError::Unaffordable { .. })));
}

#[test]
fn a_fast_driven_body_passes_through_nothing() {
    for (speed, x) in [20.0, 60.0].into_iter().flat_map(|v| [0.0, 0.07, 0.14, 0.2].map(|x| (v, x)))
    {
        let key = |time: f64, x: f64| Keyframe { time, pose: Pose::translation(x, 0.0, 0.0) };
        let path = vec![key(0.0, -1.0), key(2.0 / speed, 1.0)];
        let path = KeyframedPath::new(path, PathInterpolation::Linear).unwrap();
        let mut world = World::new(weightless()).unwrap();
        let ram = put(&mut world, ram(Arc::new(path)));
        let ball = put(&mut world, body("ball", sphere(0.03, 4), GLASS, Vec3::new(x, 0.0, 0.0)));
        steps(&mut world, 60);
        let ahead = world.body(ball).unwrap();
        assert!(ahead.velocity.x > 0.99 * speed, "{} from {x}", ahead.velocity);
        assert!(ahead.pose.translation.x > 1.1, "{}", ahead.pose.translation);
        assert_eq!(world.body(ram).unwrap().pose.translation.x, 1.0);
    }
}

/// A crank turns a brick that is glued to it: the work of the joint is the brick's energy.
#[test]
fn a_driven_body_works_through_its_joints() {
    let turn = |time: f64, angle: f64| Keyframe {
        time,
        pose: Pose::new(Vec3::zeros(), Vec3::y() * angle),
    };
    let keys = vec![turn(0.0, 0.0), turn(0.5, 1.0), turn(1.0, 2.4)];
    let path = KeyframedPath::new(keys, PathInterpolation::Smooth).unwrap();
    let mut world = World::new(weightless()).unwrap();
    let crank = put(&mut world, ram(Arc::new(path)));
    let side = body("brick", cuboid(CUBE), GLASS, Vec3::new(0.2, 0.0, 0.0));
    let brick = put(&mut world, BodySpec { breakable: false, ..side });
    let spec = GlueSpec {
        bodies: GlueBodies::Pairs(vec![(brick, crank)]),
        limit: GlueLimit::EachPair { force: None, torque: None },
        gap: 1e-4,
    };
    assert_eq!(world.glue(&spec).unwrap().joints.len(), 1);
    steps(&mut world, 150);
    let energy = world.totals().kinetic_energy;
    assert!(energy > 1.0, "{energy}");
    let work = world.driven_work();
    assert!((work / energy - 1.0).abs() < 0.02, "{work} J of {energy} J");
}

#[test]
fn what_a_path_rules_out_is_refused() {
    let mut world = World::new(weightless()).unwrap();
    let both = BodySpec { breakable: true, ..ram(straight()) };
    let error = world.insert(both).unwrap_err();
    assert_eq!(error, WorldError::Driven { name: "ram".into(), what: "breakable" });
    let fixed = BodySpec { fixed: true, ..ram(straight()) };
    assert!(world.insert(fixed).unwrap_err().to_string().contains("fixed"));
    let ram = put(&mut world, ram(straight()));
    assert_eq!(world.body(ram).unwrap().pose, straight().at(0.0));
    let broken = world.replace(ram, &[], cells(CUBE, 2, 0.0), 0.0).unwrap_err();
    assert_eq!(broken, ReplaceError::Driven(ram));
    let spec = JointSpec {
        a: ram,
        b: None,
        kind: JointKind::Rigid,
        anchor: Vec3::zeros(),
        anchor_b: None,
        limits: JointLimits::default(),
        area: None,
        collide: false,
    };
    assert!(world.join(&spec).is_err());
}

#[test]
fn a_field_accelerates_and_its_work_is_booked() {
    let mut world = World::new(weightless()).unwrap();
    let ball = put(&mut world, body("ball", sphere(0.1, 4), GLASS, Vec3::zeros()));
    let wall = put(
        &mut world,
        BodySpec { fixed: true, ..body("wall", cuboid(CUBE), GLASS, Vec3::x() * 9.0) },
    );
    let field = Vec3::new(0.0, 3.0, -1.0);
    for _ in 0..120 {
        assert!(world.accelerate(ball, field * 0.5) && world.accelerate(ball, field * 0.5));
        assert!(!world.accelerate(wall, field));
        world.step().unwrap();
    }
    let velocity = world.body(ball).unwrap().velocity;
    assert!((velocity - field * 0.5).norm() < 1e-9, "{velocity}");
    let totals = world.totals();
    assert!((totals.field_work / totals.kinetic_energy - 1.0).abs() < 1e-9, "{totals:?}");
    assert!((totals.field_impulse - totals.momentum).norm() < 1e-9 * totals.momentum.norm());
    // It is over with the step that it was given for.
    steps(&mut world, 5);
    assert_eq!(world.body(ball).unwrap().velocity, velocity);
    assert!(!world.accelerate(BodyId(77), field));
}

#[test]
fn what_is_taken_out_stays_in_the_books() {
    let mut world = World::new(settings()).unwrap();
    let a = put(&mut world, body("a", sphere(0.1, 4), GLASS, Vec3::new(0.0, 0.0, 3.0)));
    put(&mut world, body("b", sphere(0.1, 4), GLASS, Vec3::new(1.0, 0.0, 2.0)));
    let spec = JointSpec {
        a,
        b: None,
        kind: JointKind::Ball,
        anchor: Vec3::new(0.0, 0.0, 3.0),
        anchor_b: None,
        limits: JointLimits::default(),
        area: None,
        collide: false,
    };
    let joint = world.join(&spec).unwrap();
    steps(&mut world, 30);
    let before = world.totals();
    assert!(world.remove(a) && !world.remove(a));
    assert!(world.joint(joint).is_none() && world.body(a).is_none());
    let after = world.totals();
    assert!((after.mass + after.removed_mass - before.mass).abs() < 1e-12);
    let energy = |t: &cullet_world::Totals| t.kinetic_energy + t.potential_energy;
    assert!((energy(&after) + after.removed_energy - energy(&before)).abs() < 1e-9);
    assert!((after.momentum + after.removed_momentum - before.momentum).norm() < 1e-12);
    steps(&mut world, 5);
}

/// A body that rests in a field falls asleep in it, and wakes when it ends.
#[test]
fn a_steady_field_lets_bodies_sleep() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, 0.1)));
    let wind = Vec3::new(0.5, 0.0, -2.0);
    for _ in 0..480 {
        assert!(world.accelerate(cube, wind));
        world.step().unwrap();
    }
    assert!(world.body(cube).unwrap().sleeping);
    for _ in 0..5 {
        world.accelerate(cube, Vec3::z() * 12.0);
        world.step().unwrap();
    }
    let lifted = world.body(cube).unwrap();
    assert!(!lifted.sleeping && lifted.velocity.z > 0.0, "{}", lifted.velocity);
}

/// A ball hangs by a rope from a trolley that drives off and stops: the rope stays as long as it
/// is, and the work of the trolley is the energy of the ball.
#[test]
fn a_trolley_drags_a_ball_on_a_rope() {
    let key = |time: f64, x: f64| Keyframe { time, pose: Pose::translation(x, 0.0, 3.0) };
    let keys = vec![key(0.0, 0.0), key(0.5, 0.8), key(1.0, 1.6)];
    let path = KeyframedPath::new(keys, PathInterpolation::Smooth).unwrap();
    let mut world = World::new(settings()).unwrap();
    let trolley = put(&mut world, ram(Arc::new(path)));
    let ball = body("ball", sphere(0.1, 4), STEEL, Vec3::new(0.0, 0.0, 2.0));
    let ball = put(&mut world, BodySpec { breakable: false, ..ball });
    let spec = JointSpec {
        a: trolley,
        b: Some(ball),
        kind: JointKind::Rope { length: 1.0 },
        anchor: Vec3::new(0.0, 0.0, 3.0),
        anchor_b: Some(Vec3::new(0.0, 0.0, 2.0)),
        limits: JointLimits::default(),
        area: None,
        collide: false,
    };
    let rope = world.join(&spec).unwrap();
    let energy = |world: &World| world.totals().kinetic_energy + world.totals().potential_energy;
    let start = energy(&world);
    let (mut longest, mut least) = (0.0f64, f64::INFINITY);
    for _ in 0..240 {
        world.step().unwrap();
        let view = world.joint(rope).unwrap();
        let along = view.point_b - view.point;
        longest = longest.max(along.norm());
        // It pulls the ball towards the trolley.
        least = least.min(-view.load.force.dot(&along));
    }
    assert!(longest < 1.01, "{longest}");
    assert!(least > -1e-9, "{least}");
    let (work, gained) = (world.driven_work(), energy(&world) - start);
    assert!(gained > 5.0 && (work / gained - 1.0).abs() < 0.03, "{work} J for {gained} J");
}

/// What is glued to a driven body that has come to its end sleeps, and so does the world; and the
/// work on what breaks off in a step is booked.
#[test]
fn what_hangs_on_a_body_at_the_end_of_its_path_sleeps() {
    let key = |time: f64, x: f64| Keyframe { time, pose: Pose::translation(x, 0.0, 0.0) };
    let keys = vec![key(0.0, 0.0), key(0.5, 0.4)];
    let path = KeyframedPath::new(keys, PathInterpolation::Smooth).unwrap();
    let held = |limit: Option<f64>| {
        let mut world = World::new(weightless()).unwrap();
        let trolley = put(&mut world, ram(Arc::new(path.clone())));
        let lamp = body("lamp", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, -0.2));
        let lamp = put(&mut world, BodySpec { breakable: false, ..lamp });
        let spec = GlueSpec {
            bodies: GlueBodies::Pairs(vec![(lamp, trolley)]),
            limit: GlueLimit::EachPair { force: limit, torque: None },
            gap: 1e-4,
        };
        assert_eq!(world.glue(&spec).unwrap().joints.len(), 1);
        (world, lamp)
    };
    let (mut world, lamp) = held(None);
    steps(&mut world, 600);
    assert!(world.at_rest(), "the world sleeps");
    assert!((world.body(lamp).unwrap().pose.translation.x - 0.4).abs() < 1e-6);
    assert!(world.driven_work().abs() < 1e-3, "what it gave it took: {}", world.driven_work());
    // Without retakes the joint gives what it gave in the step that it broke in.
    let (mut world, _) = held(Some(2.0));
    world.set_joint_retakes(0);
    steps(&mut world, 60);
    let (energy, work) = (world.totals().kinetic_energy, world.driven_work());
    assert!(energy > 0.0 && (work / energy - 1.0).abs() < 0.05, "{work} J of {energy} J");
}
