//! Runs that take up earlier ones: what is the same is taken, what changes is solved, and what a
//! kill left is enough to resume from.

use crate::common;

use common::{Cullet, Said, corpus, summary, unique};
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest wait for the first results of a run.
const LIMIT: Duration = Duration::from_secs(60);

fn call(scene: &str, out: &Path, args: &[&str]) -> Cullet {
    let scene = corpus(scene);
    Cullet::new(&["run", &scene, "--no-pictures"]).args(args).args(&["--out"]).path(out)
}

/// Runs a scene that comes to its end.
fn run(scene: &str, name: &str, args: &[&str]) -> (PathBuf, serde_json::Value, String) {
    let out = unique(name);
    let Said { code, stderr, .. } = call(scene, &out, args).output();
    assert_eq!(code, 0, "{stderr}");
    let told = summary(&out);
    (out, told, stderr)
}

/// How many results of a run went to workers, and how many were there.
fn counts(told: &serde_json::Value) -> (u64, u64) {
    let count = |key: &str| told["jobs"][key].as_u64().expect("a count");
    (count("solved"), count("taken"))
}

fn results(run: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(run.join("results")).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = files.map(|file| file.path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "verdict"));
    files.sort();
    files
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

#[test]
fn one_hit_is_solved_anew_and_the_rest_is_taken_from_an_earlier_run() {
    let _left = common::left::NobodyLeft::watch();
    let (first, before, _) = run("drop.toml", "hit-before", &["--workers", "1"]);
    let (solved, taken) = counts(&before);
    assert_eq!((taken, solved), (0, results(&first).len() as u64));
    assert!(solved >= 2, "{before:#}");
    assert_eq!(before.get("directed"), None);
    let from = ["--from", text(&first)];
    // Nothing changed, on two workers: nothing is solved.
    let (same, again, said) =
        run("drop.toml", "hit-same", &[&from[..], &["--workers", "2"]].concat());
    assert_eq!((&again["digest"], counts(&again)), (&before["digest"], (0, solved)), "{said}");
    assert!(said.contains(&format!("{solved} jobs: {solved} taken from ")), "{said}");
    // A run whose results were taken has them all for the next one.
    assert_eq!(results(&same).len() as u64, solved);
    let seed = ["--set", "hit.left.seed=11"];
    let (hit, changed, _) = run("drop.toml", "hit-one", &[&from[..], &seed].concat());
    assert_ne!(changed["digest"], before["digest"]);
    let (anew, kept) = counts(&changed);
    assert!(anew >= 1 && kept >= 1, "{changed:#}");
    assert_eq!(changed["directed"]["hits"], 1, "{changed:#}");
    // The digest follows from the scene alone: the same without what is taken.
    let (_, alone, _) = run("drop.toml", "hit-alone", &[&seed[..], &["--workers", "2"]].concat());
    assert_eq!((&alone["digest"], counts(&alone).1), (&changed["digest"], 0));
    let told = Cullet::new(&["inspect"]).path(&hit).output().stdout;
    let lines = |words: &str| told.lines().filter(|line| line.contains(words)).count();
    let mut opened = told.lines().filter(|line| line.contains("opened for left, asks brittle"));
    assert!(opened.next().is_some_and(|line| line.ends_with("directed: seed 11")), "{told}");
    assert_eq!(lines("directed: seed 11"), 1, "{told}");
    assert_eq!(lines("; taken from an earlier solve") as u64, kept, "{told}");
    assert_eq!(
        lines(&format!("{kept} taken from earlier solves, {anew} solved anew")),
        1,
        "{told}"
    );
    assert_eq!(lines("directed: 1 hit solved with settings of its own"), 1, "{told}");
}

