//! Several quantities in one sheet, and what comes into it from bodies that touch it.

use super::{begun, figure, grip, harmless, setup, solve, window, with};
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::steps::SheetRun;
use cullet_geometry::math::unit;
use cullet_geometry::{Pose, Vec3};
use cullet_model::{
    Continuum, ContinuumSetup, Proxy, ProxyMotion, SheetDiffusion, SheetQuantities, SheetRegion,
    SheetSource, SheetSourceKind, Window, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// The object of the scene that a hot body is.
const IRON: u32 = 3;
/// θ of that body, and what its film lets through by the sheet's capacity and thickness \[1/s\].
const HOT: f64 = 50.0;
const RATE: f64 = 5.0;

/// Several quantities by these names.
fn several(all: Vec<(&str, SheetDiffusion)>) -> SheetQuantities {
    let (names, all) = all.into_iter().map(|(name, what)| (name.to_owned(), what)).unzip();
    SheetQuantities { all, names, shown: 0 }
}

fn around(centre: [f64; 2]) -> SheetRegion {
    SheetRegion::Disc { centre, radius: 0.02 }
}

/// Heat and water that change nothing of the sheet.
fn heat_and_water() -> [SheetDiffusion; 2] {
    let heat = SheetDiffusion {
        conductivity: [4e-3, 1e-3],
        loss: 1e-4,
        ambient: -0.2,
        ..harmless(vec![(around([0.05, 0.05]), SheetSourceKind::Held(2.0))])
    };
    let water = SheetDiffusion {
        start: 0.1,
        saturation: 0.6,
        exposure: 0.5,
        ..harmless(vec![(around([0.12, 0.04]), SheetSourceKind::Flux(0.05))])
    };
    [heat, water]
}

/// What nothing couples does not meet: θ of each has the bits that it has alone.
#[test]
fn quantities_that_nothing_couples_do_not_touch_one_another() {
    let [heat, water] = heat_and_water();
    let solved = |all: Vec<(&str, SheetDiffusion)>| {
        let prepared = Arc::new(
            PreparedMembrane::new(&with(setup(), |s| s.diffusion = several(all))).unwrap(),
        );
        let outcome = solve(&prepared, None, window(0, 6));
        (SheetState::decode(&prepared, &outcome.state).unwrap(), outcome)
    };
    let (alone, _) = solved(vec![("heat", heat.clone())]);
    let (wet, wet_outcome) = solved(vec![("water", water.clone())]);
    let (both, outcome) = solved(vec![("heat", heat.clone()), ("water", water.clone())]);
    let (turned, _) = solved(vec![("water", water), ("heat", heat)]);
    let bits = |all: &[f64]| all.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(both.theta_of(0)), bits(&alone.theta));
    assert_eq!(bits(both.theta_of(1)), bits(&wet.theta));
    assert_eq!(bits(turned.theta_of(1)), bits(&alone.theta));
    assert_eq!(bits(&both.exposure[wet.theta.len()..]), bits(&wet.exposure));
    assert!(alone.theta.iter().any(|t| *t > 1.0) && wet.theta.iter().any(|t| *t > 0.2));
    // The books of each are its own; the ledger has the one that is shown.
    assert_eq!(figure(&outcome, "heat_in"), outcome.ledger.quantity_in);
    assert_eq!(figure(&outcome, "water_in"), wet_outcome.ledger.quantity_in);
    assert_eq!(figure(&outcome, "water_total"), wet_outcome.ledger.quantity);
    assert!(wet_outcome.figures.iter().all(|figure| !figure.name.starts_with("water")));
}

/// Frames carry the θ of the quantity that is shown, and the ledger its integral.
#[test]
fn the_quantity_that_is_shown_is_in_frames_and_in_the_ledger() {
    let shown = |shown: u32| {
        let all = heat_and_water().map(|what| SheetDiffusion { sources: vec![], ..what });
        let [heat, water] = all;
        let mut both = several(vec![("heat", heat), ("water", water)]);
        both.shown = shown;
        let prepared = PreparedMembrane::new(&with(setup(), |sheet| sheet.diffusion = both));
        let frames = Window { frame_every: 1, ..window(0, 1) };
        prepared.map(|prepared| solve(&Arc::new(prepared), None, frames))
    };
    let outcome = shown(1).unwrap();
    assert!(outcome.frames[0].quantity.iter().all(|t| *t == 0.1));
    assert!((outcome.ledger.quantity / (0.1 * 0.02 * 1e-3) - 1.0).abs() < 1e-9);
    assert!(shown(0).unwrap().frames[0].quantity.iter().all(|t| *t == 0.0));
    let refused = shown(2).err().map(|why| why.to_string()).unwrap_or_default();
    assert!(refused.contains("quantity that it shows"), "{refused}");
}

