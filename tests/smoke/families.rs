//! Each family of solvers breaks or moves one small body.

use crate::common;

use common::{Cullet, DONE, file_of, summary, unique};
use std::fs;
use std::path::Path;

/// A body that is thrown at a stone floor and broken by a family.
struct Hit {
    family: &'static str,
    material: &'static str,
    /// Size of the box \[m\].
    size: [f64; 3],
    /// Its speed towards the floor \[m/s\].
    speed: f64,
}

impl Hit {
    fn scene(&self) -> String {
        let Self { family, material, size, speed } = self;
        format!(
            r#"
[world]
duration = 0.03
impulse_threshold = 0.05
[fracture]
solver = "{family}"
max_particles = 1500
[[body]]
name = "floor"
shape = {{ kind = "box", size = [4.0, 4.0, 0.2] }}
position = [0.0, 0.0, -0.1]
material = "granite"
fixed = true
[[body]]
name = "thrown"
shape = {{ kind = "box", size = {size:?} }}
position = [0.0, 0.0, 0.16]
rotation = {{ axis = [1.0, 1.0, 0.2], degrees = 50.0 }}
velocity = [0.0, 0.0, -{speed:?}]
material = "{material}"
"#
        )
    }
}

/// What the ledger of every run must keep.
fn assert_kept(told: &serde_json::Value) {
    for key in ["mass_rel_error", "momentum_rel_error", "angular_momentum_rel_error"] {
        let error = told["ledger"][key].as_f64().expect("a number");
        assert!(error <= 1e-9, "{key} is {error}: {told:#}");
    }
    assert_eq!(told["jobs"]["failed"], 0, "{told:#}");
}

/// Solves a hit by a family that is asked for by name. Later hits of its pieces may be others'.
fn assert_solved(hit: &Hit, outcome: &str) {
    let (scene, out) = (unique(hit.family).with_extension("toml"), unique(hit.family));
    fs::write(&scene, hit.scene()).expect("a scene");
    let run = Cullet::new(&["run", "-q", "--no-pictures", "--workers", "1", "--out"]).path(&out);
    let said = run.path(&scene).output();
    assert!(DONE.contains(&said.code), "{}", said.stderr);
    let told = summary(&out);
    assert_kept(&told);
    assert!(told[outcome].as_u64() >= Some(1), "{}: {told:#}", hit.family);
    assert!(told["solvers"][hit.family].as_u64() >= Some(1), "{}: {told:#}", hit.family);
}

#[test]
fn brittle_solids_break() {
    let size = [0.1, 0.1, 0.1];
    assert_solved(&Hit { family: "brittle", material: "plaster", size, speed: 16.0 }, "fractures");
}

#[test]
fn walls_break() {
    let size = [0.16, 0.16, 0.006];
    let hit = Hit { family: "shell", material: "soda-lime-glass", size, speed: 12.0 };
    assert_solved(&hit, "fractures");
}

#[test]
fn bonded_points_break() {
    let size = [0.1, 0.1, 0.1];
    let hit = Hit { family: "peridynamics", material: "plaster", size, speed: 16.0 };
    assert_solved(&hit, "fractures");
}

#[test]
fn cells_of_the_geometric_family_break() {
    let size = [0.1, 0.1, 0.1];
    assert_solved(
        &Hit { family: "geometric", material: "plaster", size, speed: 16.0 },
        "fractures",
    );
}

#[test]
fn metal_dents() {
    let size = [0.1, 0.1, 0.1];
    assert_solved(&Hit { family: "ductile", material: "lead", size, speed: 16.0 }, "deformed");
}

/// The beginning of a shipped scene, coarse.
fn assert_moves(scene: &str, windows_at_least: u64, more: &[&str]) {
    let (folder, out) = (file_of(&format!("scenes/{scene}")), unique(scene));
    let run = Cullet::new(&["run", "-q", "--no-pictures", "--workers", "1", "--out"]).path(&out);
    let run = run.path(&folder).args(&["--set", "world.duration=0.02"]).args(more);
    let said = run.output();
    assert!(DONE.contains(&said.code), "{scene}: {}", said.stderr);
    let told = summary(&out);
    assert_kept(&told);
    let sheets = &told["sheets"];
    assert!(sheets["windows"].as_u64() >= Some(windows_at_least), "{scene}: {told:#}");
    assert!(sheets["gap"].as_f64() < Some(1.0), "{scene}: {told:#}");
    assert!(Path::new(&out).join("run.mcap").is_file());
}

#[test]
fn sheets_soak_and_move() {
    assert_moves("towel", 1, &[]);
}

#[test]
fn soft_shells_move() {
    assert_moves("tube", 1, &[]);
}

#[test]
fn soft_solids_move() {
    assert_moves("jelly", 1, &[]);
}
