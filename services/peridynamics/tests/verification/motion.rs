//! E2, E11: bodies that turn, ring and yield keep what they must.

use crate::block;
use cullet_geometry::{Mat3, Quat, Vec3};
use cullet_model::{DuctileFailure, Hardening};
use cullet_peridynamics::anisotropy::BondAnisotropy;
use cullet_peridynamics::law::{BondBreaking, PartedContact, PeridynamicDamping};
use cullet_peridynamics::{PeridynamicDomain, PeridynamicLaw};
use cullet_simd::SimdLevel;

fn elastic() -> PeridynamicLaw {
    PeridynamicLaw::elastic(2000.0, 1e9, 0.3)
}

/// E2: a body that is turned by any angle bears nothing.
#[test]
fn e2_a_turned_body_bears_nothing() {
    let mut body = block([8, 8, 8], 0.01, 0.2, 3.015, elastic());
    for angle in [0.3, 1.7, 3.0] {
        let turn = Quat::from_scaled_axis(Vec3::new(0.48, -0.6, 0.64) * angle);
        let mut turned = body.clone();
        turned.places.iter_mut().for_each(|x| *x = turn * *x + Vec3::new(1.0, 2.0, 3.0));
        turned.strain();
        let most = turned.forces.iter().map(Vec3::norm).fold(0.0, f64::max);
        assert!(most < 1e-9 * 1e9 * 1e-4, "{angle}: {most} N");
    }
    body.strain();
    assert!(body.forces.iter().all(|force| force.norm() < 1e-7));
}

/// A block that is thrown, spun, sheared and let go.
fn thrown(law: PeridynamicLaw, strain: f64) -> PeridynamicDomain {
    let mut body = block([10, 7, 5], 0.01, 0.15, 3.015, law);
    for p in 0..body.places.len() {
        let x = body.places[p];
        body.velocities[p] = Vec3::new(3.0, -1.0, 2.0) + Vec3::new(5.0, 20.0, -8.0).cross(&x);
        body.places[p] += Vec3::new(x.y, 0.5 * x.z, -0.7 * x.x) * strain;
    }
    body.strain();
    body
}

/// E11: momenta to 1e-11 of what moves, angular momentum, whose arms are rounded to f32, to 1e-9 of
/// what moves over the body's length of 0.1 m, energy within 0.2 %, elastic and yielding, and what
/// flows takes what is missing.
#[test]
fn e11_momenta_and_energy_are_kept() {
    let hardening = Some(Hardening { yield_stress: 1e6, hardening: 5e7, exponent: 1.0 });
    for (what, law) in
        [("elastic", elastic()), ("yielding", PeridynamicLaw { hardening, ..elastic() })]
    {
        let mut body = thrown(elastic(), 2e-3);
        body.law = law;
        let (dt, start) = (body.stable_step(), body.sums());
        let mut plastic = 0.0;
        for _ in 0..2000 {
            plastic += body.advance(dt, |_, v| v).plastic;
        }
        let mut end = body.sums();
        // Velocities are half a step behind.
        let ahead = body.velocities.iter().zip(&body.forces).map(|(v, f)| v.dot(f));
        end.kinetic += 0.5 * dt * ahead.sum::<f64>();
        let scale = end.kinetic.sqrt() * (1.0_f64 * 0.7).sqrt();
        let lost = (end.momentum - start.momentum).norm() / scale;
        let turned = (end.angular - start.angular).norm() / scale;
        println!("E11, {what}: momentum {lost:.1e}, angular momentum {turned:.1e} m");
        assert!(lost < 1e-11 && turned < 1e-10, "{what}: {lost}, {turned}");
        let before = start.kinetic + start.elastic;
        let after = end.kinetic + end.elastic + plastic;
        println!(
            "E11, {what}: {:.1e}, of it plastic {:.3}",
            after / before - 1.0,
            plastic / before
        );
        assert!((after / before - 1.0).abs() < 2e-3, "{what}: {before} J, {after} J");
        assert_eq!(plastic > 0.02 * start.elastic, law.hardening.is_some(), "{what}: {plastic} J");
    }
}