/// Shares that are left multiply; strains and masses add.
#[test]
fn effects_of_several_come_together() {
    let own = |share: f64, expansion: [f64; 2], weight: f64| SheetDiffusion {
        stiffness: vec![(0.0, 1.0), (1.0, share)],
        toughness: vec![(0.0, 1.0), (1.0, 0.5 * share)],
        expansion,
        weight,
        ..harmless(vec![])
    };
    let all = vec![
        ("a", own(0.5, [0.02, 0.01], 300.0)),
        ("b", own(0.4, [-0.05, 0.03], 0.0)),
        ("c", own(0.9, [0.01, 0.0], 100.0)),
    ];
    let run = begun(&with(setup(), |sheet| sheet.diffusion = several(all)), |state| {
        state.theta.iter_mut().for_each(|theta| *theta = 1.0);
    });
    let (bonds, close) = (&run.prepared.bonds, |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12);
    let whole = run.prepared.limits();
    for b in 0..bonds.ends.len() {
        let [x, y] = bonds.directions[b];
        let strain = -0.02 * x * x + 0.04 * y * y;
        assert!(close(run.table.stiffness[b], 0.18 * bonds.stiffness[b]));
        assert!(close(run.table.rest[b], 1.0 / (bonds.lengths[b] * (1.0 + strain))));
        // s_c is the root of G over E.
        let critical = (0.125 * 0.18 / 0.18_f64).sqrt() * whole.critical;
        assert!(close(run.table.limits[b].critical, critical));
    }
    assert!(run.table.softness.iter().all(|&q| close(q, 0.18)));
    let mass: f64 = run.masses.iter().map(|m| m[0]).sum();
    assert!(close(mass, 0.02 * 1.4), "{mass}");
}

/// The strains of two add up to more than a bond can follow, though neither does by itself.
#[test]
fn strains_that_add_up_to_too_much_end_a_window() {
    let own = |start| SheetDiffusion {
        expansion: [0.3; 2],
        start,
        ..harmless(vec![(around([0.1, 0.05]), SheetSourceKind::Held(start + 1.0))])
    };
    let swelling = |all: Vec<(&str, SheetDiffusion)>| {
        let setup = with(setup(), |sheet| {
            sheet.diffusion = several(all);
            sheet.grips = vec![grip([-1.0; 2], [1.0; 2], vec![])];
        });
        let prepared = Arc::new(PreparedMembrane::new(&setup).unwrap());
        let mut run =
            crate::MembraneWindow::open(prepared, None, window(0, 1)).expect("a window opens");
        loop {
            match Continuum::advance(&mut run) {
                WindowProgress::Running(_) => {}
                WindowProgress::Failed(why) => return why.to_string(),
                _ => return String::new(),
            }
        }
    };
    assert_eq!(swelling(vec![("a", own(0.0))]), "");
    let told = swelling(vec![("a", own(0.0)), ("b", own(2.0))]);
    assert!(told.contains("1.000e0 and 3.000e0, strains it by 0.600"), "{told}");
}

/// A sheet that is held all over, with what comes from bodies that touch it.
fn held(more: Vec<SheetSource>) -> ContinuumSetup {
    let contact = SheetSource {
        region: SheetRegion::Box { low: [-1.0; 2], high: [1.0; 2] },
        from: 0.0,
        until: f64::INFINITY,
        kind: SheetSourceKind::Contact { object: IRON, towards: HOT, film: 2.0 * RATE * 1e-3 },
    };
    with(setup(), |sheet| {
        sheet.spacing = 0.01;
        sheet.grips = vec![grip([-1.0; 2], [1.0; 2], vec![])];
        sheet.diffusion = Some(SheetDiffusion {
            capacity: 2.0,
            conductivity: [1e-12; 2],
            sources: [vec![contact], more].concat(),
            ..harmless(vec![])
        })
        .into();
    })
}

/// A block of 20 × 400 × 20 mm over the sheet, which it touches where it is low; it slides along x.
fn iron(x: f64, height: f64, speed: f64) -> Proxy {
    let corner = |k: u32| Vec3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1) - 0.5));
    Proxy {
        body: 7,
        object: Some(IRON),
        parts: vec![(0..8).map(|k| corner(k).component_mul(&Vec3::new(0.02, 0.4, 0.02))).collect()],
        friction: 0.0,
        pose: Pose::translation(x, 0.05, 0.01 + height),
        velocity: Vec3::new(speed, 0.0, 0.0),
        spin: Vec3::zeros(),
        motion: ProxyMotion::Steady,
    }
}

fn pressed(setup: &ContinuumSetup, proxies: Vec<Proxy>) -> (SheetState, Box<WindowOutcome>) {
    let prepared = Arc::new(PreparedMembrane::new(setup).unwrap());
    let outcome = solve(&prepared, None, Window { proxies, ..window(0, 96) });
    (SheetState::decode(&prepared, &outcome.state).unwrap(), outcome)
}