#[test]
fn what_is_damaged_is_solved_again_and_what_changes_the_past_is_refused() {
    let _left = common::left::NobodyLeft::watch();
    let (first, before, _) = run("drop.toml", "past", &["--workers", "1"]);
    let victim = &results(&first)[0];
    let mut bytes = fs::read(victim).expect("a result");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(victim, bytes).expect("a file");
    let from = ["--from", text(&first)];
    let steps = before["steps"].as_u64().expect("a number");
    let last = steps.to_string();
    let resumed = [&from[..], &["--from-step", &last]].concat();
    let (_, again, said) = run("drop.toml", "past-damaged", &resumed);
    assert_eq!((&again["digest"], counts(&again).0), (&before["digest"], 1));
    assert!(said.contains("damaged results of the earlier run"), "{said}");
    // The cubes hit the floor in the first steps: another seed for one of them is no future.
    let seed = ["--set", "hit.left.seed=11"];
    let refuse = |name: &str, args: &[&str]| {
        let out = unique(name);
        let said = call("drop.toml", &out, args).output();
        assert_eq!((said.code, out.exists()), (64, false), "{}", said.stderr);
        said.stderr
    };
    let said = refuse("past-seed", &[&resumed[..], &seed].concat());
    assert!(said.contains("the run is not as in") && said.contains("what happens"), "{said}");
    let step = said.split("at step ").nth(1).and_then(|rest| rest.split(' ').next());
    let step: u64 = step.and_then(|step| step.parse().ok()).expect("the step where it differs");
    assert!(0 < step && step < steps, "{said}");
    // From that step on it may.
    let step = step.to_string();
    run("drop.toml", "past-later", &[&from[..], &["--from-step", &step], &seed].concat());
    // A run that was shorter goes on.
    let (short, ..) = run("drop.toml", "past-short", &["--set", "world.duration=0.1"]);
    let (_, longer, _) =
        run("drop.toml", "past-longer", &["--from", text(&short), "--from-step", "24"]);
    assert_eq!(longer["digest"], before["digest"]);
    let beyond = (steps + 1).to_string();
    let said = refuse("past-end", &[&from[..], &["--from-step", &beyond]].concat());
    assert!(said.contains(&format!("is recorded up to step {last}")), "{said}");
    let longer = ["--set", "world.step=1/480 s"];
    let said = refuse("past-step", &[&from[..], &["--from-step", "3"], &longer].concat());
    assert!(said.contains("steps are 0.00416"), "{said}");
    // What is to be replaced is there still where the earlier run is not, or is the same.
    let replace = |from: &str, words: &str| {
        let args = ["--replace", "--from", from];
        let said = call("drop.toml", &first, &args).output();
        assert_eq!(said.code, 64, "{}", said.stderr);
        assert!(said.stderr.contains(words), "{}", said.stderr);
        assert!(first.join("run.mcap").is_file() && !results(&first).is_empty());
    };
    replace("no-such-run", "there is no such run");
    replace(text(&first), "a run cannot take up itself");
    replace(text(&first.join("run.mcap")), "a run cannot take up itself");
    let said = refuse("past-none", &["--from", "no-such-run"]);
    assert!(said.contains("no-such-run: there is no such run"), "{said}");
}

#[test]
fn what_a_kill_left_is_taken_up_to_the_digest_of_a_run_straight_through() {
    let _left = common::left::NobodyLeft::watch();
    let short = ["--set", "world.duration=0.15", "--set", "expect.bodies_final={}"];
    let straight = [&short[..], &["--workers", "2", "--results", "0"]].concat();
    let (whole, before, _) = run("sheets.toml", "kill-whole", &straight);
    assert!(!whole.join("results").exists(), "it keeps none");
    let killed = unique("kill-killed");
    let mut going =
        call("sheets.toml", &killed, &[&short[..], &["--workers", "1"]].concat()).spawn();
    let since = Instant::now();
    while results(&killed).len() < 6 {
        assert!(since.elapsed() < LIMIT && !going.ended(), "the run was too quick or too slow");
        sleep(Duration::from_millis(5));
    }
    going.kill();
    let kept = results(&killed).len() as u64;
    assert!(!killed.join("run.mcap").exists(), "the run was too quick for this test");
    // A recording that was cut off has what was flushed; the results are all there.
    let from = ["--from", text(&killed), "--workers", "1"];
    let (_, again, said) = run("sheets.toml", "kill-again", &[&short[..], &from].concat());
    assert_eq!(again["digest"], before["digest"]);
    assert_eq!(counts(&again).1, kept, "{said}");
    let all = counts(&again).0 + kept;
    assert_eq!(counts(&before), (all, 0));
    // It is resumed where it was killed, as far as that was recorded.
    let recovered = Cullet::new(&["recover"]).path(&killed).output();
    if recovered.code == 0 {
        let step = summary_of(&killed)["steps"].as_u64().expect("a number").to_string();
        let resumed = [&short[..], &from, &["--from-step", &step]].concat();
        let (_, again, _) = run("sheets.toml", "kill-resumed", &resumed);
        assert_eq!(again["digest"], before["digest"]);
    }
}

/// The summary that a recording by itself gives.
fn summary_of(run: &Path) -> serde_json::Value {
    let said = Cullet::new(&["inspect", "--json"]).path(run).output();
    serde_json::from_str(&said.stdout).expect("JSON")
}
