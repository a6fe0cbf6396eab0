//! How soon the pool is itself again, and what a slow link takes: in seconds, of worker processes
//! that do as they are told. `cargo build --release -p cullet-worker --examples`, then
//! `CULLET_REPEATS=6 CULLET_BULK_MB=50 cargo test --release -p cullet-worker --test farm gates --
//! --nocapture --test-threads 1` prints the figures that
//! `docs/pool.md` has, and holds them to their gates; without `CULLET_REPEATS` nothing is held to a
//! time.

use crate::figures::{gate, number, tell};
use crate::kit::{PATIENCE, config, job, next, verdict, wait_for, with_processes};
use crate::proxy::proxy;
use cullet_pool::{Pool, PoolConfig, Settlement, Share, Timing};
use cullet_proto::FractureJob;
use cullet_proto::transport::Patience;
use serde_json::Value;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// 20 Mbit/s in bytes a second.
const LINE: u64 = 2_500_000;

/// A worker process; it is killed when dropped.
struct Stub(Child);

impl Stub {
    fn start(endpoint: &str, name: &str, args: &[&str], log: Option<&Path>) -> Self {
        let mut call = Command::new(crate::kit::stub());
        call.args(["worker", "--connect", endpoint, "--name", name, "--parent-watch"]);
        call.args(args);
        if let Some(log) = log {
            let levels = "warn,cullet_worker=debug,zenoh=error";
            call.env("CULLET_LOG", levels).stderr(File::create(log).expect("a log"));
        }
        Self(call.stdin(Stdio::piped()).spawn().expect("the stub starts"))
    }
}

impl Drop for Stub {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

fn kill(pid: u32) {
    let status = Command::new("kill").args(["-9", &pid.to_string()]).status();
    assert!(status.is_ok_and(|status| status.success()), "kill {pid}");
}

/// The process in which a worker's jobs run.
fn job_process(worker: u32) -> u32 {
    let place = format!("/proc/{worker}/task");
    let threads = std::fs::read_dir(place).expect("a process").flatten();
    let all: String = threads
        .filter_map(|thread| std::fs::read_to_string(thread.path().join("children")).ok())
        .collect();
    all.trim().parse().expect("one process")
}

/// Seconds from something that is done to a job's worker to the grant to another one.
fn granted_again(pool: &Pool, harm: impl FnOnce(&str)) -> f64 {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::SeqCst);
    let solver = format!("linger-{}-{count}", std::process::id());
    let begun = std::env::temp_dir().join(format!("cullet-{solver}"));
    let run = pool.run(Share::default());
    wait_for("two workers", || pool.stats().workers == 2);
    let opened = Instant::now();
    let id = run.open(&job(&solver, count, 0));
    wait_for("a solver has it", || begun.exists());
    let holder = pool.workers().into_iter().find(|worker| !worker.jobs.is_empty());
    let harmed = opened.elapsed();
    harm(&holder.expect("it is at a worker").name);
    let settlement: Settlement = next(&run, id);
    std::fs::remove_file(begun).expect("it is there");
    let second = settlement.tries.get(1).map(|tried| tried.granted);
    let second = second.unwrap_or_else(|| panic!("it was not granted again: {settlement:?}"));
    verdict(settlement);
    second.saturating_sub(harmed).as_secs_f64()
}

#[test]
fn a_job_whose_worker_is_killed_goes_to_another_after_the_grace() {
    let repeats = number("CULLET_REPEATS", 3);
    let timing = Timing { suspect: 100, ..Timing::test() };
    let pool = Pool::start(PoolConfig { timing, ..config() }).expect("a pool on loopback");
    let mut crew: Vec<(String, Stub)> = Vec::new();
    let all = (0..repeats).map(|turn| {
        while crew.len() < 2 {
            let name = format!("s{turn}-{}", crew.len());
            let stub = Stub::start(pool.endpoint(), &name, &[], None);
            crew.push((name, stub));
        }
        granted_again(&pool, |name| crew.retain(|(known, _)| known != name))
    });
    // Dropping it kills it.
    let middle = tell("worker killed, 100 ms of grace, 50 ms of pause", all.collect());
    assert!(middle >= 0.1, "{middle} s: nobody waited for its link");
    gate(middle, 0.5);
}

/// The process of a child that has its first life, by its name.
fn child(pool: &Pool, name: &str) -> u32 {
    let index: usize = name.trim_start_matches('w').parse().expect("a number");
    pool.pids()[index - 1]
}

#[test]
fn a_job_whose_solver_is_killed_or_whose_worker_is_a_child_goes_to_another_at_once() {
    let repeats = number("CULLET_REPEATS", 3);
    // New ones each time, for one under which jobs die is sent away.
    let all = |harm: fn(&Pool, &str)| -> Vec<f64> {
        let turn = |_| {
            let pool = with_processes(2);
            granted_again(&pool, |name| harm(&pool, name))
        };
        (0..repeats).map(turn).collect()
    };
    let solver = all(|pool, name| kill(job_process(child(pool, name))));
    let solver = tell("solver killed, 50 ms of pause", solver);
    let child = all(|pool, name| kill(child(pool, name)));
    let child = tell("child of the coordinator killed, 50 ms of pause", child);
    gate(solver, 0.5);
    gate(child, 0.5);
}

