//! The catalogue of specimens in its small form: what each must come to, and how `cullet bench`
//! tells it.

mod common;

use common::{Cullet, Said, children_of, signal, unique};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn specimens() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/specimens")
}

fn file(name: &str) -> PathBuf {
    specimens().join(format!("{name}.toml"))
}

fn bench(name: &str, more: &[&str]) -> Said {
    Cullet::new(&["bench", "-q"]).path(&file(name)).args(more).output()
}

/// Runs specimens whose own expectations decide the exit code.
fn hold(names: &[&str]) {
    for name in names {
        let said = bench(name, &[]);
        assert_eq!(said.code, 0, "{name}\n{}{}", said.stdout, said.stderr);
        assert!(said.stdout.contains(name), "{}", said.stdout);
    }
}

#[test]
fn elasticity_is_true() {
    hold(&["e1-patch", "e2-turn", "e7-cantilever", "e8-vibration", "e11-conservation"]);
}

#[test]
fn waves_are_true() {
    hold(&["e3-bar-wave", "e4-lateral", "e4-slender", "e5-two-bars", "e6-two-stones"]);
}

#[test]
fn the_damage_law_spends_its_energy() {
    hold(&["f-u-point-law", "f-b-notched-bar", "f-s-fine", "f-s-capped", "d8-spall"]);
}

#[test]
fn cracks_go_where_and_as_far_as_they_must() {
    hold(&["k4-kink", "k5-cantilevers", "k7-disc"]);
}

/// K2 on half the grid, where the kink's direction is too coarse to ask for.
#[test]
fn a_sheared_crack_kinks_when_it_must() {
    let said = bench("k2-shear", &["--set", "spacing=5mm", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&said.stdout).expect("JSON");
    assert_eq!(told["metrics"][0]["metric"], "critical shear");
    assert_eq!(told["metrics"][0]["verdict"], "holds", "{told:#}");
}

/// H1 on a coarse grid, a/h = 1.4: within the same bounds.
#[test]
fn two_spheres_meet_as_hertz_says() {
    let said = bench("h1-spheres", &["--set", "spacing=7mm"]);
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
}

/// Every file of the catalogue is read, whatever it costs to run.
#[test]
fn every_specimen_is_read() {
    let mut count = 0;
    for entry in std::fs::read_dir(specimens()).expect("the catalogue") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|end| end == "toml") {
            count += 1;
            // Refused at once: no specimen has so few points.
            let said = Cullet::new(&["bench", "-q", "--set", "max_points=8"]).path(&path).output();
            assert_eq!(said.code, 3, "{}\n{}", path.display(), said.stderr);
            assert!(said.stdout.contains("the number of points"), "{}", said.stdout);
        }
    }
    assert!(count >= 15, "{count}");
}

