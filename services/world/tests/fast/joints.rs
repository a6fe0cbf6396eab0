//! Joints and glue: what they carry at rest, and what breaks them.

use crate::common;

use common::*;
use cullet_geometry::Vec3;
use cullet_world::{
    BodyId, BodySpec, GlueBodies, GlueLimit, GlueSpec, JointError, JointId, JointKind, JointLimits,
    JointSpec, World,
};

const BRICK: Vec3 = Vec3::new(0.2, 0.1, 0.1);
const G: f64 = 9.81;

fn brick(name: &str, at: Vec3) -> BodySpec {
    BodySpec { breakable: false, ..body(name, cuboid(BRICK), STEEL, at) }
}

fn mass() -> f64 {
    7800.0 * BRICK.x * BRICK.y * BRICK.z
}

fn glue(world: &mut World, bodies: &[BodyId], limit: GlueLimit) -> Vec<JointId> {
    let spec = GlueSpec { bodies: GlueBodies::Group(bodies.to_vec()), limit, gap: 1e-4 };
    let report = world.glue(&spec).unwrap();
    assert!(report.alone.is_empty(), "{:?}", report.alone);
    report.joints
}

const UNBREAKABLE: GlueLimit = GlueLimit::EachPair { force: None, torque: None };

fn rigid(a: BodyId, b: Option<BodyId>, anchor: Vec3) -> JointSpec {
    JointSpec {
        a,
        b,
        kind: JointKind::Rigid,
        anchor,
        anchor_b: None,
        limits: JointLimits::default(),
        area: None,
        collide: false,
    }
}

/// Five bricks glued end to end to a block that never moves.
fn cantilever(limit: GlueLimit) -> (World, Vec<BodyId>, Vec<JointId>) {
    let mut world = World::new(settings()).unwrap();
    let wall = BodySpec { fixed: true, ..brick("wall", Vec3::new(-0.1, 0.0, 2.0)) };
    let mut bodies = vec![put(&mut world, wall)];
    for k in 0..5 {
        let at = Vec3::new(0.1 + 0.2 * f64::from(k), 0.0, 2.0);
        bodies.push(put(&mut world, brick("brick", at)));
    }
    let joints = glue(&mut world, &bodies, limit);
    assert_eq!(joints.len(), 5);
    (world, bodies, joints)
}

#[test]
fn a_cantilever_bears_half_its_weight_times_its_length() {
    let (mut world, _, joints) = cantilever(UNBREAKABLE);
    steps(&mut world, 240);
    for (k, &id) in joints.iter().enumerate() {
        let beyond = (5 - k) as f64;
        let load = world.joint(id).unwrap().load;
        let weight = beyond * mass() * G;
        let moment = weight * beyond * BRICK.x / 2.0;
        println!(
            "{k}: {} N of {weight}, {} N m of {moment}",
            load.force.norm(),
            load.torque.norm()
        );
        assert!((load.force - Vec3::z() * weight).norm() < 0.01 * weight, "{k}: {}", load.force);
        assert!((load.torque.norm() / moment - 1.0).abs() < 0.01, "{k}: {}", load.torque);
    }
    assert_eq!(world.joint_counts().not_converged, 0);
}

/// σ = M/W with W = b h²/6 at the root.
#[test]
fn a_cantilever_breaks_at_its_root_at_the_stress_of_a_beam() {
    let moment = 5.0 * mass() * G * 0.5;
    let stress = moment / (BRICK.y * BRICK.z * BRICK.z / 6.0);
    let run = |tensile: f64| {
        let (mut world, bodies, joints) = cantilever(GlueLimit::Stress { tensile, shear: 1e12 });
        let mut broken = Vec::new();
        for _ in 0..240 {
            world.step().unwrap();
            broken.extend(world.broken_joints().to_vec());
        }
        (world, bodies, joints, broken)
    };
    let (mut world, _, joints) = cantilever(UNBREAKABLE);
    let peaks: Vec<f64> = (0..60)
        .map(|_| {
            world.step().unwrap();
            world.joint(joints[0]).unwrap().load.torque.norm() / moment
        })
        .collect();
    let (world, _, joints, broken) = run(1.02 * stress);
    assert!(broken.is_empty(), "{broken:?}");
    assert!(peaks.iter().all(|peak| (peak - 1.0).abs() < 0.01), "{peaks:?}");
    let share = world.joint(joints[0]).unwrap().load.share;
    assert!((share * 1.02 - 1.0).abs() < 0.01, "{share}");
    let (world, bodies, joints, broken) = run(0.98 * stress);
    assert_eq!(broken.len(), 1, "{broken:?}");
    assert_eq!(broken[0].joint, joints[0]);
    assert!(broken[0].share > 1.0 && world.joint(joints[0]).is_none());
    // The rest falls as one.
    let heights: Vec<f64> =
        bodies[1..].iter().map(|&id| world.body(id).unwrap().pose.translation.z).collect();
    assert!(heights.iter().all(|z| *z < 1.9), "{heights:?}");
}

