//! T11: a sheet with two legs that are drawn apart out of its plane.

use super::kit::{cracks, grip, prepare, setup, sheet, solve};
use cullet_geometry::Vec3;
use cullet_membrane::SheetState;
use cullet_model::MembranePace;

const WIDTH: f64 = 0.12;
const LENGTH: f64 = 0.17;
const SPACING: f64 = 5e-3;
const THICKNESS: f64 = 1.5e-4;
const TOUGHNESS: f64 = 750.0;
/// Where the notch ends \[m\].
const TIP: f64 = 0.12;

/// What came of a tear.
struct Tear {
    /// Force of a grip over Gh/2 while the tear went from a third to nine tenths of its way \[1\].
    force: f64,
    /// Energy lost by G and the way over the same \[1\].
    spent: f64,
    /// Kinetic energy, dashpots and air beside the work of the grips \[1\].
    beside: f64,
    /// Angle between the tear and the notch \[°\].
    angle: f64,
    /// How far it went \[m\].
    way: f64,
}

/// Legs of which each moves at `speed` \[m/s\], of a sheet whose waves are made this slow \[m/s\].
fn torn(speed: f64, pace: f64, seed: u64) -> Tear {
    let half = 0.5 * WIDTH;
    let mut sheet = sheet([-half, 0.0], [half, LENGTH], SPACING);
    sheet.thickness = THICKNESS;
    sheet.notches = vec![vec![[0.0, 1.0], [0.0, TIP]]];
    sheet.material.density = 300.0;
    sheet.material.young = 5e7;
    sheet.material.fracture_energy = TOUGHNESS;
    sheet.material.bending_floor = 0.1;
    sheet.material.damping = 0.02;
    // Bonds soften from 0.27 s_c on. From half of it on the tear goes in jerks: 1.5 Gh/2.
    sheet.material.strength = 6e5;
    sheet.air.density = 1.2;
    sheet.air.drag = 1.0;
    sheet.pace = MembranePace::Heavier(pace);
    let leg = |low: f64, high: f64, v: f64| {
        let path = vec![(0.0, Vec3::zeros()), (10.0, Vec3::new(0.0, 0.0, 10.0 * v))];
        grip([low, LENGTH - 0.012], [high, 1.0], path)
    };
    sheet.grips = vec![leg(-1.0, -0.5 * SPACING, -speed), leg(0.5 * SPACING, 1.0, speed)];
    let prepared = prepare(&setup(sheet, 1.0 / 240.0, seed));
    let mut state = SheetState::start(&prepared);
    let lowest = |state: &SheetState| {
        let all = cracks(&prepared, state);
        all.into_iter().fold([0.0, TIP], |low, p| if p[1] < low[1] { p } else { low })
    };
    // Tip, steps, work of the grips, energy lost and motion at both ends of what counts.
    let mut marks: Vec<[f64; 5]> = Vec::new();
    let (mut work, mut lost, mut beside) = (0.0, 0.0, 0.0);
    let (from, to) = (TIP - 0.03, 0.025);
    while state.step < 1200 {
        let (outcome, next) = solve(&prepared, &state, 2);
        state = next;
        work += outcome.ledger.grips;
        lost += outcome.ledger.broken;
        beside += outcome.ledger.damped - outcome.ledger.air;
        let [_, tip] = lowest(&state);
        let time = state.step as f64 / 240.0;
        let mark = [tip, time, work, lost, beside + outcome.ledger.kinetic];
        if (tip < from && marks.is_empty()) || (tip < to && marks.len() == 1) {
            marks.push(mark);
        }
        if marks.len() == 2 {
            break;
        }
    }
    assert!(marks.len() == 2, "the tear ended at {:?}", lowest(&state));
    let [first, last] = [marks[0], marks[1]];
    let way = first[0] - last[0];
    let [off, tip] = lowest(&state);
    Tear {
        force: (last[2] - first[2])
            / (2.0 * speed * (last[1] - first[1]))
            / (0.5 * TOUGHNESS * THICKNESS),
        spent: (last[3] - first[3]) / (TOUGHNESS * THICKNESS * way),
        beside: (last[4] - first[4]) / (last[2] - first[2]),
        angle: off.atan2(TIP - tip).to_degrees(),
        way,
    }
}

/// A slow tear goes straight on and takes somewhat more than Gh/2 from each leg.
#[test]
fn legs_are_drawn_with_half_of_gh() {
    let Tear { force, spent, beside, angle, way } = torn(0.15, 100.0, 1);
    println!("F {force:.3} Gh/2, spent {spent:.3} G, {beside:.3} beside, {angle:.1}°, {way:.3} m");
    // Of the excess half is damage beside the tear, half what jerks leave to dashpots.
    assert!((1.0..1.4).contains(&force), "{force}");
    assert!((0.9..1.2).contains(&spent), "{spent}");
    assert!(angle.abs() < 5.0, "{angle}");
}
