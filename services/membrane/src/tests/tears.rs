//! Modes of docs/failures.md that concern tears.

use super::{begun, figure, grip, harmless, setup, solve_from, warns, with};
use crate::prepared::PreparedMembrane;
use crate::steps::SheetRun;
use cullet_geometry::Vec3;
use cullet_model::{ContinuumSetup, SheetDiffusion, SheetRegion, SheetSourceKind};
use std::sync::Arc;

fn everywhere() -> SheetRegion {
    SheetRegion::Box { low: [-1.0; 2], high: [1.0; 2] }
}

/// A sheet whose bonds soften from 0.011 and break at 0.045, or so.
fn brittle() -> ContinuumSetup {
    with(setup(), |sheet| sheet.material.fracture_energy = 8.0)
}

/// A clamped strip with a notch, stretched by this much, at rest before anything breaks, then let
/// go with bonds that soften from this share of s_c. How many bonds break in 50 ms.
fn broken_from(stretch: f64, share: f64) -> usize {
    let strip = |work: f64| {
        with(setup(), |sheet| {
            let (low, high) = (0.0125, 0.2 - 0.0125);
            let moved = |by: f64| vec![(0.0, Vec3::new(0.0, by, 0.0))];
            let by = 0.5 * (high - low) * stretch;
            sheet.outline = vec![[0.0, 0.0], [0.3, 0.0], [0.3, 0.2], [0.0, 0.2]];
            sheet.notches = vec![vec![[-0.1, 0.1], [0.12, 0.1]]];
            sheet.spacing = 0.01;
            sheet.material.fracture_energy = work;
            sheet.grips = vec![
                grip([-1.0, -1.0], [1.0, low], moved(-by)),
                grip([-1.0, high], [1.0, 1.0], moved(by)),
            ];
        })
    };
    let mut still = begun(&strip(1e9), |state| {
        state.places.iter_mut().for_each(|x| x.y += stretch * (x.y.clamp(0.0125, 0.1875) - 0.1));
    });
    for _ in 0..2000 {
        still.advance();
        still.state.velocities.iter_mut().for_each(|v| *v *= 0.98);
    }
    let mut prepared = PreparedMembrane::new(&strip(10.0)).unwrap();
    prepared.table.limits.iter_mut().for_each(|limits| limits.first = share * limits.critical);
    let mut state = still.state;
    (state.step, state.pieces[0].still) = (0, 0);
    state.velocities.fill(Vec3::zeros());
    let mut run = SheetRun::new(Arc::new(prepared), state, vec![]);
    for _ in 0..12 * run.prepared.substeps {
        run.advance();
    }
    let bonds = &run.prepared.bonds;
    let broken = |b: &usize| run.state.damage[*b] >= 1.0 && !bonds.cut[*b];
    (0..bonds.ends.len()).filter(broken).count() / 2
}

/// A notch under a load at which bonds that break at once hold it; those that soften let it run.
#[test]
fn f79m_bonds_that_break_at_once_hold_a_crack() {
    let stretch = 0.012;
    let (sudden, softened) = (broken_from(stretch, 0.999), broken_from(stretch, 0.5));
    assert!(sudden < 30 && softened > 150, "{sudden} {softened}");
    // No strength makes them sudden.
    let strong = with(brittle(), |sheet| sheet.material.strength = 1e12);
    let limits = PreparedMembrane::new(&strong).unwrap().limits();
    assert!(limits.first <= 0.5 * limits.critical);
}

/// A sheet that flies apart: its bonds are seen far beyond where they break only if a step is
/// long beside that.
#[test]
fn f80m_a_tear_faster_than_steps_is_told() {
    let stretched = |rate: f64| {
        solve_from(&brittle(), 2, |state| {
            for (x, v) in state.places.iter_mut().zip(&mut state.velocities) {
                *v = *x * rate;
                *x *= 1.03;
            }
        })
    };
    let slow = stretched(6.0);
    assert!(slow.ledger.torn_area > 0.0);
    assert!((1.0..1.03).contains(&figure(&slow, "break_overshoot")), "{:?}", slow.figures);
    assert!(!warns(&slow, "bonds broke at"));
    let fast = stretched(300.0);
    assert!(figure(&fast, "break_overshoot") > 1.03 && warns(&fast, "bonds broke at"));
}