/// What a sliding iron gives is what the sheet has more; it heats the strip that it slid over, each
/// point for as long as it was on it, and nothing else.
#[test]
fn a_moving_contact_heats_where_it_touched() {
    let setup = held(vec![]);
    let (speed, height) = (0.2, 1e-3);
    let (state, outcome) = pressed(&setup, vec![iron(0.06, height, speed)]);
    let ledger = &outcome.ledger;
    assert!(ledger.quantity_in > 0.0, "{ledger:?}");
    assert!((ledger.quantity / ledger.quantity_in - 1.0).abs() < 1e-9, "{ledger:?}");
    let places = &PreparedMembrane::new(&setup).unwrap().points.places;
    // It stands over [0.05, 0.07] at first, and over [0.13, 0.15] after 0.4 s; the corner of a
    // block touches from the contact distance, 1.5 mm.
    let round = 1.5e-3;
    let due = 1.0 - libm::exp(-RATE * 0.02 / speed);
    let mut whole = 0;
    for (place, theta) in places.iter().zip(&state.theta) {
        let share = theta / HOT;
        if place[0] < 0.05 - round || place[0] > 0.15 + round {
            assert!(share < 1e-6, "{place:?} {share}");
        } else if place[0] > 0.07 + round && place[0] < 0.13 - round {
            whole += 1;
            assert!((share / due - 1.0).abs() < 0.15, "{place:?} {share} {due}");
        }
    }
    assert!(whole > 20, "{whole}");
}

/// A body that is out of reach of contact, or none of the object's, gives nothing.
#[test]
fn only_bodies_of_the_object_that_touch_give() {
    let none = |iron: Proxy| pressed(&held(vec![]), vec![iron]).1.ledger.quantity_in;
    assert_eq!(none(iron(0.1, 1.6e-3, 0.0)), 0.0);
    assert!(none(iron(0.1, 1.4e-3, 0.0)) > 0.0);
    assert_eq!(none(Proxy { object: Some(IRON + 1), ..iron(0.1, 1e-3, 0.0) }), 0.0);
    assert_eq!(none(Proxy { object: None, ..iron(0.1, 1e-3, 0.0) }), 0.0);
    // Two fragments of it on one place count as one body.
    let (one, _) = pressed(&held(vec![]), vec![iron(0.1, 1e-3, 0.0)]);
    let second = Proxy { body: 8, ..iron(0.1, 1e-3, 0.0) };
    let (two, _) = pressed(&held(vec![]), vec![iron(0.1, 1e-3, 0.0), second]);
    assert_eq!(one.theta, two.theta);
}

/// A contact may be anywhere, so it bounds the step everywhere: with a film that would overshoot
/// within a step of the world, θ stays below what it goes towards.
#[test]
fn steps_are_stable_under_a_thick_film() {
    let step = |film: f64, object: u32| {
        let kind = SheetSourceKind::Contact { object, towards: HOT, film };
        let region = SheetRegion::Box { low: [-1.0; 2], high: [1.0; 2] };
        let more = SheetSource { region, from: 0.0, until: 1.0, kind };
        let setup = held(vec![more]);
        (setup.clone(), PreparedMembrane::new(&setup).unwrap().diffusion[0].step)
    };
    let (setup, found) = step(3.0, IRON);
    assert!((found / (0.5 * 2e-3 / (3.0 + 2.0 * RATE * 1e-3)) - 1.0).abs() < 1e-6, "{found}");
    let (state, outcome) = pressed(&setup, vec![iron(0.1, 1e-3, 0.0)]);
    let most = state.theta.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.99 * HOT && most <= HOT, "{most}");
    assert!((outcome.ledger.quantity / outcome.ledger.quantity_in - 1.0).abs() < 1e-9);
}

/// Windows of any length give the same bits while something touches.
#[test]
fn windows_with_contacts_give_the_bytes_of_a_whole_one() {
    let prepared = Arc::new(PreparedMembrane::new(&held(vec![])).unwrap());
    let on = |first, steps, x| {
        let place = x + 0.2 * first as f64 * prepared.setup.world_step;
        Window { proxies: vec![iron(place, 1e-3, 0.2)], ..window(first, steps) }
    };
    let whole = solve(&prepared, None, on(0, 8, 0.06));
    let first = solve(&prepared, None, on(0, 3, 0.06));
    let state = SheetState::decode(&prepared, &first.state).unwrap();
    assert!(state.theta.iter().any(|t| *t > 0.0));
    // The iron's own place is the rounding of another sum: what matters is who touches.
    let second = solve(&prepared, Some(&first.state), on(3, 5, 0.06));
    let [one, two] = [&whole, &second].map(|it| SheetState::decode(&prepared, &it.state).unwrap());
    assert_eq!(one.theta, two.theta);
}

/// A sheet of three quantities comes back from its bytes.
#[test]
fn a_state_of_several_is_kept() {
    let [heat, water] = heat_and_water();
    let all = vec![("heat", heat.clone()), ("water", water), ("acid", heat)];
    let run: SheetRun = begun(&with(setup(), |sheet| sheet.diffusion = several(all)), |state| {
        let both = state.theta.iter_mut().chain(&mut state.exposure).enumerate();
        both.for_each(|(i, value)| *value = unit(5, 0, i as u64));
    });
    let bytes = run.state.encode(&run.prepared);
    let back = SheetState::decode(&run.prepared, &bytes).unwrap();
    assert_eq!(back, run.state);
    assert_eq!(back.theta.len(), 3 * back.places.len());
}
