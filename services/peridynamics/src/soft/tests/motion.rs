//! Motion: falls, spins, windows cut in halves, contact.

use super::*;
use cullet_geometry::{Mat3, Quat};
use cullet_model::ProxyMotion;

#[test]
fn a_block_falls_as_a_stone_does() {
    let mut setup = block([0.06; 3], 0.01, elastic());
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    body(&mut setup).velocity = Vec3::new(1.0, 0.0, 2.0);
    let prepared = prepared(&setup);
    let end = solved(&prepared, None, window(0, 240, vec![])).unwrap();
    let state = super::super::SoftSolidState::decode(&prepared, &end.state).unwrap();
    let moved = Vec3::new(1.0, 0.0, 2.0 - 0.5 * 9.81);
    for (x, at) in state.domain.places.iter().zip(&prepared.rest) {
        assert!((x - at - moved).norm() < 1e-9, "{}", x - at - moved);
    }
    assert!(end.ledger.stretching < 1e-12, "{:?}", end.ledger);
    // The picture falls along: its first frame is the body at rest, its last one second later.
    let [first, last] = [&end.frames[0], &end.frames[60]];
    assert_eq!((first.step, last.step), (0, 240));
    assert!((last.origin - first.origin - moved).norm() < 1e-6);
    let most = first.offsets.iter().map(|x| x[0].abs()).fold(0.0, f32::max);
    assert!((most - 0.03).abs() < 1e-5, "{most}");
}

/// Three turns, near the origin and 100 m from it: momenta and energy stay.
#[test]
fn a_spinning_block_keeps_momenta_and_energy_wherever_it_is() {
    let spin = Vec3::new(3.0, -4.0, 18.0);
    let steps = (3.0 * std::f64::consts::TAU / spin.norm() / WORLD_STEP).ceil() as u32;
    let mut found = Vec::new();
    for away in [0.0, 100.0] {
        let mut setup = block([0.10, 0.07, 0.05], 0.01, elastic());
        let part = body(&mut setup);
        (part.spin, part.velocity) = (spin, Vec3::new(0.5, 0.2, -0.1));
        part.material.young = 5e5;
        part.pose.translation.vector = Vec3::new(away, -away, away);
        let prepared = prepared(&setup);
        let first = solved(&prepared, None, window(0, 1, vec![])).unwrap().ledger;
        let end = solved(&prepared, None, window(0, steps, vec![])).unwrap();
        let ledger = end.ledger;
        let mass = ledger.mass;
        let [one, two] = [&first, &ledger].map(|it| Vec3::from(it.angular_momentum));
        let own = spin.norm() * mass * (0.01 + 0.0049) / 12.0;
        let lost = (one - two).norm() / own;
        let slid = Vec3::from(ledger.momentum_residual).norm() / (mass * 0.5);
        let energy = ledger.residual / (first.kinetic + first.stretching);
        println!("{away} m: angular {lost:.1e}, momentum {slid:.1e}, energy {energy:.1e}");
        // Places 100 m away are rounded to 1e-14 m: arms of a block of 0.1 m to 1e-13 of theirs.
        assert!(lost < 1e-9 * (1.0 + away), "{away}: {lost}");
        assert!(slid < 1e-11 && energy.abs() < 1e-3, "{away}: {slid}, {energy}");
        assert!(ledger.stretching < 0.05 * ledger.kinetic);
        found.push(ledger.stretching);
    }
    assert!((found[0] / found[1] - 1.0).abs() < 1e-3, "{found:?}");
}

/// A block thrown at a fixed wall beside a free body, with all that a state holds.
fn eventful() -> ContinuumSetup {
    let bonds = BondedSolid {
        hardening: Some(cullet_model::Hardening {
            yield_stress: 3e3,
            hardening: 4e4,
            exponent: 1.0,
        }),
        breaks: true,
        ..elastic()
    };
    let mut setup = block([0.08, 0.05, 0.05], 0.01, bonds);
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    let part = body(&mut setup);
    part.material.fracture_energy = 0.5;
    part.damping = 0.1;
    part.velocity = Vec3::new(0.0, 0.0, -0.5);
    part.air.density = 1.2;
    part.air.drag = 1.0;
    part.grips = vec![BodyGrip {
        until: Some(0.03),
        ..end_grip(0.02, 0.09, vec![(0.0, Vec3::zeros()), (0.1, Vec3::new(0.04, 0.0, 0.0))])
    }];
    let corner = |y: f64, z: f64| Vec3::new(-0.02, y, z);
    let corners = vec![corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    part.cuts = vec![cullet_model::BodyCut { corners }];
    setup
}

/// A box of this mass, or a fixed one.
fn stone(size: f64, place: Vec3, mass: Option<f64>) -> Proxy {
    let side = |k: usize, bit: usize| if k >> bit & 1 == 1 { 0.5 * size } else { -0.5 * size };
    let corners = (0..8).map(|k| Vec3::new(side(k, 0), side(k, 1), side(k, 2))).collect();
    let motion = match mass {
        Some(mass) => {
            let inertia = Mat3::identity() * (mass * size * size / 6.0);
            ProxyMotion::Free { mass, inertia }
        }
        None => ProxyMotion::Steady,
    };
    Proxy {
        body: if mass.is_some() { 2 } else { 1 },
        object: None,
        parts: vec![corners],
        friction: 0.5,
        pose: Pose::from_parts(place.into(), Quat::identity()),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        motion,
    }
}

#[test]
fn windows_in_halves_and_other_numbers_of_threads_give_the_same_bits() {
    let prepared = prepared(&eventful());
    let wall = || vec![stone(0.5, Vec3::new(0.0, 0.0, -0.28), None)];
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solved(&prepared, None, window(0, 12, wall())).unwrap())
    };
    let [one, three] = [run(1), run(3)];
    assert_eq!(one, three);
    let figure = figure(&one, "plastic_strain");
    assert!(
        figure > 0.0 && one.ledger.broken > 0.0 && one.ledger.bodies != 0.0,
        "{:?}",
        one.ledger
    );
    let half = solved(&prepared, None, window(0, 5, wall())).unwrap();
    let rest = solved(&prepared, Some(&half.state), window(5, 7, wall())).unwrap();
    assert_eq!(rest.state, one.state);
    let last = |all: &WindowOutcome| all.frames.last().unwrap().offsets.clone();
    assert_eq!(last(&rest), last(&one));
}

