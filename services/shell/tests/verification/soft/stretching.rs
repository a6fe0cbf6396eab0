//! Walls that are stretched, pressed and bent far: closed forms, and what yields.

use super::harness::{
    RUBBER, WHOLE, figure, free_ball, grip_x, places, prepare, setup, sheet, solve,
};
use cullet_geometry::Vec3;
use cullet_model::{Hardening, Material, MembranePace, SoftLaw};
use cullet_shell::section::NeoHookean;

/// A strip pulled to one and a half of its length bears what a neo-Hookean strip does.
#[test]
fn a_strip_at_large_stretch_bears_its_closed_form() {
    let (length, width, t) = (0.6, 0.05, 2e-3);
    let mut body = sheet([length, width, t], 0.0125, WHOLE, RUBBER);
    let pull = 0.3;
    let path = |way: f64| vec![(3.0, Vec3::new(way, 0.0, 0.0))];
    body.grips = vec![grip_x(-1.0, -0.29, path(-0.5 * pull)), grip_x(0.29, 1.0, path(0.5 * pull))];
    body.damping = 0.5;
    let setup = setup(body, Vec3::zeros());
    let prepared = prepare(&setup);
    let pulled = solve(&prepared, None, 0, 4 * 240, vec![]);
    let held = solve(&prepared, Some(&pulled.state), 4 * 240, 24, vec![]);
    // Stretch in the middle, from the drawn surface.
    let now = places(&held);
    let surface = &held.surfaces[0];
    let near = |x: f64| {
        let off = |k: &usize| (f64::from(surface.reference[*k][0]) - x).abs();
        (0..now.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
    };
    let ([a, b], of) = ([near(-0.1), near(0.1)], |k: usize| f64::from(surface.reference[k][0]));
    let stretch = (now[b].x - now[a].x) / (of(b) - of(a));
    let (_, stress) = NeoHookean::new(3.2e5, 0.3).strip(0.5 * (stretch * stretch - 1.0));
    let wanted = stress * stretch * width * t;
    let force = figure(&held, "grip_2_force_x");
    println!("stretch {stretch:.4}: {force:.4} N, {wanted:.4} N");
    assert!(stretch > 1.45, "{stretch}");
    assert!((force / wanted - 1.0).abs() < 0.01, "{force} {wanted}");
    // What was pulled in is stored or damped.
    let ledger = &pulled.ledger;
    assert!(ledger.residual.abs() < 0.01 * ledger.grips, "{ledger:?}");
}

/// A metal sheet that a ball has struck keeps a dent; one that does not yield keeps none.
#[test]
fn a_sheet_that_yields_keeps_its_dent() {
    let depth = |hardening: Option<Hardening>| {
        let material = Material { young: 2e7, density: 2000.0, ..RUBBER };
        let law = SoftLaw::Shell { hardening, breaks: false };
        let mut body = sheet([0.3, 0.15, 4e-3], 0.0125, law, material);
        body.grips = vec![grip_x(-1.0, -0.13, vec![]), grip_x(0.13, 1.0, vec![])];
        body.damping = 0.2;
        (body.air.density, body.air.drag) = (20.0, 10.0);
        let setup = setup(body, Vec3::zeros());
        let prepared = prepare(&setup);
        let ball = free_ball(0.03, 0.1, Vec3::new(0.0, 0.0, 0.045), Vec3::new(0.0, 0.0, -3.0));
        let hit = solve(&prepared, None, 0, 24, vec![ball]);
        assert!(hit.handed[0].impulses.iter().map(|i| i[0].z).sum::<f64>() > 0.2);
        let after = solve(&prepared, Some(&hit.state), 24, 240, vec![]);
        let low = places(&after).iter().map(|x| x.z).fold(0.0, f64::min);
        (low, hit.ledger, after.ledger)
    };
    let flow = Hardening { yield_stress: 3e5, hardening: 1e6, exponent: 0.5 };
    let (dent, hit, after) = depth(Some(flow));
    println!("dent {dent:.2e} m, plastic work {:.2e} J of {:.2e} J", hit.plastic, hit.bodies);
    assert!(hit.plastic > 0.2 * hit.bodies, "{hit:?}");
    assert!(after.bending >= 0.0, "{after:?}");
    assert!(dent < -2e-3, "{dent}");
    assert!(hit.residual.abs() < 0.02 * hit.bodies, "{hit:?}");
    assert!(after.kinetic < 2e-2 * hit.plastic, "{after:?}");
    let (none, ..) = depth(None);
    assert!(none.abs() < 0.1 * dent.abs(), "{none} without yielding, {dent} with");
}

/// A shell with a softer material bends like the real one, and a heavier one hangs like it.
#[test]
fn a_slower_pace_keeps_how_a_strip_hangs() {
    let tip = |pace: MembranePace| {
        let material = Material { young: 2e6, poisson: 0.0, ..RUBBER };
        let mut body = sheet([0.2, 0.05, 4e-3], 0.0125, WHOLE, material);
        body.grips = vec![grip_x(-1.0, -0.08, vec![])];
        body.damping = 0.3;
        (body.air.density, body.air.drag) = (100.0, 10.0);
        body.pace = pace;
        let setup = setup(body, Vec3::new(0.0, 0.0, -9.81));
        let prepared = prepare(&setup);
        let outcome = solve(&prepared, None, 0, 8 * 240, vec![]);
        let low = places(&outcome).iter().map(|x| x.z).fold(0.0, f64::min);
        (low, figure(&outcome, "steps"))
    };
    let (real, steps) = tip(MembranePace::Real);
    assert!(real < -0.01, "{real}");
    for pace in [MembranePace::Softer(20.0), MembranePace::Heavier(20.0)] {
        let (low, fewer) = tip(pace);
        println!("{pace:?}: {low:.5} m in {fewer} steps, {real:.5} m in {steps}");
        assert!((low / real - 1.0).abs() < 0.03, "{pace:?}: {low} {real}");
        assert!(fewer < 0.8 * steps, "{pace:?}: {fewer} of {steps}");
    }
}
