use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::tests::{grip, setup, solve, window, with};
use cullet_geometry::{Mat3, Pose, Vec3};
use cullet_model::{
    Continuum, ContinuumSetup, MembraneLaw, MembranePace, Proxy, ProxyMotion, SheetDiffusion,
    SheetRegion, SheetSource, SheetSourceKind, Window, WindowProgress,
};
use std::sync::Arc;

fn prepared(setup: &ContinuumSetup) -> Arc<PreparedMembrane> {
    Arc::new(PreparedMembrane::new(setup).unwrap())
}

/// A sheet takes memory by its points: the cache of prepared sheets counts on it.
#[test]
fn memory_goes_with_the_number_of_points() {
    let of = |spacing: f64| {
        let prepared = prepared(&with(setup(), |sheet| sheet.spacing = spacing));
        crate::MembraneWindow::bytes(&prepared) as f64 / prepared.points.places.len() as f64
    };
    let [few, many] = [4e-3, 2e-3].map(of);
    assert!((0.8..1.3).contains(&(many / few)), "{few} and {many} bytes a point");
    assert!((500.0..20_000.0).contains(&many), "{many} bytes a point");
}

/// A ball as a hull.
fn ball(radius: f64) -> Vec<Vec3> {
    let golden = 2.399963229728653;
    (0..48)
        .map(|k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 48.0;
            let (sin, cos) = (golden * f64::from(k)).sin_cos();
            let rho = (1.0 - z * z).sqrt();
            Vec3::new(rho * cos, rho * sin, z) * radius
        })
        .collect()
}

fn striker(height: f64, speed: f64) -> Proxy {
    Proxy {
        body: 7,
        object: None,
        parts: vec![ball(0.015)],
        friction: 0.3,
        pose: Pose::translation(0.1, 0.05, height),
        velocity: Vec3::new(0.0, 0.0, -speed),
        spin: Vec3::new(3.0, 0.0, 1.0),
        motion: ProxyMotion::Free { mass: 0.02, inertia: Mat3::identity() * 2e-6 },
    }
}

fn pinned() -> ContinuumSetup {
    let mut setup = with(setup(), |sheet| {
        sheet.grips = [[0.0, 0.0], [0.19, 0.0], [0.0, 0.09], [0.19, 0.09]]
            .map(|[x, y]| grip([x, y], [x + 0.01, y + 0.01], vec![]))
            .to_vec();
        sheet.material.bending_floor = 0.3;
    });
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    setup
}

/// T15: two half windows give the bytes of one, with foil that flows and tears, and with a body
/// that meets nothing.
#[test]
fn half_windows_give_the_bytes_of_a_whole_one() {
    for law in [MembraneLaw::Brittle, MembraneLaw::Foil, MembraneLaw::Rubber] {
        let pulled = |sign: f64| vec![(0.0, Vec3::zeros()), (1.0, Vec3::new(0.0, 0.0, 3.0 * sign))];
        let setup = with(pinned(), |sheet| {
            sheet.material.law = law;
            sheet.material.fracture_energy = 20.0;
            sheet.material.strength = 5e4;
            sheet.air.density = 1.2;
            sheet.air.gusts = [1.0, 30.0];
            sheet.air.wind = Vec3::new(1.0, 0.0, 2.0);
            sheet.notches = vec![vec![[0.1, 0.11], [0.1, 0.05]]];
            sheet.grips = vec![
                grip([0.0, 0.09], [0.09, 0.1], pulled(1.0)),
                grip([0.11, 0.09], [0.2, 0.1], pulled(-1.0)),
            ];
        });
        let prepared = prepared(&setup);
        let far = Proxy { pose: Pose::translation(0.1, 0.05, 5.0), ..striker(5.0, 0.0) };
        let with_far = |window: Window| Window { proxies: vec![far.clone()], ..window };
        let whole = solve(&prepared, None, with_far(window(0, 8)));
        let first = solve(&prepared, None, window(0, 4));
        let second = solve(&prepared, Some(&first.state), window(4, 4));
        assert!(whole.ledger.torn_area > 0.0, "{law:?} did not tear");
        assert!(whole.state == second.state, "{law:?}");
        assert!(whole.state != first.state);
    }
}

