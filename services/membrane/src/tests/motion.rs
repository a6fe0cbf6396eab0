//! Modes of docs/failures.md that concern how a sheet moves, and what touches it.

use super::{begun, figure, grip, harmless, setup, solve, solve_from, warns, window, with};
use crate::detectors::{self, SheetCondition, WindowExtremes, pressed_through};
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::window::MembraneWindow;
use cullet_continuum::crossings::crossings;
use cullet_geometry::math::unit;
use cullet_geometry::{Mat3, Pose, Vec3};
use cullet_model::{
    Continuum, MembraneLaw, MembranePace, Proxy, ProxyMotion, SheetDiffusion, SheetRegion,
    SheetSourceKind, WindowProgress,
};
use std::sync::Arc;

/// Velocities in the plane that differ from point to point.
fn shaken(state: &mut SheetState) {
    for (i, v) in state.velocities.iter_mut().enumerate() {
        let chance = |k: u64| unit(6, k, i as u64) - 0.5;
        *v = Vec3::new(chance(0), chance(1), 0.0) * 0.05;
    }
}

/// Velocities that are taken away again and again, at twice the usual step, feed nothing: a step
/// begins with half a drift, so that from rest it is half a step of the places. A whole one would
/// make each motion with ω dt > √2 grow.
#[test]
fn f85m_stopping_a_sheet_makes_no_energy() {
    let mut prepared = PreparedMembrane::new(&setup()).unwrap();
    prepared.substeps = (0.45 * f64::from(prepared.substeps)) as u32;
    let share = prepared.step() / prepared.stable;
    assert!((0.8..1.0).contains(&share), "{share}");
    let mut state = SheetState::start(&prepared);
    shaken(&mut state);
    let mut run = crate::steps::SheetRun::new(Arc::new(prepared), state, vec![]);
    run.advance();
    let first = run.energies()[0];
    for _ in 0..200 {
        run.state.velocities.fill(Vec3::zeros());
        run.advance();
    }
    let last = run.energies()[0] + run.kinetic();
    assert!(first > 0.0 && last < first, "{last} {first}");
}

/// What dashpots take of a shaken sheet is what it loses.
#[test]
fn f86m_the_work_of_damping_is_what_is_lost() {
    let setup = with(setup(), |sheet| sheet.material.damping = 0.5);
    let outcome = solve_from(&setup, 1, shaken);
    let ledger = &outcome.ledger;
    assert!(ledger.damped > 10.0 * (ledger.kinetic + ledger.stretching), "{ledger:?}");
    assert!(ledger.residual.abs() < 0.05 * ledger.damped, "{ledger:?}");
}

/// Area of a foil over that at rest, once it has flown and lies still again.
fn area_of_foil(pulled: f64, sheared: f64) -> f64 {
    let setup = with(setup(), |sheet| {
        sheet.material.law = MembraneLaw::Foil;
        sheet.material.strength = 2e3;
        sheet.material.fracture_energy = 1e6;
        if pulled > 0.0 {
            let far = Vec3::new(0.18 * pulled, 0.0, 0.0);
            sheet.grips = vec![
                grip([-1.0, -1.0], [0.01, 1.0], vec![]),
                grip([0.19, -1.0], [1.0, 1.0], vec![(0.0, Vec3::zeros()), (0.05, far)]),
            ];
        }
    });
    let mut run = begun(&setup, |state| {
        state.places.iter_mut().for_each(|x| x.x += sheared * x.y);
    });
    for _ in 0..16 * run.prepared.substeps {
        run.advance();
        run.state.velocities.iter_mut().for_each(|v| *v *= 0.99);
    }
    SheetCondition::of(&run).area
}

/// Bonds flow each by itself. A foil that is sheared keeps its area; one that is pulled contracts
/// as bonds do, by a third, and not by the half of a metal: the figure says what area it has.
#[test]
fn f89m_area_that_flow_makes_is_reported() {
    let sheared = area_of_foil(0.0, 0.4);
    assert!((sheared - 1.0).abs() < 2e-3, "{sheared}");
    let pulled = area_of_foil(0.2, 0.0);
    println!("F89m: sheared {sheared:.4}, pulled {pulled:.4}, of a metal {:.4}", 1.18_f64.sqrt());
    assert!(pulled > 1.01 * 1.18_f64.sqrt() && pulled < 1.18, "{pulled}");
    let outcome =
        solve_from(&setup(), 1, |state| state.places.iter_mut().for_each(|x| *x *= 1.001));
    assert!((figure(&outcome, "area_ratio") - 1.0).abs() < 0.003);
}

