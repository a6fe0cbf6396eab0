//! Cuts and tears: what they cost, and that nothing holds across them.

use super::harness::{RUBBER, TEARS, WHOLE, figure, grip_x, places, prepare, setup, sheet, solve};
use cullet_geometry::Vec3;
use cullet_model::BodyCut;

/// A cut along y in the plane x = 0.
fn cut(from: f64, to: f64) -> BodyCut {
    let corner = |y: f64, z: f64| Vec3::new(1e-6, y, z);
    BodyCut {
        corners: vec![corner(from, -1.0), corner(to, -1.0), corner(to, 1.0), corner(from, 1.0)],
    }
}

/// A cut right across a sheet lets its halves go without force.
#[test]
fn a_cut_opens_without_force() {
    let mut body = sheet([0.3, 0.2, 3e-3], 0.02, WHOLE, RUBBER);
    body.cuts = vec![cut(-1.0, 1.0)];
    body.velocity = Vec3::x();
    body.grips = vec![grip_x(-1.0, -0.13, vec![])];
    let prepared = prepare(&setup(body, Vec3::zeros()));
    let outcome = solve(&prepared, None, 0, 24, vec![]);
    assert_eq!(outcome.pieces.len(), 2, "{:?}", outcome.pieces);
    assert!(outcome.pieces.iter().all(|piece| (piece.area / 0.03 - 1.0).abs() < 0.01));
    assert_eq!(outcome.ledger.torn_area, 0.0);
    // The free half flies on as if nothing had been there.
    let right = |x: &&Vec3| x.x > 0.05;
    let flown = places(&outcome);
    let far = flown.iter().map(|x| x.x).fold(0.0, f64::max);
    assert!((far - 0.25).abs() < 1e-6, "{far}");
    let first = flown.iter().filter(right).map(|x| x.x).fold(1.0, f64::min);
    assert!((first - 0.1).abs() < 1e-6, "{first}");
}

/// A notched sheet that is pulled apart tears in two, and pays for it by G_f.
#[test]
fn a_notched_sheet_tears_in_two_for_its_toughness() {
    let (side, t) = (0.24, 4e-3);
    let mut body = sheet([side, side, t], 0.012, TEARS, RUBBER);
    let pull = |way: f64| vec![(0.8, Vec3::new(way, 0.0, 0.0))];
    body.grips = vec![grip_x(-1.0, -0.1, pull(-0.04)), grip_x(0.1, 1.0, pull(0.04))];
    body.cuts = vec![cut(-1.0, -0.04)];
    body.damping = 0.2;
    let prepared = prepare(&setup(body, Vec3::zeros()));
    let outcome = solve(&prepared, None, 0, 192, vec![]);
    let ledger = &outcome.ledger;
    let area = (side - 0.08) * t;
    let cost = ledger.broken / (RUBBER.fracture_energy * area);
    println!(
        "tore {:.3e} of {area:.3e} m², work {cost:.3} G A, {} pieces, residual {:.1e} of {:.1e} J",
        ledger.torn_area,
        outcome.pieces.len(),
        ledger.residual,
        ledger.grips
    );
    println!("{} control points split", figure(&outcome, "splits"));
    let large = outcome.pieces.iter().filter(|piece| piece.area > 0.2 * side * side).count();
    assert_eq!(large, 2, "{:?}", outcome.pieces);
    assert!((1.0..1.4).contains(&cost), "{cost}");
    assert!(ledger.residual.abs() < 0.02 * ledger.grips, "{ledger:?}");
    // Nothing holds the halves together any more: the grips bear what swings.
    let later = solve(&prepared, Some(&outcome.state), 192, 60, vec![]);
    let force = figure(&later, "grip_2_force_x").abs();
    assert!(force < 0.5, "{force} N");
}
