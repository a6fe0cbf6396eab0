//! Bars and beams against closed forms.

use super::super::SoftSolidState;
use super::*;
use std::f64::consts::{PI, TAU};

/// Runs windows of one step and gives what `probe` sees after each.
fn history(
    prepared: &Arc<PreparedSoftSolid>,
    mut state: SoftSolidState,
    steps: u32,
    probe: impl Fn(&SoftSolidState) -> f64,
) -> Vec<f64> {
    let mut seen = vec![probe(&state)];
    for _ in 0..steps {
        let bytes = state.encode(prepared);
        let window = Window { frame_every: 0, ..window(state.step, 1, vec![]) };
        let end = solved(prepared, Some(&bytes), window).unwrap();
        state = SoftSolidState::decode(prepared, &end.state).unwrap();
        seen.push(probe(&state));
    }
    seen
}

/// Frequency of a signal sampled every `dt` \[s\] from its zero crossings \[Hz\].
fn frequency(signal: &[f64], dt: f64) -> f64 {
    let mut crossings = Vec::new();
    for (k, two) in signal.windows(2).enumerate() {
        if (two[0] > 0.0) != (two[1] > 0.0) {
            crossings.push((k as f64 + two[0] / (two[0] - two[1])) * dt);
        }
    }
    let last = crossings.len() - 1;
    0.5 * last as f64 / (crossings[last] - crossings[0])
}

/// C5, vibration: a bar that is clamped at one end rings along its length with √(E/ρ)/4L.
#[test]
fn a_clamped_bar_rings_along_its_length() {
    let mut setup = block([0.24, 0.04, 0.04], 0.008, elastic());
    setup.world_step = 1.0 / 960.0;
    let part = body(&mut setup);
    part.material.poisson = 0.25;
    part.material.young = 1e5;
    // What the grip holds does not ring: the bar begins half a spacing behind its last points.
    part.grips = vec![end_grip(-0.13, -0.1, vec![])];
    let prepared = prepared(&setup);
    let held = prepared.grips[0].points.iter().map(|&p| prepared.rest[p as usize].x);
    let from = held.fold(f64::NEG_INFINITY, f64::max);
    let length = 0.12 - from - 0.25 * 0.008;
    let mut state = SoftSolidState::start(&prepared);
    let shape = |x: f64| libm::sin(0.5 * PI * ((x - from) / length).max(0.0));
    for (place, at) in state.domain.places.iter_mut().zip(&prepared.rest) {
        place.x += 1e-4 * shape(at.x);
    }
    let probe = |state: &SoftSolidState| {
        let moved = state.domain.places.iter().zip(&prepared.rest);
        moved.map(|(x, at)| (x.x - at.x) * shape(at.x)).sum::<f64>()
    };
    let seen = history(&prepared, state, 170, probe);
    let found = frequency(&seen, setup.world_step);
    let wanted = (1e5_f64 / 1000.0).sqrt() / (4.0 * length);
    println!("along: {found:.4} Hz of {wanted:.4}");
    assert!((found / wanted - 1.0).abs() < 0.03, "{found} of {wanted} Hz");
}

/// C5, bending: the first frequency of a cantilever, by Timoshenko's correction of Euler's beam.
#[test]
fn a_cantilever_swings_at_its_first_frequency() {
    let mut setup = block([0.30, 0.05, 0.05], 0.00625, elastic());
    setup.world_step = 1.0 / 240.0;
    let part = body(&mut setup);
    part.material.young = 2e5;
    part.grips = vec![end_grip(-0.16, -0.12, vec![])];
    let prepared = prepared(&setup);
    let held = prepared.grips[0].points.iter().map(|&p| prepared.rest[p as usize].x);
    let from = held.fold(f64::NEG_INFINITY, f64::max);
    let length: f64 = 0.15 - from - 0.25 * 0.00625;
    let mut state = SoftSolidState::start(&prepared);
    let shape = |x: f64| {
        let s = ((x - from) / length).max(0.0);
        s * s * (6.0 - 4.0 * s + s * s) / 3.0
    };
    for (place, at) in state.domain.places.iter_mut().zip(&prepared.rest) {
        let s = ((at.x - from) / length).max(0.0);
        place.z += 2e-3 * shape(at.x);
        // Sections turn along.
        place.x -= 2e-3 * at.z * (12.0 * s - 12.0 * s * s + 4.0 * s * s * s) / (3.0 * length);
    }
    let probe = |state: &SoftSolidState| {
        let moved = state.domain.places.iter().zip(&prepared.rest);
        moved.map(|(x, at)| (x.z - at.z) * shape(at.x)).sum::<f64>()
    };
    let seen = history(&prepared, state, 140, probe);
    let found = frequency(&seen, setup.world_step);
    let (h, e, rho) = (0.05_f64, 2e5_f64, 1000.0_f64);
    let (area, second) = (h * h, h.powi(4) / 12.0);
    let euler = 1.875_104_f64.powi(2) / TAU * (e * second / (rho * area)).sqrt() / length.powi(2);
    // Dunkerley: compliances of bending and of shear add up, and sections turn with inertia.
    let shear = (5.0 / 6.0 * e / 2.5 / rho).sqrt() / (4.0 * length);
    let wanted = 1.0 / (1.0 / (euler * euler) + 1.0 / (shear * shear)).sqrt();
    println!("bending: {found:.4} Hz of {wanted:.4} (Euler {euler:.4})");
    assert!((found / wanted - 1.0).abs() < 0.05, "{found} of {wanted} Hz");
}