#[test]
fn foreign_and_truncated_states_are_refused() {
    let prepared = prepared(&pinned());
    let state = solve(&prepared, None, window(0, 1)).state;
    let refused = |bytes: &[u8]| {
        let run = crate::MembraneWindow::open(Arc::clone(&prepared), Some(bytes), window(1, 1));
        run.err().map(|refusal| refusal.to_string()).unwrap_or_default()
    };
    assert!(refused(&state[..state.len() - 1]).contains("cut short"));
    assert!(refused(&[&state[..], &[0]].concat()).contains("after its end"));
    let mut other = state.clone();
    other[0] = 9;
    assert!(refused(&other).contains("version"));
    let other = Arc::new(PreparedMembrane::new(&setup()).unwrap());
    let bytes = solve(&other, None, window(0, 1)).state;
    assert!(refused(&bytes).is_empty() || refused(&bytes).contains("another sheet"));
    assert_eq!(refused(&state), "");
}

/// The kernel's whole numbers hold no more: the window fails before they wrap around.
#[test]
fn a_sheet_that_is_stretched_beyond_all_measure_fails() {
    let elastic = with(setup(), |sheet| sheet.material.fracture_energy = 1e9);
    let prepared = prepared(&elastic);
    for (stretch, fails) in [(8.0, false), (25.0, true)] {
        let mut state = SheetState::start(&prepared);
        state.places.iter_mut().for_each(|x| *x *= stretch);
        let bytes = state.encode(&prepared);
        let mut run =
            crate::MembraneWindow::open(Arc::clone(&prepared), Some(&bytes), window(0, 1)).unwrap();
        let end = loop {
            match Continuum::advance(&mut run) {
                WindowProgress::Running(_) => {}
                end => break end,
            }
        };
        match end {
            WindowProgress::Failed(failure) => {
                assert!(fails && failure.to_string().contains("16 horizons"), "{failure}");
            }
            _ => assert!(!fails, "{stretch}"),
        }
    }
}

/// A ball falls on a sheet that is held at four pins: what it gets is what the sheet loses.
#[test]
fn a_ball_and_a_sheet_exchange_momentum() {
    let prepared = prepared(&pinned());
    let window = Window { proxies: vec![striker(0.02, 2.0)], ..window(0, 12) };
    let outcome = solve(&prepared, None, window);
    let handed = &outcome.handed[0];
    let given: Vec3 = handed.impulses.iter().map(|[impulse, _]| impulse).sum();
    assert!(given.z > 0.01, "{given:?}");
    let ledger = &outcome.ledger;
    assert!(Vec3::from(ledger.momentum_residual).norm() < 1e-12, "{ledger:?}");
    assert!(ledger.residual.abs() < 0.02 * ledger.bodies.abs(), "{ledger:?}");
    // Its own motion: gravity and what it was given, at their own steps.
    let step = prepared.setup.world_step;
    let mut velocity = Vec3::new(0.0, 0.0, -2.0);
    let mut place = Vec3::new(0.1, 0.05, 0.02);
    for [impulse, _] in &handed.impulses {
        let next = velocity + impulse / 0.02 + prepared.setup.gravity * step;
        place += 0.5 * (velocity + next) * step;
        velocity = next;
    }
    assert!((place - handed.poses.last().expect("a pose").translation.vector).norm() < 2e-3);
    assert!(outcome.figures.iter().any(|f| f.name == "body_7_depth" && f.value < 1e-3));
}

/// Where nothing else acts, the ball gets what the sheet loses.
#[test]
fn a_ball_and_a_free_sheet_keep_their_momentum() {
    let prepared = prepared(&setup());
    let mut ball = striker(0.02, 2.0);
    ball.pose = Pose::translation(0.12, 0.05, 0.02);
    let outcome = solve(&prepared, None, Window { proxies: vec![ball], ..window(0, 6) });
    let handed = &outcome.handed[0];
    let given: Vec3 = handed.impulses.iter().map(|[impulse, _]| impulse).sum();
    let turned: Vec3 = handed.impulses.iter().map(|[_, moment]| moment).sum();
    let sum = Vec3::from(outcome.ledger.momentum) + given;
    assert!(given.z > 0.01 && turned.norm() > 1e-8, "{given:?} {turned:?}");
    assert!(sum.norm() < 1e-13, "{sum:?}");
}

