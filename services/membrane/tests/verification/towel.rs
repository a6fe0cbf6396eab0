//! A paper towel, torn out of its plane from a notch, dry and with drops of water.

use super::kit::{cracks, mean_and_most, seeds};
use cullet_geometry::{Pose, Vec3};
use cullet_membrane::{MembraneWindow, PreparedMembrane, SheetState};
use cullet_model::{
    Continuum, ContinuumBody, ContinuumSetup, MembraneLaw, MembraneMaterial, MembranePace,
    MembraneSheet, SheetAir, SheetDiffusion, SheetGrip, SheetPlace, SheetRegion, SheetSource,
    SheetSourceKind, Window, WindowOutcome, WindowProgress,
};
use std::sync::Arc;

/// Points of a towel are this far apart \[m\].
const SPACING: f64 = 8e-3;

/// What is torn, and how.
#[derive(Clone, Copy, Debug)]
struct Towel {
    wet: bool,
    law: MembraneLaw,
    pace: MembranePace,
    /// Of each hand \[m/s\].
    speed: f64,
    seed: u64,
}

const DRY: Towel = Towel {
    wet: false,
    law: MembraneLaw::Brittle,
    pace: MembranePace::Softer(170.0),
    speed: 2.0,
    seed: 3,
};

fn towel(Towel { wet, law, pace, speed, seed }: Towel) -> ContinuumSetup {
    let leg = |low: f64, high: f64, speed: f64| SheetGrip {
        region: SheetRegion::Box { low: [low, 0.225], high: [high, 1.0] },
        path: vec![(0.0, Vec3::zeros()), (1.0, Vec3::new(0.0, 0.0, speed))],
        until: None,
    };
    let drop = |k: u32| SheetSource {
        region: SheetRegion::Disc {
            centre: [0.03 + 0.14 * f64::from(k * 7 % 12) / 11.0, 0.02 + 0.012 * f64::from(k)],
            radius: 0.02,
        },
        from: 0.0,
        until: 0.05,
        kind: SheetSourceKind::Held(1.0),
    };
    let water = SheetDiffusion {
        capacity: 1.0,
        conductivity: [1e-5; 2],
        expansion: [0.01; 2],
        start: 0.0,
        saturation: 1.0,
        stiffness: vec![(0.0, 1.0), (1.0, 0.4)],
        toughness: vec![(0.0, 1.0), (1.0, 0.12)],
        strength: vec![(0.0, 1.0), (1.0, 0.3)],
        exposure: 0.0,
        weight: 300.0,
        loss: 0.0,
        ambient: 0.0,
        sources: (0..12).map(drop).collect(),
    };
    let sheet = MembraneSheet {
        outline: vec![[0.0, 0.0], [0.2, 0.0], [0.2, 0.24], [0.0, 0.24]],
        notches: vec![vec![[0.1, 0.25], [0.1, 0.14]]],
        thickness: 1.5e-4,
        spacing: SPACING,
        horizon: 3.015,
        material: MembraneMaterial {
            density: 300.0,
            young: 5e7,
            poisson: 0.2,
            fracture_energy: 750.0,
            strength: 2e6,
            law,
            scatter: 0.05,
            bending_floor: 1.0,
            damping: 0.1,
        },
        pose: Pose::identity(),
        velocity: Vec3::zeros(),
        grips: vec![leg(0.0, 0.09, speed), leg(0.11, 0.2, -speed)],
        air: SheetAir {
            density: 1.2,
            drag: 1.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        },
        diffusion: wet.then_some(water).into(),
        foundation: None,
        pace,
    };
    ContinuumSetup {
        body: ContinuumBody::Membrane(sheet),
        world_step: 1.0 / 240.0,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        seed,
    }
}

/// Tears a towel in windows of four steps of the world.
fn torn(setup: &ContinuumSetup, windows: u32) -> Vec<WindowOutcome> {
    let prepared = Arc::new(PreparedMembrane::new(setup).unwrap());
    let mut all: Vec<WindowOutcome> = Vec::new();
    for number in 0..windows {
        let first_step = u64::from(4 * number);
        let window =
            Window { first_step, steps: 4, frame_every: 4, proxies: vec![], retired: None };
        let state = all.last().map(|outcome| outcome.state.as_slice());
        let mut run = MembraneWindow::open(Arc::clone(&prepared), state, window).unwrap();
        all.push(loop {
            match Continuum::advance(&mut run) {
                WindowProgress::Running(_) => {}
                WindowProgress::Done(outcome) => break *outcome,
                WindowProgress::Failed(failure) => panic!("{failure}"),
            }
        });
    }
    all
}

