//! What a crack costs: a plane that is opened, and a strip that is torn (Rice).

use crate::block;
use cullet_geometry::Vec3;
use cullet_peridynamics::PeridynamicLaw;
use cullet_peridynamics::law::BondBreaking;

const SPACING: f64 = 1e-3;
const TOUGHNESS: f64 = 10.0;

pub(crate) fn glass(poisson: f64, dust: f64) -> PeridynamicLaw {
    let breaking = Some(BondBreaking { fracture_energy: TOUGHNESS, dust });
    PeridynamicLaw { breaking, ..PeridynamicLaw::elastic(2500.0, 70e9, poisson) }
}

/// Energy over G_f and the area that it takes to move two halves of a block apart across a plane
/// through its middle.
pub(crate) fn opened(horizon: f64, law: PeridynamicLaw, normal: Vec3) -> f64 {
    let mut body = block([15, 15, 15], SPACING, 0.1, horizon, law);
    let (n, start) = (normal.normalize(), body.places.clone());
    let mut spent = 0.0;
    for step in 1..=400 {
        let gap = 4.0 * body.critical * horizon * SPACING * f64::from(step) / 400.0;
        for (x, s) in body.places.iter_mut().zip(&start) {
            *x = s + n * if s.dot(&n) > 0.0 { gap } else { 0.0 };
        }
        spent += body.strain().broken;
    }
    // A cube is cut in a square, a rectangle and a hexagon.
    let zeros = normal.iter().filter(|&&c| c == 0.0).count();
    let area = [0.75 * 3.0_f64.sqrt(), 2.0_f64.sqrt(), 1.0][zeros] * (15.0 * SPACING).powi(2);
    spent / (TOUGHNESS * area)
}

/// A plane that is opened costs G_f over its area, whatever its direction, the horizon and ν.
#[test]
fn a_plane_that_is_opened_costs_its_energy() {
    let some = [(2.04, 0.25), (3.015, 0.1), (3.015, 0.25), (3.015, 0.4), (4.0, 0.25)];
    for (horizon, poisson) in some {
        for normal in [Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 1.0)] {
            let cost = opened(horizon, glass(poisson, 0.0), normal);
            println!("A plane, m {horizon}, ν {poisson}, {:?}: {cost:.3} G_f", normal.as_slice());
            assert!((cost - 1.0).abs() < 0.08, "m {horizon}, ν {poisson}, {normal}: {cost}");
        }
    }
}

/// Bonds of points that have lost some break later: a plane costs more, the more so the more α is.
#[test]
fn dust_control_makes_bonds_break_later() {
    let [none, some, more] =
        [0.0, 0.5, 1.0].map(|dust| opened(3.015, glass(0.25, dust), Vec3::x()));
    println!("A plane with α of 0, 0.5 and 1: {none:.3}, {some:.3}, {more:.3} G_f");
    assert!(some > 1.05 * none && more > 1.05 * some, "{none}, {some}, {more}");
}

/// What came of a strip.
#[derive(Debug)]
struct Torn {
    /// Share of its length that it tore.
    length: f64,
    /// What breaking took over G_f and the area of the crack.
    cost: f64,
    /// Energy at the end over that at the start.
    ledger: f64,
}

/// A strip between clamps that have moved apart until G is `ratio` G_f, with a slit at one end.
fn strip(ratio: f64) -> Torn {
    let counts = [60, 30, 4];
    let mut body = block(counts, SPACING, 0.1, 3.015, glass(0.25, 0.0));
    let start = body.places.clone();
    let [length, height, width] = counts.map(|n| n as f64 * SPACING);
    let tip = -0.25 * length;
    body.sever(|a, b| {
        let at = a.x + (b.x - a.x) * a.y / (a.y - b.y);
        a.y * b.y < 0.0 && at < tip
    });
    // Nothing moves along the strip, nothing is held through its width: G = E/(1 − ν²) e²h/2.
    let free = height - 6.0 * SPACING;
    let young = 70e9 / (1.0 - 0.0625);
    let strain = (2.0 * ratio * TOUGHNESS / (young * free)).sqrt();
    let held: Vec<bool> = start.iter().map(|x| x.y.abs() > 0.5 * free).collect();
    for (x, s) in body.places.iter_mut().zip(&start) {
        x.y += strain * s.y.clamp(-0.5 * free, 0.5 * free);
    }
    // It comes to rest before anything may break.
    let critical = std::mem::replace(&mut body.critical, f64::INFINITY);
    let dt = body.stable_step();
    body.strain();
    for _ in 0..300 {
        body.advance(dt, |p, v| if held[p] { Vec3::zeros() } else { v * 0.98 });
    }
    body.critical = critical;
    let (energy, mut spent) = (body.sums().elastic, 0.0);
    // Three quarters of its length at half of the speed of Rayleigh's waves.
    for _ in 0..(1.6 * length / 3000.0 / dt) as usize {
        spent += body.advance(dt, |p, v| if held[p] { Vec3::zeros() } else { v }).broken;
    }
    let after = body.sums();
    let torn = |p: &usize| body.states[*p].damage > 0.3 && start[*p].y.abs() < SPACING;
    let far = (0..start.len()).filter(torn).map(|p| start[p].x).fold(tip, f64::max) - tip;
    Torn {
        length: far / length,
        cost: spent / (TOUGHNESS * width * far.max(SPACING)),
        ledger: (after.elastic + after.kinetic + spent) / energy,
    }
}

/// Rice's strip: a crack rests at G_f and runs at 1.25 G_f, which costs 0.9 to 1.15 G_f. At 1.5 G_f
/// it damages more than its own line.
#[test]
fn a_strip_tears_near_its_toughness() {
    for (ratio, [low, high]) in [(1.0, [0.0, 0.0]), (1.25, [0.9, 1.15]), (1.5, [0.9, 1.4])] {
        let torn = strip(ratio);
        println!("Rice's strip at {ratio} G_f: {torn:?}");
        assert!((torn.ledger - 1.0).abs() < 5e-3, "{ratio}: {torn:?}");
        if ratio > 1.0 {
            assert!(torn.length > 0.7 && (low..high).contains(&torn.cost), "{ratio}: {torn:?}");
        } else {
            assert!(torn.length < 0.05, "{ratio}: {torn:?}");
        }
    }
}
