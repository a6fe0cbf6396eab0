//! T12: an edge of a strip is cooled, and cracks run in from it.

use super::kit::{cracks, grip, prepare, quantity, setup, sheet, solve, stairs};
use cullet_geometry::Vec3;
use cullet_membrane::SheetState;
use cullet_model::{MembranePace, SheetPlace, SheetRegion};

const LENGTH: f64 = 0.2;
const WIDTH: f64 = 0.06;
const SPACING: f64 = 4e-3;
/// Cracks that are shallower do not count \[m\].
const DEEP: f64 = 6e-3;

/// Cracks of a strip whose lower edge has come to the strain `−strain` after `rise` \[s\]: the
/// middle of the deeper half of each, and that of the other half.
fn quenched(strain: f64, rise: f64, seconds: f64, seed: u64) -> Vec<[SheetPlace; 2]> {
    let mut strip = sheet([0.0, 0.0], [LENGTH, WIDTH], SPACING);
    strip.material.young = 1e9;
    strip.material.fracture_energy = 100.0;
    strip.material.damping = 0.1;
    strip.pace = MembranePace::Heavier(3.0);
    // Held at two points far from the edge, so that it does not drift.
    strip.grips = vec![grip([0.09, 0.052], [0.11, 0.06], vec![(0.0, Vec3::zeros())])];
    let mut cold = quantity(1.0, 1e-5);
    let edge = SheetRegion::Box { low: [-1.0, -1.0], high: [1.0, SPACING] };
    cold.sources = stairs(edge, -strain, rise, 60);
    strip.diffusion = Some(cold).into();
    let prepared = prepare(&setup(strip, 0.01, seed));
    let mut state = SheetState::start(&prepared);
    let steps = (seconds / 0.01) as u64;
    while state.step < steps {
        state = solve(&prepared, &state, 50).1;
    }
    grouped(cracks(&prepared, &state))
}

/// Broken bonds that lie within two spacings of each other belong to one crack.
fn grouped(mut rest: Vec<SheetPlace>) -> Vec<[SheetPlace; 2]> {
    let mut found = Vec::new();
    while let Some(first) = rest.pop() {
        let mut group = vec![first];
        let mut k = 0;
        while k < group.len() {
            let [x, y] = group[k];
            let near = |p: &SheetPlace| (p[0] - x).hypot(p[1] - y) < 1.5 * SPACING;
            let (joined, other) = rest.into_iter().partition(near);
            rest = other;
            group.extend::<Vec<SheetPlace>>(joined);
            k += 1;
        }
        group.sort_by(|a, b| a[1].total_cmp(&b[1]));
        if group[group.len() - 1][1] > DEEP {
            let (low, high) = group.split_at(group.len() / 2);
            found.push([middle(high), middle(low)]);
        }
    }
    found
}

fn middle(all: &[SheetPlace]) -> SheetPlace {
    [0, 1].map(|k| all.iter().map(|p| p[k]).sum::<f64>() / all.len() as f64)
}

/// How far a crack leans from the perpendicular \[°\].
fn lean([deep, low]: &[SheetPlace; 2]) -> f64 {
    (deep[0] - low[0]).abs().atan2(deep[1] - low[1]).to_degrees()
}

/// No crack at a small shock; at greater ones more of them, across the edge.
#[test]
fn a_cooled_edge_cracks_across() {
    let mut last = 0;
    for (strain, range) in [(0.003, 0..=0), (0.007, 0..=5), (0.015, 3..=12)] {
        let all = quenched(strain, 3.0, 8.0, 1);
        let leans: Vec<f64> = all.iter().map(lean).collect();
        println!("{:.1} %: {} cracks, leaning {leans:.0?}", strain * 1e2, all.len());
        assert!(range.contains(&all.len()), "{strain}: {all:?}");
        assert!(all.len() >= last, "{strain}: {all:?}");
        last = all.len();
        let upright = leans.iter().filter(|lean| **lean < 45.0).count();
        assert!(4 * upright >= 3 * all.len(), "{leans:?}");
    }
}
