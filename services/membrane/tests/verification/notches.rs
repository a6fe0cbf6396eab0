//! T10: two notches from opposite edges of a strip that is pulled apart.

use super::kit::{cracks, grip, prepare, settled, setup, sheet, solve};
use cullet_geometry::Vec3;
use cullet_membrane::SheetState;
use cullet_model::ContinuumSetup;

const WIDTH: f64 = 0.5;
const HEIGHT: f64 = 0.6;
const SPACING: f64 = 0.01;
const TOUGHNESS: f64 = 10.0;
const NOTCH: f64 = 0.15;
/// How far the notches lie above and below the middle \[m\].
const OFFSET: f64 = 0.03;
const CLAMP: f64 = 0.02;

fn strip(breaks: bool, path: &[(f64, f64)], seed: u64) -> ContinuumSetup {
    let half = 0.5 * HEIGHT;
    let led = |sign: f64| -> Vec<(f64, Vec3)> {
        let at = |&(time, stretch): &(f64, f64)| {
            (time, Vec3::new(0.0, sign * (half - CLAMP) * stretch, 0.0))
        };
        path.iter().map(at).collect()
    };
    let mut sheet = sheet([0.0, -half], [WIDTH, half], SPACING);
    sheet.notches = vec![
        vec![[-0.1, OFFSET], [NOTCH, OFFSET]],
        vec![[WIDTH + 0.1, -OFFSET], [WIDTH - NOTCH, -OFFSET]],
    ];
    sheet.material.fracture_energy = if breaks { TOUGHNESS } else { 1e9 };
    sheet.material.damping = 0.1;
    sheet.grips = vec![
        grip([-1.0, -1.0], [9.0, CLAMP - half], led(-1.0)),
        grip([-1.0, half - CLAMP], [9.0, 1.0], led(1.0)),
    ];
    setup(sheet, 1e-3, seed)
}

/// Energy lost by G and torn area, pieces of a tenth of the sheet, and where it broke.
fn torn(seed: u64) -> (f64, usize, Vec<[f64; 2]>) {
    let (begin, rise) = (0.004, 0.4);
    let elastic = prepare(&strip(false, &[(0.0, begin)], seed));
    let mut state = SheetState::start(&elastic);
    for (x, p) in state.places.iter_mut().zip(&elastic.points.places) {
        let near = 0.5 * HEIGHT - CLAMP;
        x.y = p[1] + begin * p[1].clamp(-near, near);
    }
    let (rested, _) = settled(&elastic, state, 200);
    let prepared = prepare(&strip(true, &[(0.0, begin), (rise, 0.02), (3.0 * rise, 0.1)], seed));
    let mut state = SheetState::start(&prepared);
    state.places = rested.places;
    let (mut broken, mut work) = (0.0, 0.0);
    loop {
        let (outcome, next) = solve(&prepared, &state, 20);
        state = next;
        broken += outcome.ledger.broken;
        work += outcome.ledger.grips;
        let halves = outcome.pieces.iter().filter(|piece| piece.area > 0.1 * WIDTH * HEIGHT);
        let halves = halves.count();
        if halves > 1 || state.step > 1180 {
            println!(
                "seed {seed}: in {halves} after {} ms, grips {work:.4} J, broken {broken:.4} J",
                state.step
            );
            let area = outcome.ledger.torn_area;
            return (broken / (TOUGHNESS * area), halves, cracks(&prepared, &state));
        }
    }
}

/// The cracks pass each other and hook, or meet; the sheet parts, and pays for what it tears.
#[test]
fn cracks_from_both_edges_hook_or_meet() {
    for seed in 1..=2 {
        let (cost, halves, all) = torn(seed);
        let reach = all.iter().map(|p| p[1].abs()).fold(0.0, f64::max);
        let inner = all.iter().filter(|p| p[1].abs() < 0.5 * OFFSET).count();
        println!("cost {cost:.3} G, as far as {:.1} dx from the middle", reach / SPACING);
        assert_eq!(halves, 2);
        assert!((1.0..1.3).contains(&cost), "{cost}");
        assert!(reach < 2.5 * OFFSET, "{reach}");
        // On its way to the other side one of them crosses the middle.
        assert!(inner > 0);
    }
}
