//! The gates with the timing of real runs: how soon a job that a `kill -9` took away is with
//! another worker, and how soon a worker is back after a blackhole. With the timing of tests they
//! are in the suite `gates` of the worker.
//!
//! `CULLET_REPEATS=8 CULLET_HOLE_S=15 cargo test --release -p cullet --test farm recovery:: --
//! --nocapture --test-threads 1` prints the figures that `docs/pool.md` has, and holds them to
//! their gates; without `CULLET_REPEATS` nothing is held to a time.

use crate::common;

use common::farm::{Farm, Role};
use common::figures::{gate, number, tell};
use common::history::{lines, moment};
use common::{
    Cullet, DONE, Going, LONGER, children_of, corpus, fetched, quiet_digest, signal, unique, until,
};
use serde_json::Value;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::thread::sleep;
use std::time::{Duration, SystemTime};

/// Longest a test waits for anything.
const LONG: Duration = Duration::from_secs(300);

/// Now \[s since 1970\].
fn now() -> f64 {
    SystemTime::UNIX_EPOCH.elapsed().expect("a clock").as_secs_f64()
}

/// A log that a coordinator writes.
struct Log(PathBuf);

impl Log {
    /// The first line that is as wanted, when there is one.
    fn line(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let mut found = Value::Null;
        until(what, LONG, || {
            found = lines(&self.0).into_iter().find(&wanted).unwrap_or_default();
            !found.is_null()
        });
        found
    }

    /// Who has a job that a solver has begun, by a grant that is newer than `after`.
    fn at_work(&self, after: f64) -> (String, String) {
        let line = self.line("a job is granted", |line| {
            line["message"] == "job granted" && moment(line) > Some(after)
        });
        sleep(Duration::from_millis(250));
        let text = |name: &str| line[name].as_str().expect("a name").to_owned();
        (text("job"), text("worker"))
    }

    /// Seconds from then to the next grant of a job.
    fn granted_again(&self, job: &str, since: f64) -> f64 {
        let line = self.line("it is granted again", |line| {
            let same = line["message"] == "job granted" && line["job"] == job;
            same && moment(line) > Some(since)
        });
        moment(&line).expect("a time") - since
    }
}

/// Hands a run in, with a seed that no other has.
fn submit(endpoint: &str, seed: u64, args: &[&str]) -> String {
    let (scene, seed) = (corpus("drop.toml"), format!("world.seed={seed}"));
    let call = ["submit", &scene, "--detach", "--connect", endpoint, "--set", &seed];
    let said = Cullet::new(&call).args(args).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    said.stdout.trim().to_owned()
}

/// Enough was seen of a run.
fn cancel(endpoint: &str, run: &str) {
    let said = Cullet::new(&["cancel", run, "--connect", endpoint]).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    Cullet::new(&["wait", run, "--connect", endpoint]).output();
}

/// What happens to the worker of a job, and how soon the job is with another one, in a farm of two
/// that are far away.
fn far(what: &str, repeats: u64, harm: impl Fn(&mut Farm, usize)) -> f64 {
    let mut farm = Farm::start(unique("gates"), 2);
    let log = Log(farm.log_of(Role::Coordinator, 0));
    let endpoint = farm.door.1.clone();
    let all = (0..repeats).map(|seed| {
        let after = now();
        let run = submit(&endpoint, seed, &LONGER);
        let (job, worker) = log.at_work(after);
        let since = now();
        harm(&mut farm, worker[1..].parse().expect("a number"));
        let took = log.granted_again(&job, since);
        farm.tend();
        cancel(&endpoint, &run);
        farm.tend();
        took
    });
    tell(what, all.collect())
}

/// A link that ends may come back: its job waits for it for 3 s. What ends a solver is told at
/// once.
#[test]
fn a_job_of_a_killed_worker_waits_for_its_link_and_that_of_a_killed_solver_does_not() {
    let _left = common::left::NobodyLeft::watch();
    let repeats = number("CULLET_REPEATS", 1);
    let killed = far("worker killed, 3 s of grace, 0.2 s of pause", repeats, |farm, worker| {
        farm.kill(Role::Worker(worker));
    });
    assert!(killed >= 3.0, "{killed} s: nobody waited for its link");
    gate(killed, 4.0);
    let killed = far("solver killed, 0.2 s of pause", repeats, |farm, worker| {
        until("its solver is killed", LONG, || farm.kill_job(worker));
    });
    gate(killed, 0.5);
}

