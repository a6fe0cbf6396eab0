//! What a scene is told of itself: errors of all stages at once, advice, and what is certain of it
//! before it runs.

use super::{SMALL, errors_of, from_text};

/// Errors of every stage in one scene: keys, units, materials, meshes, sizes, overrides, places,
/// expectations, and what the rigid world does not take.
const EVERY_STAGE: &str = r#"
[wrld]
[world]
step = "1 fortnight"
[[body]]
name = "floor"
shape = { kind = "box", size = [4, 4, 0.2] }
material = "granite"
fixed = true
[[body]]
name = "sunk"
shape = { kind = "box", size = [1, 1, 1] }
material = "granite"
[[body]]
name = "many"
colour = "red"
mesh = "no-such.obj"
material = "glass"
velocity = [99999, 0, 0]
rotation = { axis = [0, 0, 0], degrees = 3 }
[[body]]
name = "odd"
shape = { kind = "box", size = [1, 2] }
material = "granit"
[[grid]]
name = "g"
count = [0, 1, 1]
spacing = [1, 1, 1]
body = { shape = { kind = "sphere", radius = -1 }, material = "iron" }
[expect]
broken = ["sunkk"]
colour = 1
"#;

#[test]
fn what_is_wrong_in_one_stage_hides_nothing_of_another() {
    let said = errors_of(EVERY_STAGE, &["body.nobody.fixed=true", "view.eye=[1, 2, 3]"]);
    for words in [
        "wrld: unknown key `wrld`",
        "world.step: \"fortnight\" is not a unit of time",
        "body.sunk.position: \"sunk\" overlaps \"floor\" at the start",
        "body.many.colour: unknown key `colour`",
        "body.many.mesh: scene/no-such.obj is not in the bundle",
        "body.many.material: there is no material \"glass\"",
        "or `soda-lime-glass`?",
        "body.many.velocity: must be at most",
        "body.many.rotation.axis: must have a length above 1e-6",
        "body.odd.shape.size: must have 3 items; it has 2",
        "body.odd.material: there is no material \"granit\"",
        "grid.g.count: must be at least 1 in each direction",
        "grid.g.body.shape.radius: must be above 0 m",
        "grid.g.body.material: there is no material \"iron\"",
        "expect.broken[0]: there is no body \"sunkk\"",
        "did you mean `sunk`?",
        "expect.colour: unknown key `colour`",
        "the scene has no body \"nobody\"",
        "`target` is missing",
    ] {
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
    assert!(!said.contains("a body needs a `shape`") && !said.contains("`material` is missing"));
}

/// What is no TOML is said alone, and so is an include that cannot be read: the rest may follow.
#[test]
fn errors_of_syntax_are_told_without_what_follows_from_them() {
    let told = errors_of(&format!("{EVERY_STAGE}\nend = = 1\n"), &["view.eye=[1, 2, 3]"]);
    let heads: Vec<&str> = told.lines().filter(|line| line.contains(".toml:")).collect();
    assert!(heads.iter().all(|line| line.starts_with("scene.toml:34:")), "{told}");
    assert!(!heads.is_empty() && !told.contains("fortnight"), "{told}");
    let told = errors_of("[world]\nduration = 1\n[[body]\nname = \"a\"\n", &[]);
    assert!(told.starts_with("scene.toml:3:") && told.lines().count() == 3, "{told}");
    let told = errors_of(&format!("include = [\"none.toml\"]\n{EVERY_STAGE}"), &[]);
    assert!(told.contains("none.toml") && told.lines().count() == 3, "{told}");
    // Each of these lines has two errors.
    let many: String = (0..30).map(|number| format!("a{number} = = 1\n")).collect();
    let told = errors_of(&many, &[]);
    assert!(told.matches(".toml:").count() == 20 && told.ends_with("\nand 40 more"), "{told}");
}

#[test]
fn what_is_no_toml_at_all_is_told_in_one_line() {
    let load = |name: &str, bytes: &[u8]| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        let told = crate::load(&path, &[]).expect_err("it is no scene").to_string();
        assert!(!told.contains('\n') && told.contains(name), "{told}");
        told
    };
    let script = b"#!/bin/sh\nset -e\nfor a in b; do echo $a; done\n";
    assert!(load("run.sh", script).ends_with("is no text in TOML: line 2 is `set -e`"));
    assert!(load("scene.toml", b"\x89PNG\r\n\x1a\n\0").contains("is a picture (PNG)"));
    assert!(load("scene.toml", b"a = 1\n\xff").ends_with("it is not UTF-8, byte 6 is wrong"));
}