/// It comes apart in two, pays for what it tears, and its books close. The dry tear stays in the
/// middle; a wet one leaves it and costs less.
#[test]
fn a_towel_is_torn_in_two() {
    let mut costs = Vec::new();
    for (wet, law) in
        [(false, MembraneLaw::Brittle), (true, MembraneLaw::Brittle), (false, MembraneLaw::Foil)]
    {
        let all = torn(&towel(Towel { wet, law, ..DRY }), 8);
        let sum = |f: &dyn Fn(&WindowOutcome) -> f64| all.iter().map(f).sum::<f64>();
        let last = &all[all.len() - 1];
        let grips = sum(&|o| o.ledger.grips);
        let residual = sum(&|o| o.ledger.residual);
        assert!(residual.abs() < 0.01 * grips, "{residual} {grips}");
        assert!(all.iter().flat_map(|o| &o.warnings).all(|warning| !warning.contains("energy")));
        let halves: Vec<f64> =
            last.pieces.iter().map(|piece| piece.area).filter(|&area| area > 0.01).collect();
        assert_eq!(halves.len(), 2, "{:?}", last.pieces);
        let off = (halves[0] - halves[1]).abs() / (halves[0] + halves[1]);
        assert_eq!(off > 0.1, wet, "{halves:?}");
        let area: f64 = last.pieces.iter().map(|piece| piece.area).sum();
        assert!((area / 0.048 - 1.0).abs() < 1e-9);
        let lost = sum(&|o| o.ledger.broken + o.ledger.plastic);
        assert!(lost < grips && (wet || lost > 750.0 * last.ledger.torn_area), "{lost}");
        assert!(last.frames.len() == 1 && !last.surfaces[0].triangles.is_empty());
        costs.push(lost);
    }
    assert!(costs[1] < 0.8 * costs[0], "{costs:?}");
}

/// Where a torn towel broke, what that took \[J\], its area at rest and what is torn \[m²\].
fn path(setup: &ContinuumSetup, windows: u32) -> (Vec<SheetPlace>, f64, f64, f64) {
    let prepared = PreparedMembrane::new(setup).unwrap();
    let all = torn(setup, windows);
    let last = &all[all.len() - 1];
    let state = SheetState::decode(&prepared, &last.state).unwrap();
    let lost = all.iter().map(|o| o.ledger.broken + o.ledger.plastic).sum();
    let area: f64 = last.pieces.iter().map(|piece| piece.area).sum();
    (cracks(&prepared, &state), lost, area, last.ledger.torn_area)
}

/// Mean of x of what broke in each band of the way, where it did.
fn bands(path: &[SheetPlace]) -> Vec<Option<f64>> {
    let band = |k: u32| {
        let low = 0.012 * f64::from(k);
        let own: Vec<f64> =
            path.iter().filter(|p| (low..low + 0.012).contains(&p[1])).map(|p| p[0]).collect();
        (!own.is_empty()).then(|| own.iter().sum::<f64>() / own.len() as f64)
    };
    (0..11).map(band).collect()
}

/// T16: over two seeds, or as many as `CULLET_SEEDS` says, a wet tear leaves the middle more than
/// three times as far as a dry one.
#[test]
fn t16_over_seeds() {
    let (mut dry, mut wet) = (Vec::new(), Vec::new());
    for seed in seeds(2) {
        for (is_wet, found) in [(false, &mut dry), (true, &mut wet)] {
            let own = Towel { wet: is_wet, seed, ..DRY };
            let (all, lost, area, _) = path(&towel(own), 8);
            let offs: Vec<f64> =
                bands(&all).into_iter().flatten().map(|x| (x - 0.1).abs()).collect();
            let (mean, most) = mean_and_most(&offs);
            println!(
                "seed {seed}, wet {is_wet}: off by {:.1} mm, at most {:.1}; {lost:.4} J; {:.1e}",
                mean * 1e3,
                most * 1e3,
                area / 0.048 - 1.0
            );
            assert!((area / 0.048 - 1.0).abs() < 1e-9);
            found.push(mean);
        }
    }
    let ratio = mean_and_most(&wet).0 / mean_and_most(&dry).0;
    println!("wet over dry: {ratio:.2}");
    assert!(ratio > 3.0, "{ratio}");
}

/// Greatest distance of two paths in a band \[m\], and what each lost over G and what is torn.
fn compared(towels: [Towel; 2], windows: u32) -> (f64, [f64; 2]) {
    let [(first, lost, _, torn), (second, other, _, more)] =
        towels.map(|own| path(&towel(own), windows));
    let rows = bands(&first).into_iter().zip(bands(&second));
    let apart: Vec<f64> = rows.filter_map(|(a, b)| Some((a? - b?).abs())).collect();
    (mean_and_most(&apart).1, [lost / (750.0 * torn), other / (750.0 * more)])
}

/// Half the pace changes the path of a tear by less than two spacings.
#[test]
fn half_the_pace_tears_alike() {
    let of = |pace| Towel { pace, speed: 2.0, ..DRY };
    for pace in [MembranePace::Softer, MembranePace::Heavier] {
        let (apart, [first, second]) = compared([of(pace(340.0)), of(pace(170.0))], 8);
        println!("{:.2} dx apart, spent {first:.3} and {second:.3} G", apart / SPACING);
        assert!(apart < 2.0 * SPACING, "{:?}: {apart}", pace(170.0));
    }
}
