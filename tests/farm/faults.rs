//! Faults for real: processes are killed and interrupted while they work, and nothing that counts
//! is lost.

use crate::common;

use common::history::lines;
use common::{Cullet, Going, LONGER, children_of, corpus, quiet_digest, signal, summary, unique};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Waits until the run has worker processes, and returns them.
fn workers_of(parent: u32) -> Vec<u32> {
    let until = Instant::now() + Duration::from_secs(20);
    while Instant::now() < until {
        let children = children_of(parent);
        if !children.is_empty() {
            return children;
        }
        sleep(Duration::from_millis(20));
    }
    panic!("no worker process appeared");
}

/// A worker of this coordinator whose job process is at work.
fn busy(coordinator: u32) -> Option<u32> {
    // After the name: the state, ten more, then its own time in 1/100 s.
    let spent = |job: u32| -> u64 {
        let text = fs::read_to_string(format!("/proc/{job}/stat")).unwrap_or_default();
        let rest = text.rsplit(')').next().unwrap_or_default().split_whitespace();
        rest.skip(11).take(2).filter_map(|ticks| ticks.parse::<u64>().ok()).sum()
    };
    let jobs = |worker: u32| children_of(worker).into_iter().map(move |job| (worker, job));
    let jobs = children_of(coordinator).into_iter().flat_map(jobs);
    let before: Vec<_> = jobs.map(|(worker, job)| (worker, job, spent(job))).collect();
    sleep(Duration::from_millis(100));
    let worked = |(_, job, before): &(u32, u32, u64)| spent(*job) >= before + 3;
    before.into_iter().find(worked).map(|(worker, ..)| worker)
}

#[test]
fn a_worker_killed_in_the_middle_of_a_job_costs_time_and_no_result() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("killed");
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "-v", "--workers", "2", "--out"])
        .path(&out)
        .args(&LONGER)
        .spawn();
    let mut killed = 0;
    // A job bears two losses: the third would end the run aloud.
    while killed < 2 && !run.ended() {
        if let Some(worker) = busy(run.id()) {
            signal(worker, "KILL");
            killed += 1;
        }
    }
    assert!(killed > 0, "nobody was killed: the run was too quick for this test");
    assert_eq!(run.wait(Duration::from_secs(120)), Some(0), "{}", run.stderr());
    let summary = summary(&out);
    assert!(summary["jobs"]["resent"].as_u64() >= Some(1), "{summary:#}");
    assert_eq!(summary["digest"], quiet_digest(&LONGER));
    let timeline = fs::read_to_string(out.join("timeline.svg")).expect("a timeline");
    assert!(timeline.contains("lost with w") && timeline.contains("; sent again to w"));
    let trace = fs::read_to_string(out.join("timeline.trace.json")).expect("a trace");
    assert!(trace.contains("\"ending\":\"lost\"") && trace.contains("lost with w"), "{trace}");
}

/// The jobs that a log says were lost and that it does not say were solved since.
fn find_unsolved_jobs(log: &Path) -> BTreeSet<String> {
    let mut jobs = BTreeSet::new();
    for line in lines(log) {
        let job = line["job"].as_str().unwrap_or_default();
        if line["message"] == "attempt lost" {
            jobs.insert(job.to_owned());
        } else if line["message"] == "result taken" {
            jobs.remove(job);
        }
    }
    jobs
}

/// A window is a pure job: two sheets and twenty bodies go through deaths of workers to the digest
/// of one worker that nobody disturbs.
#[test]
#[ignore = "long"]
fn windows_of_sheets_go_through_kills_to_the_digest_of_a_quiet_run() {
    let _left = common::left::NobodyLeft::watch();
    let (quiet, out) = (unique("sheets-quiet"), unique("sheets-killed"));
    let call = |workers| ["run", "--no-pictures", "--workers", workers, "--set"];
    let started = |workers, out: &Path, log: Option<&PathBuf>| {
        let call = Cullet::new(&call(workers)).args(&["world.duration=1.2"]);
        let call = call.args(&["--out"]).path(out).args(&[&corpus("sheets.toml")]);
        match log {
            Some(log) => call.log(log).spawn(),
            None => call.spawn(),
        }
    };
    let mut alone = started("1", &quiet, None);
    assert_eq!(alone.wait(Duration::from_secs(120)), Some(0), "{}", alone.stderr());
    let log = unique("sheets-log");
    let mut run = started("3", &out, Some(&log));
    let mut killed = 0;
    while killed < 6 && !run.ended() {
        // A window bears two losses: what was lost is solved before the next worker is killed,
        // however long that takes.
        if let Some(worker) = busy(run.id()).filter(|_| find_unsolved_jobs(&log).is_empty()) {
            signal(worker, "KILL");
            killed += 1;
            sleep(Duration::from_millis(500));
        }
    }
    assert!(killed > 1, "{killed} were killed: the run was too quick for this test");
    let said = || fs::read_to_string(&log).unwrap_or_default();
    assert_eq!(run.wait(Duration::from_secs(120)), Some(0), "{}", said());
    let (quiet, summary) = (summary(&quiet), summary(&out));
    assert_eq!(summary["digest"], quiet["digest"]);
    let sheets = &summary["sheets"];
    assert_eq!((&sheets["sheets"], &sheets["windows"]), (&2.into(), &108.into()), "{sheets:#}");
    assert!(sheets["gap"].as_f64() < Some(1.0) && sheets == &quiet["sheets"], "{sheets:#}");
}