/// A strain of 1e-6 gives the same stress however far the body has moved and turned: displacements
/// are counted from where it is.
#[test]
fn e2_faint_strains_do_not_depend_on_where_a_body_is() {
    let still = block([10, 10, 10], 0.01, 0.2, 3.015, elastic());
    let middle = (0..1000)
        .min_by(|&a, &b| still.places[a].norm_squared().total_cmp(&still.places[b].norm_squared()));
    let middle = middle.expect("a point");
    let stress = |turn: Quat, away: Vec3| {
        let mut body = still.clone();
        for x in &mut body.places {
            *x = turn * (*x + Vec3::new(1e-6 * x.x, -2e-7 * x.y, 3e-7 * x.x)) + away;
        }
        body.strain();
        // The kernel's own figure: a third of the trace of the strain.
        let mean = body.states[middle].mean / (0.8e-6 / 3.0) - 1.0;
        assert!(mean.abs() < 1e-4, "mean extension off by {mean}");
        let back = turn.inverse().to_rotation_matrix();
        back * body.stress(middle) * back.transpose()
    };
    let wanted = stress(Quat::identity(), Vec3::zeros());
    assert!((wanted[(0, 0)] / 1.2e3 - 1.0).abs() < 0.2, "{wanted}");
    for (angle, away) in [(0.0, 50.0), (2.0, 0.0), (3.0, -20.0)] {
        let turn = Quat::from_scaled_axis(Vec3::new(0.48, -0.6, 0.64) * angle);
        let found = stress(turn, Vec3::new(1.0, 0.5, -0.3) * away);
        let miss = (found - wanted).amax() / wanted.amax();
        println!("E2, turned by {angle} and moved by {away} m: stress off by {miss:.1e}");
        assert!(miss < 1e-5, "{angle}, {away}: {miss}");
    }
}

/// Halves that have flown apart are each far from where the body is as a whole: what that costs in
/// strain, in 1e-7 |u|/δ.
#[test]
fn parts_that_are_far_from_each_other_lose_digits() {
    let (horizon, bulk) = (0.03015, elastic().bulk);
    for horizons in [1.0, 10.0, 100.0, 1000.0] {
        let mut body = block([10, 8, 8], 0.01, 0.2, 3.015, elastic());
        body.sever(|a, b| a.x * b.x < 0.0);
        let half = Vec3::new(0.7, 0.5, 0.3).normalize() * horizons * horizon;
        for x in &mut body.places {
            *x += if x.x < 0.0 { -half } else { half };
        }
        body.strain();
        let most = body.states.iter().map(|state| state.mean.abs()).fold(0.0, f64::max);
        let stress = (0..body.places.len()).map(|p| body.stress(p).norm()).fold(0.0, f64::max);
        println!(
            "f32, moved by {horizons} δ: mean extension off by {most:.1e}, stress by {:.1e} K",
            stress / bulk
        );
        assert!(most < 1e-7 * horizons, "{horizons}: {most}");
    }
}

/// The same bits of a body that yields and breaks, however many threads there are and whichever
/// instructions the processor has.
#[test]
fn the_bits_depend_neither_on_threads_nor_on_the_level() {
    let hardening = Some(Hardening { yield_stress: 1e6, hardening: 5e7, exponent: 0.5 });
    let run = |threads: usize, level: SimdLevel, everything: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let breaking = Some(BondBreaking { fracture_energy: 60.0, dust: 1.0 });
            let law = PeridynamicLaw { hardening, breaking, ..elastic() };
            let law = if everything { with_everything(law) } else { law };
            let mut body = thrown(law, 4e-3);
            body.level = level;
            let (dt, mut tally) = (body.stable_step(), [0.0; 2]);
            for _ in 0..100 {
                let step = body.advance(dt, |_, v| v);
                tally = [tally[0] + step.plastic, tally[1] + step.broken];
            }
            assert!(tally.iter().all(|&energy| energy > 0.0), "{tally:?}");
            body.places.iter().flat_map(|x| [x.x, x.y, x.z].map(f64::to_bits)).collect::<Vec<_>>()
        })
    };
    assert!(SimdLevel::all().len() > 1);
    for everything in [false, true] {
        let one = run(1, SimdLevel::best(), everything);
        for threads in [2, 3, 8] {
            assert!(run(threads, SimdLevel::best(), everything) == one, "{threads} threads");
        }
        for level in SimdLevel::all() {
            assert!(run(1, level, everything) == one, "{level}");
        }
    }
}

/// A law with all that a law can have.
fn with_everything(law: PeridynamicLaw) -> PeridynamicLaw {
    let stretched = Mat3::from_diagonal(&Vec3::new(1.2, 1.0, 0.9));
    PeridynamicLaw {
        ductile: Some(DuctileFailure { d: [1e-4, 1e-3, -1.5, 0.0, 0.0] }),
        max_plastic_stretch: Some(1e-3),
        anisotropy: Some(BondAnisotropy::of_matrix(&stretched)),
        contact: Some(PartedContact { friction: 0.3 }),
        damping: PeridynamicDamping { bonds: 0.05, air: 10.0 },
        ..law
    }
}