/// A cube above the sheet's middle.
fn cube(mass: f64, speed: f64) -> Proxy {
    let side = |k: usize, bit: usize| if k >> bit & 1 == 1 { 0.015 } else { -0.015 };
    let corners = (0..8).map(|k| Vec3::new(side(k, 0), side(k, 1), side(k, 2))).collect();
    Proxy {
        body: 4,
        object: None,
        parts: vec![corners],
        friction: 0.3,
        pose: Pose::translation(0.1, 0.05, 0.017),
        velocity: Vec3::new(0.0, 0.0, -speed),
        spin: Vec3::zeros(),
        motion: ProxyMotion::Free { mass, inertia: Mat3::identity() * (mass * 1.5e-4) },
    }
}

/// A body that goes deep into a sheet is told, and that it is heavy where it is.
#[test]
fn f91m_a_heavy_body_that_presses_through_is_told() {
    let prepared = Arc::new(PreparedMembrane::new(&setup()).unwrap());
    let hit = |mass: f64, speed: f64| {
        let proxies = vec![cube(mass, speed)];
        solve(&prepared, None, cullet_model::Window { proxies, ..window(0, 1) })
    };
    let light = hit(0.02, 1.0);
    assert!((figure(&light, "body_4_mass_ratio") - 1.0).abs() < 1e-9);
    assert!(figure(&light, "body_4_depth") > 0.0 && !warns(&light, "inside of body 4"));
    let heavy = hit(200.0, 60.0);
    assert!(warns(&heavy, "inside of body 4, which has 1.0e4 times"), "{:?}", heavy.warnings);
    let contact = prepared.contact();
    let told = |mass: f64, depth: f64| pressed_through(&cube(mass, 0.0), depth, contact, 0.02);
    assert_eq!(told(200.0, 1.9 * contact), None);
    assert!(told(0.02, 2.1 * contact).is_some_and(|text| !text.contains("times")));
}

/// A pace at which a sheet moves or stretches too much is told.
#[test]
fn f92m_a_pace_that_lies_is_told() {
    let paced = |pace| {
        with(setup(), |sheet| {
            (sheet.pace, sheet.velocity.x) = (pace, 1.0);
            sheet.material.fracture_energy = 100.0;
            sheet.spacing = 0.01;
        })
    };
    let moves = |pace| warns(&solve_from(&paced(pace), 1, |_| {}), "the heavier sheet moves");
    assert!(moves(MembranePace::Heavier(10.0)) && !moves(MembranePace::Real));
    let told = |pace, stretch: f64| {
        let run = begun(&paced(pace), |state| {
            state.places.iter_mut().for_each(|x| *x *= 1.0 + stretch);
        });
        let condition = SheetCondition::of(&run);
        assert!((condition.stretch / stretch - 1.0).abs() < 1e-6, "{}", condition.stretch);
        let all = detectors::warnings(&run, &condition, WindowExtremes::default());
        all.iter().any(|text| text.contains("the softer sheet is stretched"))
    };
    let softer = MembranePace::Softer(30.0);
    assert!(told(softer, 0.06) && !told(softer, 0.04) && !told(MembranePace::Real, 0.06));
    // One that would break only beyond what its law holds for is refused.
    assert!(PreparedMembrane::new(&paced(MembranePace::Softer(25.0))).is_err());
}

/// A film in a gale that would turn it back and forth follows it, and the number of it is told.
#[test]
fn f94m_drag_that_would_flutter_is_implicit_and_told() {
    let blown = |speed: f64| {
        let setup = with(setup(), |sheet| {
            sheet.thickness = 1e-5;
            sheet.air.density = 100.0;
            sheet.air.wind = Vec3::new(0.0, 0.0, speed);
        });
        let prepared = PreparedMembrane::new(&setup).unwrap();
        let mut run = begun(&setup, |_| {});
        for _ in 0..prepared.substeps {
            run.advance();
            let within = |v: &Vec3| v.z > -1e-9 && v.z < speed;
            assert!(run.state.velocities.iter().all(within));
        }
        let outcome = solve_from(&setup, 1, |state| {
            // It flies against the wind.
            state.velocities.fill(Vec3::new(0.0, 0.0, -speed));
        });
        (figure(&outcome, "drag_share"), warns(&outcome, "drag would take"))
    };
    let (share, told) = blown(1.0);
    assert!(share < 0.5 && !told, "{share}");
    let (share, told) = blown(3000.0);
    assert!(share > 0.5 && told, "{share}");
}

