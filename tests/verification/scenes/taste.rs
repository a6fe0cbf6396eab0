//! Fracture to taste: pieces that are asked for, guide points, parts that stay whole, scored lines,
//! and that all of it is told as directed.

use crate::common::{Cullet, corpus, unique};
use cullet_record::{FragmentOrigin, Recording};
use serde_json::Value;
use std::path::PathBuf;

/// Runs a scene of the corpus; hands back its folder and its summary.
fn run(scene: &str, sets: &[&str]) -> (PathBuf, Value) {
    let folder = unique(scene);
    let command = Cullet::new(&["run", "-q", "--no-pictures", &corpus(scene), "--out"]);
    let run = command.path(&folder).args(sets).output();
    assert_eq!(run.code, 0, "{scene}: {}", run.stderr);
    let told = super::summary(&folder);
    (folder, told)
}

#[test]
fn a_vase_comes_apart_as_the_scene_wants() {
    let (folder, told) = run("taste.toml", &[]);
    let recording = Recording::open(&folder.join("run.mcap")).expect("a recording");
    let first: Vec<_> = recording.bodies.iter().filter(|body| body.generation == 1).collect();
    assert!((20..=28).contains(&first.len()), "{} pieces", first.len());
    let origins = recording.origins();
    let directed = |id: &u64| origins.get(id) == Some(&FragmentOrigin::Directed);
    let count = first.iter().filter(|body| directed(&body.id)).count() as u64;
    assert!(count > 0 && told["directed"]["pieces"] == count, "{count} in {told:#}");
    assert!(told["shares"]["directed"]["pieces"].as_u64() <= Some(count), "{told:#}");
    let area = |key: &str| told["directed"][key].as_f64().unwrap_or_default();
    assert!(area("added_crack_area") + area("closed_crack_area") > 0.0, "{told:#}");
    let ledger = &told["ledger"];
    for key in ["mass_rel_error", "momentum_rel_error", "angular_momentum_rel_error"] {
        assert!(ledger[key].as_f64().is_some_and(|value| value <= 1e-9), "{key} in {told:#}");
    }
    let look = recording.interiors()["vase"];
    assert_eq!((look.colour, look.roughness), ([0.72, 0.33, 0.2], 1.0));
    let said = Cullet::new(&["inspect"]).path(&folder.join("run.mcap")).output();
    assert!(said.stdout.contains(" directed"), "{}", said.stdout);
    let table = Cullet::new(&["inspect", "--masses"]).path(&folder.join("run.mcap")).output();
    assert!(table.stdout.contains(",directed,false\n"), "{}", table.stdout);
}
