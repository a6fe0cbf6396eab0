//! Log lines for programs: with `--log json` nothing else is on standard error, and the life of a
//! run can be read from them without more being asked for.

use crate::common;

use common::{Cullet, Going, LONGER, corpus, signal, unique, until};
use serde_json::Value;
use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);

/// A process whose standard error is a file, and every line there.
struct Told(Going, PathBuf);

impl Told {
    fn start(name: &str, args: &[&str]) -> Self {
        Self::of(name, Cullet::new(args))
    }

    fn of(name: &str, call: Cullet) -> Self {
        let path = unique(name);
        let file = File::create(&path).expect("a log");
        Self(call.args(&["--log", "json"]).errors(file).spawn(), path)
    }

    /// Each line is an object; a run's number where there is one.
    fn lines(&self) -> Vec<Value> {
        objects(&self.1)
    }

    fn until(&self, message: &str) {
        let said = |line: &Value| line["message"] == message;
        until(message, LONG, || self.lines().iter().any(said));
    }
}

/// Lines of a file, each of which is an object, but for one that is being written.
fn objects(path: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(path).expect("a log");
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    let object = |line: &str| match serde_json::from_str(line) {
        Ok(Value::Object(line)) => Value::Object(line),
        other => panic!("no object: {line:?}: {other:?}"),
    };
    whole.lines().map(object).collect()
}

#[test]
fn every_line_is_an_object_and_a_run_can_be_followed_to_its_fragments() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let call = ["coordinator", "--listen", &endpoint, "--workers", "1"];
    let mut coordinator = Told::start("coordinator-log", &call);
    let mut worker = Told::start("worker-log", &["worker", "--connect", &endpoint]);
    let errors = unique("client-log");
    let file = File::create(&errors).expect("a log");
    let call = ["submit", &corpus("drop.toml"), "--watch", "--log", "json", "--out"];
    let submit = Cullet::new(&call).path(&unique("told")).args(&["--connect", &endpoint]);
    assert_eq!(submit.args(&LONGER).errors(file).output().code, 0);
    // A run that is not there, and arguments that are not understood.
    let bad = ["wait", "99", "--connect", &endpoint, "--log=json"];
    let more = || OpenOptions::new().append(true).open(&errors).expect("a log");
    assert_eq!(Cullet::new(&bad).errors(more()).output().code, 66);
    let bad = ["coordinator", "--log", "json", "--runs", "x"];
    assert_eq!(Cullet::new(&bad).errors(more()).output().code, 64);
    for process in [&mut worker, &mut coordinator] {
        signal(process.0.id(), "TERM");
        assert_eq!(process.0.wait(Duration::from_secs(30)), Some(0));
    }
    let told = objects(&errors);
    let errors = told.iter().filter(|line| line["level"] == "ERROR");
    assert_eq!(errors.count(), 2, "{told:#?}");
    let lines = coordinator.lines();
    let of = |message: &str| -> Vec<&Value> {
        lines.iter().filter(|line| line["message"] == message).collect()
    };
    let run = &of("run handed in")[0]["run"];
    assert_eq!(run, 1);
    for (message, count) in [("run handed in", 1), ("run started", 1), ("run ended", 1)] {
        assert_eq!(of(message).len(), count, "{message}");
    }
    let opened = of("job opened");
    assert!(!opened.is_empty());
    let mut fragments = 0;
    for job in opened.iter().map(|line| &line["job"]) {
        for message in ["job opened", "job granted", "job settled"] {
            let found = of(message).into_iter().find(|line| line["job"] == *job);
            assert_eq!(found.map(|line| &line["run"]), Some(run), "{message} {job}");
        }
    }
    for line in of("body broken") {
        assert_eq!(line["run"], *run);
        let settled = of("job settled").into_iter().find(|other| other["job"] == line["job"]);
        assert_eq!(settled.map(|other| &other["fragments"]), Some(&line["fragments"]));
        fragments += line["fragments"].as_u64().unwrap_or(0);
    }
    assert!(fragments > 1, "nothing broke");
    assert_eq!(of("run ended")[0]["settled"], opened.len());
    let solved = |line: &&Value| line["message"] == "job solved" && line["run"] == *run;
    let all = worker.lines().into_iter().chain(lines.clone());
    assert!(all.collect::<Vec<_>>().iter().filter(solved).count() >= 1, "no worker says so");
}

/// What a job process says as it dies is not between the lines either.
#[test]
fn a_job_process_that_dies_says_so_in_an_object() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let call = ["coordinator", "--listen", &endpoint, "--log", "json"];
    let _coordinator = Cullet::new(&call).spawn();
    // What the system does not give ends a process aloud, what its worker takes from it silently.
    let program = env!("CARGO_BIN_EXE_cullet");
    let script = "ulimit -c 0; ulimit -d 200000; exec \"$@\"";
    let call = ["-c", script, "sh", program, "worker", "--connect", &endpoint, "--memory", "none"];
    let worker = Told::of("dying-log", Cullet::of(Path::new("sh"), &call));
    // Starts well below that, and asks for more at once.
    let call = ["submit", &corpus("drop.toml"), "--detach", "--connect", &endpoint];
    let large = ["--set", "fracture.max_particles=1000000", "--set", "fracture.solver=brittle"];
    assert_eq!(Cullet::new(&call).args(&large).output().code, 0);
    worker.until("job given back");
    let said = |line: &Value| {
        let text = line["message"].as_str().unwrap_or_default();
        text.starts_with("the job process says: ")
    };
    until("it is heard", LONG, || worker.lines().iter().any(said));
}