/// What is no TOML is left out, and may be what is missing: a key, or the kind of a table.
#[test]
fn nothing_is_missing_in_garbled_text() {
    let scene = "[[body]]\nname = \"a\"\nmaterial = \"soda-lime-glass\"\nshape = { radius = 1 }\n\
                 [view]\neye = [1, 2, 3]\n";
    let said = errors_of(scene, &[]);
    assert!(said.contains("`kind` is missing") && said.contains("`target` is missing"), "{said}");
    let garbled = errors_of(&format!("{scene}end = = 1\n"), &[]);
    assert!(garbled.contains("scene.toml:7:") && !garbled.contains("is missing"), "{garbled}");
}

#[test]
fn advice_is_near_to_what_was_written() {
    let cases = [
        ("[camera]\neye = [1, 2, 3]\n", "did you mean `view`? it says where pictures look from"),
        ("[objects]\n", "did you mean `body`?"),
        ("[xyzzy]\n", "known: body, description"),
        ("[world]\ngravit = [0, 0, 1]\n", "did you mean `gravity`?"),
    ];
    for (text, words) in cases {
        let said = errors_of(&format!("{text}{SMALL}"), &[]);
        assert!(said.contains(words), "{words:?} is not in:\n{said}");
    }
    let said = errors_of(SMALL, &["body.cube.material=glass"]);
    assert!(said.contains("`soda-lime-glass`") && !said.contains("granite"), "{said}");
    let said = errors_of(SMALL, &["camera.eye=[1,2,3]"]);
    assert!(said.contains("did you mean `view`?"), "{said}");
}

fn warned(text: &str, overrides: &[&str]) -> String {
    let scene = from_text(text, overrides).unwrap_or_else(|errors| panic!("{errors}"));
    scene.warnings.join("\n")
}

#[test]
fn a_scene_in_which_nothing_can_break_or_that_has_no_floor_says_so() {
    let floor = "[[body]]\nname = \"floor\"\nfixed = true\nmaterial = \"granite\"\n\
                 shape = { kind = \"box\", size = [60, 60, 1] }\nposition = [0, 0, -5]\n";
    let whole = format!("{SMALL}{floor}");
    assert_eq!(warned(&whole, &["world.duration=2"]), "");
    let cases: [(&[&str], &str); 8] = [
        (
            &["body.cube.breakable=false"],
            "can break: `ball` is made of what does not break: steel; \
             `cube` has `breakable = false`; what is fixed does not",
        ),
        (&["world.max_generation=0"], "can break: world.max_generation is 0"),
        (&["body.cube.impulse_threshold=1e9"], "can break: a hit breaks from 1e9 N·s on, and none"),
        (&["world.impulse_threshold=1e9"], "can break: a hit breaks from 1e9 N·s on"),
        (
            &["body.floor.position=[90, 0, -5]"],
            "no floor under each of `cube`, `ball`: nothing fixed",
        ),
        (&["body.cube.position=[0, 50, 0]"], "no floor under `cube`: nothing fixed is in the way"),
        (&["body.cube.position=[0, 50, 0]"], "can break: `cube` can, and meets nothing in the 2 s"),
        (&["world.gravity=[0, 0, 0]"], "can break: `cube` can, and meets nothing"),
    ];
    for (set, words) in cases {
        let said = warned(&whole, &[set, &["world.duration=2"]].concat());
        assert!(said.contains(words), "{set:?}: {words:?} is not in {said:?}");
    }
    assert!(warned(SMALL, &[]).contains("there is no floor: no body is fixed"));
    let fixed = warned(floor, &[]);
    assert!(fixed.contains("nothing in this scene can break: all its bodies are fixed"), "{fixed}");
    // A body in the way of one that comes down is not lost, and a ball that flies past a floor is.
    let aimed = ["body.ball.position=[-12, 0, 1]", "world.duration=2"];
    assert!(!warned(&whole, &aimed).contains("can break"), "{}", warned(&whole, &aimed));
}
