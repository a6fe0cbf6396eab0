//! The service as people use it: processes on loopback, killed and told things in the middle.

use crate::common;

use common::{Cullet, Going, LONGER, children_of, corpus, quiet_digest, signal, summary, unique};
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

const LONG: Duration = Duration::from_secs(300);

/// A coordinator with workers of its own.
struct Farm {
    endpoint: String,
    state: PathBuf,
    workers: &'static str,
    process: Going,
}

impl Farm {
    fn start(name: &str, args: &[&str]) -> Self {
        Self::with(name, "1", args)
    }

    /// With so many workers of its own.
    fn with(name: &str, workers: &'static str, args: &[&str]) -> Self {
        let (endpoint, state) = (common::free_endpoint(), unique(name));
        let process = Self::process(&endpoint, &state, workers, args);
        Self { endpoint, state, workers, process }
    }

    fn process(endpoint: &str, state: &Path, workers: &str, args: &[&str]) -> Going {
        let call = ["coordinator", "--listen", endpoint, "--workers", workers];
        Cullet::new(&call).args(args).args(&["--state"]).path(state).spawn()
    }

    /// Kills it as a crash of the machine would, and starts it again.
    fn crash(&mut self, args: &[&str]) {
        let workers = children_of(self.process.id());
        signal(self.process.id(), "KILL");
        self.process.wait(Duration::from_secs(5));
        let until = Instant::now() + Duration::from_secs(10);
        while workers.iter().any(|id| common::is_alive(*id)) && Instant::now() < until {
            sleep(Duration::from_millis(20));
        }
        self.process = Self::process(&self.endpoint, &self.state, self.workers, args);
    }

    fn ask(&self, args: &[&str]) -> common::Said {
        Cullet::new(args).args(&["--connect", &self.endpoint]).output()
    }

    fn json(&self, args: &[&str]) -> Value {
        let said = self.ask(&[args, &["--json"]].concat());
        assert_eq!(said.code, 0, "{args:?}: {}", said.stderr);
        serde_json::from_str(&said.stdout).unwrap_or_else(|why| panic!("{why}: {}", said.stdout))
    }

    fn submit(&self, args: &[&str]) -> String {
        let call = ["submit", &corpus("drop.toml"), "--detach"];
        let said = self.ask(&[&call[..], args].concat());
        assert_eq!(said.code, 0, "{}", said.stderr);
        said.stdout.trim().to_owned()
    }

    /// Asks about a run until it is as wanted.
    fn until(&self, run: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let until = Instant::now() + LONG;
        loop {
            let shown = self.json(&["show", run]);
            if wanted(&shown) {
                return shown;
            }
            assert!(Instant::now() < until, "never: {shown:#}");
            sleep(Duration::from_millis(30));
        }
    }

    fn fetch(&self, run: &str) -> Value {
        common::fetched(run, &["--connect", &self.endpoint])
    }
}

fn is(state: &'static str) -> impl Fn(&Value) -> bool {
    move |shown| shown["state"] == state
}

fn settled(count: u64) -> impl Fn(&Value) -> bool {
    move |shown| shown["jobs"]["settled"].as_u64() >= Some(count)
}

#[test]
fn a_killed_coordinator_goes_on_to_the_same_digest_and_solves_nothing_twice() {
    let _left = common::left::NobodyLeft::watch();
    // Without the cache, which might answer too.
    let mut farm = Farm::start("killed", &["--cache", "0"]);
    let run = farm.submit(&LONGER);
    // While nothing is solved, and with one of two jobs settled.
    let written = farm.state.join("runs").join(&run).join("timeline");
    let wanted = || fs::read_to_string(&written).is_ok_and(|text| text.contains("\"opened\""));
    common::until("a job is wanted", LONG, wanted);
    farm.crash(&["--cache", "0"]);
    let before = farm.until(&run, settled(1));
    assert_eq!(before["state"], "running", "it was too quick for this test: {before:#}");
    farm.crash(&["--cache", "0"]);
    let wait = farm.ask(&["wait", &run]);
    assert_eq!(wait.code, 0, "{}", wait.stderr);
    let shown = farm.json(&["show", &run]);
    assert_eq!(shown["attempt"], 3, "{shown:#}");
    assert!(shown["jobs"]["kept"].as_u64() >= Some(1), "solved again: {shown:#}");
    assert_eq!(farm.fetch(&run), quiet_digest(&LONGER));
    // What is over stays over, with its files and what it cost.
    farm.crash(&["--cache", "0"]);
    let again = farm.json(&["show", &run]);
    assert_eq!((&again["files"], &again["jobs"]), (&shown["files"], &shown["jobs"]));
    assert_eq!(farm.fetch(&run), quiet_digest(&LONGER));
    let logs = farm.ask(&["logs", &run]);
    assert!(logs.stdout.contains("begins anew, attempt 3"), "{}", logs.stdout);
    tells_of_three_lives(&farm, &run);
}

