//! Treatments of glass: presets, written numbers, and bodies that cannot have one.

use super::from_text;
use cullet_model::{Interlayer, Treatment};

/// A pane of a material, on a floor that it lies above.
fn scene(material: &str, pane: &str) -> String {
    format!(
        "[[material]]\nname = \"own\"\n{material}\n\
         [[body]]\nname = \"pane\"\nmaterial = \"own\"\nposition = [0, 0, 1]\n{pane}\n\
         [[body]]\nname = \"floor\"\nshape = {{ kind = \"box\", size = [2, 2, 0.2] }}\n\
         material = \"granite\"\nfixed = true\n"
    )
}

/// A bowl with a thin wall.
const BOWL: &str = "shape = { kind = \"shell\", thickness = \"3 mm\", profile = [[0, 0], \
                    [0.03, 0.004], [0.06, 0.02], [0.08, 0.045], [0.09, 0.08]] }";

const PANE: &str = "shape = { kind = \"box\", size = [\"40 cm\", \"30 cm\", \"6 mm\"] }";

fn treatment(material: &str) -> Option<Treatment> {
    let scene = from_text(&scene(material, PANE), &[]).unwrap_or_else(|why| panic!("{why}"));
    scene.bodies.iter().find(|body| body.name == "pane").expect("a pane").material.treatment
}

fn errors(material: &str, pane: &str) -> String {
    from_text(&scene(material, pane), &[]).expect_err("refused").to_string()
}

#[test]
fn numbers_come_from_the_scene_the_preset_or_the_default() {
    let toughened = |surface_stress| Some(Treatment::Toughened { surface_stress });
    let glass = "preset = \"soda-lime-glass\"\n";
    let laminated = |thickness, strength| {
        let interlayer = Interlayer { thickness, strength, stretch: 2.0 };
        Some(Treatment::Laminated { interlayer })
    };
    let film = "interlayer = { thickness = \"1.52 mm\", strength = \"25 MPa\" }";
    for (written, wanted) in [
        (glass.to_owned(), None),
        (format!("{glass}treatment = \"annealed\""), None),
        ("preset = \"toughened-glass\"\ntreatment = \"annealed\"".to_owned(), None),
        ("preset = \"toughened-glass\"".to_owned(), toughened(90e6)),
        ("preset = \"toughened-glass\"\nsurface_stress = \"120 MPa\"".to_owned(), toughened(120e6)),
        (format!("{glass}treatment = \"toughened\"\nsurface_stress = 7e7"), toughened(70e6)),
        (
            format!("{glass}treatment = \"heat-strengthened\""),
            Some(Treatment::HeatStrengthened { surface_stress: 40e6 }),
        ),
        ("preset = \"laminated-glass\"".to_owned(), laminated(0.76e-3, 20e6)),
        (format!("{glass}treatment = \"laminated\"\n{film}"), laminated(1.52e-3, 25e6)),
    ] {
        assert_eq!(treatment(&written), wanted, "{written}");
    }
}

#[test]
fn what_is_no_treatment_is_told_with_its_place_and_bound() {
    let glass = |keys: &str| format!("preset = \"soda-lime-glass\"\n{keys}");
    let cube = "shape = { kind = \"box\", size = [0.2, 0.2, 0.2] }";
    let thick = "shape = { kind = \"box\", size = [0.2, 0.2, 0.03] }";
    let named = format!("{PANE}\nsolver = \"brittle\"");
    for (material, pane, words) in [
        (glass("treatment = \"tempered\""), PANE, "material.own.treatment: "),
        (glass("treatment = \"toughened\"\nsurface_stress = \"-9 MPa\""), PANE, "at least 1e6 Pa"),
        (glass("treatment = \"toughened\"\nsurface_stress = \"9 mm\""), PANE, "surface_stress: "),
        (glass("surface_stress = \"90 MPa\""), PANE, "material.own.surface_stress: is of `heat-"),
        (
            glass("treatment = \"toughened\"\ninterlayer = { stretch = 2 }"),
            PANE,
            "material.own.interlayer: is of `laminated` glass",
        ),
        (
            glass("treatment = \"laminated\"\ninterlayer = { stretch = 0.5 }"),
            PANE,
            "material.own.interlayer.stretch: must be",
        ),
        (
            glass("treatment = \"toughened\"\nweak_plane = { normal = [0, 0, 1], ratio = 0.5 }"),
            PANE,
            "material.own.weak_plane: toughened glass has none",
        ),
        (
            glass("treatment = \"toughened\""),
            cube,
            "body.pane.material: toughened glass breaks only",
        ),
        (glass("treatment = \"toughened\""), thick, "this is 0.150 times as thick as it is wide"),
        (
            glass("treatment = \"toughened\""),
            BOWL,
            "toughened glass breaks only as a flat thin plate, and this is none",
        ),
        (
            glass("treatment = \"laminated\""),
            cube,
            "laminated glass breaks only as a thin plate or wall, and this is",
        ),
        (
            glass("treatment = \"laminated\""),
            named.as_str(),
            "body.pane.solver: `brittle` takes no laminated glass: `shell` does",
        ),
    ] {
        let said = errors(&material, pane);
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
    for kind in ["laminated", "heat-strengthened"] {
        let bowl = from_text(&scene(&glass(&format!("treatment = \"{kind}\"")), BOWL), &[]);
        assert!(bowl.is_ok(), "a curved wall of {kind} glass");
    }
    let whole = format!("{cube}\nbreakable = false");
    assert!(from_text(&scene(&glass("treatment = \"toughened\""), &whole), &[]).is_ok());
}