/// A fold that goes through the sheet below it is counted, told, and not frozen; one above it, or
/// a flat sheet, has none.
#[test]
fn f95m_a_sheet_through_itself_is_told_and_stays_awake() {
    let folded = |low: f64| {
        move |state: &mut SheetState| {
            for x in state.places.iter_mut().filter(|x| x.x > 0.1) {
                let along = x.x - 0.1;
                *x = Vec3::new(0.1 - along, x.y, low + 0.3 * along);
            }
        }
    };
    let framed = |change: &dyn Fn(&mut SheetState)| {
        let prepared = Arc::new(PreparedMembrane::new(&setup()).unwrap());
        let mut state = SheetState::start(&prepared);
        change(&mut state);
        let bytes = state.encode(&prepared);
        let window = cullet_model::Window { frame_every: 1, ..window(0, 1) };
        solve(&prepared, Some(&bytes), window)
    };
    let (through, above, flat) =
        (framed(&folded(-0.015)), framed(&folded(0.006)), framed(&|_: &mut SheetState| {}));
    assert!(figure(&through, "crossings") > 5.0 && warns(&through, "goes through itself"));
    for clear in [above, flat] {
        assert_eq!(figure(&clear, "crossings"), 0.0);
        assert!(!warns(&clear, "goes through itself"));
    }
    let still_after = |low: f64| {
        let mut run = begun(&setup(), folded(low));
        run.state.pieces[0].still = 120;
        run.keep_crossed_awake();
        run.state.pieces[0].still
    };
    assert_eq!([still_after(-0.015), still_after(0.006)], [0, 120]);
}

#[test]
fn an_edge_through_a_triangle_is_found_and_one_beside_it_is_not() {
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
    let with = |x: f64, low: f64| {
        let own = [[x, 0.2, low], [x, 0.2, low + 1.0], [x + 3.0, 0.2, low]].map(Vec3::from);
        let places = [flat, own].concat();
        crossings(&[[0, 1, 2], [3, 4, 5]], &places).len()
    };
    // Its edge, and one of the triangle's own edges through the other.
    assert_eq!(with(0.2, -0.5), 2);
    assert_eq!([with(1.2, -0.5), with(0.2, 0.1), with(0.2, 0.0)], [0, 0, 0]);
}

/// Without gravity, a sheet that drifts at a centimetre a second is not frozen: nothing holds it.
#[test]
fn a_sheet_in_free_flight_is_never_frozen() {
    let drifting = with(setup(), |sheet| {
        sheet.velocity = Vec3::new(0.01, 0.0, 0.0);
        sheet.spacing = 0.01;
    });
    let outcome = solve_from(&drifting, 130, |_| {});
    assert!(!outcome.pieces[0].frozen);
    assert!((outcome.ledger.momentum[0] / (0.02 * 0.01) - 1.0).abs() < 1e-9);
}

/// What is taken up may not strain a sheet by more than half: not by a source that is known, and
/// not as it comes.
#[test]
fn what_shrinks_a_sheet_too_much_ends_its_run() {
    let everywhere = SheetRegion::Box { low: [-1.0; 2], high: [1.0; 2] };
    let taking = |kind| {
        with(setup(), |sheet| {
            let what = harmless(vec![(everywhere, kind)]);
            sheet.diffusion = Some(SheetDiffusion { expansion: [-0.1; 2], ..what }).into();
        })
    };
    let held = |theta: f64| PreparedMembrane::new(&taking(SheetSourceKind::Held(theta)));
    assert!(held(4.9).is_ok());
    let refused = held(8.0).err().map(|refusal| refusal.to_string()).unwrap_or_default();
    assert!(refused.contains("strain by what a sheet takes up"), "{refused}");
    let prepared = Arc::new(PreparedMembrane::new(&taking(SheetSourceKind::Flux(1.0))).unwrap());
    let mut run = MembraneWindow::open(prepared, None, window(0, 4)).unwrap();
    let ended = loop {
        match Continuum::advance(&mut run) {
            WindowProgress::Running(_) => {}
            WindowProgress::Done(_) => panic!("it swelled without end"),
            WindowProgress::Failed(failure) => break failure.to_string(),
        }
    };
    assert!(ended.contains("strains it by -0."), "{ended}");
}