/// C5, twist: torque GJθ/L of a square bar, J = 0.1406 a⁴, twisted by 0.6 rad.
#[test]
fn a_twisted_bar_resists_with_its_torque() {
    let bonds = BondedSolid { air_damping: 20.0, ..elastic() };
    let mut setup = block([0.24, 0.06, 0.06], 0.0075, bonds);
    let angle = 0.4;
    let part = body(&mut setup);
    part.damping = 0.2;
    let turning = BodyGrip {
        turn: Vec3::new(angle / 0.5, 0.0, 0.0),
        ..end_grip(0.09, 0.13, vec![(0.0, Vec3::zeros()), (0.5, Vec3::zeros())])
    };
    part.grips = vec![end_grip(-0.13, -0.09, vec![]), turning];
    let prepared = prepared(&setup);
    let reach = |k: usize, pick: fn(f64, f64) -> f64, from: f64| {
        let held = prepared.grips[k].points.iter().map(|&p| prepared.rest[p as usize].x);
        held.fold(from, pick)
    };
    let length = reach(1, f64::min, 9.0) - reach(0, f64::max, -9.0) - 0.5 * 0.0075;
    let begin = Window { frame_every: 0, ..window(0, 240, vec![]) };
    let end = solved(&prepared, None, begin).unwrap();
    let last = Window { frame_every: 0, ..window(240, 24, vec![]) };
    let end = solved(&prepared, Some(&end.state), last).unwrap();
    let found = figure(&end, "grip_2_moment_x");
    let other = figure(&end, "grip_1_moment_x");
    let shear = 5e4 / 2.5;
    let wanted = shear * 0.1406 * 0.06_f64.powi(4) * angle / length;
    println!("twist: {found:.5} N·m of {wanted:.5}, other end {other:.5}, L {length:.4}");
    assert!((found + other).abs() < 0.02 * wanted);
    assert!((found / wanted - 1.0).abs() < 0.05, "{found} of {wanted} N·m");
}

/// A bar that is pulled beyond its yield and let go keeps its set; an elastic one does not.
#[test]
fn a_plastic_bar_keeps_its_set() {
    let mut sets = Vec::new();
    for yields in [false, true] {
        let hardening =
            cullet_model::Hardening { yield_stress: 2e3, hardening: 1e3, exponent: 1.0 };
        let bonds =
            BondedSolid { hardening: yields.then_some(hardening), air_damping: 40.0, ..elastic() };
        let mut setup = block([0.16, 0.04, 0.04], 0.008, bonds);
        let part = body(&mut setup);
        part.damping = 0.3;
        let path = vec![(0.0, Vec3::zeros()), (0.4, Vec3::new(0.0144, 0.0, 0.0))];
        let pulled = BodyGrip { until: Some(0.45), ..end_grip(0.06, 0.09, path) };
        part.grips = vec![end_grip(-0.09, -0.06, vec![]), pulled];
        let prepared = prepared(&setup);
        let end = solved(&prepared, None, Window { frame_every: 0, ..window(0, 480, vec![]) });
        let end = end.unwrap();
        assert!(end.ledger.residual.abs() < 0.02 * end.ledger.grips, "{:?}", end.ledger);
        let state = SoftSolidState::decode(&prepared, &end.state).unwrap();
        let set: f64 = prepared.grips[1]
            .points
            .iter()
            .map(|&p| p as usize)
            .map(|p| state.domain.places[p].x - prepared.rest[p].x)
            .sum::<f64>()
            / prepared.grips[1].points.len() as f64;
        assert_eq!(end.ledger.plastic > 0.0, yields);
        sets.push(set);
    }
    println!("sets: {sets:?} m");
    // Stretched by 0.12 over 0.12 m, of which 0.04 is elastic at the yield stress.
    assert!(sets[0].abs() < 2e-4, "{sets:?}");
    assert!((sets[1] / 0.0094 - 1.0).abs() < 0.1, "{sets:?}");
}
