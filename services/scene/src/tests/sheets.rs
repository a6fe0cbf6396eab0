//! What cannot hold of a sheet is told when its scene is read, at its key.

use super::from_text;

/// A sheet of paper of a material, with more keys.
fn scene(material: &str, more: &str) -> String {
    format!(
        "[[material]]\nname = \"own\"\npreset = \"steel\"\nbreakable = true\n{material}\n\
         [[sheet]]\nname = \"sheet\"\nmaterial = \"own\"\nsize = [0.2, 0.1]\n\
         thickness = 0.0001\nspacing = 0.005\n{more}\n"
    )
}

fn told(material: &str, more: &str) -> String {
    match from_text(&scene(material, more), &[]) {
        Ok(scene) => {
            assert_eq!(scene.moving.len(), 1);
            String::new()
        }
        Err(errors) => errors.to_string(),
    }
}

const SOFT: &str = "density = 1000\nyoung = 1e9\npoisson = 0.2\nfracture_energy = 1000";

#[test]
fn a_sheet_that_cannot_be_simulated_is_told_before_its_run() {
    assert_eq!(told(SOFT, "law = \"brittle\""), "");
    let rubber = told(SOFT, "law = \"rubber\"");
    assert!(
        rubber.contains("sheet.sheet.material") && rubber.contains("1/3 by nature"),
        "{rubber}"
    );
    assert_eq!(told(SOFT, "law = \"brittle\"\npace = { softer = 115 }"), "");
    let pace = told(SOFT, "law = \"brittle\"\npace = { softer = 99 }");
    assert!(
        pace.contains("sheet.sheet.pace.softer") && pace.contains("critical stretch"),
        "{pace}"
    );
}

#[test]
fn a_source_that_swells_a_sheet_too_much_is_told() {
    let water = |value: f64| {
        let source =
            |value| format!("{{ patch = {{ centre = [0, 0], radius = 0.02 }}, value = {value} }}");
        let sources = [source(1.0), source(value)].join(", ");
        let more = format!(
            "law = \"brittle\"\n[sheet.diffusion]\ndiffusivity = [1e-5, 1e-5]\n\
             expansion = [-0.1, 0.1]\nsource = [{sources}]"
        );
        told(SOFT, &more)
    };
    assert_eq!(water(4.9), "");
    let swollen = water(5.1);
    assert!(swollen.contains("sheet.sheet.diffusion.source[1]"), "{swollen}");
    assert!(swollen.contains("strain by what a sheet takes up"), "{swollen}");
}

/// They would end the run at its first window.
#[test]
fn too_many_points_are_told() {
    let text = scene(SOFT, "law = \"brittle\"").replace("spacing = 0.005", "spacing = 0.0004");
    let told = from_text(&text, &[]).err().map(|errors| errors.to_string()).unwrap_or_default();
    assert!(told.contains("sheet.sheet.spacing") && told.contains("1.000e5"), "{told}");
}