#[test]
fn foreign_and_broken_states_are_refused() {
    let setup = eventful();
    let prepared = prepared(&setup);
    let wall = vec![stone(0.5, Vec3::new(0.0, 0.0, -0.28), None)];
    let bytes = solved(&prepared, None, window(0, 4, wall)).unwrap().state;
    let open = |prepared: &Arc<PreparedSoftSolid>, bytes: &[u8]| {
        let window = window(4, 1, vec![]);
        SoftSolidWindow::open(Arc::clone(prepared), Some(bytes), window).err()
    };
    assert_eq!(open(&prepared, &bytes), None);
    let mut other = setup;
    other.seed = 8;
    let why = |refusal: Option<cullet_model::Refusal>| refusal.unwrap().to_string();
    let foreign = why(open(&super::prepared(&other), &bytes));
    assert!(foreign.contains("another body"), "{foreign}");
    for length in [0, 1, 8, 100, bytes.len() / 2, bytes.len() - 1] {
        let cut = why(open(&prepared, &bytes[..length]));
        assert!(cut.contains("cut short"), "{length}: {cut}");
    }
    let mut more = bytes.clone();
    more.push(0);
    assert!(why(open(&prepared, &more)).contains("after its end"));
    let mut version = bytes.clone();
    version[0] = 9;
    assert!(why(open(&prepared, &version)).contains("version 9"));
    let late = SoftSolidWindow::open(Arc::clone(&prepared), Some(&bytes), window(5, 1, vec![]));
    assert!(why(late.err()).contains("step 4"));
}

/// A stone is thrown at a block that is clamped at one end: what the stone loses, the block and the
/// clamp gain.
#[test]
fn a_thrown_body_and_a_clamped_block_exchange_momentum_exactly() {
    let mut setup = block([0.12, 0.06, 0.06], 0.01, elastic());
    body(&mut setup).grips = vec![end_grip(-0.07, -0.04, vec![])];
    body(&mut setup).damping = 0.1;
    let prepared = prepared(&setup);
    let mut thrown = stone(0.04, Vec3::new(0.04, 0.0, 0.051), Some(0.05));
    thrown.velocity = Vec3::new(0.2, 0.1, -1.5);
    let end = solved(&prepared, None, window(0, 24, vec![thrown])).unwrap();
    let given: Vec3 = end.handed[0].impulses.iter().map(|pair| pair[0]).sum();
    assert!(given.z > 0.075, "it bounced: {given}");
    let held = ["x", "y", "z"].map(|axis| figure(&end, &format!("grip_1_force_{axis}")) * 0.1);
    let off = Vec3::from(end.ledger.momentum) + given - Vec3::from(held);
    assert!(off.norm() < 1e-12, "{off}");
    let scale = 0.05 * 1.5 * 1.5;
    assert!(end.ledger.residual.abs() < 0.01 * scale, "{:?}", end.ledger);
    assert!(end.warnings.is_empty(), "{:?}", end.warnings);
}

/// A block dropped on a plate comes to rest with its surface on it, and freezes.
#[test]
fn a_block_rests_with_its_surface_on_a_plate() {
    let mut setup = block([0.06, 0.06, 0.04], 0.01, BondedSolid { air_damping: 8.0, ..elastic() });
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    body(&mut setup).damping = 0.2;
    let prepared = prepared(&setup);
    let plate = vec![stone(0.5, Vec3::new(0.0, 0.0, -0.272), None)];
    let end = solved(&prepared, None, window(0, 360, plate)).unwrap();
    assert!(end.pieces[0].frozen, "{:?}", end.pieces);
    let frame = end.frames.last().unwrap();
    let lowest = frame.offsets.iter().map(|x| f64::from(x[2]) + frame.origin.z);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    // The plate's top is at -0.022 m.
    assert!((lowest + 0.022).abs() < 0.001, "{lowest}");
}

/// Nothing carries it: at the top of its way what flies is as slow as what lies.
#[test]
fn a_block_in_free_flight_is_never_at_rest() {
    let prepared = prepared(&block([0.06, 0.06, 0.06], 0.015, elastic()));
    let outcome = solved(&prepared, None, window(0, 150, vec![])).unwrap();
    assert!(outcome.extent.speed < 1e-9, "{:?}", outcome.extent);
    assert!(outcome.pieces.iter().all(|piece| !piece.frozen), "{:?}", outcome.pieces);
}
