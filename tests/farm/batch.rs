//! What batch systems run: single runs of a sweep, what gathers them, templates of Open Job
//! Description, a job type of Flamenco, workers that leave when idle.

use crate::common;

use common::{Cullet, Said, corpus, file_of, summary, unique, until};
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(120);
/// Few points, so that a run takes a moment.
const QUICK: &str = "fracture.max_particles=1000";

/// A sweep of two seeds over the drop scene, in a folder of its own.
fn seeds(name: &str) -> (PathBuf, PathBuf) {
    let folder = unique(name);
    fs::create_dir_all(&folder).expect("a folder");
    fs::copy(corpus("drop.toml"), folder.join("drop.toml")).expect("a scene");
    let file = folder.join("seeds.toml");
    let text = format!("scene = \"drop.toml\"\nset = [\"{QUICK}\", \"world.duration=0.05\"]\n");
    fs::write(&file, text + "[product]\n\"world.seed\" = [5, 6]\n").expect("a sweep");
    (folder, file)
}

fn run(file: &Path, args: &[&str], out: &Path) -> Said {
    Cullet::new(&["run", "-q", "--workers", "1"])
        .args(args)
        .args(&["--out"])
        .path(out)
        .path(file)
        .output()
}

/// The digests in the table of a sweep.
fn digests(out: &Path) -> Vec<String> {
    let text = fs::read_to_string(out.join("table.csv")).expect("a table");
    let last = |line: &str| line.rsplit(',').next().unwrap_or_default().to_owned();
    text.lines().skip(1).map(last).collect()
}

#[test]
fn runs_of_a_sweep_one_by_one_are_gathered_as_if_they_were_done_together() {
    let _left = common::left::NobodyLeft::watch();
    let (folder, file) = seeds("one-by-one");
    let (whole, parts) = (folder.join("whole"), folder.join("parts"));
    let said = run(&file, &["--no-pictures"], &whole);
    assert!(common::DONE.contains(&said.code), "{}", said.stderr);
    let none = run(&file, &["--gather"], &parts);
    assert_eq!(none.code, 66, "{}", none.stderr);
    assert!(none.stderr.contains("no run of"), "{}", none.stderr);
    // An expectation that does not hold is for the one who gathers.
    let unmet = ["--only", "2", "--no-pictures", "--set", "expect.fractures.max=0"];
    assert_eq!(run(&file, &unmet, &parts).code, 0);
    let half = run(&file, &["--gather", "--json"], &parts);
    assert_eq!(half.code, 66, "one is missing: {}", half.stderr);
    let rows: Vec<Value> =
        half.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!((&rows[0]["code"], &rows[1]["code"]), (&Value::Null, &3.into()));
    assert_eq!(run(&file, &["--only", "1", "--no-pictures"], &parts).code, 0);
    assert_eq!(run(&file, &["--gather"], &parts).code, 3);
    // What was expected belongs to the digest.
    assert_eq!(digests(&parts)[0], digests(&whole)[0]);
    assert_ne!(digests(&parts)[1], digests(&whole)[1]);
    // The same once more takes the place of what is there, and of nothing else.
    fs::write(parts.join("2/note"), "mine").expect("a file");
    let again = ["--only", "2", "--no-pictures"];
    assert_eq!(run(&file, &again, &parts).code, 64, "there is a run");
    fs::rename(parts.join("2/run.mcap"), parts.join("2/run.mcap.partial")).expect("cut off");
    assert_eq!(run(&file, &[&again[..], &["--replace"]].concat(), &parts).code, 0);
    assert!(parts.join("2/note").is_file() && !parts.join("2/run.mcap.partial").exists());
    let said = run(&file, &["--gather", "--at", "0,0.02,9"], &parts);
    assert_eq!(said.code, 0, "{}", said.stderr);
    assert_eq!(digests(&parts), digests(&whole));
    assert_eq!(size(&parts.join("sheet.png")), (3 * 486 + 6, 2 * 326 + 6));
    // Of a sweep that asks for other values it is not.
    let text = fs::read_to_string(&file).expect("a sweep");
    fs::write(&file, text.replace("[5, 6]", "[5, 7]")).expect("a sweep");
    let other = run(&file, &["--gather"], &parts);
    assert_eq!(other.code, 66, "{}", other.stderr);
    for why in ["with other values than its row has", "world.seed=7", "world.seed=6"] {
        assert!(other.stderr.contains(why), "{why}: {}", other.stderr);
    }
}

