//! Directed scenes: joints, glue, driven bodies, bodies of several shapes.

use super::{Shown, summary};

/// How many joints were made and broke, and the work of driven bodies \[J\].
fn directed(shown: &Shown) -> (u64, u64, f64) {
    let told = summary(&shown.folder);
    let of = &told["directed"];
    let count = |key: &str| of[key].as_u64().unwrap_or_else(|| panic!("no {key} in {told:#}"));
    let work = of["driven_work"].as_f64().unwrap_or(f64::NAN);
    assert!(shown.told.contains("directed: "), "{}", shown.told);
    (count("joints"), count("joints_broken"), work)
}

/// The ball goes through: it takes bricks out of the middle, and what it does not reach stands.
#[test]
fn mortar() {
    let shown = Shown::of("mortar");
    let (joints, broken, _) = directed(&shown);
    assert!(joints > 300 && broken > 20 && broken < joints, "{broken} of {joints}");
    assert!(!shown.told.contains("of ball and the world breaks"), "the rope holds");
}

#[test]
fn facade() {
    let shown = Shown::of("facade");
    let (joints, broken, work) = directed(&shown);
    assert!(joints > 150 && broken > 20 && broken < joints, "{broken} of {joints}");
    assert!(work > 0.0, "the ball did {work} J");
}

/// Cups of two shapes each are closed, and break as one body.
#[test]
fn tea() {
    let shown = Shown::of("tea");
    let recording = shown.recording();
    let cups = recording.bodies.iter().filter(|body| body.parent.is_none());
    let cups: Vec<_> = cups.filter(|body| body.name.starts_with("cup")).collect();
    assert_eq!(cups.len(), 3);
    // A wall of 6.5 mm and a handle.
    assert!(cups.iter().all(|cup| (1e-4..2.5e-4).contains(&cup.volume)), "{}", cups[0].volume);
    let (joints, _, work) = directed(&shown);
    assert!(joints == 0 && work > 0.0, "the arm did {work} J");
}