/// The timeline of a run whose coordinator was killed twice, the second time with a job settled,
/// has who solved that, and when the coordinator was away.
fn tells_of_three_lives(farm: &Farm, run: &str) {
    let out = unique("lives");
    let fetch = Cullet::new(&["fetch", run, "--connect", &farm.endpoint, "--out"]).path(&out);
    assert_eq!(fetch.output().code, 0);
    let text = fs::read_to_string(out.join("timeline.trace.json")).expect("a trace");
    let trace: Value = serde_json::from_str(&text).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events");
    let of = |kind: &'static str| events.iter().filter(move |event| event["cat"] == kind);
    let time = |event: &Value, key: &str| event[key].as_f64().expect("a time");
    let end = |event: &Value| time(event, "ts") + time(event, "dur");
    assert_eq!(of("attempt").count(), 3, "{text}");
    let away: Vec<&Value> = of("away").collect();
    let names: Vec<_> = away.iter().map(|event| &event["name"]).collect();
    assert_eq!(names, ["coordinator away"; 2], "{text}");
    assert!(away.iter().all(|event| time(event, "dur") > 0.0), "{text}");
    let kept: Vec<_> = of("job").filter(|job| job["args"]["kept"] == true).collect();
    assert!(!kept.is_empty(), "{text}");
    for job in kept {
        assert!(time(job, "ts") >= end(away[1]), "it is kept in the last life: {text}");
        let solved = |other: &&Value| {
            let args = &other["args"];
            other["name"] == job["name"] && args["ending"] == "solved" && args["attempt"] == 1
        };
        let found = of("job").find(solved).unwrap_or_else(|| panic!("who solved it? {text}"));
        assert!(time(found, "ts") >= end(away[0]) && end(found) <= time(away[1], "ts"), "{text}");
        let row = |event: &&Value| event["name"] == "thread_name" && event["tid"] == found["tid"];
        let row = events.iter().find(row).expect("a row");
        assert_eq!(row["args"]["name"], "w1", "{text}");
    }
    // What the first life wanted it did not get.
    let lost = |job: &&Value| end(job) <= time(away[0], "ts");
    let lost: Vec<_> = of("job").filter(lost).map(|job| &job["args"]["ending"]).collect();
    assert!(!lost.is_empty() && lost.iter().all(|ending| *ending == "cut off"), "{text}");
    let picture = fs::read_to_string(out.join("timeline.svg")).expect("a timeline");
    assert_eq!(picture.matches(" s: the coordinator was away").count(), 2, "{picture}");
    assert!(picture.contains(", 3 attempts"), "{picture}");
    // It is written down where the run is kept, and goes once nothing comes after it.
    assert!(!farm.state.join("runs").join(run).join("timeline").exists());
}

#[test]
fn two_runs_at_once_have_the_digests_that_they_have_alone() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("together", &["--runs", "2"]);
    let seeds = [["--set", "world.seed=7"], ["--set", "world.seed=8"]];
    let runs: Vec<String> =
        seeds.iter().map(|seed| farm.submit(&[&LONGER[..], seed].concat())).collect();
    let both = |run: &Value| run["state"] == "running";
    let until = Instant::now() + LONG;
    while !farm.json(&["ps"])["runs"].as_array().is_some_and(|all| all.iter().all(both)) {
        assert!(Instant::now() < until, "they never go on together");
        sleep(Duration::from_millis(20));
    }
    for (run, seed) in runs.iter().zip(seeds) {
        assert_eq!(farm.ask(&["wait", run]).code, 0);
        assert_eq!(farm.fetch(run), quiet_digest(&[&LONGER[..], &seed].concat()));
    }
}