/// Three times as long as a lease of a job lasts, and four times as long as one of a link.
#[test]
fn a_worker_behind_a_blackhole_is_back_as_soon_as_it_heals_and_nothing_is_lost() {
    let repeats = number("CULLET_REPEATS", 1);
    let pool = Pool::start(config()).expect("a pool on loopback");
    let (weather, behind) = proxy(pool.endpoint());
    let _far = Stub::start(&behind, "far", &[], None);
    let run = pool.run(Share::default());
    wait_for("a worker", || pool.stats().workers == 1);
    let all = (0..repeats).map(|turn| {
        let jobs: Vec<_> = (0..3).map(|k| job("echo", turn << 8 | k, 1_500)).collect();
        let ids: Vec<_> = jobs.iter().map(|job| run.open(job)).collect();
        wait_for("it has a job", || pool.stats().jobs.running == 1);
        weather.silent.store(true, Ordering::SeqCst);
        sleep(Duration::from_millis(3 * Timing::test().lease));
        let mut held = pool.stats();
        wait_for("nobody is there", || {
            held = pool.stats();
            (held.workers, held.jobs.running) == (0, 0)
        });
        weather.silent.store(false, Ordering::SeqCst);
        let healed = Instant::now();
        let before = held.jobs.settled;
        wait_for("it is at work", || {
            let now = pool.stats().jobs;
            now.running == 1 || now.settled > before
        });
        let took = healed.elapsed().as_secs_f64();
        ids.iter().for_each(|id| drop(verdict(next(&run, *id))));
        took
    });
    let middle = tell("blackhole of 4.5 s, healed: at work again", all.collect());
    let counts = pool.stats();
    assert_eq!(counts.jobs.opened, counts.jobs.settled);
    assert!(counts.lost >= repeats && counts.back >= repeats, "a link that ended is counted");
    gate(middle, 2.0);
}

/// A result comes over a slow line in little more than the line's own time, and renewals come
/// through in between.
#[test]
fn a_large_result_on_a_slow_link_takes_the_time_of_the_line_and_holds_no_renewal_up() {
    let size = number("CULLET_BULK_MB", 6);
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("log");
    // Patient, so that what is sent again is so for no stall of the machine.
    let (timing, patience) = (Timing { renew: 300, ..Timing::default() }, Patience::production());
    let pool = PoolConfig { timing, patience, ..config() };
    let pool = Pool::start(pool).expect("a pool on loopback");
    let (weather, behind) = proxy(pool.endpoint());
    weather.rate.store(LINE, Ordering::SeqCst);
    let _far = Stub::start(&behind, "far", &["--patient"], Some(&log));
    let run = pool.run(Share::default());
    let id = run.open(&FractureJob::smallest(&format!("bulk-{size}"), 1));
    let patience = PATIENCE + Duration::from_secs(size);
    let (settled, settlement) = run.settled(patience).expect("a settlement in time");
    assert_eq!((settled, settlement.attempts, settlement.tries.len()), (id, 1, 1), "sent again");
    let bytes = verdict(settlement).encode().expect("a verdict").len();
    wait_for("a receipt is logged", || read(&log).iter().any(|l| l["message"] == HANDED_IN));
    let lines = read(&log);
    let at = |message: &str| {
        let line = lines.iter().find(|line| line["message"] == message);
        line.and_then(|line| line["seconds"].as_f64()).unwrap_or_else(|| panic!("no {message}"))
    };
    let (took, line) = (at(HANDED_IN) - at("job solved"), bytes as f64 / LINE as f64);
    let renewed = lines.iter().filter(|line| line["message"] == "renewed");
    assert!(renewed.clone().all(|line| line["heard"] == true), "a renewal was not answered");
    let mut renewed: Vec<f64> = renewed.filter_map(|line| line["seconds"].as_f64()).collect();
    renewed.sort_by(f64::total_cmp);
    let most = renewed[(renewed.len() * 99).div_ceil(100) - 1];
    println!(
        "{bytes} bytes at {LINE} bytes a second: {took:.2} s, {:.3} times the line's {line:.2} s; \
         {} renewals, 99 % within {most:.3} s",
        took / line,
        renewed.len(),
    );
    assert!(renewed.len() as f64 > line / 2.0, "{renewed:?}");
    let passed = weather.passed.load(Ordering::SeqCst) as f64 / bytes as f64;
    assert!(passed < 1.2, "{passed} times as many bytes passed");
    gate(took, 1.2 * line);
    gate(most, 1.0);
    let counts = pool.stats();
    assert_eq!((counts.jobs.resent, counts.fenced, counts.damaged), (0, 0, 0));
    // Its link was never given up in all that time, not for a moment.
    assert_eq!((counts.workers, counts.lost, counts.back), (1, 0, 0), "the link flapped");
}

/// What a worker says when a result has been taken.
const HANDED_IN: &str = "result handed in";

fn read(log: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(log).expect("a log");
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}
