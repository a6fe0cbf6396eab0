//! What a change can reach: each kind of change once, and that the scenes which stand for the
//! families are tests that exist.

use cullet_tests::house::MAY_USE;
use cullet_tests::reach::{LONG, Reach, SCENES};
use cullet_tests::{files, root};
use std::collections::BTreeSet;
use std::fs;

fn of(changed: &[&str]) -> Reach {
    Reach::of(changed.iter().copied())
}

#[test]
fn a_solver_reaches_its_suite_and_what_solves_with_it() {
    let reach = of(&["services/shell/src/lib.rs"]);
    assert_eq!(reach.everything, None);
    assert!(reach.has("shell") && reach.has("worker") && reach.has("cullet"));
    assert!(!reach.has("fracture") && !reach.has("geometry"), "{reach:?}");
    let tests = reach.tests();
    assert!(tests.contains("package(cullet-shell)") && tests.contains("package(cullet-tests)"));
    assert!(!tests.contains("package(cullet-fracture)"), "{tests}");
    assert!(reach.left_out().contains("verification of fracture"), "{}", reach.left_out());
}

#[test]
fn a_picture_reaches_no_solver() {
    let reach = of(&["services/view/src/lib.rs", "docs/watch.md", "README.md"]);
    let tests = reach.tests();
    assert_eq!((reach.everything.as_ref(), reach.exports, reach.wheel), (None, true, false));
    assert!(!tests.contains("package(cullet-shell)") && tests.contains("binary(farm)"), "{tests}");
    assert!(tests.contains("scenes") && tests.contains("pot|bulb"), "{tests}");
    assert!(!tests.contains("test(/^scenes::/)"), "{tests}");
}

#[test]
fn documents_reach_the_scenes_of_each_family_and_the_farm_alone() {
    let reach = of(&["docs/method.md", "CHANGELOG.md", "tests/fast/sizes.rs", ".ci/green"]);
    assert_eq!(reach.everything, None);
    assert!(reach.crates.is_empty() && !reach.wheel && !reach.exports && !reach.stability);
    assert_eq!(reach.tests().matches("binary(verification)").count(), 1, "{}", reach.tests());
}

#[test]
fn what_is_in_doubt_reaches_everything() {
    for path in ["Cargo.lock", "Cargo.toml", ".ci/run", "tests/common/mod.rs", "a-new-folder/x"] {
        assert!(of(&[path]).everything.is_some(), "{path}");
    }
    for folder in ["proto", "services/model", "services/geometry"] {
        let reach = of(&[&format!("{folder}/src/lib.rs")]);
        assert!(reach.everything.is_some() && reach.wheel && reach.exports, "{folder}");
        assert_all_suites(&reach);
    }
    assert_all_suites(&Reach::everything("no base"));
}

/// All suites, and of the scenes those that stand for a family.
fn assert_all_suites(reach: &Reach) {
    let tests = reach.tests();
    let suites = "binary(farm) | (binary(verification) - (package(cullet) & test(/^scenes::/)))";
    assert!(tests.starts_with(suites) && tests.contains("?(pot|bulb|"), "{tests}");
    assert_eq!(reach.folders_of_scenes().len(), SCENES.len());
    let left_out = "scenes that stand for no family, long tests of what did not change";
    assert_eq!(reach.left_out(), left_out);
}

#[test]
fn long_tests_run_where_their_crate_changed() {
    let long = |path: &str| of(&[path]).long_tests();
    assert_eq!(long("services/shell/src/lib.rs"), "none()");
    assert_eq!(long("services/fracture/src/lib.rs"), "test(/^specimens::/)");
    assert_eq!(long("services/worker/src/lib.rs"), "binary_id(cullet::farm)");
    assert_eq!(long("tests/farm/history.rs"), "binary_id(cullet::farm)");
    let suites = "test(/^coupling::/) | test(/^fidelity::/) | test(/^specimens::/)";
    assert_eq!(long("tests/verification/specimens.rs"), suites);
    for (_, crates) in LONG {
        for folder in crates {
            assert!(MAY_USE.iter().any(|(name, _)| name == folder), "{folder}");
        }
    }
}

/// Every ignored test is a long one of a suite that `LONG` finds, and whatever `LONG` names has
/// one. Tests of a crate run wherever it is reached.
#[test]
fn what_is_ignored_is_long_and_known() {
    let mut found = BTreeSet::new();
    let mut strange = Vec::new();
    for file in files(&root(), &[".rs"]) {
        let text = fs::read_to_string(&file).expect("a source file is readable");
        let lines = text.lines().map(str::trim);
        let marks: Vec<&str> = lines.filter(|line| line.starts_with("#[ignore")).collect();
        if marks.is_empty() {
            continue;
        }
        let path = file.strip_prefix(root()).expect("below the root").display().to_string();
        let mut parts = path.split('/');
        let filter = match (parts.next(), parts.next(), parts.next()) {
            (Some("tests"), Some("verification"), Some(name)) => {
                format!("test(/^{}::/)", name.trim_end_matches(".rs"))
            }
            (Some("tests"), Some("farm"), _) => "binary_id(cullet::farm)".to_owned(),
            _ => path.clone(),
        };
        let long = marks.iter().all(|mark| *mark == "#[ignore = \"long\"]");
        if !long || !LONG.iter().any(|(tests, _)| *tests == filter) {
            strange.push(path);
        }
        found.insert(filter);
    }
    assert_eq!(strange, Vec::<String>::new());
    assert!(LONG.iter().all(|(tests, _)| found.contains(*tests)), "{found:?}");
}

#[test]
fn a_scene_that_changed_is_run() {
    let reach = of(&["scenes/two-sources/scene.toml"]);
    assert!(reach.tests().contains("|two_sources)"), "{}", reach.tests());
    assert!(reach.folders_of_scenes().contains(&"two-sources".to_owned()));
}

#[test]
fn the_scenes_that_stand_for_families_are_tests() {
    let mut text = String::new();
    for file in files(&root().join("tests/verification"), &[".rs"]) {
        text += &fs::read_to_string(file).expect("a source file is readable");
    }
    for (scene, family) in SCENES {
        assert!(text.contains(&format!("fn {scene}() {{")), "{scene}, for {family}, is no test");
        assert!(root().join("scenes").join(scene.replace('_', "-")).is_dir(), "{scene}");
    }
    let hits = cullet_plan::family::FAMILIES.iter().map(|family| family.name);
    let moving = cullet_worker::families::CONTINUA.iter().map(|family| family.name);
    for name in hits.chain(moving) {
        assert!(SCENES.iter().any(|(_, family)| *family == name), "no scene stands for {name}");
    }
}

/// The commands that README names are those that `.ci/run` calls.
#[test]
fn readme_names_the_test_command_that_is_run() {
    let command = "cargo test --locked --release --workspace --lib --bins --test fast --test smoke";
    for name in ["README.md", "CONTRIBUTING.md", ".ci/run", "justfile"] {
        let text = fs::read_to_string(root().join(name)).expect(name);
        assert!(text.contains(command), "{name} does not name `{command}`");
    }
}
