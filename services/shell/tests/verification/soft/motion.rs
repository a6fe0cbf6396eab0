//! Motion: free fall, spin, bending under weight, bodies that bounce.

use super::harness::{
    RUBBER, WHOLE, figure, free_ball, grip_x, places, prepare, setup, sheet, solve,
};
use cullet_geometry::{Quat, Vec3};
use cullet_model::{BodyCut, BodyGrip, Material};

/// A thrown sheet falls as a point does, and nothing strains.
#[test]
fn free_fall_is_exact() {
    let mut body = sheet([0.2, 0.1, 2e-3], 0.02, WHOLE, RUBBER);
    body.pose.translation.vector = Vec3::new(100.0, -50.0, 30.0);
    body.velocity = Vec3::new(1.0, 2.0, 3.0);
    body.damping = 0.1;
    let gravity = Vec3::new(0.0, 0.0, -9.81);
    let setup = setup(body, gravity);
    let prepared = prepare(&setup);
    let outcome = solve(&prepared, None, 0, 120, vec![]);
    let t = 0.5;
    let wanted =
        Vec3::new(100.0, -50.0, 30.0) + Vec3::new(1.0, 2.0, 3.0) * t + gravity * (0.5 * t * t);
    let frame = outcome.frames.last().unwrap();
    assert!((frame.origin - wanted).norm() < 1e-10, "{}", frame.origin - wanted);
    let mass = 0.2 * 0.1 * 2e-3 * 1000.0;
    assert!((outcome.ledger.mass / mass - 1.0).abs() < 1e-12, "{}", outcome.ledger.mass);
    let momentum =
        Vec3::from(outcome.ledger.momentum) - (Vec3::new(1.0, 2.0, 3.0) + gravity * t) * mass;
    assert!(momentum.norm() < 1e-12, "{momentum}");
    let kinetic = outcome.ledger.kinetic;
    assert!(outcome.ledger.stretching + outcome.ledger.bending < 1e-16 * kinetic);
    assert!(outcome.ledger.residual.abs() < 1e-12 * kinetic, "{}", outcome.ledger.residual);
    assert!(outcome.warnings.is_empty(), "{:?}", outcome.warnings);
}

/// A sheet that spins keeps its angular momentum and its energy over three turns.
#[test]
fn a_spinning_sheet_goes_on_spinning() {
    let mut body = sheet([0.2, 0.1, 4e-3], 0.02, WHOLE, RUBBER);
    body.spin = Vec3::new(0.0, 0.0, 20.0);
    let centre = Vec3::new(40.0, 0.0, 10.0);
    body.pose.translation.vector = centre;
    body.pose.rotation = Quat::from_scaled_axis(Vec3::new(0.4, 0.3, 0.0));
    body.spin = body.pose.rotation * Vec3::new(0.0, 0.0, 20.0);
    let setup = setup(body, Vec3::zeros());
    let prepared = prepare(&setup);
    let first = solve(&prepared, None, 0, 1, vec![]);
    let last = solve(&prepared, Some(&first.state), 1, 240, vec![]);
    let [a, b] = [&first, &last].map(|o| Vec3::from(o.ledger.angular_momentum));
    assert!((a - b).norm() < 1e-9 * a.norm(), "{a} {b}");
    let energy = |l: &cullet_model::WindowLedger| l.kinetic + l.stretching + l.bending;
    let off = energy(&last.ledger) / energy(&first.ledger) - 1.0;
    println!("energy off by {off:.2e} over 3 turns");
    assert!(off.abs() < 1e-3, "{off}");
    assert!(last.ledger.stretching > 0.0, "it is pulled outwards");
    assert!((last.frames.last().unwrap().origin - centre).norm() < 1e-9);
}