/// Neither the number of threads nor that of tasks on them changes a bit.
#[test]
fn threads_change_no_bit() {
    let setup = with(pinned(), |sheet| {
        sheet.outline = vec![[0.0, 0.0], [0.3, 0.0], [0.3, 0.15], [0.0, 0.15]];
        sheet.material.poisson = 0.2;
        sheet.air.pressure = 40.0;
        sheet.air.density = 1.2;
    });
    let prepared = prepared(&setup);
    assert!(prepared.points.places.len() > 3 * 512);
    let solved = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let again = Arc::new(PreparedMembrane::new(&setup).unwrap());
            solve(&again, None, window(0, 2))
        })
    };
    let one = solved(1);
    let three = solved(3);
    assert!(one.state == three.state);
    assert_eq!(one.ledger, three.ledger);
}

/// A softer sheet has its waves and G, and what it breaks at grows with it; a heavier one has its
/// weight.
#[test]
fn paces_keep_what_they_should() {
    let stiff = |pace| {
        with(setup(), |sheet| {
            sheet.material.young = 1e8;
            sheet.material.strength = 1e6;
            sheet.pace = pace;
        })
    };
    let real = prepared(&stiff(MembranePace::Real));
    let soft = prepared(&stiff(MembranePace::Softer(150.0)));
    let heavy = prepared(&stiff(MembranePace::Heavier(31.6)));
    let slower = 1e5_f64.sqrt() / 150.0;
    // Bending stays as it is, and takes its part of the step.
    let longer = soft.stable / real.stable;
    assert!(longer > 0.85 * slower && longer < slower, "{longer}");
    assert!((soft.critical / real.critical / slower - 1.0).abs() < 1e-9);
    let ratio = |sheet: &PreparedMembrane| sheet.limits().first / sheet.limits().critical;
    assert!((ratio(&soft) / ratio(&real) - 1.0).abs() < 1e-9);
    assert_eq!(soft.bending, real.bending);
    let outcome = solve(&heavy, None, window(0, 1));
    assert!((outcome.ledger.mass / 0.02 - 1.0).abs() < 1e-9);
    let speed = outcome.figures.iter().find(|f| f.name == "working_wave_speed").unwrap();
    assert_eq!((speed.value, speed.unit.as_str()), (31.6, "m/s"));
    assert!(heavy.stable > 9.9 * real.stable);
    assert!(PreparedMembrane::new(&stiff(MembranePace::Softer(30.0))).is_err());
}

/// What a wet sheet takes up weighs, swells it, and moves with it.
#[test]
fn water_has_weight_and_momentum() {
    let mut setup = with(setup(), |sheet| {
        sheet.velocity = Vec3::new(1.0, 0.0, 0.0);
        sheet.diffusion = Some(SheetDiffusion {
            capacity: 1.0,
            conductivity: [1e-6; 2],
            expansion: [0.01, 0.01],
            start: 0.0,
            saturation: 0.5,
            stiffness: vec![(0.0, 1.0), (0.5, 0.4)],
            toughness: vec![(0.0, 1.0), (0.5, 0.1)],
            strength: vec![],
            exposure: 0.0,
            weight: 800.0,
            loss: 0.0,
            ambient: 0.0,
            sources: vec![SheetSource {
                region: SheetRegion::Disc { centre: [0.1, 0.05], radius: 0.03 },
                from: 0.0,
                until: 1.0,
                kind: SheetSourceKind::Flux(0.01),
            }],
        })
        .into();
    });
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    let prepared = prepared(&setup);
    let whole = solve(&prepared, None, window(0, 8));
    let ledger = &whole.ledger;
    let gained = ledger.mass - 0.02;
    assert!(gained > 1e-5, "{gained}");
    assert!((gained / (800.0 * ledger.quantity) - 1.0).abs() < 1e-9);
    assert!((ledger.quantity / ledger.quantity_in - 1.0).abs() < 1e-12);
    // It arrives where the sheet swells and moves a little.
    assert!((ledger.momentum[0] / ledger.mass - 1.0).abs() < 1e-5, "{ledger:?}");
    assert!(Vec3::from(ledger.momentum_residual).norm() < 1e-14, "{ledger:?}");
    assert!(ledger.residual.abs() < 1e-3 * ledger.kinetic, "{ledger:?}");
    let first = solve(&prepared, None, window(0, 3));
    let second = solve(&prepared, Some(&first.state), window(3, 5));
    assert!(whole.state == second.state);
}