/// The document's examples are read and hold.
#[test]
fn the_examples_of_the_document_hold() {
    let text = include_str!("../../docs/specimens.md");
    let examples: Vec<&str> =
        text.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(examples.len(), 2);
    for (k, example) in examples.iter().enumerate() {
        let folder = unique(&format!("example-{k}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join("example.toml");
        std::fs::write(&file, example).expect("a file");
        let said = Cullet::new(&["bench", "-q"]).path(&file).output();
        assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
        std::fs::remove_dir_all(&folder).ok();
    }
}

/// A sweep over a spacing, a bad step and a limit of time: every run is a line, whatever became of
/// it, and the files are there.
#[test]
fn a_sweep_is_a_line_a_run_and_failures_are_told() {
    let out = unique("bench");
    std::fs::create_dir_all(&out).expect("a folder");
    let csv = out.join("all.csv");
    let (table, folder) = (csv.to_string_lossy(), out.to_string_lossy());
    let more = ["--sweep", "step_factor=0.8,3", "--sweep", "spacing=2cm,1cm"];
    let said = bench("e4-slender", &[&more[..], &["--csv", &table, "--out", &folder]].concat());
    assert_eq!(said.code, 3, "{}", said.stderr);
    let text = std::fs::read_to_string(&csv).expect("a table");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5, "{text}");
    let words: Vec<&str> = lines[1..].iter().filter_map(|line| line.rsplit(',').next()).collect();
    assert_eq!(words[..2], ["ok", "ok"], "{text}");
    assert!(words[2..].iter().all(|w| ["unstable", "nan"].contains(w)), "{text}");
    let name = "e4-slender.step_factor-0.8.spacing-1cm";
    for end in ["csv", "mcap", "png"] {
        let file = out.join(format!("{name}.{end}"));
        assert!(file.metadata().is_ok_and(|data| data.len() > 1000), "{}", file.display());
    }
    std::fs::remove_dir_all(&out).ok();
    let slow = bench("e8-vibration", &["--limit", "0.1", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&slow.stdout).expect("JSON");
    assert_eq!((slow.code, told["status"].as_str()), (3, Some("timeout")));
    assert_eq!(told["metrics"].as_array().map(Vec::len), Some(2));
}

/// A solver that is killed is a line of its own, told with the signal; the next run goes on, and
/// nothing is left behind.
#[test]
fn a_solver_that_is_killed_is_a_status_and_the_next_one_runs() {
    let [long, short] = ["d2-branching", "e4-slender"].map(file);
    let mut going =
        Cullet::new(&["bench", "-q", "--json", "--workers", "1"]).path(&long).path(&short).spawn();
    let until = Instant::now() + Duration::from_secs(60);
    let solver = loop {
        let workers = children_of(going.id());
        let found = workers.into_iter().find_map(|worker| children_of(worker).pop());
        match found {
            Some(id) => break id,
            None => assert!(Instant::now() < until, "no solver began"),
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    signal(solver, "KILL");
    assert_eq!(going.wait(Duration::from_secs(120)), Some(3));
    let text = going.stdout();
    let lines: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let words: Vec<_> = lines.iter().map(|line| line["status"].as_str().unwrap_or("")).collect();
    assert_eq!(words, ["crashed", "ok"], "{text}");
    assert!(lines[0]["trouble"].as_str().is_some_and(|why| why.contains("signal: 9")), "{text}");
}

/// Bad input is told with its place, before anything runs.
#[test]
fn bad_input_is_told_with_its_place() {
    let said = bench("e4-slender", &["--sweep", "spacing=1cm,-1cm"]);
    assert_eq!(said.code, 64);
    assert!(said.stderr.contains("solver.spacing") && said.stderr.contains("above 0 m"));
    let none = Cullet::new(&["bench", "no-such-file.toml"]).output();
    assert_eq!(none.code, 64);
    assert!(none.stderr.contains("no such file"), "{}", none.stderr);
}

/// The schema beside the catalogue is that of the reader.
#[test]
fn the_schema_is_the_readers() {
    let said = Cullet::new(&["schema", "--specimen"]).output();
    let file = std::fs::read_to_string(specimens().join("specimen.schema.json")).expect("a file");
    let how = "cullet schema --specimen > tests/specimens/specimen.schema.json";
    assert_eq!(said.stdout, file, "{how}");
}

/// The materials of the table of F-S: E \[GPa\], σ_f \[MPa\], G_f \[J/m²\].
const TABLE: [(&str, [f64; 3]); 7] = [
    ("soda-lime", [70.0, 50.0, 8.0]),
    ("porcelain", [70.0, 60.0, 20.0]),
    ("alumina", [300.0, 300.0, 40.0]),
    ("PMMA", [3.2, 60.0, 400.0]),
    ("plaster", [3.0, 3.0, 5.0]),
    ("granite", [60.0, 10.0, 100.0]),
    ("concrete", [32.0, 3.0, 100.0]),
];

/// F-S: on a grid finer than h_max = 0.375 · 2EG_f/σ_f² cracks grow at the strength, on a coarser
/// one at the share of it that keeps G_f, and the share is told.
#[test]
fn the_snap_back_map_is_that_of_the_table() {
    for (name, [young, strength, energy]) in TABLE {
        let longest = 2.0 * young * 1e9 * energy / (strength * strength * 1e12);
        for share in [0.3, 0.37, 0.38, 1.5] {
            let h = share * longest;
            let body = format!("geometry.shape.size=[{0},{0},{0}]", 4.0 * h);
            let sets = [
                format!("material.young={young} GPa"),
                format!("material.strength={strength} MPa"),
                format!("material.fracture_energy={energy} J/m2"),
                format!("spacing={h}"),
                body,
                "end=1e-9".to_owned(),
            ];
            let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
            let said = bench("f-s-fine", &[&sets[..], &["--json"]].concat());
            let told: serde_json::Value = serde_json::from_str(&said.stdout).expect("JSON");
            assert_eq!(told["status"], "ok", "{name}: {told:#}");
            let ratio = told["strength_ratio"].as_f64().expect("a number");
            // l = 2.3 k/(k + 0.0245) h, but k no more than 0.37.
            let k = share.min(0.37);
            let length = 2.3 * k / (k + 0.0245) * h;
            let cap = 0.9 * (longest / length).sqrt();
            assert!((ratio - cap.min(1.0)).abs() < 1e-9, "{name} at {share}: {ratio}, {cap}");
            assert_eq!(ratio < 1.0, share > 0.375, "{name} at {share}: {ratio}");
        }
    }
}
