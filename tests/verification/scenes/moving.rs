//! Scenes of sheets on a base or under a quench, of soft shells and of soft solids.

use super::{Cullet, Path, Recording, Shown, parts_along, torn, unique};
use cullet_geometry::Vec3;

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

/// Two patches that share an edge are one wall: they drape as one patch does. Compared by how far
/// the cloth spreads each way and hangs down.
#[test]
fn cloth_of_two_patches_is_that_of_one() {
    let spread = |mesh: &str| {
        let folder = unique("patches");
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cloth");
        let mesh = scene.join(mesh);
        let set = format!("body.cloth.mesh={:?}", mesh.display().to_string());
        let call = Cullet::new(&["run", "-q", "--no-pictures", "--set", &set, "--out"]);
        let call = call.path(&folder).args(&["--set", "world.duration=0.4"]).path(&scene);
        let run = call.output();
        assert_eq!(run.code, 0, "{}", run.stderr);
        let recording = Recording::open(&folder.join("run.mcap")).expect("a recording");
        let last = recording.sheets()[0].frames.last().copied().expect("a frame");
        let moment = recording.sheet_at(0, last.step).expect("sound").expect("a moment");
        std::fs::remove_dir_all(&folder).ok();
        let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        moment.places.iter().fold(none, |(low, high), p| (low.inf(p), high.sup(p)))
    };
    let (one, two) = (spread("one-patch.json"), spread("two-patches.json"));
    let off = (one.0 - two.0).norm().max((one.1 - two.1).norm());
    assert!(two.0.z < 0.1 && off < 5e-3, "{off} m: {one:?} {two:?}");
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
    let shown = Shown::of("rubber");
    let (pieces, area, off) = torn(&shown);
    assert!(
        pieces >= 2 && (2.2e-4..1.2e-3).contains(&area) && off < 0.02,
        "{pieces}, {area}, {off}"
    );
    shown.is_predicted_by_a_draft("rubber");
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