#[test]
fn each_joint_of_a_hanging_chain_carries_what_is_below() {
    let mut world = World::new(settings()).unwrap();
    let mut ids = Vec::new();
    for k in 0..4 {
        let at = Vec3::new(0.0, 0.0, 3.0 - 0.15 * f64::from(k));
        ids.push(put(&mut world, brick("link", at)));
    }
    let mut joints = Vec::new();
    for (k, &id) in ids.iter().enumerate() {
        let anchor = Vec3::new(0.0, 0.0, 3.075 - 0.15 * k as f64);
        let spec = rigid(id, k.checked_sub(1).map(|above| ids[above]), anchor);
        let kind = if k == 2 { JointKind::Ball } else { JointKind::Rigid };
        joints.push(world.join(&JointSpec { kind, ..spec }).unwrap());
    }
    steps(&mut world, 240);
    for (k, &joint) in joints.iter().enumerate() {
        let load = world.joint(joint).unwrap().load;
        let below = (4 - k) as f64 * mass() * G;
        // `b` is above, or the world.
        assert!((load.force + Vec3::z() * below).norm() < 0.01 * below, "{k}: {}", load.force);
    }
}

#[test]
fn two_hangers_side_by_side_share_equally_and_a_rope_only_pulls() {
    let mut world = World::new(settings()).unwrap();
    let beam = put(&mut world, brick("beam", Vec3::new(0.0, 0.0, 2.0)));
    let rope = |x: f64, up: f64| JointSpec {
        kind: JointKind::Rope { length: 0.5 },
        anchor_b: Some(Vec3::new(x, 0.0, 2.0 + up)),
        ..rigid(beam, None, Vec3::new(x, 0.0, 2.0))
    };
    let joints: Vec<JointId> = [rope(-0.1, 0.5), rope(0.1, 0.5), rope(0.0, -0.3)]
        .iter()
        .map(|spec| world.join(spec).unwrap())
        .collect();
    steps(&mut world, 480);
    let load = |k: usize| world.joint(joints[k]).unwrap().load.force;
    let half = mass() * G / 2.0;
    assert!((load(0).norm() / half - 1.0).abs() < 0.01, "{}", load(0));
    assert!((load(1).norm() / half - 1.0).abs() < 0.01, "{}", load(1));
    assert!(load(2).norm() < 1e-9, "{}", load(2));
    let place = world.body(beam).unwrap().pose.translation.vector;
    assert!((place.z - 2.0).abs() < 2e-3, "{place}");
}

/// A slack rope bears nothing, and that is no failure of a solve.
#[test]
fn a_slack_rope_is_no_trouble() {
    let mut world = World::new(settings()).unwrap();
    let ball = put(&mut world, brick("ball", Vec3::new(0.0, 0.0, 2.0)));
    let spec = JointSpec {
        kind: JointKind::Rope { length: 0.5 },
        anchor_b: Some(Vec3::new(0.0, 0.0, 2.2)),
        ..rigid(ball, None, Vec3::new(0.0, 0.0, 2.0))
    };
    let rope = world.join(&spec).unwrap();
    steps(&mut world, 20);
    assert_eq!(world.joint(rope).unwrap().load.force, Vec3::zeros());
    steps(&mut world, 480);
    let pull = world.joint(rope).unwrap().load.force.norm();
    assert!((pull / (mass() * G) - 1.0).abs() < 0.05, "{pull}");
    assert_eq!(world.joint_counts().not_converged, 0);
}

