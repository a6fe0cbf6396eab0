//! What is on the disk of a coordinator is as it was written, or named: nothing is lost, used or
//! deleted in silence.

use crate::common;

use common::{Cullet, Going, corpus, free_endpoint, quiet_digest, signal, summary, unique};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A run that is over in a moment.
const QUICK: [&str; 2] = ["--set", "world.duration=0.02"];
const BOUND: Duration = Duration::from_secs(30);
/// A file of the command could not be read.
const FILE: i32 = 74;

struct Farm {
    endpoint: String,
    state: PathBuf,
    process: Going,
}

impl Farm {
    fn start(state: PathBuf) -> Self {
        let endpoint = free_endpoint();
        let call = ["coordinator", "--listen", &endpoint, "--workers", "1", "--state"];
        let process = Cullet::new(&call).path(&state).spawn();
        let farm = Self { endpoint, state, process };
        common::until("it is there", BOUND, || farm.ask(&["ps"]).code == 0);
        farm
    }

    /// Ends it as a crash would.
    fn crash(mut self) -> PathBuf {
        signal(self.process.id(), "KILL");
        self.process.wait(BOUND);
        self.state
    }

    fn ask(&self, args: &[&str]) -> common::Said {
        Cullet::new(args).args(&["--connect", &self.endpoint]).output()
    }

    fn hand_in(&self, args: &[&str]) -> String {
        let scene = corpus("drop.toml");
        let said = self.ask(&[&["submit", &scene, "--detach"], args].concat());
        assert_eq!(said.code, 0, "{}", said.stderr);
        said.stdout.trim().to_owned()
    }

    fn quick(&self) -> String {
        let run = self.hand_in(&QUICK);
        assert_eq!(self.ask(&["wait", &run]).code, 0);
        run
    }

    fn runs(&self) -> usize {
        let said = self.ask(&["ps", "--json"]);
        let all: Value = serde_json::from_str(&said.stdout).expect("JSON");
        all["runs"].as_array().expect("runs").len()
    }
}

/// How a coordinator ends that is to start there and does not.
fn refused(state: &Path) -> common::Said {
    let call = ["coordinator", "--listen", &free_endpoint(), "--stop-after", "0", "--state"];
    Cullet::new(&call).path(state).output()
}

/// All files of a folder and what is in them.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let all = fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path());
    let read = |path: PathBuf| match path.is_dir() {
        true => files(&path),
        false => vec![(path.clone(), fs::read(&path).expect("a file"))],
    };
    all.flat_map(read).collect()
}

#[test]
fn a_journal_that_is_damaged_or_missing_is_named_and_no_run_of_it_is_lost() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("damaged"));
    farm.quick();
    farm.hand_in(&QUICK);
    let state = farm.crash();
    let journal = state.join("journal");
    let sound = fs::read(&journal).expect("a journal");
    let lines = sound.iter().filter(|byte| **byte == b'\n').count();
    let last = sound[..sound.len() - 1].iter().rposition(|byte| *byte == b'\n').expect("lines");
    // In the last line, which is whole, its end, and the middle.
    for (at, line) in [(last + 20, lines), (sound.len() - 1, lines), (40, 2)] {
        let mut bad = sound.clone();
        bad[at] ^= 1;
        fs::write(&journal, &bad).expect("a journal");
        let said = refused(&state);
        assert_eq!(said.code, FILE, "{}", said.stderr);
        assert!(said.stderr.contains(&format!("journal, line {line}: ")), "{}", said.stderr);
        assert_eq!(fs::read(&journal).expect("a journal"), bad, "it is changed");
        let copies = files(&state.join("set-aside"));
        assert!(copies.iter().any(|(_, copy)| *copy == bad), "no copy of it is kept");
    }
    fs::remove_file(&journal).expect("it goes");
    let before = files(&state.join("runs"));
    let said = refused(&state);
    assert_eq!(said.code, FILE, "{}", said.stderr);
    assert!(said.stderr.contains("the journal is missing, but"), "{}", said.stderr);
    assert_eq!(files(&state.join("runs")), before, "a run is gone");
    assert!(!journal.exists(), "another is begun");
    fs::write(&journal, &sound).expect("a journal");
    let farm = Farm::start(state);
    assert_eq!(farm.runs(), 2);
    assert_eq!(farm.ask(&["wait", "2"]).code, 0);
}