/// Where most of a sheet softens at once there is no crack, and that is told.
#[test]
fn f81m_a_sheet_that_softens_all_over_is_told() {
    let limits = PreparedMembrane::new(&brittle()).unwrap().limits();
    let stretched = |by: f64| {
        solve_from(&brittle(), 1, |state| {
            state.places.iter_mut().for_each(|x| *x *= 1.0 + by);
        })
    };
    let firm = stretched(0.5 * limits.first);
    assert_eq!(figure(&firm, "softening_share"), 0.0);
    assert!(!warns(&firm, "bonds that soften hold"));
    let soft = stretched(1.4 * limits.first);
    assert!(figure(&soft, "softening_share") > 0.15, "{:?}", soft.figures);
    assert!(warns(&soft, "bonds that soften hold"));
    // EG/σ² of what it works with: s₀ is s_c/2.
    let zone = 8.0 / (1e6 * limits.first * limits.first);
    assert!((figure(&soft, "process_zone") / zone - 1.0).abs() < 1e-9);
}

/// A grip that jerks tears a sheet at the end of the strip that it guards; a notch, where it is.
#[test]
fn f82m_a_sheet_that_tears_at_its_grip_is_told() {
    let pulled = |notches: Vec<Vec<[f64; 2]>>, speed: f64, steps| {
        let setup = with(brittle(), |sheet| {
            let far = Vec3::new(speed, 0.0, 0.0);
            sheet.notches = notches;
            sheet.grips = vec![
                grip([0.0, 0.0], [0.01, 0.1], vec![]),
                grip([0.19, 0.0], [0.2, 0.1], vec![(0.0, Vec3::zeros()), (1.0, far)]),
            ];
        });
        solve_from(&setup, steps, |_| {})
    };
    let jerked = pulled(vec![], 3.0, 2);
    assert!(jerked.ledger.torn_area > 0.0 && warns(&jerked, "around grip 2"));
    let notched = pulled(vec![vec![[0.1, -0.1], [0.1, 0.05]]], 0.3, 8);
    assert!(notched.ledger.torn_area > 0.0 && !warns(&notched, "around grip"));
}

/// An edge that is cooled at once parts from the sheet before anything has spread.
#[test]
fn f83m_rows_that_part_at_a_sudden_edge_are_told() {
    let cooled = |region, to: f64| {
        let setup = with(brittle(), |sheet| {
            let held = SheetSourceKind::Held(to);
            sheet.diffusion =
                Some(SheetDiffusion { expansion: [1.0; 2], ..harmless(vec![(region, held)]) })
                    .into();
            sheet.grips =
                vec![grip([0.0, 0.0], [0.01, 0.1], vec![]), grip([0.19, 0.0], [0.2, 0.1], vec![])];
        });
        solve_from(&setup, 4, |_| {})
    };
    let edge = SheetRegion::Box { low: [0.0, 0.0], high: [0.2, 0.004] };
    let shock = cooled(edge, -0.2);
    assert!(shock.ledger.torn_area > 0.0 && warns(&shock, "rows part along"));
    let even = cooled(everywhere(), -0.08);
    assert!(even.ledger.torn_area > 0.0 && !warns(&even, "rows part along"));
}

/// A line that has parted for its neighbours is crossed by longer bonds: they are dropped, counted,
/// and their energy is booked.
#[test]
fn f84m_ties_over_a_parted_line_are_dropped() {
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] < 0.1) != (b[0] < 0.1);
    let setup = with(setup(), |sheet| sheet.spacing = 0.01);
    let prepared = PreparedMembrane::new(&setup).unwrap();
    let (bonds, places) = (&prepared.bonds, &prepared.points.places);
    let crosses = |i: usize, b: usize| apart(places[i], places[bonds.ends[b] as usize]);
    let all = (0..places.len()).flat_map(|i| bonds.of(i).map(move |b| (i, b)));
    let across: Vec<usize> = all.filter(|&(i, b)| crosses(i, b)).map(|(_, b)| b).collect();
    let short = |b: &&usize| bonds.lengths[**b] <= 0.016;
    let shorter: Vec<usize> = across.iter().filter(short).copied().collect();
    assert!(shorter.len() < across.len());
    let run = begun(&setup, |state| {
        shorter.iter().for_each(|&b| state.damage[b] = 1.0);
        state.places.iter_mut().for_each(|x| *x *= 1.001);
    });
    assert_eq!(run.state.pieces.len(), 2);
    assert!(across.iter().all(|&b| run.state.damage[b] >= 1.0));
    assert_eq!(run.watch.ties, (across.len() - shorter.len()) as u64 / 2);
    let cost: f64 = across.iter().map(|&b| 0.25 * bonds.stiffness[b] * 1e-6).sum();
    assert!(run.books.sums.broken > 0.1 * cost && run.books.sums.broken < cost);
}