#[test]
fn runs_are_laid_aside_taken_up_cancelled_and_waited_for() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("told", &["--runs", "1"]);
    let endless = farm.submit(&["--set", "world.duration=600"]);
    let next = farm.submit(&["--priority", "-1"]);
    let urgent = farm.submit(&["--priority", "1"]);
    farm.until(&endless, settled(1));
    assert_eq!(farm.json(&["show", &next])["state"], "queued");
    for run in [&endless, &next] {
        let said = farm.ask(&["fetch", run]);
        assert_eq!(said.code, 75, "{}", said.stderr);
        assert!(said.stderr.contains("nothing to fetch before its end"), "{}", said.stderr);
    }
    assert_eq!(farm.ask(&["pause", &endless]).code, 0);
    farm.until(&endless, is("paused"));
    // The urgent one goes first.
    let shown = farm.until(&urgent, is("done"));
    assert_ne!(farm.json(&["show", &next])["state"], "done", "{shown:#}");
    assert_eq!(farm.ask(&["wait", &next]).code, 0);
    assert_eq!(farm.ask(&["resume", &endless]).code, 0);
    let shown = farm.until(&endless, |shown| shown["attempt"] == 2 && settled(1)(shown));
    assert!(shown["jobs"]["kept"].as_u64() >= Some(1), "solved again: {shown:#}");
    let mut waiting =
        Cullet::new(&["wait", &endless, "--connect", &farm.endpoint, "--json"]).spawn();
    assert_eq!(waiting.wait(Duration::from_secs(1)), None, "it is not over");
    assert_eq!(farm.ask(&["cancel", &endless]).code, 0);
    assert_eq!(waiting.wait(Duration::from_secs(20)), Some(5), "{}", waiting.stderr());
    // Its recording so far can be fetched; a finished run can be neither cancelled nor retried.
    let out = unique("cancelled");
    let fetch = Cullet::new(&["fetch", &endless, "--connect", &farm.endpoint, "--out"]).path(&out);
    assert_eq!(fetch.output().code, 5);
    assert!(out.join("run.mcap").is_file());
    for verb in ["cancel", "retry", "pause", "resume"] {
        let said = farm.ask(&[verb, &next]);
        assert_eq!(said.code, 77, "{verb}: {}", said.stderr);
        assert!(said.stderr.contains("is done"), "{verb}: {}", said.stderr);
    }
    for verb in ["show", "wait", "watch", "logs", "fetch", "cancel", "delete"] {
        let said = farm.ask(&[verb, "99"]);
        assert_eq!(said.code, 66, "{verb}: {}", said.stderr);
        assert!(said.stderr.contains("there is no run 99"), "{verb}: {}", said.stderr);
    }
    let wait = ["wait", "1", "--connect", &common::free_endpoint(), "--patience", "1"];
    assert_eq!(Cullet::new(&wait).output().code, 69);
}

#[test]
fn a_run_that_failed_says_so_and_is_tried_again() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("failing", &[]);
    let recordings = farm.state.join("recordings");
    let taken = recordings.join("drop-1");
    let run = farm.submit(&["--set", "world.duration=600"]);
    farm.until(&run, is("running"));
    assert_eq!(farm.ask(&["pause", &run]).code, 0);
    farm.until(&run, is("paused"));
    // A file stands where its folder was.
    fs::remove_dir_all(&taken).expect("its folder");
    fs::write(&taken, "").expect("a file");
    assert_eq!(farm.ask(&["resume", &run]).code, 0);
    assert_eq!(farm.ask(&["wait", &run]).code, 8);
    assert_eq!(farm.json(&["show", &run])["state"], "failed");
    fs::remove_file(&taken).expect("it goes");
    assert_eq!(farm.ask(&["retry", &run]).code, 0);
    farm.until(&run, settled(1));
    assert_eq!(farm.ask(&["cancel", &run]).code, 0);
    assert_eq!(farm.ask(&["wait", &run]).code, 5);
}