/// The worker that has this name, among the children of a process.
fn named(coordinator: &Going, name: &str) -> u32 {
    let is = |id: &u32| {
        let text = std::fs::read(format!("/proc/{id}/cmdline")).unwrap_or_default();
        text.split(|byte| *byte == 0).any(|word| word == name.as_bytes())
    };
    children_of(coordinator.id()).into_iter().find(is).expect("a child of that name")
}

/// That a child has ended is known, and nobody waits for its link.
#[test]
fn a_job_of_a_killed_child_goes_to_another_at_once() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("children");
    std::fs::create_dir_all(&folder).expect("a folder");
    let (endpoint, log) = (common::free_endpoint(), Log(folder.join("log")));
    let call = Cullet::new(&["coordinator", "--workers", "3", "--listen", &endpoint]);
    let coordinator = call.log(&log.0).args(&["--state"]).path(&folder.join("state")).spawn();
    let all = (0..number("CULLET_REPEATS", 1)).map(|seed| {
        let after = now();
        let run = submit(&endpoint, seed, &LONGER);
        let (job, worker) = log.at_work(after);
        // Should this coordinator end, so does the child, and nobody need wait for it.
        let kept = std::fs::read_to_string(folder.join("state/at-work"));
        assert_eq!(kept.expect("the jobs at work"), "");
        let since = now();
        signal(named(&coordinator, &worker), "KILL");
        let took = log.granted_again(&job, since);
        cancel(&endpoint, &run);
        took
    });
    let middle = tell("child of the coordinator killed, 0.2 s of pause", all.collect());
    gate(middle, 0.5);
}

/// Nothing passes for longer than a link is held, and than the first try to make another lasts;
/// `docs/pool.md` has three times as long as a link is held.
#[test]
fn a_worker_is_back_soon_after_a_blackhole() {
    let _left = common::left::NobodyLeft::watch();
    let hole = Duration::from_secs(number("CULLET_HOLE_S", 13));
    let mut farm = Farm::start(unique("hole"), 1);
    let log = Log(farm.log_of(Role::Coordinator, 0));
    let (endpoint, weather) = (farm.door.1.clone(), farm.links[0].0.clone());
    let all = (0..number("CULLET_REPEATS", 1)).map(|turn| {
        let after = now();
        // The first one keeps it at work until the hole is there.
        let kinds: [&[&str]; 3] = [&LONGER, &[], &[]];
        let seeds = 3 * turn..;
        let runs: Vec<String> =
            kinds.iter().zip(seeds).map(|(kind, seed)| submit(&endpoint, seed, kind)).collect();
        log.at_work(after);
        weather.silent.store(true, Ordering::SeqCst);
        sleep(hole);
        weather.silent.store(false, Ordering::SeqCst);
        let healed = now();
        let line = log.line("it is at work", |line| {
            let back = line["message"] == "job granted" || line["message"] == "result taken";
            back && moment(line) > Some(healed)
        });
        for run in &runs {
            let said = Cullet::new(&["wait", run, "--connect", &endpoint]).output();
            assert!(DONE.contains(&said.code), "{}", said.stderr);
        }
        moment(&line).expect("a time") - healed
    });
    let middle = tell(&format!("blackhole of {hole:?}, healed: at work again"), all.collect());
    farm.leave();
    let lost = common::history::check_jobs(&farm.steps());
    assert!(lost.is_empty(), "{lost:#?}");
    gate(middle, 2.0);
}

