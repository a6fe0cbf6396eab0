//! `cullet frontier` from a standing set to its table, its CSV and its charts.

use crate::common;

use common::{Cullet, Said, spent, unique};
use std::path::{Path, PathBuf};
use std::time::Duration;

fn tiny() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/frontier/tiny.toml")
}

fn frontier(out: &Path, more: &[&str]) -> Said {
    let said = Cullet::new(&["frontier", "--machine", "here", "--out"]).path(out).path(&tiny());
    said.args(more).output()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What a column of each row of a chart says.
fn column(csv: &str, chart: &str, name: &str) -> Vec<String> {
    let head: Vec<&str> = csv.lines().next().expect("a head").split(',').collect();
    let at = head.iter().position(|column| *column == name).expect("a column");
    let rows = csv.lines().filter(|line| line.split(',').next() == Some(chart));
    rows.map(|line| line.split(',').nth(at).unwrap_or_default().to_owned()).collect()
}

/// Points, a refused run, an unstable one and a scene: each is a row, a line and a mark; what is
/// drawn again from the file is the same.
#[test]
fn every_run_is_a_row_and_a_mark() {
    let out = unique("frontier");
    let said = frontier(&out, &["--quiet"]);
    assert_eq!((said.code, said.stdout.as_str()), (0, ""), "{}", said.stderr);
    let csv = read(&out.join("here.csv"));
    let statuses = column(&csv, "wave", "status");
    assert_eq!(statuses[..4], ["ok", "ok", "ok", "refused"], "{csv}");
    assert!(["unstable", "nan"].contains(&statuses[4].as_str()), "{csv}");
    assert_eq!(column(&csv, "wave", "standard"), ["0", "1", "0", "0", "0", "0"]);
    // The same work under two names was done once.
    let walls = column(&csv, "wave", "wall_s");
    assert_eq!((&walls[1], statuses[5].as_str()), (&walls[5], "ok"), "{csv}");
    let number = |text: &String| text.parse::<f64>().unwrap_or(f64::NAN);
    let errors: Vec<f64> = column(&csv, "wave", "err").iter().map(number).collect();
    assert!(errors[1].abs() < errors[0].abs() && errors[0].abs() < 0.2, "{errors:?}");
    assert!(errors[3].is_nan() && errors[4].is_nan(), "{errors:?}");
    let masses = column(&csv, "masses", "value");
    assert_eq!(column(&csv, "masses", "status"), ["ok", "ok", "ok"], "{csv}");
    assert!(masses[..2].iter().map(number).all(|m| m > 0.0 && m < 5.0), "{csv}");
    let costs = column(&csv, "masses", "cpu_s");
    assert!(costs.iter().map(number).all(|cost| cost > 0.0), "{csv}");

    // Both shares of each run, which was done once.
    let shares: Vec<f64> = column(&csv, "sampled", "value").iter().map(number).collect();
    assert!(shares.len() == 4 && shares.iter().all(|s| (0.0..=1.0).contains(s)), "{csv}");
    let walls = column(&csv, "sampled", "wall_s");
    assert_eq!(walls[..2], walls[2..], "{csv}");
    let metrics = column(&csv, "sampled", "metric");
    assert_eq!((&*metrics[1], &*metrics[2]), ("share of pieces sampled", "share of mass sampled"));
    assert!(std::fs::read(out.join("here/sampled.png")).is_ok_and(|data| data.len() > 10_000));

    let svg = read(&out.join("here/wave.svg"));
    // Two crosses in the plot, one in the key, two strokes each.
    assert_eq!(svg.matches("stroke-width=\"3\"").count(), 6, "{svg}");
    assert!(svg.contains("too few points") && svg.contains("not reached"), "{svg}");
    let picture = std::fs::read(out.join("here/masses.png")).expect("a picture");
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000);

    let again = frontier(&out, &["--redraw"]);
    assert_eq!((again.code, read(&out.join("here/wave.svg"))), (0, svg), "{}", again.stderr);
    assert_eq!(read(&out.join("here.csv")), csv);
    let table = again.stdout;
    for told in ["wave: when a wave comes by", "refused", "to 10 %: ", "mass distance", "*"] {
        assert!(table.contains(told), "{told}\n{table}");
    }
    std::fs::remove_dir_all(&out).ok();
}