#[test]
fn a_run_whose_job_keeps_dying_leaves_what_reproduces_it_and_a_timeline() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("dying");
    let call = ["run", &corpus("drop.toml"), "--workers", "2", "--no-pictures", "--out"];
    let mut run = Cullet::new(&call).path(&out).args(&LONGER).spawn();
    let until = Instant::now() + Duration::from_secs(120);
    let code = loop {
        assert!(Instant::now() < until, "it never gives the job up");
        if let Some(code) = run.wait(Duration::from_millis(300)) {
            break code;
        }
        for job in children_of(run.id()).into_iter().flat_map(children_of) {
            // It may have ended by now.
            std::process::Command::new("kill").args(["-KILL", &job.to_string()]).output().ok();
        }
    };
    let text = run.stderr();
    assert!(code == 6 && text.contains("was abandoned"), "{code}: {text}");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{e}"));
    let timeline = read("timeline.svg");
    assert!(timeline.contains("its solver died"), "{timeline}");
    assert!(timeline.contains("; sent again to ") && timeline.contains("; the job was given up"));
    assert!(read("attempts.txt").contains("Crashed"), "{}", read("attempts.txt"));
    let again = Cullet::new(&["job"]).path(&out.join("job.bin")).output();
    assert_eq!(again.code, 0, "{}", again.stderr);
    assert!(again.stdout.contains("fragments; result "), "{}", again.stdout);
}

/// A worker from elsewhere may be called as one of the coordinator's own: the end of that one is
/// not the end of the other, which goes on with what it has.
#[test]
fn a_worker_that_is_killed_takes_no_job_from_another_of_its_name() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, log) = (common::free_endpoint(), unique("namesake"));
    let coordinator = Cullet::new(&["coordinator", "--workers", "1", "--listen", &endpoint]);
    let coordinator = coordinator.args(&["--out"]).path(&unique("namesakes")).log(&log).spawn();
    let own = workers_of(coordinator.id());
    let call = ["worker", "--connect", &endpoint, "--name", "w1"];
    let _other = Cullet::new(&call).spawn();
    let ask = |args: &[&str]| Cullet::new(args).args(&["--connect", &endpoint]).output();
    let runs = ["7", "8"].map(|seed| {
        let call = ["submit", &corpus("drop.toml"), "--detach", "--set"];
        let said = ask(&[&call[..], &[&format!("world.seed={seed}")], &LONGER].concat());
        assert_eq!(said.code, 0, "{}", said.stderr);
        said.stdout.trim().to_owned()
    });
    let both = || ask(&["workers"]).stdout.lines().filter(|line| line.contains(" busy ")).count();
    common::until("both are at work", Duration::from_secs(60), || both() == 2);
    signal(own[0], "KILL");
    for run in runs {
        assert_eq!(ask(&["wait", &run]).code, 0);
    }
    let lines = common::history::lines(&log);
    let lost = lines.iter().filter(|line| line["message"] == "attempt lost");
    let lost: Vec<_> = lost.map(|line| (&line["job"], &line["worker"])).collect();
    assert!(lost.len() < 2, "one ended, and took of another: {lost:?}");
}

/// Waits until a file is there.
fn wait_for(path: &Path) {
    let until = Instant::now() + Duration::from_secs(60);
    while !path.exists() {
        assert!(Instant::now() < until, "{} does not appear", path.display());
        sleep(Duration::from_millis(20));
    }
}

/// Waits until processes have ended.
fn all_end(processes: &[u32]) {
    let until = Instant::now() + Duration::from_secs(10);
    while processes.iter().any(|id| common::is_alive(*id)) {
        assert!(Instant::now() < until, "of {processes:?} some are left behind");
        sleep(Duration::from_millis(50));
    }
}

/// Makes a named pipe: who opens it to read or write waits for the other.
fn make_pipe(path: &Path) {
    let made = std::process::Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo {}", path.display());
}

