//! T13: a narrow film on a base dries and shrinks, and cracks across.

use super::kit::{cracks, prepare, quantity, setup, sheet, solve, stairs};
use cullet_membrane::SheetState;
use cullet_model::{SheetPlace, SheetRegion};

const LENGTH: f64 = 2.0;
const WIDTH: f64 = 0.06;
const SPACING: f64 = 0.01;
/// √(Eh/k_b) \[m\].
const SHEAR_LENGTH: f64 = 0.08;
/// Time of the ramp \[s\].
const RISE: f64 = 1.5;

/// Broken bonds in a spacing of the film's length from which on a crack is there: all of one break
/// some ninety, over four spacings. Points in its middle may cling to the base with a bond left.
const DENSE: usize = 15;

/// Cracks across the film.
fn counted(all: &[SheetPlace]) -> usize {
    let mut bins = vec![0; (LENGTH / SPACING) as usize + 1];
    all.iter().for_each(|p| bins[(p[0] / SPACING) as usize] += 1);
    bins.windows(2).filter(|pair| pair[0] < DENSE && pair[1] >= DENSE).count()
}

/// Mean spacing of cracks across the film, in ℓ, at each of these strains over s_c.
fn spacings(strains: &[f64], scatter: f64, seed: u64) -> (Vec<f64>, f64) {
    let everywhere = SheetRegion::Box { low: [-9.0; 2], high: [9.0; 2] };
    let mut film = sheet([0.0, 0.0], [LENGTH, WIDTH], SPACING);
    film.material.damping = 0.1;
    film.material.scatter = scatter;
    film.foundation = Some(1e6 * film.thickness / (SHEAR_LENGTH * SHEAR_LENGTH));
    let critical = prepare(&setup(film.clone(), 1e-3, seed)).critical;
    let last = strains[strains.len() - 1] * critical;
    let mut drying = quantity(1.0, 1e-9);
    drying.sources = stairs(everywhere, -last, RISE, 300);
    film.diffusion = Some(drying).into();
    let prepared = prepare(&setup(film, 1e-3, seed));
    let mut state = SheetState::start(&prepared);
    let mut found = Vec::new();
    let mut first = f64::INFINITY;
    for strain in strains {
        let until = (strain * critical / last * RISE / 1e-3).round() as u64;
        while state.step < until {
            let steps = (until - state.step).min(15) as u32;
            let (outcome, next) = solve(&prepared, &state, steps);
            state = next;
            let lost = outcome.ledger.residual.abs();
            let ledger = &outcome.ledger;
            let scale = ledger.stretching + ledger.quantity_work.abs() + ledger.broken;
            assert!(lost < 0.02 * scale, "{ledger:?}");
            if first.is_infinite() && counted(&cracks(&prepared, &state)) > 0 {
                first = state.step as f64 * 1e-3 / RISE * last / critical;
            }
        }
        let parts = counted(&cracks(&prepared, &state)) + 1;
        found.push(LENGTH / parts as f64 / SHEAR_LENGTH);
    }
    (found, first)
}

/// Cracks lie between a* and 2a* apart, cosh(a*/ℓ) = 1/(1 − ε₁/ε), where the film softens at
/// ε₁ = s_c/2.
#[test]
fn cracks_of_a_drying_film_have_their_spacing() {
    let first = 0.5;
    let over = [1.35, 1.8, 2.7, 3.2, 4.5];
    let strains = over.map(|ratio| ratio * first);
    let (found, began) = spacings(&strains, 0.1, 1);
    println!("the film first parted at {began:.3} s_c");
    for (ratio, spacing) in over.iter().zip(&found) {
        let least = (1.0 / (1.0 - 1.0 / ratio)).acosh();
        println!(
            "{ratio} of the first strain: {spacing:.2} l, of {least:.2} to {:.2}",
            2.0 * least
        );
        assert!((0.9 * least..2.2 * least).contains(spacing), "{ratio}: {spacing} {least}");
    }
    assert!((0.35..0.65).contains(&began), "{began}");
}