/// Whose the bars of a job are in the timeline of a run, and how each ends.
fn bars_of(endpoint: &str, run: &str, job: &str) -> Vec<(String, String)> {
    let out = unique(&format!("timeline{run}"));
    let fetch = Cullet::new(&["fetch", run, "--connect", endpoint, "--out"]).path(&out);
    let code = fetch.output().code;
    assert!(DONE.contains(&code), "{code}");
    let text = std::fs::read_to_string(out.join("timeline.trace.json")).expect("a timeline");
    let told: Value = serde_json::from_str(&text).expect("JSON");
    let events = told["traceEvents"].as_array().expect("events");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let row = |tid: &Value| {
        let named = |event: &&Value| event["name"] == "thread_name" && event["tid"] == *tid;
        events.iter().find(named).map(|event| text(&event["args"]["name"])).unwrap_or_default()
    };
    let bars = events.iter().filter(|event| event["cat"] == "job" && event["name"] == *job);
    bars.map(|bar| (row(&bar["tid"]), text(&bar["args"]["ending"]))).collect()
}

/// A job lasts longer than a worker is silent.
const FINE: [&str; 2] = ["--set", "fracture.max_particles=24000"];

/// Others are idle, and get none of it.
#[test]
#[ignore = "long"]
fn what_is_at_work_when_the_coordinator_ends_is_not_begun_anew() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start(unique("orphans"), 3);
    let endpoint = farm.door.1.clone();
    let mut kept = Vec::new();
    for life in 0..number("CULLET_REPEATS", 2) as u32 {
        let log = Log(farm.log_of(Role::Coordinator, life));
        let after = now();
        let run = submit(&endpoint, u64::from(life), &FINE);
        let (job, worker) = log.at_work(after);
        if life % 2 == 0 {
            farm.kill(Role::Coordinator);
        } else {
            farm.stop(Role::Coordinator);
        }
        farm.tend();
        let said = Cullet::new(&["wait", &run, "--connect", &endpoint]).output();
        assert!(DONE.contains(&said.code), "{}", said.stderr);
        let next = lines(&farm.log_of(Role::Coordinator, life + 1));
        let of = |message: &str| {
            let same = |line: &&Value| line["message"] == message && line["job"] == *job;
            next.iter().filter(same).count()
        };
        assert_eq!(of("job granted"), 0, "begun anew: {next:#?}");
        let bars = bars_of(&endpoint, &run, &job);
        let ending = if life % 2 == 0 { "cut off" } else { "unsettled" };
        let due = [ending, "solved"].map(|ending| (worker.clone(), ending.to_owned()));
        assert_eq!(bars, due, "the timeline of run {run}");
        println!("job {job} of {worker}: renewed {}", of("goes on from before"));
        kept.push(fetched(&run, &["--connect", &endpoint]));
    }
    assert!(farm.by_themselves.is_empty(), "{:?}", farm.by_themselves);
    farm.leave();
    assert!(farm.left().is_empty(), "{:?}", farm.left());
    for (seed, digest) in kept.iter().enumerate() {
        let seed = format!("world.seed={seed}");
        assert_eq!(*digest, quiet_digest(&[&FINE[..], &["--set", &seed]].concat()));
    }
}

/// A job lasts longer than anybody waits here.
const ENDLESS: [&str; 2] = ["--set", "fracture.max_particles=400000"];

