//! What parts of a broken body do: they touch, rub and fly off.

use crate::block;
use cullet_geometry::Vec3;
use cullet_peridynamics::law::PartedContact;
use cullet_peridynamics::{PeridynamicDomain, PeridynamicLaw};

const SPACING: f64 = 1e-3;

fn glass(contact: Option<PartedContact>) -> PeridynamicLaw {
    PeridynamicLaw { contact, ..PeridynamicLaw::elastic(2500.0, 70e9, 0.25) }
}

/// F82: a point without bonds flies on by itself, however far and fast, and the others do not feel
/// it.
#[test]
fn f82_a_lone_point_becomes_debris() {
    let mut body = block([8, 8, 8], SPACING, 0.1, 3.015, glass(None));
    let corner = body.places[0];
    body.sever(|a, b| *a == corner || *b == corner);
    body.strain();
    let speed = Vec3::new(-1e30, 3e29, 0.0);
    body.velocities[0] = speed;
    let dt = body.stable_step();
    for _ in 0..200 {
        body.advance(dt, |_, v| v);
    }
    let sum = body.sums();
    let most = (1..body.places.len()).map(|p| body.velocities[p].norm()).fold(0.0, f64::max);
    println!("F82: {} debris, others move by {most:.1e} m/s", sum.debris);
    assert_eq!((sum.debris, sum.debris_mass), (1, body.mass(0)));
    assert_eq!(sum.debris_momentum, speed * body.mass(0));
    assert!(most < 1e-6, "{most} m/s");
}

/// What came of two halves of a block that were parted, and thrown at each other.
struct Thrown {
    body: PeridynamicDomain,
    /// Least distance between points of different halves over the spacing.
    nearest: f64,
    /// What friction took \[J\].
    friction: f64,
    /// Energy with it less that at the start, over that, where it is worst.
    ledger: f64,
    /// Speed of the left half along and across, at the end \[m/s\].
    speed: [f64; 2],
}

fn thrown(contact: Option<PartedContact>, shake: f64, along: f64, across: f64) -> Thrown {
    let mut body = block([12, 8, 8], SPACING, shake, 2.04, glass(contact));
    let left: Vec<bool> = body.places.iter().map(|x| x.x < 0.0).collect();
    body.sever(|a, b| a.x * b.x < 0.0);
    let sign = |p: usize| if left[p] { 1.0 } else { -1.0 };
    for p in 0..left.len() {
        body.velocities[p] = Vec3::new(along, across, 0.0) * sign(p);
    }
    body.strain();
    let (dt, start) = (0.5 * body.stable_step(), body.sums());
    let (mut friction, mut nearest, mut ledger) = (0.0, f64::INFINITY, 0.0_f64);
    let halves = |side: bool| (0..left.len()).filter(|&p| left[p] == side).collect::<Vec<_>>();
    let (ones, others) = (halves(true), halves(false));
    for step in 0..800 {
        friction += body.advance(dt, |_, v| v).friction;
        if step % 20 == 0 {
            let mut now = body.sums();
            // Velocities are half a step behind.
            let ahead = body.velocities.iter().zip(&body.forces).map(|(v, f)| v.dot(f));
            now.kinetic += 0.5 * dt * ahead.sum::<f64>();
            let all = now.kinetic + now.elastic + now.contact + friction;
            ledger = ledger.max((all / start.kinetic - 1.0).abs());
            for &p in &ones {
                let near = others.iter().map(|&q| (body.places[p] - body.places[q]).norm());
                nearest = near.fold(nearest, f64::min);
            }
        }
    }
    let end = body.sums();
    let mean = |axis: usize| ones.iter().map(|&p| body.velocities[p][axis]).sum::<f64>();
    let speed = [0, 1].map(|axis| mean(axis) / ones.len() as f64);
    let drift = (end.momentum - start.momentum).norm();
    assert!(drift < 1e-12 * body.mass(0) * left.len() as f64 * along, "momentum off by {drift}");
    Thrown { body, nearest: nearest / SPACING, friction, ledger, speed }
}

/// F52: halves that are pushed together part again and do not go through each other; energy is
/// booked, and friction slows them across.
#[test]
fn f52_parted_halves_do_not_go_through_each_other() {
    let smooth = thrown(Some(PartedContact { friction: 0.0 }), 0.1, 10.0, 4.0);
    let rough = thrown(Some(PartedContact { friction: 0.5 }), 0.1, 10.0, 4.0);
    for (what, hit) in [("smooth", &smooth), ("rough", &rough)] {
        println!(
            "F52, {what}: nearest {:.3}, ledger {:.4}, speeds {:.2?} m/s, friction {:.4} J",
            hit.nearest, hit.ledger, hit.speed, hit.friction
        );
        assert!(hit.nearest > 0.6, "{what}: {}", hit.nearest);
        assert!(hit.speed[0] < -5.0, "{what}: {:?} m/s", hit.speed);
        assert!(hit.ledger < 0.01, "{what}: {}", hit.ledger);
        assert!(hit.body.sums().contact < 1e-3 * hit.body.sums().kinetic);
    }
    assert_eq!(smooth.friction, 0.0);
    let through = thrown(None, 0.1, 10.0, 4.0);
    assert!(through.nearest < 0.5 && through.speed[0] > 9.0, "{}", through.nearest);
    assert!(rough.speed[1] < smooth.speed[1] - 0.5, "{:?}", rough.speed);
    // Points in rows that meet head on do not rub.
    let head_on = thrown(Some(PartedContact { friction: 0.5 }), 0.0, 10.0, 0.0);
    println!("F52, head on: friction {:.1e} J, speeds {:.2?} m/s", head_on.friction, head_on.speed);
    assert!(rough.friction > 5e-3 && head_on.friction < 1e-4, "{}", head_on.friction);
}