/// A strip that is laid upon itself stays apart; without contact its halves would fall through.
#[test]
fn a_fold_does_not_fall_through_itself() {
    let mut setup = with(setup(), |sheet| {
        sheet.grips = vec![grip([0.0, 0.0], [0.09, 0.1], vec![])];
        sheet.material.damping = 0.5;
    });
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    let prepared = prepared(&setup);
    let mut state = SheetState::start(&prepared);
    let bend = 0.004;
    for x in state.places.iter_mut().filter(|x| x.x > 0.1) {
        let along = x.x - 0.1;
        let angle = (along / bend).min(std::f64::consts::PI);
        let flat = (along - std::f64::consts::PI * bend).max(0.0);
        x.x = 0.1 + bend * angle.sin() - flat;
        x.z = bend * (1.0 - angle.cos());
    }
    let outcome = solve(&prepared, Some(&state.encode(&prepared)), window(0, 24));
    let end = SheetState::decode(&prepared, &outcome.state).unwrap();
    // What has slid off the held half hangs down.
    let above = |(p, x): &(&[f64; 2], &Vec3)| p[0] > 0.13 && x.x < 0.085;
    let upper = prepared.points.places.iter().zip(&end.places).filter(above);
    assert!(upper.clone().count() > 50);
    let lowest = upper.map(|(_, x)| x.z).fold(f64::INFINITY, f64::min);
    assert!(lowest > 2e-3, "{lowest}");
    assert!(outcome.ledger.residual.abs() < 0.02 * outcome.ledger.gravity.abs());
}

/// A sheet that lies on a floor is frozen after half a second, and wakes when a ball comes.
#[test]
fn a_piece_at_rest_is_frozen_until_something_comes() {
    let mut setup = with(setup(), |sheet| {
        sheet.pose = Pose::translation(0.0, 0.0, 0.0016);
        sheet.material.damping = 0.5;
        sheet.spacing = 0.01;
    });
    setup.gravity = Vec3::new(0.0, 0.0, -9.81);
    let prepared = prepared(&setup);
    let corner = |k: u32| Vec3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1) - 0.5));
    let floor = Proxy {
        body: 1,
        object: None,
        parts: vec![(0..8).map(|k| corner(k).component_mul(&Vec3::new(1.0, 1.0, 0.2))).collect()],
        pose: Pose::translation(0.1, 0.05, -0.1),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        motion: ProxyMotion::Steady,
        ..striker(0.0, 0.0)
    };
    let on = |first, steps, proxies| Window { proxies, ..window(first, steps) };
    let whole = solve(&prepared, None, on(0, 200, vec![floor.clone()]));
    assert!(whole.pieces[0].frozen, "{:?}", whole.ledger);
    assert_eq!(whole.ledger.kinetic, 0.0);
    let first = solve(&prepared, None, on(0, 130, vec![floor.clone()]));
    let second = solve(&prepared, Some(&first.state), on(130, 70, vec![floor.clone()]));
    assert!(second.state == whole.state);
    let ball = striker(0.03, 1.0);
    let third = solve(&prepared, Some(&whole.state), on(200, 4, vec![floor, ball]));
    assert!(!third.pieces[0].frozen && third.ledger.kinetic > 0.0, "{:?}", third.ledger);
}

/// A sheet on a base swings as one with √(k_b/ρh), and the base stores what it takes.
#[test]
fn a_base_pulls_a_sheet_back_and_stores_what_that_takes() {
    let by_area = 1e4;
    let setup = with(setup(), |sheet| {
        sheet.foundation = Some(by_area);
        sheet.velocity = Vec3::new(0.3, 0.0, 0.4);
    });
    let prepared = prepared(&setup);
    let outcome = solve(&prepared, None, window(0, 24));
    let end = SheetState::decode(&prepared, &outcome.state).unwrap();
    let rate = (by_area / (1000.0 * 1e-3_f64)).sqrt();
    let time = 24.0 * prepared.setup.world_step;
    for (p, x) in prepared.points.places.iter().zip(&end.places) {
        let moved = x - Vec3::new(p[0], p[1], 0.0);
        let due = prepared.sheet().velocity * ((rate * time).sin() / rate);
        assert!((moved - due).norm() < 1e-3 * due.norm(), "{moved} {due}");
    }
    let ledger = &outcome.ledger;
    let whole = 0.5 * ledger.mass * 0.25;
    assert!(((ledger.kinetic + ledger.stretching) / whole - 1.0).abs() < 1e-3, "{ledger:?}");
    assert!(ledger.stretching > 0.1 * whole && ledger.bodies.abs() < 1e-9 * whole, "{ledger:?}");
    assert!(ledger.residual.abs() < 1e-3 * whole, "{ledger:?}");
    assert!(Vec3::from(ledger.momentum_residual).norm() < 1e-12, "{ledger:?}");
}