#[test]
fn a_run_told_to_stop_finishes_its_recording_and_leaves_no_process() {
    let _left = common::left::NobodyLeft::watch();
    for name in ["INT", "TERM"] {
        let out = unique("interrupted");
        let mut run = Cullet::new(&["run", &corpus("drop.toml"), "--out"])
            .path(&out)
            .args(&LONGER)
            .args(&["--set", "world.duration=600"])
            .spawn();
        let workers = workers_of(run.id());
        wait_for(&out.join("run.mcap.partial"));
        signal(run.id(), name);
        assert_eq!(run.wait(Duration::from_secs(30)), Some(130), "{name}: {}", run.stderr());
        all_end(&workers);
        let inspect = Cullet::new(&["inspect", "--json"]).path(&out.join("run.mcap")).output();
        assert_eq!(inspect.code, 0, "{}", inspect.stderr);
        let told: serde_json::Value = serde_json::from_str(&inspect.stdout).expect("JSON");
        assert_eq!(told, summary(&out));
    }
}

/// A picture that waits for a reader holds the run up after its first signal for as long as it
/// takes.
#[test]
fn a_second_interrupt_quits_at_once_and_a_second_termination_does_not() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("twice");
    fs::create_dir_all(&out).expect("a folder");
    make_pipe(&out.join("preview.png.partial"));
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "--out"])
        .path(&out)
        .args(&["--set", "world.duration=600"])
        .spawn();
    let workers = workers_of(run.id());
    wait_for(&out.join("run.mcap.partial"));
    signal(run.id(), "TERM");
    wait_for(&out.join("summary.json"));
    signal(run.id(), "TERM");
    assert_eq!(run.wait(Duration::from_secs(1)), None, "it still has a picture to draw");
    assert!(common::is_alive(run.id()), "a second SIGTERM ended it");
    signal(run.id(), "INT");
    assert_eq!(run.wait(Duration::from_secs(10)), Some(130), "a second SIGINT did not end it");
    all_end(&workers);
}

#[test]
fn a_worker_told_to_stop_leaves_with_or_without_a_coordinator() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    for name in ["INT", "TERM"] {
        let mut worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
        sleep(Duration::from_secs(1));
        signal(worker.id(), name);
        assert_eq!(worker.wait(Duration::from_secs(10)), Some(0), "{name}, alone");
    }
    let mut coordinator = Cullet::new(&["coordinator", "--listen", &endpoint]).spawn();
    for name in ["INT", "TERM"] {
        let mut worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
        sleep(Duration::from_secs(2));
        signal(worker.id(), name);
        assert_eq!(worker.wait(Duration::from_secs(10)), Some(0), "{name}, while it waits");
    }
    signal(coordinator.id(), "TERM");
    assert_eq!(coordinator.wait(Duration::from_secs(10)), Some(0));
}

/// A coordinator with a worker of its own, and a client whose long scene it runs.
fn served(runs: &Path) -> (Going, Going, String, PathBuf) {
    let endpoint = common::free_endpoint();
    let coordinator = Cullet::new(&["coordinator", "--workers", "1", "--listen", &endpoint])
        .args(&["--out"])
        .path(runs)
        .log(&log_of(runs))
        .spawn();
    let out = unique("followed");
    let client = follow(&endpoint, &out);
    wait_for(&runs.join("drop-1/run.mcap.partial"));
    (coordinator, client, endpoint, out)
}

fn log_of(runs: &Path) -> PathBuf {
    runs.with_extension("log")
}

fn follow(endpoint: &str, out: &Path) -> Going {
    let submit = ["submit", &corpus("drop.toml"), "--set", "world.duration=600"];
    Cullet::new(&submit).args(&["--connect", endpoint, "--out"]).path(out).spawn()
}

#[test]
fn a_coordinator_told_to_stop_tells_its_clients_first() {
    let _left = common::left::NobodyLeft::watch();
    let runs = unique("told");
    let (mut coordinator, mut first, endpoint, out) = served(&runs);
    let workers = workers_of(coordinator.id());
    // While the first one cannot ask, the coordinator stays and the second one comes.
    signal(first.id(), "STOP");
    signal(coordinator.id(), "TERM");
    let never = unique("never-begun");
    let mut second = follow(&endpoint, &never);
    assert_eq!(second.wait(Duration::from_secs(30)), Some(5), "{}", second.stderr());
    assert!(second.stderr().contains("left before the run began"), "{}", second.stderr());
    assert!(!never.exists(), "a run that never began has no folder");
    signal(first.id(), "CONT");
    assert_eq!(first.wait(Duration::from_secs(30)), Some(5), "{}", first.stderr());
    assert!(first.stderr().contains("was stopped"), "{}", first.stderr());
    // Nobody is left to wait for: it need not see that they ask no more.
    assert_eq!(coordinator.wait(Duration::from_secs(6)), Some(0), "{}", coordinator.stderr());
    all_end(&workers);
    let inspect = Cullet::new(&["inspect", "--json"]).path(&out.join("run.mcap")).output();
    assert_eq!(inspect.code, 0, "{}", inspect.stderr);
    // The log has the code that the client had.
    let log = common::history::lines(&log_of(&runs));
    let ends: Vec<_> = log.iter().filter(|line| line["message"] == "run ended").collect();
    let codes: Vec<_> = ends.iter().map(|line| (&line["run"], &line["code"])).collect();
    assert_eq!(codes, [(&2.into(), &5.into()), (&1.into(), &5.into())], "{ends:?}");
}