/// Of three ropes in a row the one far from the weight would have to push; it hangs loose.
#[test]
fn a_rope_that_would_push_bears_nothing() {
    let mut world = World::new(settings()).unwrap();
    let beam = put(&mut world, brick("beam", Vec3::new(0.0, 0.0, 2.0)));
    let ropes = [-0.19, -0.09, 0.01].map(|x| {
        let spec = JointSpec {
            kind: JointKind::Rope { length: 0.5 },
            anchor_b: Some(Vec3::new(x, 0.0, 2.5)),
            ..rigid(beam, None, Vec3::new(x, 0.0, 2.0))
        };
        world.join(&spec).unwrap()
    });
    let weight = mass() * G;
    let mut sum = 0.0;
    for _ in 0..240 {
        world.step().unwrap();
        // On the world: down.
        let pulls = ropes.map(|id| -world.joint(id).unwrap().load.force.z);
        assert!(pulls.iter().all(|pull| *pull > -1e-6 * weight), "{pulls:?}");
        sum = pulls.iter().sum();
    }
    assert!((sum / weight - 1.0).abs() < 0.05, "{sum} N of {weight} N");
}

#[test]
fn a_hinge_turns_about_its_axis_alone() {
    let mut world = World::new(settings()).unwrap();
    let arm = put(&mut world, brick("arm", Vec3::new(0.1, 0.0, 2.0)));
    let kind = JointKind::Hinge { axis: Vec3::y() * 3.0 };
    let joint = world.join(&JointSpec { kind, ..rigid(arm, None, Vec3::new(0.0, 0.0, 2.0)) });
    let joint = joint.unwrap();
    let mut lowest = f64::INFINITY;
    for _ in 0..240 {
        world.step().unwrap();
        let at = world.body(arm).unwrap();
        lowest = lowest.min(at.pose.translation.z);
        assert!((at.pose.translation.vector - Vec3::z() * 2.0).norm() < 0.103);
        assert!(at.spin.x.abs() + at.spin.z.abs() < 1e-3 * (1.0 + at.spin.y.abs()));
        let load = world.joint(joint).unwrap().load;
        assert!(load.torque.y.abs() < 1e-6 * mass() * G, "{}", load.torque);
    }
    assert!(lowest < 1.91, "{lowest}");
}

#[test]
fn a_joint_with_a_limit_drops_what_is_too_heavy() {
    let hang = |limit: f64| {
        let mut world = World::new(settings()).unwrap();
        let id = put(&mut world, brick("weight", Vec3::new(0.0, 0.0, 3.0)));
        let limits = JointLimits { force: Some(limit), torque: None };
        let spec = JointSpec { limits, ..rigid(id, None, Vec3::new(0.0, 0.0, 3.05)) };
        let joint = world.join(&spec).unwrap();
        steps(&mut world, 60);
        (world.joint(joint).is_some(), world.body(id).unwrap().pose.translation.z)
    };
    let weight = mass() * G;
    let (there, z) = hang(1.01 * weight);
    assert!(there && (z - 3.0).abs() < 1e-3, "{z}");
    let (there, z) = hang(0.99 * weight);
    assert!(!there && z < 2.75, "{z}");
}

