//! A draft is a coarser scene, and nothing else.

use super::{SMALL, Scene, from_text};
use cullet_model::ContinuumBody;

const PAPER: &str = "[[material]]\nname = \"own\"\ndensity = 800\nyoung = 2e9\npoisson = 0.333\n\
                     strength = 30e6\nfracture_energy = 3000\n[[sheet]]\nname = \"sheet\"\n\
                     material = \"own\"\nsize = [0.2, 0.1]\nthickness = 1e-4\nspacing = 4e-3\n\
                     law = \"brittle\"\n";

/// A draft of 16 times: 16^(1/4) = 2 for solids, and 2³ fewer points.
#[test]
fn a_draft_is_coarser_by_what_its_cost_goes_with() {
    let more = ["body.cube.resolution.spacing=4 mm", "fracture.max_particles=8000"];
    let whole = from_text(SMALL, &more).expect("loads");
    let draft = from_text(SMALL, &[more[0], more[1], "fidelity.draft=16"]).expect("loads");
    assert_eq!((whole.bodies[0].spacing, draft.bodies[0].spacing), (Some(0.004), Some(0.008)));
    assert_eq!((whole.fracture.max_particles, draft.fracture.max_particles), (8000, 1000));
    assert!(!draft.fidelity.is_asked(), "a draft asks for no other grids");
    let told = |scene: &Scene| scene.warnings.iter().any(|line| line.contains("16 times cheaper"));
    assert!(told(&draft) && !told(&whole));
    let sheet = |scene: &Scene| match &scene.moving[0].body {
        ContinuumBody::Membrane(sheet) => sheet.spacing,
        _ => panic!("a sheet"),
    };
    let (whole, draft) = (from_text(PAPER, &[]), from_text(PAPER, &["fidelity.draft=8"]));
    let (whole, draft) = (whole.expect("loads"), draft.expect("loads"));
    assert!((sheet(&draft) / sheet(&whole) - 2.0).abs() < 1e-12, "8^(1/3)");
    let low = from_text(SMALL, &["fidelity.draft=0.5"]).expect_err("below 1").to_string();
    assert!(low.contains("fidelity.draft") && low.contains('1'), "{low}");
}
