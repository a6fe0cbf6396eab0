//! Metals that yield: presets, written numbers, and bodies that cannot be of one.

use super::from_text;
use cullet_model::{Hardening, JohnsonCook};

/// A plate of a material, on a floor that it lies above.
fn scene(material: &str, more: &str) -> String {
    format!(
        "[[material]]\nname = \"own\"\n{material}\n\
         [[body]]\nname = \"plate\"\nmaterial = \"own\"\nposition = [0, 0, 1]\n\
         shape = {{ kind = \"box\", size = [0.4, 0.3, 0.001] }}\n{more}\n\
         [[body]]\nname = \"floor\"\nshape = {{ kind = \"box\", size = [2, 2, 0.2] }}\n\
         material = \"granite\"\nfixed = true\n"
    )
}

/// How the plate yields, and the stress from which its hits are worth a solve \[Pa\].
fn plasticity(material: &str) -> (Option<JohnsonCook>, f64) {
    let scene = from_text(&scene(material, ""), &[]).unwrap_or_else(|why| panic!("{why}"));
    let plate = scene.bodies.iter().find(|body| body.name == "plate").expect("a plate");
    (plate.material.plasticity, crate::rigid::spec(plate).material.solid.failure_stress)
}

#[test]
fn numbers_come_from_the_scene_or_the_preset() {
    let steel = "preset = \"steel\"\nbreakable = true\n";
    let hardening = |yield_stress, hardening, exponent| {
        let hardening = Hardening { yield_stress, hardening, exponent };
        (Some(JohnsonCook::from(hardening)), yield_stress)
    };
    for (written, wanted) in [
        (steel.to_owned(), (None, 450e6)),
        ("preset = \"mild-steel\"".to_owned(), hardening(200e6, 400e6, 0.45)),
        (format!("{steel}plasticity = {{ yield_stress = 3e8 }}"), hardening(3e8, 0.0, 1.0)),
        (
            "preset = \"mild-steel\"\nplasticity = { yield_stress = \"250 MPa\", hardening = 1e8 }"
                .to_owned(),
            hardening(250e6, 1e8, 1.0),
        ),
    ] {
        assert_eq!(plasticity(&written), wanted, "{written}");
    }
}

/// What is written of the law comes whole, and presets have theirs.
#[test]
fn a_metal_goes_by_rate_and_warmth_and_tears() {
    let written = "preset = \"steel\"\nbreakable = true\n[material.plasticity]\n\
                   yield_stress = \"792 MPa\"\nhardening = \"510 MPa\"\nexponent = 0.26\n\
                   rate = 0.014\nsoftening = { melting = 1500, exponent = 1.03, \
                   heat_capacity = 477 }\nfailure = [0.05, 3.44, -2.12, 0.002, 0.61]\n";
    let (own, preset) = (plasticity(written).0, plasticity("preset = \"armour-steel\"").0);
    assert!(own.is_some_and(|flow| !flow.is_plain()) && own == preset, "{own:?}, {preset:?}");
}

/// The toughness of a material that only flows is not looked at; a tear costs G_f.
#[test]
fn the_toughness_of_what_tears_is_looked_at() {
    let doubts = |material: &str| {
        let scene = from_text(&scene(material, ""), &[]).unwrap_or_else(|why| panic!("{why}"));
        scene.warnings.iter().filter(|line| line.contains("K_Ic")).count()
    };
    let metal = "preset = \"mild-steel\"\nfracture_energy = 1e-4\n";
    let tears = "plasticity = { yield_stress = 3e8, failure = [0.1, 0.5, -1.5, 0, 0] }";
    assert_eq!(doubts(metal), 0);
    assert_eq!(doubts(&format!("{metal}{tears}")), 1);
}

#[test]
fn what_cannot_yield_is_told_with_its_place_and_bound() {
    let steel = |keys: &str| format!("preset = \"mild-steel\"\n{keys}");
    for (material, more, words) in [
        (
            steel("plasticity = { yield_stress = 9e2 }"),
            "",
            "plasticity.yield_stress: must be at least 1000 Pa",
        ),
        (steel("plasticity = { yield_stress = \"9 mm\" }"), "", "plasticity.yield_stress: "),
        (
            steel("plasticity = { yield_stress = 2e8, hardening = -1 }"),
            "",
            "plasticity.hardening: must be at least 0",
        ),
        (
            steel("plasticity = { yield_stress = 2e8, exponent = 1.5 }"),
            "",
            "plasticity.exponent: must be at most 1",
        ),
        (steel("plasticity = { hardening = 2e8 }"), "", "yield_stress"),
        (
            steel("plasticity = { yield_stress = 2e8, rate = -0.1 }"),
            "",
            "plasticity.rate: must be at least 0",
        ),
        (
            steel("plasticity = { yield_stress = 2e8, failure = [0.1, 0.2] }"),
            "",
            "plasticity.failure",
        ),
        (
            steel("plasticity = { yield_stress = 2e8, failure = [-1, 0, 0, 0, 0] }"),
            "",
            "failure strain of a slow pull [1] must lie in [0.01, 100]; it is -1",
        ),
        (
            steel("weak_plane = { normal = [0, 0, 1], ratio = 0.5 }"),
            "",
            "material.own.weak_plane: a metal that yields has none",
        ),
        (
            steel("layers = { normal = [0, 0, 1], thickness = 0.01, ratio = 0.5 }"),
            "",
            "material.own.layers: a metal that yields has none",
        ),
        (
            "preset = \"toughened-glass\"\nplasticity = { yield_stress = 2e8 }".to_owned(),
            "",
            "material.own.plasticity: toughened glass does not yield",
        ),
        (
            steel(""),
            "solver = \"brittle\"",
            "body.plate.solver: `brittle` takes nothing that yields: `shell` and `ductile` do",
        ),
        (
            "preset = \"granite\"".to_owned(),
            "solver = \"ductile\"",
            "body.plate.solver: `ductile` takes only what yields",
        ),
    ] {
        let told = from_text(&scene(&material, more), &[]).expect_err("refused").to_string();
        assert!(told.contains(words), "{words:?} is not in:\n{told}");
    }
}