/// Place of the end of a strip of length 1 that is clamped at one end and bends under its weight:
/// θ'' = −κ (1 − s) cos θ with κ = wL³/EI, by shooting.
fn elastica(load: f64) -> [f64; 2] {
    let end = |slope: f64| {
        let (n, mut angle, mut bend, mut x, mut y) = (4000, 0.0_f64, slope, 0.0, 0.0);
        let h = 1.0 / f64::from(n);
        for k in 0..n {
            let s = f64::from(k) * h;
            // Midpoint rule.
            let middle = angle + 0.5 * h * bend;
            let bent = bend + 0.5 * h * load * (1.0 - s) * angle.cos();
            bend += h * load * (1.0 - s - 0.5 * h) * middle.cos();
            x += h * middle.cos();
            y += h * middle.sin();
            angle += h * bent;
        }
        (bend, x, y)
    };
    let (mut low, mut high) = (-load, 0.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        *(if end(middle).0 > 0.0 { &mut high } else { &mut low }) = middle;
    }
    let (_, x, y) = end(low);
    [x, y]
}

/// S10: a strip that is clamped at one end hangs as the elastica does.
#[test]
fn s10_a_cantilever_hangs_as_the_elastica() {
    let (length, t) = (0.2, 5e-3);
    let material = Material { young: 3e6, poisson: 0.0, density: 1000.0, ..RUBBER };
    let clamp = 0.03;
    let mut body = sheet([length + clamp, 0.02, t], 0.005, WHOLE, material);
    let end = 0.5 * (length + clamp);
    body.grips = vec![grip_x(-1.0, clamp - end, vec![])];
    body.damping = 0.3;
    (body.air.density, body.air.drag) = (100.0, 10.0);
    let setup = setup(body, Vec3::new(0.0, 0.0, -9.81));
    let prepared = prepare(&setup);
    let outcome = solve(&prepared, None, 0, 5 * 240, vec![]);
    let ledger = &outcome.ledger;
    assert!(ledger.kinetic < 1e-4 * ledger.bending, "{ledger:?}");
    // EI and the weight by width.
    let load = 1000.0 * 9.81 * t * length * length * length / (3e6 * t * t * t / 12.0);
    let wanted = elastica(load);
    let tip = places(&outcome).into_iter().max_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
    let found = [(tip.x - (clamp - end)) / length, tip.z / length];
    println!("S10: load {load:.3}, tip {found:.4?}, elastica {wanted:.4?}");
    assert!((found[0] - wanted[0]).abs() < 0.03 && (found[1] - wanted[1]).abs() < 0.03);
    assert!(wanted[1] < -0.5, "it is no large deflection");
}

/// A ball on a clamped sheet bounces: momentum is that of the ball, the sheet, grips and gravity.
#[test]
fn a_ball_bounces_on_a_trampoline() {
    let mut body = sheet([0.4, 0.2, 3e-3], 0.02, WHOLE, RUBBER);
    body.grips = vec![grip_x(-1.0, -0.17, vec![]), grip_x(0.17, 1.0, vec![])];
    body.damping = 0.05;
    let gravity = Vec3::new(0.0, 0.0, -9.81);
    let setup = setup(body, gravity);
    let prepared = prepare(&setup);
    let mass = 0.05;
    let start = Vec3::new(0.01, 0.0, -2.0);
    let ball = free_ball(0.03, mass, Vec3::new(0.01, 0.0, 0.05), start);
    let outcome = solve(&prepared, None, 0, 120, vec![ball]);
    let ledger = &outcome.ledger;
    let handed = &outcome.handed[0];
    let given: Vec3 = handed.impulses.iter().map(|impulse| impulse[0]).sum();
    assert!(given.z > mass * 2.0, "it does not bounce: {given}");
    // The sheet's momentum: gravity, grips, and the opposite of what the ball was given.
    let grips: Vec3 = [1, 2]
        .iter()
        .map(|k| {
            let part = |axis: &str| figure(&outcome, &format!("grip_{k}_force_{axis}")) * 0.5;
            Vec3::new(part("x"), part("y"), part("z"))
        })
        .sum();
    let wanted = gravity * (ledger.mass * 0.5) + grips - given;
    let off = (Vec3::from(ledger.momentum) - wanted).norm();
    assert!(off < 1e-9 * (grips.norm() + given.norm()), "{off}");
    let residual = Vec3::from(ledger.momentum_residual).norm();
    assert!(residual < 1e-9 * given.norm(), "{residual}");
    println!("ball: {given}, {ledger:?}");
    assert!(ledger.residual.abs() < 0.02 * ledger.bodies.abs().max(0.1), "{}", ledger.residual);
    assert!(outcome.warnings.is_empty(), "{:?}", outcome.warnings);
}