/// A client that hears nothing keeps the coordinator waiting.
#[test]
fn a_coordinator_interrupted_twice_quits_at_once() {
    let _left = common::left::NobodyLeft::watch();
    let runs = unique("leaving");
    let (mut coordinator, client, _, _) = served(&runs);
    let workers = workers_of(coordinator.id());
    signal(client.id(), "STOP");
    signal(coordinator.id(), "INT");
    wait_for(&runs.join("drop-1/preview.gif"));
    signal(coordinator.id(), "INT");
    assert_eq!(coordinator.wait(Duration::from_secs(5)), Some(130), "it still waits");
    all_end(&workers);
}

/// Runs a line of shell. A program that this process wrote itself could be busy: a child that
/// another test is just starting still holds what is open for writing here.
fn shell(line: &str) {
    let status = std::process::Command::new("sh").args(["-c", line]).status().expect("a shell");
    assert!(status.success(), "{line}");
}

/// The program is removed or replaced while the process starts. Whether the process asks for its
/// own path before or after that, its workers' program is missing or is another one.
#[test]
fn a_pool_whose_workers_cannot_live_ends_aloud() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("dying");
    fs::create_dir_all(folder.join("own")).expect("a folder");
    let program = folder.join("cullet");
    let run = |worker: Option<&str>| {
        shell(&format!("cp '{}' '{}'", env!("CARGO_BIN_EXE_cullet"), program.display()));
        let other = ["cullet (deleted)", "other"].map(|name| folder.join(name));
        for place in other.iter().filter(|_| worker.is_some()) {
            let (worker, place) = (worker.unwrap_or_default(), place.display());
            shell(&format!("printf '%s' '{worker}' >'{place}' && chmod 755 '{place}'"));
        }
        let call = Cullet::of(&program, &["run", "-q", "--out"]).path(&folder.join("own"));
        let mut run = call.args(&[&corpus("drop.toml")]).spawn();
        match worker {
            Some(_) => fs::rename(&other[1], &program).expect("another program in its place"),
            None => fs::remove_file(&program).expect("the copy goes"),
        }
        (run.wait(Duration::from_secs(60)), run.stderr())
    };
    let (code, stderr) = run(None);
    assert_eq!(code, Some(70), "{stderr}");
    assert!(stderr.contains("cannot start the worker"), "{stderr}");
    assert!(folder.join("own").is_dir(), "a folder of the user's is gone");
    let (code, stderr) = run(Some("#!/bin/sh\nexit 7\n"));
    assert_eq!(code, Some(6), "{stderr}");
    assert!(stderr.contains("before it asked for work, last with exit status: 7"), "{stderr}");
}

#[test]
fn a_killed_parent_leaves_no_worker_and_a_recording_that_can_be_recovered() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("orphans");
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "--workers", "2", "--out"])
        .path(&out)
        .args(&LONGER)
        .args(&["--set", "world.duration=600"])
        .spawn();
    let workers = workers_of(run.id());
    sleep(Duration::from_secs(3));
    signal(run.id(), "KILL");
    run.wait(Duration::from_secs(5));
    let until = Instant::now() + Duration::from_secs(10);
    let alive = || workers.iter().any(|id| common::is_alive(*id));
    while alive() && Instant::now() < until {
        sleep(Duration::from_millis(50));
    }
    assert!(!alive(), "workers outlive their parent");
    let partial = out.join("run.mcap.partial");
    assert!(partial.is_file() && !out.join("run.mcap").exists());
    let recovered = out.join("saved.mcap");
    let recover = Cullet::new(&["recover"]).path(&partial).args(&["-o"]).path(&recovered).output();
    assert_eq!(recover.code, 0, "{}", recover.stderr);
    let inspect = Cullet::new(&["inspect", "--json"]).path(&recovered).output();
    assert_eq!(inspect.code, 0, "{}", inspect.stderr);
    let told: serde_json::Value = serde_json::from_str(&inspect.stdout).expect("JSON");
    assert!(told["steps"].as_u64() > Some(0), "{told:#}");
    assert!(fs::metadata(&recovered).expect("a file").len() > 0);
}