/// Two runs have a job each at work, and the coordinator is killed; the next life runs one at a
/// time, and knows from the disk alone that somebody is at the job of the other. `stopped`: that
/// one's worker hears nothing until a life that finds the run cancelled. Seconds from when its run
/// is cancelled, or it can hear, until its solver has ended.
fn renounced(folder: PathBuf, stopped: bool) -> f64 {
    let mut farm = Farm::start(folder, 2);
    let (endpoint, log) = (farm.door.1.clone(), Log(farm.log_of(Role::Coordinator, 0)));
    let runs = [0, 1].map(|seed| submit(&endpoint, seed, &ENDLESS));
    let held = [1, 2].map(|run| {
        let granted = |line: &Value| line["message"] == "job granted" && line["run"] == run;
        let line = log.line("its job is granted", granted);
        let text = |name: &str| line[name].as_str().expect("a name").to_owned();
        (text("job"), Role::Worker(text("worker")[1..].parse().expect("a number")))
    });
    sleep(Duration::from_millis(500));
    farm.runs = "1";
    let restart = |farm: &mut Farm, life| {
        farm.kill(Role::Coordinator);
        farm.tend();
        let next = Log(farm.log_of(Role::Coordinator, life));
        next.line("the first goes on", |line| line["message"] == "goes on from before");
    };
    let process = farm.post(held[1].1).process.id();
    if stopped {
        signal(process, "STOP");
    }
    restart(&mut farm, 1);
    let said = Cullet::new(&["show", &runs[1], "--json", "--connect", &endpoint]).output();
    assert!(said.stdout.contains("\"state\":\"queued\""), "{}", said.stdout);
    let mut since = now();
    cancel(&endpoint, &runs[1]);
    if stopped {
        restart(&mut farm, 2);
        since = now();
        signal(process, "CONT");
    }
    let ended = |k: usize| {
        let (job, worker) = &held[k];
        let line = Log(farm.log_of(*worker, 0)).line("its solver ends", |line| {
            line["message"] == "job not wanted any more" && line["job"] == **job
        });
        moment(&line).expect("a time")
    };
    let took = ended(1) - since;
    cancel(&endpoint, &runs[0]);
    ended(0);
    assert!(farm.by_themselves.is_empty(), "{:?}", farm.by_themselves);
    farm.leave();
    assert!(farm.left().is_empty(), "{:?}", farm.left());
    took
}

#[test]
fn a_run_that_is_cancelled_before_it_is_done_again_ends_its_job_at_its_worker() {
    let _left = common::left::NobodyLeft::watch();
    for (stopped, what, most) in [(false, "is told", 0.5), (true, "hears again", 2.0)] {
        let all = 0..number("CULLET_REPEATS", 1);
        let all = all.map(|k| renounced(unique(&format!("renounced{k}-{stopped}")), stopped));
        let what = format!("cancelled before it is done again, its worker {what}: solver ends");
        gate(tell(&what, all.collect()), most);
    }
}

/// Two runs want one job, and the coordinator is killed; the next life runs one at a time. The one
/// that has taken the job up again is cancelled: it goes on for the other.
#[test]
#[ignore = "long"]
fn a_job_goes_on_for_the_next_heir_when_the_first_is_cancelled() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start(unique("heirs"), 2);
    let (endpoint, log) = (farm.door.1.clone(), Log(farm.log_of(Role::Coordinator, 0)));
    let fine = ["--set", "fracture.max_particles=40000"];
    let runs = [0, 0].map(|seed| submit(&endpoint, seed, &fine));
    let (job, _) = log.at_work(0.0);
    let at_work = farm.folder.join("state/at-work");
    until("both want it, as the disk has it", LONG, || {
        let kept = std::fs::read_to_string(&at_work).unwrap_or_default();
        kept.lines().filter(|line| line.starts_with(&job)).count() == 2
    });
    farm.runs = "1";
    farm.kill(Role::Coordinator);
    farm.tend();
    let next = Log(farm.log_of(Role::Coordinator, 1));
    let goes_on = |run: u64| {
        let of = |line: &Value| line["message"] == "goes on from before" && line["run"] == run;
        next.line("it goes on", of)
    };
    goes_on(1);
    cancel(&endpoint, &runs[0]);
    goes_on(2);
    let said = Cullet::new(&["wait", &runs[1], "--connect", &endpoint]).output();
    assert!(DONE.contains(&said.code), "{}", said.stderr);
    let all = lines(&next.0);
    let again = |line: &&Value| line["message"] == "job granted" && line["job"] == *job;
    assert_eq!(all.iter().filter(again).count(), 0, "begun anew: {all:#?}");
    assert!(farm.by_themselves.is_empty(), "{:?}", farm.by_themselves);
    let digest = fetched(&runs[1], &["--connect", &endpoint]);
    farm.leave();
    assert!(farm.left().is_empty(), "{:?}", farm.left());
    assert_eq!(digest, quiet_digest(&[&fine[..], &["--set", "world.seed=0"]].concat()));
}

