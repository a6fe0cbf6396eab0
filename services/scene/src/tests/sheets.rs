//! What cannot hold of a sheet is told when its scene is read, at its key.

use super::from_text;
use cullet_model::{ContinuumBody, MembraneSheet, SheetSourceKind};

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

/// A ball and a sheet with these quantities.
fn with_ball(quantities: &str) -> String {
    let ball = "[[body]]\nname = \"iron\"\nmaterial = \"steel\"\nposition = [0, 0, 0.1]\n\
                shape = { kind = \"sphere\", radius = 0.02 }\n\
                [[body]]\nname = \"hot ball\"\nmaterial = \"steel\"\nposition = [0, 0, 0.2]\n\
                shape = { kind = \"sphere\", radius = 0.02 }\n";
    format!("{}{ball}", scene(SOFT, &format!("law = \"brittle\"\n{quantities}")))
}

fn sheet_of(quantities: &str) -> Result<MembraneSheet, String> {
    let scene = from_text(&with_ball(quantities), &[]).map_err(|errors| errors.to_string())?;
    match &scene.moving[0].body {
        ContinuumBody::Membrane(sheet) => Ok(sheet.clone()),
        _ => Err("another body".to_owned()),
    }
}

const HEAT: &str = "[[sheet.diffusion]]\nname = \"heat\"\ndiffusivity = [1e-5, 1e-5]\n\
                    source = [{ body = \"hot ball\", film = 1e-3, towards = 80 }]\n";
const WATER: &str = "[[sheet.diffusion]]\nname = \"water\"\nexpansion = [0.01, 0.01]\n\
                     source = [{ patch = { centre = [0, 0], radius = 0.02 }, value = 1 }]\n";

#[test]
fn several_quantities_have_names_and_one_is_shown() -> Result<(), String> {
    let sheet = sheet_of(&[HEAT, WATER].concat())?;
    assert_eq!(sheet.diffusion.names, ["heat", "water"]);
    assert_eq!((sheet.diffusion.all.len(), sheet.diffusion.shown), (2, 0));
    let kind = SheetSourceKind::Contact { object: 1, towards: 80.0, film: 1e-3 };
    assert_eq!(sheet.diffusion.all[0].sources[0].kind, kind);
    assert!(sheet.diffusion.all[0].sources[0].region.has([1e3, -1e3]));
    let shown = |water: &str| sheet_of(&[HEAT, WATER, water].concat()).map(|s| s.diffusion.shown);
    assert_eq!(shown("show = true")?, 1);
    assert_eq!(sheet_of(&[HEAT, "show = false\n", WATER].concat())?.diffusion.shown, 1);
    let twice = sheet_of(&[HEAT, "show = true\n", WATER, "show = true\n"].concat());
    assert!(twice.is_err_and(|told| told.contains("sheet.sheet.diffusion[1].show")));
    Ok(())
}

/// One quantity as a table, as a list of one, with the name that it has without one.
#[test]
fn one_quantity_is_the_same_as_a_table_and_in_a_list() -> Result<(), String> {
    let table = WATER.replace("[[sheet.diffusion]]", "[sheet.diffusion]");
    let nameless = table.replace("name = \"water\"\n", "");
    let named = nameless.replace("expansion", "name = \"quantity\"\nexpansion");
    let list = nameless.replace("[sheet.diffusion]", "[[sheet.diffusion]]");
    let first = sheet_of(&nameless)?;
    assert!(first.diffusion.further().is_none(), "its jobs keep their ids");
    assert_eq!(sheet_of(&named)?, first);
    assert_eq!(sheet_of(&list)?, first);
    assert_eq!(sheet_of(&table)?.diffusion.name(0), "water");
    Ok(())
}

/// Each at its place, and all together.
#[test]
fn what_is_wrong_with_quantities_is_told_at_its_place() {
    let told = |quantities: &[&str]| sheet_of(&quantities.concat()).err().unwrap_or_default();
    let has = |told: String, words: &[&str]| {
        words.iter().for_each(|words| assert!(told.contains(words), "{words}: {told}"));
    };
    let body = |name: &str| HEAT.replace("hot ball", name);
    let absent = ["sheet.sheet.diffusion[1].source[0].body", "no rigid body \"hot bal\""];
    has(told(&[WATER, &body("hot bal")]), &absent);
    has(told(&[WATER, &body("hot bal")]), &["did you mean `hot ball`?"]);
    let jelly = "[[body]]\nname = \"jelly\"\nmaterial = \"rubber\"\nposition = [0, 0, 0.3]\n\
                 solver = \"peridynamics\"\nbreakable = false\n\
                 shape = { kind = \"box\", size = [0.05, 0.05, 0.05] }\n[body.dynamic]\n";
    let soft = format!("{}{jelly}", with_ball(&body("jelly")));
    let soft = from_text(&soft, &[]).err().map(|errors| errors.to_string()).unwrap_or_default();
    has(soft, &["sheet.sheet.diffusion[0].source[0].body", "\"jelly\" is no rigid body"]);
    let double = ["sheet.sheet.diffusion[1].name", "a second quantity is called \"water\""];
    has(told(&[WATER, WATER]), &double);
    let nameless = WATER.replace("name = \"water\"\n", "");
    has(told(&[HEAT, &nameless]), &["sheet.sheet.diffusion[1]", "`name` is missing"]);
    let many: Vec<String> = (0..5).map(|k| WATER.replace("water", &format!("w{k}"))).collect();
    has(told(&[&many.concat()]), &["sheet.sheet.diffusion", "1 to 4 items"]);
    let flux = HEAT.replace("film = 1e-3, towards = 80", "flux = 3");
    has(told(&[&flux]), &["sheet.sheet.diffusion[0].source[0]", "beside `body`"]);
    let nowhere = HEAT.replace("body = \"hot ball\", ", "");
    has(told(&[&nowhere]), &["sheet.sheet.diffusion[0].source[0]", "`patch` is missing"]);
    let swollen = HEAT.replace("source", "expansion = [0.1, 0.1]\nsource");
    has(told(&[WATER, &swollen]), &["sheet.sheet.diffusion[1].source[0]", "strain by what"]);
    has(told(&["diffusion = 3\n"]), &["sheet.sheet.diffusion", "must be a table"]);
    has(told(&["diffusion = [3]\n"]), &["sheet.sheet.diffusion[0]", "must be a table"]);
    has(
        told(&[WATER, "losses = 3\n"]),
        &["sheet.sheet.diffusion[0].losses", "did you mean `loss`"],
    );
    let table = WATER.replace("[[sheet.diffusion]]", "[sheet.diffusion]");
    has(told(&[&table, "losses = 3\n"]), &["sheet.sheet.diffusion.losses", "did you mean `loss`"]);
}