#[test]
fn what_is_no_joint_is_refused() {
    let mut world = World::new(settings()).unwrap();
    let a = put(&mut world, brick("a", Vec3::zeros()));
    let b = put(&mut world, BodySpec { fixed: true, ..brick("b", Vec3::new(1.0, 0.0, 0.0)) });
    let refused = |world: &mut World, spec: JointSpec| world.join(&spec).unwrap_err();
    let spec = rigid(a, None, Vec3::zeros());
    assert_eq!(
        refused(&mut world, JointSpec { a: BodyId(9), ..spec }),
        JointError::Unknown(BodyId(9))
    );
    let itself = refused(&mut world, JointSpec { b: Some(a), ..spec });
    assert_eq!(itself, JointError::Itself { name: "a".into() });
    let dead = refused(&mut world, JointSpec { a: b, ..spec }).to_string();
    assert!(dead.contains("\"b\"") && dead.contains("the world"), "{dead}");
    let limits = JointLimits { force: Some(-1.0), torque: None };
    let text = refused(&mut world, JointSpec { limits, ..spec }).to_string();
    assert!(text.contains("limit of the force [N]") && text.contains("\"a\""), "{text}");
    let short = JointKind::Rope { length: 0.5 };
    let far = Some(Vec3::new(0.0, 0.0, 1.0));
    let text = refused(&mut world, JointSpec { kind: short, anchor_b: far, ..spec }).to_string();
    assert!(text.contains("distance of the ends of the rope"), "{text}");
    let apart = refused(&mut world, JointSpec { anchor_b: far, ..spec }).to_string();
    assert!(apart.contains("distance of the two anchors"), "{apart}");
    let glue = GlueSpec { bodies: GlueBodies::Pairs(vec![(b, a)]), limit: UNBREAKABLE, gap: 1e-3 };
    let report = world.glue(&glue).unwrap();
    assert_eq!((report.alone, report.apart), (vec![a, b], vec![(a, b)]));
    let limit = GlueLimit::Stress { tensile: f64::NAN, shear: 1.0 };
    let text = world.glue(&GlueSpec { limit, ..glue }).unwrap_err().to_string();
    assert!(text.contains("tensile strength"), "{text}");
}

/// A dumb-bell of two bricks that whirls about its middle: the joint pulls with m ω² r.
#[test]
fn a_whirling_pair_is_pulled_by_its_joint() {
    let mut world = World::new(weightless()).unwrap();
    let (spin, arm) = (Vec3::new(0.0, 0.0, 12.0), BRICK.x / 2.0);
    let drift = Vec3::new(0.3, -0.2, 0.5);
    let ids: Vec<BodyId> = [-arm, arm]
        .into_iter()
        .map(|x| {
            let at = Vec3::new(x, 0.0, 0.0);
            let velocity = drift + spin.cross(&at);
            put(&mut world, BodySpec { velocity, spin, ..brick("bell", at) })
        })
        .collect();
    let joint = glue(&mut world, &ids, UNBREAKABLE)[0];
    let want = mass() * spin.norm_squared() * arm;
    for _ in 0..120 {
        world.step().unwrap();
        let view = world.joint(joint).unwrap();
        let b = world.body(ids[1]).unwrap();
        let inward = (view.point - b.pose.translation.vector).normalize();
        let pull = view.load.force.dot(&inward);
        assert!((pull / want - 1.0).abs() < 0.01, "{pull} of {want} N");
    }
}

/// Four bricks glued to a hook tumble: angular momentum and energy stay, and so does the hook.
#[test]
fn what_is_glued_tumbles_as_one() {
    let mut world = World::new(weightless()).unwrap();
    let spin = Vec3::new(3.0, 5.0, -4.0);
    let places = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.1, 0.0], [0.2, 0.1, 0.1]];
    let ids: Vec<BodyId> = places
        .iter()
        .map(|&[x, y, z]| {
            let at = Vec3::new(x, y, z);
            let velocity = spin.cross(&at) + Vec3::x();
            put(&mut world, BodySpec { velocity, spin, ..brick("hook", at) })
        })
        .collect();
    glue(&mut world, &ids, UNBREAKABLE);
    let before = world.totals();
    steps(&mut world, 480);
    let after = world.totals();
    let turned = (after.angular_momentum - before.angular_momentum).norm();
    assert!(turned < 1e-9 * before.angular_momentum.norm(), "{turned}");
    assert!((after.momentum - before.momentum).norm() < 1e-9 * before.momentum.norm());
    let energy = after.kinetic_energy / before.kinetic_energy;
    assert!((energy - 1.0).abs() < 0.01, "{energy}");
    let apart = |a: usize, b: usize| {
        let place = |k: usize| world.body(ids[k]).unwrap().pose.translation.vector;
        (place(a) - place(b)).norm()
    };
    let want = |a: usize, b: usize| {
        let [p, q] = [places[a], places[b]].map(|[x, y, z]| Vec3::new(x, y, z));
        (p - q).norm()
    };
    for (a, b) in [(0, 1), (0, 3), (1, 2), (2, 3)] {
        assert!((apart(a, b) - want(a, b)).abs() < 1e-9, "{a} {b}: {}", apart(a, b));
    }
}