#[test]
fn a_state_folder_that_is_none_or_in_use_is_refused() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("foreign");
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("thesis.tex"), "x").expect("a file");
    let start = |folder: &Path| {
        let call = ["coordinator", "--listen", &common::free_endpoint(), "--state"];
        Cullet::new(&call).path(folder).output()
    };
    let said = start(&folder);
    assert_eq!(said.code, 64, "{}", said.stderr);
    assert!(said.stderr.contains("thesis.tex"), "{}", said.stderr);
    let mut farm = Farm::start("in-use", &[]);
    farm.submit(&[]);
    let said = start(&farm.state);
    assert_eq!(said.code, 74, "{}", said.stderr);
    assert!(said.stderr.contains("another coordinator"), "{}", said.stderr);
    signal(farm.process.id(), "TERM");
    assert_eq!(farm.process.wait(Duration::from_secs(20)), Some(0));
    let journal = farm.state.join("journal");
    let mut bytes = fs::read(&journal).expect("a journal");
    bytes[30] ^= 1;
    fs::write(&journal, bytes).expect("it is damaged");
    let said = start(&farm.state);
    assert_eq!(said.code, 74, "{}", said.stderr);
    assert!(said.stderr.contains("line 2") && said.stderr.contains("checksum"), "{}", said.stderr);
}

fn get(address: &str, path: &str) -> String {
    let mut stream = std::net::TcpStream::connect(address).expect("somebody listens");
    write!(stream, "GET {path} HTTP/1.0\r\n\r\n").expect("it is sent");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("an answer");
    text
}

#[test]
fn a_doctor_metrics_and_health_tell_of_a_coordinator() {
    let _left = common::left::NobodyLeft::watch();
    let address = common::free_endpoint().replace("tcp/", "");
    let farm = Farm::start("watched", &["--metrics", &address]);
    let run = farm.submit(&[]);
    assert_eq!(farm.ask(&["wait", &run]).code, 0);
    sleep(Duration::from_millis(1500));
    let metrics = get(&address, "/metrics");
    assert!(metrics.contains("cullet_runs{state=\"done\"} 1"), "{metrics}");
    assert!(metrics.contains("# TYPE cullet_jobs_settled_total counter"), "{metrics}");
    assert!(get(&address, "/healthz").starts_with("HTTP/1.0 200"));
    assert!(get(&address, "/else").starts_with("HTTP/1.0 404"));
    let said = farm.ask(&["doctor", "--disk", "/"]);
    for word in ["coordinator", "clocks", "versions", "geometric, membrane, soft-shell"] {
        assert!(said.stdout.contains(word), "{word}: {}", said.stdout);
    }
    assert!(said.stdout.contains("solves brittle single double"), "{}", said.stdout);
    let nobody = Cullet::new(&["doctor", "--connect", &common::free_endpoint()]).output();
    assert_eq!(nobody.code, 69, "{}", nobody.stdout);
    // The timeline is among what can be fetched.
    let names = farm.json(&["show", &run])["files"].to_string();
    assert!(names.contains("timeline.svg") && names.contains("timeline.trace.json"), "{names}");
}

#[test]
fn a_run_whose_job_kills_its_workers_stalls_and_goes_on_when_told() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::with("poison", "2", &[]);
    let run = farm.submit(&LONGER);
    let until = Instant::now() + LONG;
    let shown = loop {
        let shown = farm.json(&["show", &run]);
        if shown["state"] != "queued" && shown["state"] != "running" {
            break shown;
        }
        assert!(Instant::now() < until, "it never stalls: {shown:#}");
        let busy = farm.json(&["workers"])["workers"].to_string().contains("\"jobs\":[\"");
        if busy {
            for worker in children_of(farm.process.id()) {
                signal(worker, "KILL");
            }
        }
        sleep(Duration::from_millis(100));
    };
    assert_eq!((shown["state"].as_str(), shown["code"].as_u64()), (Some("stalled"), Some(6)));
    assert_eq!(farm.ask(&["wait", &run]).code, 6);
    // Who handed it in gets what reproduces it, wherever that may be.
    let told = farm.ask(&["show", &run]).stdout;
    assert!(
        told.contains("job.bin") && told.contains("--out there`, then `cullet job there/job.bin`"),
        "{told}"
    );
    let out = unique("poisoned");
    let fetch = Cullet::new(&["fetch", &run, "--connect", &farm.endpoint, "--out"]).path(&out);
    assert_eq!(fetch.output().code, 6);
    let attempts = fs::read_to_string(out.join("attempts.txt")).expect("attempts");
    assert!(attempts.lines().count() >= 3 && attempts.contains("Down"), "{attempts}");
    let timeline = fs::read_to_string(out.join("timeline.svg")).expect("a timeline");
    assert!(timeline.contains("lost with w") && timeline.contains("; the job was given up"));
    assert!(out.join("run.mcap.partial").is_file(), "what it had recorded");
    let again = Cullet::new(&["job"]).path(&out.join("job.bin")).output();
    assert!(again.code == 0 && again.stdout.contains("fragments; result"), "{}", again.stderr);
    assert_eq!(farm.ask(&["retry", &run]).code, 0);
    assert_eq!(farm.ask(&["wait", &run]).code, 0);
    assert_eq!(farm.fetch(&run), quiet_digest(&LONGER));
    let files = farm.json(&["show", &run])["files"].to_string();
    assert!(!files.contains("job.bin"), "it is done, and nothing is given up: {files}");
}