/// It has begun, and is cancelled while it does not go on: paused, or in the queue again after
/// the coordinator was killed.
#[test]
fn what_a_run_had_recorded_is_there_when_it_is_cancelled_while_it_waits() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start(unique("aside"), 1);
    let endpoint = farm.door.1.clone();
    let ask = |args: &[&str]| Cullet::new(args).args(&["--connect", &endpoint]).output();
    let runs = [0, 1].map(|seed| submit(&endpoint, seed, &["--set", "world.duration=600"]));
    let far = |run: &str| {
        let shown: Value =
            serde_json::from_str(&ask(&["show", run, "--json"]).stdout).unwrap_or_default();
        shown["jobs"]["settled"].as_u64() >= Some(1)
            && shown["position"]["time"].as_f64() > Some(1.0)
    };
    for run in &runs {
        until("it is under way", LONG, || far(run));
    }
    let fetched_of = |run: &str| {
        let said = ask(&["cancel", run]);
        assert_eq!((said.code, said.stdout), (0, format!("run {run} is cancelled\n")));
        let out = unique(&format!("aside{run}"));
        let fetch = Cullet::new(&["fetch", run, "--connect", &endpoint, "--out"]).path(&out);
        let said = fetch.output();
        assert_eq!(said.code, 5, "{}", said.stderr);
        assert!(out.join("timeline.svg").is_file(), "{}", said.stderr);
        out
    };
    assert_eq!(ask(&["pause", &runs[0]]).code, 0);
    let out = fetched_of(&runs[0]);
    let frames = |file: PathBuf| {
        let said = Cullet::new(&["inspect", "--json"]).path(&file).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
    };
    frames(out.join("run.mcap"));
    // The second is one of two in the queue as the coordinator is back, and the other is before it.
    let first = submit(&endpoint, 2, &["--set", "world.duration=600", "--priority", "100"]);
    until("it is under way", LONG, || far(&first));
    farm.runs = "1";
    farm.kill(Role::Coordinator);
    farm.tend();
    until("the first goes on", LONG, || {
        ask(&["show", &first, "--json"]).stdout.contains("\"state\":\"running\"")
    });
    let out = fetched_of(&runs[1]);
    let whole = out.join("run.mcap");
    assert!(!whole.exists());
    let recover = Cullet::new(&["recover"]).path(&out.join("run.mcap.partial"));
    let said = recover.output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    frames(whole);
    cancel(&endpoint, &first);
    // Tried again, it is done from its beginning.
    assert_eq!(ask(&["retry", &runs[1]]).code, 0);
    until("it is under way", LONG, || far(&runs[1]));
    cancel(&endpoint, &runs[1]);
    farm.leave();
    assert!(farm.left().is_empty(), "{:?}", farm.left());
}

/// Its job goes on, and it gets no other, of whichever life of the coordinator.
#[test]
fn a_worker_that_was_drained_is_drained_when_the_coordinator_is_back() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start(unique("drained"), 2);
    let endpoint = farm.door.1.clone();
    let run = submit(&endpoint, 0, &FINE);
    let (_, worker) = Log(farm.log_of(Role::Coordinator, 0)).at_work(0.0);
    let role = Role::Worker(worker[1..].parse().expect("a number"));
    let said = Cullet::new(&["drain", &worker, "--connect", &endpoint]).output();
    assert_eq!((said.code, said.stdout), (0, format!("{worker} gets no more jobs\n")));
    farm.kill(Role::Coordinator);
    farm.tend();
    let said = Cullet::new(&["wait", &run, "--connect", &endpoint]).output();
    assert!(DONE.contains(&said.code), "{}", said.stderr);
    assert_eq!(farm.post(role).process.wait(LONG), Some(0), "it does not leave");
    let next = lines(&farm.log_of(Role::Coordinator, 1));
    let granted = |line: &&Value| line["message"] == "job granted" && line["worker"] == *worker;
    assert_eq!(next.iter().filter(granted).count(), 0, "{next:#?}");
    farm.tend();
    // One of its name that is started again is another one.
    let alone = submit(&endpoint, 1, &LONGER);
    let said = Cullet::new(&["wait", &alone, "--connect", &endpoint]).output();
    assert!(DONE.contains(&said.code), "{}", said.stderr);
    farm.leave();
    assert!(farm.left().is_empty(), "{:?}", farm.left());
}