/// Pixels of a PNG.
fn size(file: &Path) -> (u32, u32) {
    let bytes = fs::read(file).expect("a picture");
    let side = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    assert!(bytes.starts_with(b"\x89PNG"));
    (side(16), side(20))
}

#[test]
fn what_is_for_sweeps_or_out_of_bounds_is_refused_with_the_reason() {
    let (folder, file) = seeds("refused");
    let (out, scene) = (folder.join("out"), folder.join("drop.toml"));
    let many = vec!["0.1"; 17].join(",");
    for (source, args, words) in [
        (&scene, &["--only", "1"][..], "are for sweeps"),
        (&scene, &["--gather"], "are for sweeps"),
        (&scene, &["--at", "0.1"], "--at: it is for sweeps"),
        (&file, &["--only", "3"], "has runs 1 to 2"),
        (&file, &["--only", "0"], "a whole number of at least 1"),
        (&file, &["--only", "1", "--gather"], "cannot be used with"),
        (&file, &["--only", "1", "--at", "0.1"], "--gather draws"),
        (&file, &["--at=-1"], "at least 0"),
        (&file, &["--at", &many], "17 times; the sheet of a sweep has at most 16"),
        (&file, &["--close=vase"], "it has floor, left, right"),
        (&scene, &["--close=vase"], "it has floor, left, right"),
        (&scene, &["--set-file", "/no/such/file"], "/no/such/file"),
    ] {
        let said = run(source, args, &out);
        assert!([64, 74].contains(&said.code), "{args:?}: {} {}", said.code, said.stderr);
        assert!(said.stderr.contains(words), "{args:?}: {words:?} is not in {}", said.stderr);
    }
    let said = Cullet::new(&["run", "--only", "1"]).path(&file).output();
    assert!(said.code == 64 && said.stderr.contains("--out"), "{}", said.stderr);
    assert!(!out.exists(), "a folder is left");
}

#[test]
fn overrides_of_a_file_come_before_those_that_are_typed() {
    let (folder, _) = seeds("overridden");
    let set = folder.join("set");
    fs::write(&set, "# a comment\n\n  world.seed = 9\nbody.left.material=glass\n").expect("a file");
    let check = |more: &[&str]| {
        let call = Cullet::new(&["check"]).path(&folder.join("drop.toml"));
        call.args(&["--set-file"]).path(&set).args(more).output()
    };
    let said = check(&[]);
    assert_eq!(said.code, 64, "{}", said.stdout);
    assert!(said.stderr.contains("glass"), "{}", said.stderr);
    let said = check(&["--set", "body.left.material=granite"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    assert!(said.stdout.contains("left: granite"), "{}", said.stdout);
}

/// Says that a test was not made, also where what tests print is not shown.
fn skip(why: &str) {
    writeln!(std::io::stderr(), "SKIPPED, and nothing is shown: {why}").ok();
}

/// Open Job Description's own program runs what is written, where there is one.
#[test]
fn templates_are_taken_and_run_by_openjd() {
    let _left = common::left::NobodyLeft::watch();
    let (folder, file) = seeds("openjd");
    let written = |source: &Path, name: &str, more: &[&str]| {
        let template = folder.join(name);
        let call = Cullet::new(&["openjd"]).path(source).args(more);
        let said = call.args(&["-o"]).path(&template).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        let text = fs::read_to_string(&template).expect("a template");
        let read: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(read["specificationVersion"], "jobtemplate-2023-09");
        template
    };
    let scene = folder.join("drop.toml");
    let set = ["--set", QUICK, "--set", "world.duration=0.05"];
    let one = written(&scene, "scene.json", &set);
    let all = written(&file, "sweep.json", &["--at", "0,0.03"]);
    let said = Cullet::new(&["openjd", "-o", "template.yaml"]).path(&scene).output();
    assert!(said.code == 64 && said.stderr.contains("name it .json"), "{}", said.stderr);
    let named = std::env::var("CULLET_PYTHON").ok();
    let python = named.clone().unwrap_or_else(|| "python3".to_owned());
    let openjd = |args: &[&str], template: &Path| {
        let (verb, more) = (args[0], &args[1..]);
        Command::new(&python).args(["-m", "openjd", verb]).arg(template).args(more).output()
    };
    let has = Command::new(&python).args(["-c", "import openjd.cli"]).output();
    if !has.is_ok_and(|has| has.status.success()) {
        assert!(named.is_none(), "CULLET_PYTHON: {python} has no openjd-cli");
        return skip("openjd: no openjd-cli (name a Python with it: CULLET_PYTHON)");
    }
    let program = format!("Cullet={}", env!("CARGO_BIN_EXE_cullet"));
    let run = |template: &Path, out: &str| {
        let said = openjd(&["check"], template).expect("it starts");
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stdout));
        let output = format!("Output={}", folder.join(out).display());
        let said = openjd(&["run", "-p", &program, "-p", &output, "-p", "Workers=1"], template);
        let said = said.expect("it starts");
        let text = String::from_utf8_lossy(&said.stdout).into_owned();
        assert!(said.status.success(), "{text}\n{}", String::from_utf8_lossy(&said.stderr));
        folder.join(out)
    };
    let (single, sweep) = (run(&one, "single"), run(&all, "sweep"));
    let rows = digests(&sweep);
    assert_eq!(summary(&single)["digest"], rows[0].as_str(), "the scene has seed 5");
    assert!(rows.len() == 2 && rows[0] != rows[1], "{rows:?}");
    assert_eq!(size(&sweep.join("sheet.png")), (2 * 486 + 6, 2 * 326 + 6));
    // A job that is tried again takes the place of the try before.
    run(&one, "single");
    let broken = folder.join("broken.json");
    let text = fs::read_to_string(&all).expect("a template");
    fs::write(&broken, text.replace("dependsOn", "after")).expect("a file");
    let said = openjd(&["check"], &broken).expect("it starts");
    assert!(!said.status.success(), "it takes everything");
}