/// A sheet that has come to rest on a floor is not simulated any more, until something comes near.
#[test]
fn a_sheet_at_rest_is_frozen_until_something_comes_near() {
    let mut body = sheet([0.16, 0.16, 4e-3], 0.02, WHOLE, RUBBER);
    body.pose.translation.vector.z = 0.01;
    body.damping = 0.5;
    (body.air.density, body.air.drag) = (20.0, 5.0);
    let setup = setup(body, Vec3::new(0.0, 0.0, -9.81));
    let prepared = prepare(&setup);
    let floor = || {
        let mut floor = free_ball(0.1, 1.0, Vec3::new(0.0, 0.0, -0.1), Vec3::zeros());
        let corner = |k: usize, axis: usize| if k >> axis & 1 == 1 { 0.3 } else { -0.3 };
        let corners = (0..8).map(|k| Vec3::new(corner(k, 0), corner(k, 1), corner(k, 2) / 3.0));
        floor.parts = vec![corners.collect()];
        floor.motion = cullet_model::ProxyMotion::Steady;
        floor
    };
    let rested = solve(&prepared, None, 0, 3 * 240, vec![floor()]);
    assert!(rested.pieces[0].frozen, "{:?} {:?}", rested.pieces, rested.ledger);
    assert_eq!(rested.ledger.kinetic, 0.0);
    let later = solve(&prepared, Some(&rested.state), 720, 24, vec![floor()]);
    assert_eq!(places(&later), places(&rested));
    let ball = free_ball(0.03, 0.1, Vec3::new(0.0, 0.0, 0.05), Vec3::new(0.0, 0.0, -2.0));
    let hit = solve(&prepared, Some(&later.state), 744, 24, vec![ball, floor()]);
    assert!(!hit.pieces[0].frozen && hit.ledger.bodies != 0.0, "{:?}", hit.ledger);
}

/// The right half of a sheet, cut off, is laid on the left one, which is held: it comes to rest
/// there, with nothing but the other piece under it.
#[test]
fn a_piece_that_lies_on_another_comes_to_rest() {
    let mut body = sheet([0.32, 0.16, 4e-3], 0.02, WHOLE, RUBBER);
    let corner = |y: f64, z: f64| Vec3::new(0.04 + 1e-6, y, z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    body.cuts = vec![BodyCut { corners }];
    let to = |t: f64, x: f64, z: f64| (t, Vec3::new(x, 0.0, z));
    let over = vec![to(0.15, 0.0, 0.03), to(0.4, -0.18, 0.03), to(0.6, -0.18, 0.014)];
    let laid = BodyGrip { until: Some(0.65), ..grip_x(0.09, 1.0, over) };
    body.grips = vec![grip_x(-1.0, -0.01, vec![]), laid];
    body.damping = 0.5;
    (body.air.density, body.air.drag) = (60.0, 5.0);
    let prepared = prepare(&setup(body, Vec3::new(0.0, 0.0, -9.81)));
    let rested = solve(&prepared, None, 0, 6 * 240, vec![]);
    assert_eq!(rested.pieces.len(), 2, "{:?}", rested.pieces);
    assert_eq!(rested.pieces.iter().filter(|p| p.frozen).count(), 1, "{:?}", rested.pieces);
    let laid = places(&rested).into_iter().filter(|x| x.z > 2.5e-3);
    let (low, high) = laid.fold((1.0, 0.0), |(low, high), x| (x.z.min(low), x.z.max(high)));
    assert!(low > 4e-3 && high < 0.04, "{low} {high}");
}
