//! Scenes from text with files that are given, and with a folder.

use super::super::Scene;
use cullet_document::SceneFile;
use std::sync::Arc;

const TEXT: &str = "\
[world]
duration = 0.1
[[body]]
name = \"a\"
mesh = \"tetra.obj\"
material = \"plaster\"
";

const TETRA: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn given() -> Vec<SceneFile> {
    vec![SceneFile { key: "scene/tetra.obj".to_owned(), bytes: Arc::new(TETRA.into()) }]
}

#[test]
fn a_text_has_its_files_from_what_is_given_or_from_its_folder() {
    let set = ["world.seed=9".to_owned()];
    let first = Scene::assemble("t", TEXT, given(), None, &set).expect("a scene");
    assert!((first.bodies[0].volume - 1.0 / 6.0).abs() < 1e-12);
    assert_eq!((first.name.as_str(), first.world.seed), ("t", 9));
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("tetra.obj"), TETRA).expect("a mesh");
    let second = Scene::assemble("t", TEXT, Vec::new(), Some(folder.path()), &set);
    let second = second.expect("a scene");
    // Whatever they come from, another machine gets the same.
    assert_eq!(first.bundle(), second.bundle());
    let missing = Scene::assemble("t", TEXT, Vec::new(), None, &[]).expect_err("no mesh");
    assert!(missing.to_string().contains("tetra.obj is not in the bundle"), "{missing}");
}