/// One chart is run anew; the rows of the others stay. A quick run leaves them all alone.
#[test]
fn one_chart_leaves_the_others_alone() {
    let out = unique("frontier-only");
    std::fs::create_dir_all(&out).expect("a folder");
    let first = frontier(&out, &["--only", "wave", "-q"]);
    assert_eq!(first.code, 0, "{}", first.stderr);
    let table = out.join("here.csv");
    let before = read(&table).replace("wave,as it is", "kept,as it is");
    std::fs::write(&table, &before).expect("a file");
    let second = frontier(&out, &["--only", "wave"]);
    assert!(second.stderr.contains("wave 5/5 "), "five different runs\n{}", second.stderr);
    let after = read(&table);
    assert_eq!(after.matches("kept,as it is").count(), 2, "{after}");
    assert_eq!(after.matches("wave,as it is").count(), 2, "{after}");
    let quick = frontier(&out, &["--only", "wave", "--quick", "-q"]);
    assert_eq!((quick.code, read(&table)), (0, after), "{}", quick.stderr);
    assert!(out.join("here-quick.csv").exists() && out.join("here-quick/wave.svg").exists());
    std::fs::remove_dir_all(&out).ok();
}

/// What is wrong is told before anything runs.
#[test]
fn bad_input_is_told() {
    let out = unique("frontier-bad");
    let none = frontier(&out, &["--redraw"]);
    assert_eq!(none.code, 74, "{}", none.stderr);
    let unknown = frontier(&out, &["--only", "vawe"]);
    assert_eq!(unknown.code, 64);
    assert!(unknown.stderr.contains("known: wave, masses, sampled"), "{}", unknown.stderr);
    let named = frontier(&out, &["--machine", "a/b"]);
    assert_eq!(named.code, 64, "{}", named.stderr);
    assert!(!out.exists(), "nothing was made");
}

/// What a scene costs includes its solver, which runs in a process of a worker's.
#[test]
fn the_solvers_time_is_counted() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/bullet");
    let out = unique("cost");
    let sets = ["world.duration=0.01", "fracture.solver=brittle", "fracture.max_particles=10000"];
    let sets: Vec<&str> = sets.iter().flat_map(|value| ["--set", value]).collect();
    let run = Cullet::new(&["run", scene, "-q", "--no-pictures", "--workers", "1"]).args(&sets);
    let mut run = run.args(&["--out"]).path(&out).spawn();
    let [own, others] = spent(run.id(), Duration::from_secs(300)).expect("it ends");
    assert_eq!(run.wait(Duration::from_secs(1)), Some(0), "{}", run.stderr());
    assert!(others > own, "{others} ticks of workers and solver, {own} of its own");
    std::fs::remove_dir_all(&out).ok();
}

/// The standing sets of the tree are read, whatever they cost to run.
#[test]
fn the_standing_sets_are_read() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for name in ["standing", "sampled", "peridynamics"] {
        let set = root.join(format!("tests/frontier/{name}.toml"));
        let out = unique("frontier-standing");
        let said = Cullet::new(&["frontier", "--redraw", "--out"]).path(&out).path(&set).output();
        // Nothing is wrong with it; what it would draw is not there.
        assert_eq!(said.code, 74, "{}", said.stderr);
        assert!(said.stderr.contains(".csv"), "{}", said.stderr);
    }
}

/// The document's example is a set that runs.
#[test]
fn the_example_of_the_document_runs() {
    let text = include_str!("../../docs/frontier.md");
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let specimens = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/specimens");
    let example =
        example.expect("an example").replace("../specimens", &specimens.to_string_lossy());
    let out = unique("frontier-example");
    std::fs::create_dir_all(&out).expect("a folder");
    let set = out.join("set.toml");
    std::fs::write(&set, example).expect("a file");
    let said = Cullet::new(&["frontier", "--quick", "--machine", "m", "--out"]).path(&out);
    let said = said.path(&set).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let failed = ["unstable", "nan"].iter().any(|word| said.stdout.contains(word));
    assert!(failed && said.stdout.contains("single precision"), "{}", said.stdout);
    std::fs::remove_dir_all(&out).ok();
}
