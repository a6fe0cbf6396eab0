//! Scenes of sheets on a base or under a quench, of soft shells and of soft solids.

use super::{Shown, parts_along, torn};

/// Cracks run in from the cold edge and part nothing.
#[test]
fn quench() {
    let (_, area, off) = torn(&Shown::of("quench"));
    assert!((2e-5..3e-4).contains(&area) && off < 0.06, "{area}, {off}");
}

/// Plates of some centimetres: cracks of more than 4 m in 0.12 m² of mud, 5 mm thick.
#[test]
fn mud() {
    let (pieces, area, off) = torn(&Shown::of("mud"));
    assert!(pieces > 10 && (1.5e-2..4e-2).contains(&area) && off < 0.02, "{pieces}, {area}, {off}");
}

/// Two parts, as it was cut, and nothing tears on.
#[test]
fn jelly() {
    let (pieces, area, off) = torn(&Shown::of("jelly"));
    assert!(pieces == 2 && area < 1e-4 && off < 0.02, "{pieces}, {area}, {off}");
}

/// The arm is off: its section is some 4 cm².
#[test]
fn gummy() {
    let (pieces, area, off) = torn(&Shown::of("gummy"));
    assert!(pieces >= 2 && (2e-4..3e-3).contains(&area) && off < 0.02, "{pieces}, {area}, {off}");
}

/// Nothing tears, and the books close.
#[test]
fn beams() {
    let (pieces, area, off) = torn(&Shown::of("beams"));
    assert!(pieces == 5 && area == 0.0 && off < 0.01, "{pieces}, {area}, {off}");
}

/// Nothing tears, and the books close.
#[test]
fn cloth() {
    let (pieces, area, off) = torn(&Shown::of("cloth"));
    assert!(pieces == 1 && area == 0.0 && off < 0.02, "{pieces}, {area}, {off}");
}

/// Nothing tears, and the books close.
#[test]
fn tube() {
    let (pieces, area, off) = torn(&Shown::of("tube"));
    assert!(pieces == 1 && area == 0.0 && off < 0.02, "{pieces}, {area}, {off}");
}

/// A tear of 140 mm from notch to notch through 2 mm of rubber, with what tears beside it.
#[test]
fn rubber() {
    let (pieces, area, off) = torn(&Shown::of("rubber"));
    assert!(
        pieces >= 2 && (2.2e-4..1.2e-3).contains(&area) && off < 0.02,
        "{pieces}, {area}, {off}"
    );
}

/// It tears.
#[test]
fn garment() {
    let (pieces, area, off) = torn(&Shown::of("garment"));
    assert!(pieces >= 2 && area > 1e-4 && off < 0.02, "{pieces}, {area}, {off}");
}

/// The ball goes through a hole of more than its size.
#[test]
fn pierced() {
    let shown = Shown::of("pierced");
    let (_, area, off) = torn(&shown);
    assert!(area > 3e-4 && off < 0.03, "{area}, {off}");
    let along = parts_along(&shown.recording(), "ball", 2);
    let last = along.last().expect("a step")[0].1;
    assert!(last < -0.1, "the ball is at {last} m");
}

/// One piece, as long as the spiral, and nothing tears.
#[test]
fn spiral() {
    let (pieces, area, off) = torn(&Shown::of("spiral"));
    assert!(pieces == 1 && area == 0.0 && off < 0.02, "{pieces}, {area}, {off}");
}