#[test]
fn a_start_deletes_nothing_and_says_what_it_sets_aside() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("aside"));
    farm.quick();
    farm.quick();
    let state = farm.crash();
    // Of the second run the journal knows nothing any more, and half of a line.
    let journal = state.join("journal");
    let text = fs::read_to_string(&journal).expect("a journal");
    let second = text.find(r#" {"event":"submitted","run":2"#).expect("run 2");
    fs::write(&journal, &text[..second + 30]).expect("a journal");
    fs::create_dir_all(state.join("runs/77/kept")).expect("a folder");
    fs::write(state.join("runs/77/kept/x"), "a verdict").expect("a file");
    fs::write(state.join(".cullet-halved"), "half of something").expect("a file");
    let contents = |files: Vec<(PathBuf, Vec<u8>)>| {
        files.into_iter().map(|(_, bytes)| bytes).collect::<BTreeSet<_>>()
    };
    // What a start writes anew: how often, up to which number, and what is at work.
    let anew = |(path, _): &(PathBuf, Vec<u8>)| {
        ["incarnation", "numbers", "at-work"].iter().any(|name| path.ends_with(name))
    };
    let mut before = files(&state);
    before.retain(|file| !anew(file));
    let said = Cullet::new(&["coordinator", "--listen", &free_endpoint(), "--stop-after", "0"]);
    let said = said.args(&["--state"]).path(&state).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let after = contents(files(&state));
    for (path, bytes) in before {
        assert!(after.contains(&bytes), "{} is gone", path.display());
    }
    let named = ["runs/2", "runs/77", ".cullet-halved", "the last, has no end", "set aside as"];
    for name in named {
        assert!(said.stderr.contains(name), "{name} is not told: {}", said.stderr);
    }
    let farm = Farm::start(state);
    assert_eq!((farm.runs(), farm.quick().as_str()), (1, "78"));
}

#[test]
fn a_bit_that_turned_in_a_bundle_ends_its_run_by_name_and_changes_no_result() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("bundle"));
    farm.hand_in(&["--set", "world.duration=600"]);
    for _ in 0..2 {
        farm.hand_in(&QUICK);
    }
    assert_eq!(farm.ask(&["pause", "2"]).code, 0);
    assert_eq!(farm.ask(&["pause", "3"]).code, 0);
    let state = farm.crash();
    let path = state.join("runs/2/bundle");
    let mut bundle = fs::read(&path).expect("a bundle");
    // A digit of a length or place of the scene, which makes another scene that is as good.
    let scene = bundle.iter().position(|byte| *byte == b'\n').expect("a table");
    let digit = bundle[scene..].iter().rposition(u8::is_ascii_digit).expect("a number") + scene;
    bundle[digit] ^= 1;
    fs::write(&path, &bundle).expect("it is damaged");
    let farm = Farm::start(state);
    assert_eq!(farm.ask(&["cancel", "1"]).code, 0);
    for (run, code) in [("2", 8), ("3", 0)] {
        assert_eq!(farm.ask(&["resume", run]).code, 0);
        let said = farm.ask(&["wait", run]);
        assert_eq!(said.code, code, "run {run}: {}", said.stderr);
        let named = said.stderr.contains("runs/2/bundle is damaged");
        assert_eq!(named, code != 0, "run {run}: {}", said.stderr);
    }
    let out = unique("sound");
    let fetch = ["fetch", "3", "--connect", &farm.endpoint, "--out"];
    assert_eq!(Cullet::new(&fetch).path(&out).output().code, 0);
    assert_eq!(summary(&out)["digest"], quiet_digest(&QUICK));
}

#[cfg(unix)]
#[test]
fn what_a_coordinator_keeps_is_its_owners_alone() {
    use std::os::unix::fs::PermissionsExt;
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("rights"));
    farm.quick();
    farm.hand_in(&["--set", "world.duration=600"]);
    common::until("it goes on", BOUND, || farm.state.join("runs/2/reached").exists());
    let state = farm.crash();
    let mode = |path: &Path| fs::metadata(path).expect("it").permissions().mode() & 0o777;
    assert_eq!(mode(&state), 0o700);
    let recordings = state.join("recordings");
    let kept = files(&state).into_iter().map(|(path, _)| path);
    let kept: Vec<PathBuf> = kept.filter(|path| !path.starts_with(&recordings)).collect();
    assert!(kept.len() > 8, "{kept:?}");
    for path in kept {
        assert_eq!(mode(&path) & 0o077, 0, "{}", path.display());
    }
}