/// Of any outline no edge of what is drawn is without a bond; where one is, it is told.
#[test]
fn f87m_edges_without_bonds_are_told() {
    let hook = vec![[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.15, 0.2], [0.1, 0.1], [0.0, 0.1]];
    let turn = |k: u32| std::f64::consts::TAU * f64::from(k) / 60.0;
    let disc = (0..60).map(|k| [0.1 * turn(k).cos(), 0.1 * turn(k).sin()]).collect();
    for outline in [hook, disc] {
        let setup = with(setup(), |sheet| sheet.outline = outline);
        let outcome = solve_from(&setup, 1, |_| {});
        assert_eq!(figure(&outcome, "edges_without_bonds"), 0.0);
        assert!(!warns(&outcome, "without a bond"));
    }
    let mut prepared = PreparedMembrane::new(&setup()).unwrap();
    prepared.pairs[5] = None;
    let outcome = super::solve(&Arc::new(prepared), None, super::window(0, 1));
    assert!(figure(&outcome, "edges_without_bonds") == 1.0 && warns(&outcome, "without a bond"));
}

/// A ribbon narrower than two spacings has too few neighbours to bend.
#[test]
fn f88m_points_that_do_not_bend_are_counted() {
    let ribbon = |width: f64| {
        let line = |x: f64| vec![[x, -0.1], [x, 0.2]];
        with(setup(), |sheet| sheet.notches = vec![line(0.1), line(0.1 + width)])
    };
    // A corner may have too few.
    assert!(figure(&solve_from(&setup(), 1, |_| {}), "share_without_bending") < 0.01);
    let wide = figure(&solve_from(&ribbon(0.03), 1, |_| {}), "share_without_bending");
    let narrow = figure(&solve_from(&ribbon(0.007), 1, |_| {}), "share_without_bending");
    assert!(wide < 0.02 && narrow > wide + 0.015, "{wide} {narrow}");
}

/// A torn sheet that dries grows stiff again: that is booked as work of drying, and no bond heals.
#[test]
fn f93m_drying_heals_nothing_and_is_booked() {
    let setup = with(brittle(), |sheet| {
        sheet.diffusion = Some(SheetDiffusion {
            stiffness: vec![(0.0, 1.0), (1.0, 0.4)],
            toughness: vec![(0.0, 1.0), (1.0, 0.5)],
            loss: 0.02,
            ..harmless(vec![])
        })
        .into();
        sheet.grips = vec![
            grip([-1.0, 0.0], [0.01, 0.1], vec![]),
            grip([0.19, 0.0], [1.0, 0.1], vec![(0.0, Vec3::new(0.18 * 0.015, 0.0, 0.0))]),
        ];
    });
    let mut run = begun(&setup, |state| {
        state.theta.fill(1.0);
        for x in state.places.iter_mut().filter(|x| (0.01..0.19).contains(&x.x)) {
            x.x += (x.x - 0.01) * 0.015;
        }
    });
    let stored: f64 = run.energies().iter().sum();
    let (mut last, mut dry) = (run.state.damage.clone(), 1.0_f64);
    for _ in 0..12 * run.prepared.substeps {
        run.advance();
        assert!(run.state.damage.iter().zip(&last).all(|(now, before)| now >= before));
        last.clone_from(&run.state.damage);
        dry = dry.min(run.state.theta[0]);
    }
    let partly = last.iter().filter(|&&d| d > 0.0 && d < 1.0).count();
    assert!(partly > 100 && dry < 0.5, "{partly} {dry}");
    let grew = run.energies().iter().sum::<f64>() + run.kinetic() - stored;
    let (books, sums) = (&run.books, &run.books.sums);
    assert!(books.quantity_work > 0.1 * stored, "{} {stored}", books.quantity_work);
    let residual = grew + sums.broken + sums.damped - books.quantity_work - sums.grips;
    assert!(residual.abs() < 0.02 * books.quantity_work, "{residual} {}", books.quantity_work);
}