#[test]
fn how_far_a_solve_is_can_be_watched() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("watching", &[]);
    let run = farm.submit(&["--set", "fracture.max_particles=60000"]);
    // Workers say so every few seconds.
    let shown = farm.until(&run, |shown| {
        let of = |name: &str| shown["position"][name].as_u64();
        of("permille") > Some(20) && of("jobs") >= Some(1)
    });
    assert!(shown["position"]["permille"].as_u64() <= Some(1000), "{shown:#}");
    let errors = unique("watches");
    let log = fs::File::create(&errors).expect("a file");
    let call = ["watch", &run, "--connect", &farm.endpoint];
    let mut watch = Cullet::new(&call).errors(log).spawn();
    let minute = Duration::from_secs(60);
    common::until("ps says so", minute, || farm.ask(&["ps"]).stdout.contains(" %"));
    let told = || fs::read_to_string(&errors).expect("a log");
    common::until("it is watched", minute, || told().contains(" to do (at work: "));
    assert_eq!(farm.ask(&["cancel", &run]).code, 0);
    watch.wait(minute);
}

#[test]
fn a_drained_worker_finishes_and_leaves_and_the_others_go_on() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::with("drained", "0", &[]);
    let work =
        |name: &str| Cullet::new(&["worker", "--connect", &farm.endpoint, "--name", name]).spawn();
    let (mut first, mut second) = (work("a"), work("b"));
    let run = farm.submit(&LONGER);
    farm.until(&run, settled(1));
    assert_eq!(farm.ask(&["drain", "nobody"]).code, 66);
    assert_eq!(farm.ask(&["drain", "a"]).code, 0);
    assert_eq!(first.wait(Duration::from_secs(60)), Some(0), "{}", first.stderr());
    assert_eq!(farm.ask(&["wait", &run]).code, 0);
    assert_eq!(second.wait(Duration::from_millis(100)), None, "it was not asked to leave");
    let listed = farm.json(&["workers"]).to_string();
    assert!(listed.contains("\"b\""), "{listed}");
}

