//! What the program says of itself and of what it is given: its version and scenes, scenes that are
//! not there, meshes, what is no TOML, numbers that are none.

use crate::common;

use common::{Cullet, Said, corpus, free_endpoint, summary, unique, until};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);

/// The scenes of the sources.
fn shipped() -> PathBuf {
    common::file_of("scenes")
}

fn says(said: &Said, words: &[&str]) {
    assert_eq!(said.code, 64, "{words:?}: {}{}", said.stdout, said.stderr);
    for words in words {
        assert!(said.stderr.contains(words), "{words:?} is not in: {}", said.stderr);
    }
}

/// A folder of the test's own.
fn folder(name: &str) -> PathBuf {
    let folder = unique(name);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// A cube of that many units, of which faces may be left out.
fn cube(side: f64, faces: usize) -> String {
    let corner = |n: u32| [n & 1, n >> 1 & 1, n >> 2].map(|bit| f64::from(bit) * side);
    let corners = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let sides = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    let sides = sides.iter().take(faces).map(|side| format!("f {side}\n"));
    corners.chain(sides).collect()
}

#[test]
fn the_version_has_the_commit_and_the_build_that_workers_tell() {
    let _left = common::left::NobodyLeft::watch();
    let said = Cullet::new(&["--version"]).output();
    assert_eq!((said.code, &*said.stderr), (0, ""));
    let told = said.stdout.trim_end();
    let rest = told.strip_prefix(concat!("cullet ", env!("CARGO_PKG_VERSION"), " (commit "));
    let parts = rest.and_then(|rest| rest.strip_suffix(')')?.split_once(", build "));
    let (commit, build) = parts.unwrap_or_else(|| panic!("{told:?}"));
    let hash = commit.trim_end_matches("-changed");
    assert!(hash == "unknown" || hash.chars().all(|c| c.is_ascii_hexdigit()), "{commit:?}");
    assert_eq!(build.len(), 8, "{build:?}");
    let doctor = Cullet::new(&["doctor"]).output().stdout;
    assert!(doctor.contains(told), "{doctor}");
    let endpoint = free_endpoint();
    let call = ["coordinator", "--listen", &endpoint, "--workers", "1"];
    let _coordinator = Cullet::new(&call).spawn();
    until("its worker is there", LONG, || {
        let said = Cullet::new(&["workers", "--json", "--connect", &endpoint]).output();
        let workers: Value = serde_json::from_str(&said.stdout).unwrap_or_default();
        workers["workers"][0]["build"].as_str().is_some_and(|of_worker| {
            assert_eq!(of_worker, build);
            true
        })
    });
}

#[test]
fn shipped_scenes_are_listed_and_a_copy_of_one_runs_as_the_original_does() {
    let _left = common::left::NobodyLeft::watch();
    let listed = Cullet::new(&["scenes"]).output();
    let entries = fs::read_dir(shipped()).expect("a folder");
    let scenes = entries.filter(|entry| entry.as_ref().is_ok_and(|e| e.path().is_dir())).count();
    assert_eq!((listed.code, listed.stdout.lines().count()), (0, scenes), "{}", listed.stdout);
    let told = |line: &str| line.starts_with("pot ") && line.contains("  A stoneware pot falls ");
    assert!(listed.stdout.lines().any(told), "{}", listed.stdout);
    let json = Cullet::new(&["scenes", "--json"]).output().stdout;
    let json: Vec<Value> = serde_json::from_str(&json).expect("a list");
    let garment = json.iter().find(|scene| scene["name"] == "garment").expect("it is there");
    assert!(json.len() == scenes && garment["files"][0] == "dress.obj", "{garment}");

    let base = folder("from");
    let said = Cullet::new(&["new", "mine", "--from", "pot"]).within(&base).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let read = |path: &Path| fs::read_to_string(path.join("scene.toml")).expect("a scene");
    let (copy, original) = (read(&base.join("mine")), read(&shipped().join("pot")));
    assert_eq!(copy.replace(":schema ", ":schema ../"), original);
    assert!(base.join("mine/scene.schema.json").is_file(), "editors have no schema");
    let digest = |scene: &Path| {
        let out = unique("from-run");
        let set = ["--set", "fracture.solver=geometric", "--set", "world.duration=0.05"];
        let call = Cullet::new(&["run", "-q", "--no-pictures"]).args(&set).path(scene);
        let run = call.args(&["-o"]).path(&out).output();
        assert!(common::DONE.contains(&run.code), "{}", run.stderr);
        summary(&out)["digest"].clone()
    };
    assert_eq!(digest(&base.join("mine")), digest(&shipped().join("pot")));
    says(&Cullet::new(&["new", "x", "--from", "pott"]).within(&base).output(), &["`pot`"]);
    assert!(!base.join("x").exists());
}

#[test]
fn every_command_tells_of_a_scene_that_is_not_there_which_one_is_meant() {
    let _left = common::left::NobodyLeft::watch();
    let base = folder("missing");
    let pot = "`cullet new pot --from pot`, then `cullet run pot`";
    for verb in ["run", "check", "submit", "openjd"] {
        let said = |scene: &str| Cullet::new(&[verb, scene]).within(&base).output();
        says(&said("pot"), &["no file or folder `pot`; a scene of this name is shipped", pot]);
    }
    fs::create_dir_all(base.join("scenes/pot")).expect("a folder");
    fs::write(base.join("scenes/pot/scene.toml"), "").expect("a file");
    for name in ["pot", "pott", "scenes/pott", "scenes/pott/scene.toml"] {
        let said = Cullet::new(&["check", name]).within(&base).output();
        says(&said, &[&format!("no file or folder `{name}`; did you mean scenes/pot?")]);
    }
    let sweep = "scene = \"scenes/pott\"\n[product]\n\"world.seed\" = [1]\n";
    fs::write(base.join("sweep.toml"), sweep).expect("a file");
    let said = Cullet::new(&["run", "sweep.toml"]).within(&base).output();
    says(&said, &["did you mean scenes/pot?"]);
}

#[test]
fn a_mesh_becomes_a_scene_by_the_command_that_is_named() {
    let _left = common::left::NobodyLeft::watch();
    let base = folder("mesh");
    let at = |name: &str| base.join(name);
    fs::write(at("Cow.OBJ"), format!("mtllib cow.mtl\nusemtl skin\n{}", cube(120.0, 6)))
        .expect("a mesh");
    fs::write(at("cow.mtl"), "newmtl skin\nKd 1 0 0\n").expect("a library");
    let said = Cullet::new(&["run", "Cow.OBJ"]).within(&base).output();
    let call = "`cullet new Cow --mesh Cow.OBJ`, then `cullet run Cow`";
    says(&said, &["Cow.OBJ is a mesh", call]);
    let said = Cullet::new(&["new", "cow", "--mesh", "Cow.OBJ"]).within(&base).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let told = "in metres it would be 120 m long; it is taken to be in millimetres: scale = 0.001";
    assert!(said.stdout.contains(told), "{}", said.stdout);
    for file in ["Cow.OBJ", "cow.mtl"] {
        let (made, given) = (fs::read(at("cow").join(file)), fs::read(at(file)));
        assert_eq!(made.expect("a copy"), given.expect("a file"), "{file}");
    }
    let text = fs::read_to_string(at("cow/scene.toml")).expect("a scene");
    assert!(text.contains("scale = 0.001 # in metres it would be 120 m long"), "{text}");
    let check = Cullet::new(&["check", "cow"]).within(&base).output();
    let told = check.stdout.contains("  Cow: plaster, ") && !check.stdout.contains("warning");
    assert!(check.code == 0 && told, "{}{}", check.stdout, check.stderr);
    // One that is refused leaves nothing, and says why.
    fs::write(at("flat.obj"), cube(1.0, 1)).expect("a mesh");
    fs::write(at("none.obj"), "hello\n").expect("a mesh");
    for mesh in ["flat.obj", "none.obj"] {
        let said = Cullet::new(&["new", "bad", "--mesh", mesh]).within(&base).output();
        says(&said, &[mesh]);
        assert!(!said.stderr.contains("scene.toml") && !at("bad").exists(), "{}", said.stderr);
    }
    let said = Cullet::new(&["new", "bad", "--mesh", "lost.obj"]).within(&base).output();
    assert!(said.code == 74 && !at("bad").exists(), "{}", said.stderr);
}

#[test]
fn what_is_no_toml_is_told_alone() {
    let _left = common::left::NobodyLeft::watch();
    let base = folder("syntax");
    let check = |name: &str, text: &[u8]| {
        fs::write(base.join(name), text).expect("a file");
        let said = Cullet::new(&["check", name]).within(&base).output();
        says(&said, &[name]);
        said.stderr
    };
    let told = check("a.toml", b"[world]\nduration = 1\n[[body]\nname = \"a\"\n");
    assert!(told.starts_with("error: a.toml:3:") && told.lines().count() == 3, "{told}");
    // Each of these lines has two errors.
    let many: String = (0..30).map(|number| format!("a{number} = = 1\n")).collect();
    let told = check("b.toml", many.as_bytes());
    assert!(told.matches("b.toml:").count() == 20 && told.ends_with("and 40 more\n"), "{told}");
    for (name, text, words) in [
        ("p.png", &b"\x89PNG\r\n\x1a\n\0"[..], "p.png is a picture (PNG), and no text in TOML\n"),
        ("s.py", b"import math\nprint(1)\n", "s.py is no text in TOML: line 1 is `import math`\n"),
    ] {
        let told = check(name, text);
        assert!(told.ends_with(words) && told.lines().count() == 1, "{told}");
    }
}

#[test]
fn numbers_that_are_none_are_told_with_their_bounds() {
    let _left = common::left::NobodyLeft::watch();
    let drop = corpus("drop.toml");
    for (call, words) in [
        (["run", &drop, "--workers", "two"], "it must be a whole number from 1 to 256"),
        (["submit", &drop, "--priority", "high"], "it must be a whole number from -100 to 100"),
        (["bench", &drop, "--limit", "long"], "it must be a number of at least 0"),
    ] {
        says(&Cullet::new(&call).output(), &[words, call[3]]);
    }
}