#[test]
fn a_fetch_that_was_killed_goes_on_where_it_is_asked_for_again() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("killed"));
    farm.quick();
    farm.quick();
    let fetch = |run: &str, out: &Path| {
        Cullet::new(&["fetch", run, "--connect", &farm.endpoint, "--out"]).path(out)
    };
    let whole = unique("whole");
    assert_eq!(fetch("1", &whole).output().code, 0);
    assert!(!files(&whole).iter().any(|(path, _)| path.to_string_lossy().contains(".cullet-")));
    // One that is whole is not written over.
    assert_eq!(fetch("1", &whole).output().code, 64);
    let mut broken = 0;
    for _ in 0..20 {
        let out = unique("broken");
        let mut going = fetch("1", &out).spawn();
        let begun = Instant::now();
        // As soon as anything of it is there, and without a pause.
        let came = |file: fs::DirEntry| file.file_name() != ".cullet-fetch";
        while !fs::read_dir(&out).is_ok_and(|all| all.flatten().any(came)) {
            assert!(begun.elapsed() < BOUND, "nothing comes");
        }
        going.kill();
        // The last of its files.
        if out.join("timeline.trace.json").exists() {
            continue;
        }
        broken += 1;
        // Another run does not go into it.
        let said = fetch("2", &out).output();
        assert_eq!(said.code, 64, "{}", said.stderr);
        let said = fetch("1", &out).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        let names = |folder: &Path| {
            let relative = |(path, bytes): (PathBuf, Vec<u8>)| {
                (path.strip_prefix(folder).expect("below it").to_owned(), bytes)
            };
            files(folder).into_iter().map(relative).collect::<BTreeSet<_>>()
        };
        assert_eq!(names(&out), names(&whole));
        if broken == 3 {
            return;
        }
    }
    assert!(broken > 0, "none was killed in time");
}

#[test]
fn a_priority_beyond_all_bounds_is_refused() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("priority"));
    for priority in ["-2147483648", "101", "2147483647"] {
        let scene = corpus("drop.toml");
        let set = format!("--priority={priority}");
        let said = farm.ask(&["submit", &scene, "--detach", &set]);
        assert_eq!(said.code, 64, "{priority}: {}", said.stderr);
        assert!(said.stderr.contains("a whole number from -100 to 100"), "{}", said.stderr);
    }
    assert_eq!(farm.runs(), 0);
}

/// Nobody writes to the pipe: who waited for it would wait without end, and hear no signal.
#[test]
fn a_pipe_in_place_of_any_file_of_a_state_folder_holds_nothing_up() {
    let farm = Farm::start(unique("kept-pipes"));
    farm.quick();
    let (endpoint, state) = (farm.endpoint.clone(), farm.crash());
    let names = [
        "journal",
        "numbers",
        "incarnation",
        "at-work",
        "drained",
        "cullet-state",
        "lock",
        "runs/1/log",
    ];
    for name in names {
        let (place, aside) = (state.join(name), state.with_extension("aside"));
        let there = fs::rename(&place, &aside).is_ok();
        let made = std::process::Command::new("mkfifo").arg(&place).status();
        assert!(made.is_ok_and(|made| made.success()), "{name}");
        let call = ["coordinator", "--listen", &endpoint, "--state"];
        let mut process = Cullet::new(&call).path(&state).spawn();
        let ask = || Cullet::new(&["ps", "--connect", &endpoint]).output().code == 0;
        common::until(name, BOUND, || process.ended() || ask());
        match process.ended() {
            true => {
                let said = process.stderr();
                assert!(said.contains(name) && said.contains("no regular file"), "{name}: {said}");
            }
            false => {
                signal(process.id(), "TERM");
                assert_eq!(process.wait(BOUND), Some(0), "{name}");
            }
        }
        fs::remove_file(&place).ok();
        assert!(!there || fs::rename(&aside, &place).is_ok(), "{name}");
    }
    let farm = Farm::start(state);
    assert_eq!(farm.runs(), 1);
}