/// The step is stable up to its bound, and not much smaller than it must be.
#[test]
fn the_step_is_near_its_bound() {
    for horizon in crate::HORIZONS {
        let run = |factor: f64| {
            let mut body = block([8, 8, 8], 0.01, 0.1, horizon, elastic());
            let dt = factor * body.stable_step();
            for (p, v) in body.velocities.iter_mut().enumerate() {
                let sign = if p % 2 == 0 { 1.0 } else { -1.0 };
                *v = Vec3::new(sign, 0.3, -sign) * 1e-3;
            }
            let start = body.sums().kinetic;
            for _ in 0..1000 {
                body.advance(dt, |_, v| v);
            }
            let end = body.sums();
            (end.kinetic + end.elastic) / start
        };
        let (steady, wild) = (run(1.0), run(4.0));
        println!("step, m {horizon}: {steady:.3}, four times {wild:.1e}");
        assert!((0.8..1.2).contains(&steady), "m {horizon}: {steady}");
        assert!(wild.is_nan() || wild > 10.0, "m {horizon}: {wild}");
    }
}

/// Dashpots take what a body that rings loses, and nothing of one that flies and turns.
#[test]
fn dashpots_take_what_a_ringing_body_loses() {
    let damping = PeridynamicDamping { bonds: 0.1, air: 0.0 };
    for (what, strain, spins) in [("rings", 2e-3, 0.0), ("flies and turns", 0.0, 1.0)] {
        let mut body = thrown(PeridynamicLaw { damping, ..elastic() }, strain);
        for p in 0..body.places.len() {
            let x = body.places[p];
            body.velocities[p] =
                Vec3::new(3.0, -1.0, 2.0) + Vec3::new(5.0, 20.0, -8.0).cross(&x) * spins;
        }
        body.strain();
        let (dt, start) = (body.stable_step(), body.sums());
        let mut damped = 0.0;
        for _ in 0..1000 {
            damped += body.advance(dt, |_, v| v).damped;
        }
        let mut end = body.sums();
        let ahead = body.velocities.iter().zip(&body.forces).map(|(v, f)| v.dot(f));
        end.kinetic += 0.5 * dt * ahead.sum::<f64>();
        let lost = start.kinetic + start.elastic - end.kinetic - end.elastic;
        println!(
            "Dashpots, {what}: {damped:.4} J of {:.4} J taken, {lost:.4} J lost",
            start.elastic
        );
        let scale = end.kinetic.sqrt() * (1.0_f64 * 0.7).sqrt();
        assert!((end.momentum - start.momentum).norm() < 1e-12 * scale, "{what}");
        if strain > 0.0 {
            assert!(damped > 0.8 * start.elastic, "{damped} J of {} J", start.elastic);
            assert!((damped / lost - 1.0).abs() < 0.02, "{damped} J, {lost} J");
        } else {
            assert!(damped < 1e-4 * start.kinetic, "{damped} J");
        }
    }
}

/// F83: what the air takes does not depend on the step: v₀ exp(−λt), and it is booked.
#[test]
fn f83_air_slows_alike_with_any_step() {
    let damping = PeridynamicDamping { bonds: 0.0, air: 4e3 };
    for factor in [1.0, 0.5, 0.25] {
        let mut body = block([6, 6, 6], 0.01, 0.1, 3.015, PeridynamicLaw { damping, ..elastic() });
        body.velocities.iter_mut().for_each(|v| *v = Vec3::new(3.0, -1.0, 2.0));
        body.strain();
        let (dt, start) = (factor * body.stable_step(), body.sums());
        let steps = (100.0 / factor) as u32;
        let damped: f64 = (0..steps).map(|_| body.advance(dt, |_, v| v).damped).sum();
        let (end, time) = (body.sums(), dt * f64::from(steps));
        let share = end.momentum.norm() / start.momentum.norm();
        println!("F83, {factor} of the step: {share:.9} of the momentum is left");
        assert!((share / (-4e3 * time).exp() - 1.0).abs() < 1e-10, "{factor}: {share}");
        assert!(share < 0.5, "{share}");
        let lost = start.kinetic - end.kinetic;
        assert!((damped / lost - 1.0).abs() < 1e-6, "{factor}: {damped} J, {lost} J");
    }
}
