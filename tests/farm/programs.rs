//! What programs read: with `--json` results are JSON, and so is every error.

use crate::common;

use common::{Cullet, Going, Said, corpus, file_of, unique, until};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);
/// A run that is soon over, and one that is not.
const QUICK: [&str; 2] = ["--set", "world.duration=0.02"];
const ENDLESS: [&str; 2] = ["--set", "world.duration=600"];

struct Farm {
    endpoint: String,
    _coordinator: Going,
}

impl Farm {
    fn start() -> Self {
        let endpoint = common::free_endpoint();
        let call = ["coordinator", "--listen", &endpoint, "--workers", "1", "--state"];
        let coordinator = Cullet::new(&call).path(&unique("programs")).spawn();
        let farm = Self { endpoint, _coordinator: coordinator };
        until("it is there", LONG, || farm.ask(&["ps"]).code == 0);
        farm
    }

    fn ask(&self, args: &[&str]) -> Said {
        let quiet = ["-q", "--json", "--connect", &self.endpoint];
        Cullet::new(args).args(&quiet).output()
    }
}

/// Every JSON value in a text; there is nothing else in it.
fn values(text: &str) -> Vec<Value> {
    let all = serde_json::Deserializer::from_str(text).into_iter();
    all.map(|value| value.unwrap_or_else(|why| panic!("{why}: {text}"))).collect()
}

/// A command has done its work, and printed so many values (or some: 0).
fn good(args: &[&str], said: &Said, code: i32, count: usize) -> Vec<Value> {
    assert_eq!(said.code, code, "{args:?}: {}{}", said.stdout, said.stderr);
    let told = values(&said.stdout);
    assert!(!told.is_empty() && (count == 0 || told.len() == count), "{args:?}: {}", said.stdout);
    assert!(said.stderr.is_empty(), "{args:?}: {}", said.stderr);
    told
}

/// A command has failed, and said so in one object on a line of its own, and nothing else.
fn bad(args: &[&str], said: &Said, code: i32, kind: &str) -> Value {
    assert_eq!(said.code, code, "{args:?}: {}{}", said.stdout, said.stderr);
    assert!(said.stdout.is_empty(), "{args:?}: {}", said.stdout);
    assert_eq!(said.stderr.lines().count(), 1, "{args:?}: {}", said.stderr);
    let told: Value = serde_json::from_str(&said.stderr)
        .unwrap_or_else(|why| panic!("{args:?}: {why}: {}", said.stderr));
    let keys: Vec<&str> = told.as_object().expect("an object").keys().map(String::as_str).collect();
    assert_eq!(keys, ["code", "kind", "message", "place"], "{args:?}: {told}");
    assert_eq!((told["code"].as_i64(), told["kind"].as_str()), (Some(code.into()), Some(kind)));
    assert!(told["message"].as_str().is_some_and(|text| text.len() > 5), "{args:?}: {told}");
    told
}

/// The commands that take `--json`, as their help says.
fn all() -> BTreeSet<String> {
    let help = Cullet::new(&["--help"]).output().stdout;
    let list = help.split("Commands:").nth(1).and_then(|rest| rest.split("Options:").next());
    let lines = list.expect("a list of commands").lines();
    let names = lines.filter_map(|line| line.split_whitespace().next()).filter(|n| *n != "help");
    let has = |name: &&str| Cullet::new(&[name, "--help"]).output().stdout.contains("--json");
    names.filter(has).map(str::to_owned).collect()
}

#[test]
fn what_every_command_prints_as_json_can_be_read() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start();
    let (drop, mut left) = (corpus("drop.toml"), all());
    let mut call = |args: &[&str], code: i32, count: usize| {
        left.remove(args[0]);
        good(args, &farm.ask(args), code, count)
    };
    let folder = |name: &str| unique(name).to_string_lossy().into_owned();
    let out = folder("submitted");
    call(&[&["submit", &drop, "--out", &out][..], &QUICK].concat(), 0, 1);
    assert_eq!(call(&["wait", "1"], 0, 1)[0]["state"], "done");
    assert_eq!(call(&["show", "1"], 0, 1)[0]["code"], 0);
    call(&["ps"], 0, 1);
    let lines = call(&["logs", "1"], 0, 0);
    for (number, line) in lines.iter().enumerate() {
        assert_eq!((line["run"].as_u64(), line["line"].as_u64()), (Some(1), Some(number as u64)));
        assert!(line["text"].as_str().is_some_and(|text| !text.is_empty()), "{line}");
    }
    call(&["watch", "1"], 0, 0);
    call(&["fetch", "1", "--out", &folder("fetched")], 0, 1);
    let two = call(&[&["submit", &drop, "--detach"][..], &ENDLESS].concat(), 0, 1);
    assert_eq!(two[0]["run"], 2);
    assert_eq!(call(&["pause", "2"], 0, 1)[0]["state"], "paused");
    assert_ne!(call(&["resume", "2"], 0, 1)[0]["state"], "paused");
    assert_eq!(call(&["cancel", "2"], 0, 1)[0]["state"], "cancelled");
    assert_eq!(call(&["wait", "2"], 5, 1)[0]["code"], 5);
    call(&["retry", "2"], 0, 1);
    call(&["cancel", "2"], 0, 1);
    assert_eq!(call(&["delete", "2"], 0, 1)[0]["run"], 2);
    let workers = call(&["workers"], 0, 1);
    let name = workers[0]["workers"][0]["name"].as_str().expect("a worker").to_owned();
    assert_eq!(call(&["drain", &name], 0, 1)[0]["noted"], true);
    // Its one worker is gone, which is told.
    let said = farm.ask(&["doctor", "--disk", &corpus("")]);
    assert!([0, 1].contains(&said.code), "{}", said.stderr);
    left.remove("doctor");
    assert!(values(&said.stdout)[0].as_array().is_some_and(|found| found.len() > 5));
    // Those that ask nobody.
    let mut own = |args: &[&str]| {
        left.remove(args[0]);
        good(args, &Cullet::new(args).output(), 0, 1);
    };
    own(&[
        "run",
        &drop,
        "-q",
        "--json",
        "--no-pictures",
        "--out",
        &folder("run"),
        QUICK[0],
        QUICK[1],
    ]);
    let recording = PathBuf::from(&out).join("run.mcap");
    own(&["inspect", "--json", &recording.to_string_lossy()]);
    let model = recording.with_file_name("run.glb");
    own(&["export", "--json", &recording.to_string_lossy(), "-o", &model.to_string_lossy()]);
    own(&["materials", "--json"]);
    own(&["scenes", "--json"]);
    let specimen = file_of("tests/specimens/e2-turn.toml");
    own(&["bench", "--json", "-q", &specimen.to_string_lossy()]);
    assert!(left.is_empty(), "not tried: {left:?}");
}