/// By a stub in place of Flamenco's Manager; what it compiles are calls of the program.
#[test]
fn the_job_type_for_flamenco_compiles_to_calls_of_the_program() {
    let check = file_of("deploy/flamenco/check.js");
    let node = |args: &[&str]| Command::new("node").arg(&check).args(args).output();
    let Ok(said) = node(&[]) else { return skip("Flamenco: there is no node") };
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let (folder, file) = seeds("flamenco");
    let out = folder.join("out");
    let settings = serde_json::json!({
        "source": file,
        "output": out,
        "runs": 2,
        "workers": 1,
        "program": env!("CARGO_BIN_EXE_cullet"),
        "overrides": "world.duration=0.02;",
        "times": "0.01",
    });
    let said = node(&[&settings.to_string()]).expect("it starts");
    let tasks: Vec<Value> = serde_json::from_slice(&said.stdout).expect("JSON");
    assert_eq!(tasks.len(), 3);
    for task in &tasks {
        let call = &task["commands"][0]["parameters"];
        let words: Vec<&str> =
            call["args"].as_array().expect("words").iter().filter_map(Value::as_str).collect();
        let said = Cullet::new(&words).output();
        assert!(common::DONE.contains(&said.code), "{words:?}: {}", said.stderr);
    }
    assert_eq!(size(&out.join("sheet.png")), (486 + 6, 2 * 326 + 6));
}

#[test]
fn a_worker_leaves_with_code_0_when_it_has_had_no_job_for_long_enough() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let hire = |limit: &str| {
        let call = ["worker", "--connect", &endpoint, "--name", "idle", "--exit-when-idle", limit];
        Cullet::new(&call).spawn()
    };
    // Nobody is there.
    let mut alone = hire("1s");
    assert_eq!(alone.wait(LONG), Some(0), "{}", alone.stderr());
    assert!(alone.stderr().contains("no coordinator at"));
    let call = ["coordinator", "--listen", &endpoint, "--state"];
    let _coordinator = Cullet::new(&call).path(&unique("idle")).spawn();
    let ask = |args: &[&str]| Cullet::new(args).args(&["--connect", &endpoint]).output();
    let submit = ["submit", &corpus("drop.toml"), "--detach", "--patience", "60", "--set", QUICK];
    assert_eq!(ask(&submit).code, 0);
    let mut worker = hire("3s");
    assert_eq!(ask(&["wait", "1", "--patience", "60"]).code, 0, "it works while there is work");
    assert_eq!(worker.wait(LONG), Some(0), "{}", worker.stderr());
    until("it is away", LONG, || ask(&["workers"]).stdout.contains("away"));
    let said = Cullet::new(&["worker", "--connect", &endpoint, "--exit-when-idle", "0"]).output();
    assert!(said.code == 64 && said.stderr.contains("1 s to 744 h"), "{}", said.stderr);
}