/// A name is a worker's own. Two machines that have one are told aloud, and nobody is refused: nor
/// is one that is started while the one before is still there, which is not told either.
#[test]
fn workers_of_one_name_are_told_aloud_and_drained_together() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, log) = (common::free_endpoint(), unique("twins"));
    let _coordinator = Cullet::new(&["coordinator", "--listen", &endpoint]).log(&log).spawn();
    let ask = |args: &[&str]| Cullet::new(args).args(&["--connect", &endpoint]).output();
    let listed = || -> Vec<Value> {
        let said = ask(&["workers", "--json"]);
        let all: Value = serde_json::from_str(&said.stdout).expect("JSON");
        let all = all["workers"].as_array().expect("a list").clone();
        all.into_iter().filter(|worker| worker["up"] == true).collect()
    };
    let count = |what: &str, wanted: usize| {
        common::until(what, LONG, || listed().len() == wanted);
    };
    let hire =
        || Cullet::new(&["worker", "--name", "far"]).env("CULLET_CONNECT", &endpoint).spawn();
    let mut old = hire();
    count("one is there", 1);
    let mut second = hire();
    count("another is there beside it", 2);
    signal(old.id(), "TERM");
    assert_eq!(old.wait(Duration::from_secs(20)), Some(0), "{}", old.stderr());
    count("the other is left", 1);
    assert_eq!(ask(&["doctor"]).code, 0, "a worker that was started again is well");
    let mut third = hire();
    let twins = || listed().into_iter().filter(|worker| worker["twin"] == true).count();
    common::until("two are told of", LONG, || twins() == 2);
    let sessions: Vec<String> =
        listed().iter().map(|worker| worker["session"].as_str().expect("a life").into()).collect();
    for (call, code) in [("workers", 0), ("doctor", 1)] {
        let said = ask(&[call]);
        assert_eq!(said.code, code, "{}", said.stdout);
        let told = format!("2 workers are called far ({})", sessions.join(", "));
        assert!(said.stdout.contains(&told), "{told:?} is not in {}", said.stdout);
    }
    // Once, and not of the one that was started again before.
    let lines = common::history::lines(&log);
    let told: Vec<_> = lines.iter().filter(|line| line["sessions"].is_string()).collect();
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!((&told[0]["level"], &told[0]["worker"]), (&"WARN".into(), &"far".into()));
    assert_eq!(told[0]["sessions"], sessions.join(" "));
    let said = ask(&["drain", "far"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    assert!(said.stdout.contains("2 are called far (") && said.stdout.contains(&sessions[1]));
    for worker in [&mut second, &mut third] {
        assert_eq!(worker.wait(Duration::from_secs(20)), Some(0), "{}", worker.stderr());
    }
}

#[test]
fn with_certificates_each_may_do_what_its_role_may_and_a_stranger_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("certificates");
    fs::create_dir_all(&folder).expect("a folder");
    common::certificates(&folder, &["coordinator", "w-1", "ann", "mallory"], &[]);
    let roles = folder.join("roles.toml");
    fs::write(&roles, "workers = [\"w-1\"]\nusers = [\"ann\"]\n").expect("roles");
    let endpoint = common::free_endpoint().replace("tcp/", "tls/");
    let _coordinator = Cullet::new(&["coordinator", "--listen", &endpoint, "--tls"])
        .path(&folder.join("coordinator"))
        .args(&["--roles"])
        .path(&roles)
        .args(&["--state"])
        .path(&folder.join("state"))
        .spawn();
    let _worker = Cullet::new(&["worker", "--connect", &endpoint, "--name", "w-1", "--tls"])
        .path(&folder.join("w-1"))
        .spawn();
    let ask = |call: &[&str], certificate: &str, user: &str| {
        Cullet::new(call)
            .args(&["--connect", &endpoint, "--user", user, "--patience", "3", "--tls"])
            .path(&folder.join(certificate))
            .output()
    };
    let until = Instant::now() + Duration::from_secs(20);
    while ask(&["ps"], "ann", "ann").code != 0 {
        assert!(Instant::now() < until, "the coordinator does not answer its user");
    }
    let out = folder.join("out").to_string_lossy().into_owned();
    let said = ask(&["submit", &corpus("drop.toml"), "-q", "--out", &out], "ann", "ann");
    assert_eq!(said.code, 0, "{}", said.stderr);
    assert_eq!(summary(Path::new(&out))["digest"], quiet_digest(&[]));
    for (certificate, user) in [("w-1", "w-1"), ("w-1", "ann"), ("ann", "bob"), ("mallory", "ann")]
    {
        let said = ask(&["submit", &corpus("drop.toml"), "--detach"], certificate, user);
        assert_eq!(said.code, 69, "{certificate} as {user}: {}{}", said.stdout, said.stderr);
    }
    let plain = endpoint.replace("tls/", "tcp/");
    let said = Cullet::new(&["ps", "--patience", "3", "--connect", &plain]).output();
    assert_eq!(said.code, 69, "without a certificate: {}", said.stderr);
    let open = Cullet::new(&["coordinator", "--listen", "tcp/0.0.0.0:0"]).output();
    assert_eq!(open.code, 64, "{}", open.stderr);
    assert!(open.stderr.contains("--insecure"), "{}", open.stderr);
}