#[test]
fn what_every_command_says_of_trouble_can_be_read() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start();
    let drop = corpus("drop.toml");
    // Arguments that are not understood, of each.
    let mut left = all();
    for name in &left {
        let args = [name.as_str(), "--json", "--no-such"];
        let told = bad(&args, &Cullet::new(&args).output(), 64, "usage");
        assert!(told["message"].as_str().is_some_and(|text| text.contains("--no-such")), "{told}");
    }
    let mut tried = |args: &[&str]| left.remove(args[0]);
    // What is not there, and what nobody answers.
    let nobody = common::free_endpoint();
    for verb in ["show", "logs", "watch", "wait", "cancel", "pause", "resume", "retry", "delete"] {
        let told = bad(&[verb], &farm.ask(&[verb, "99"]), 66, "unknown");
        assert!(told["message"].as_str().is_some_and(|text| text.contains("no run 99")), "{told}");
        tried(&[verb]);
    }
    for args in [&["fetch", "99"][..], &["drain", "nobody"]] {
        bad(args, &farm.ask(args), 66, "unknown");
        tried(args);
    }
    let lost = ["-q", "--json", "--patience", "0.5", "--connect", &nobody];
    for args in [&["ps"][..], &["workers"], &["wait", "1"], &["submit", &drop]] {
        let told = bad(args, &Cullet::new(args).args(&lost).output(), 69, "unreachable");
        assert_eq!(told["place"], nobody.as_str(), "{told}");
        tried(args);
    }
    // No is no fault of what was typed, and a scene that is wrong there is none of one here.
    let run = [&["submit", &drop, "--detach"][..], &QUICK].concat();
    good(&run, &farm.ask(&run), 0, 1);
    good(&["wait"], &farm.ask(&["wait", "1"]), 0, 1);
    bad(&["cancel"], &farm.ask(&["cancel", "1"]), 77, "refused");
    let told = bad(&["delete"], &farm.ask(&["delete", "98"]), 66, "unknown");
    assert_eq!(told["place"], Value::Null, "{told}");
    let scene = ["submit", &drop, "--set", "world.seeed=1"];
    let told = bad(&scene, &farm.ask(&scene), 64, "usage");
    assert_eq!(told["place"], drop.as_str(), "{told}");
    let rude = [&run[..], &["--priority", "1000"]].concat();
    bad(&rude, &farm.ask(&rude), 64, "usage");
    let huge = [&run[..], &["--user", "a-name-that-is-longer-than-a-name-may-be-here"]].concat();
    bad(&huge, &farm.ask(&huge), 64, "usage");
    // Those that ask nobody.
    let none = unique("none").to_string_lossy().into_owned();
    for (args, code, kind, placed) in [
        (&["run", &none][..], 64, "usage", true),
        (&["inspect", &none], 74, "file", true),
        (&["export", &none], 74, "file", true),
        (&["bench", &none], 64, "usage", false),
        (&["doctor", "--connect", &nobody, "--tls", &none], 64, "usage", false),
        (&["materials", "--such"], 64, "usage", false),
        (&["scenes", "--such"], 64, "usage", false),
    ] {
        let told = bad(args, &Cullet::new(args).args(&["--json"]).output(), code, kind);
        assert!(!placed || told["place"] == none.as_str(), "{told}");
        tried(args);
    }
    assert!(left.is_empty(), "not tried: {left:?}");
    // In a log that is JSON the same is a line of it.
    let said = farm.ask(&["show", "99", "--log", "json"]);
    let told: Value = serde_json::from_str(said.stderr.trim()).expect("one line");
    assert_eq!((told["code"].as_u64(), told["kind"].as_str()), (Some(66), Some("unknown")));
    assert!(told["level"] == "ERROR" && told["message"].is_string(), "{told}");
}
