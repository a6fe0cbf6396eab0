//! Workers that die, hang or stop.

use crate::kit::{
    HiredWorker, config, job, next, parts, solve, verdict, wait_for, with_processes,
    with_processes_of,
};
use cullet_pool::{JobEnding, Pool, PoolConfig, Share, SpawnConfig, Timing};
use cullet_proto::{FractureJob, Verdict};
use cullet_worker::{JobCommand, JobControl, WorkerConfig};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

fn alive(pid: u32) -> bool {
    Path::new("/proc").join(pid.to_string()).exists()
}

fn kill(pid: u32) {
    let status = Command::new("kill").args(["-9", &pid.to_string()]).status();
    assert!(status.is_ok_and(|s| s.success()), "kill {pid}");
}

#[test]
fn a_worker_killed_in_the_middle_of_a_job_costs_a_repeat_and_no_result() {
    let pool = with_processes(2);
    let run = pool.run(Share::default());
    wait_for("two workers", || pool.stats().workers == 2);
    let jobs: Vec<_> = (0..6).map(|k| job("echo", k, 400)).collect();
    let ids: Vec<_> = jobs.iter().map(|job| run.open(job)).collect();
    wait_for("both are at work", || pool.stats().jobs.running == 2);
    let first = pool.pids()[0];
    kill(first);
    for (id, job) in ids.iter().zip(&jobs) {
        let body = parts(next(&run, *id));
        assert_eq!(body.fragments.len() as u64, job.problem.seed % 7);
    }
    wait_for("another in its place", || pool.stats().respawned == 1);
    assert_eq!(pool.stats().jobs.resent, 1);
    let last = pool.pids();
    assert!(!last.contains(&first));
    pool.shutdown();
    assert!(last.into_iter().all(|pid| !alive(pid)), "a process was left behind");
}

#[test]
fn a_job_that_kills_its_workers_is_abandoned_and_the_others_settle() {
    let pool = with_processes(2);
    let run = pool.run(Share::default());
    let (poison, good) = (run.open(&job("die", 1, 0)), run.open(&job("echo", 2, 0)));
    let settlement = next(&run, poison);
    assert_eq!(settlement.attempts, 3);
    assert!(matches!(settlement.ending, JobEnding::Abandoned(_)), "{settlement:?}");
    verdict(next(&run, good));
}

/// A worker with so little memory that each of its job processes ends.
#[test]
fn a_worker_whose_every_job_dies_ends_none_while_another_is_busy_and_is_sent_away() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let exe = crate::kit::stub();
    let hire = |name, memory| {
        let command = JobCommand { exe: exe.clone(), args: vec!["job".into()], memory };
        let own = WorkerConfig { job: Some(command), ..WorkerConfig::default() };
        HiredWorker::hire_as(&pool, name, Arc::new(solve), own)
    };
    let _able = hire("able", Some(256 << 20));
    let long = run.open(&job("echo", 1, 6_000));
    wait_for("it runs", || pool.stats().jobs.running == 1);
    let _small = hire("small", Some(1 << 20));
    wait_for("the other is there", || pool.stats().workers == 2);
    let ids: Vec<_> = (2..6).map(|k| run.open(&job("echo", k, 200))).collect();
    wait_for("it is sent away", || pool.stats().workers == 1);
    let first = next(&run, long);
    assert_eq!((first.worker.as_str(), first.attempts), ("able", 1));
    for id in ids {
        let settlement = next(&run, id);
        assert_eq!((settlement.worker.as_str(), settlement.attempts), ("able", 2));
        verdict(settlement);
    }
}

#[test]
fn a_job_that_takes_its_workers_with_it_is_abandoned_and_the_others_settle() {
    let pool = with_processes(2);
    let run = pool.run(Share::default());
    wait_for("two workers", || pool.stats().workers == 2);
    let (poison, good) = (run.open(&job("drag", 1, 0)), run.open(&job("echo", 2, 0)));
    let settlement = next(&run, poison);
    // Three deaths count; of a worker that dies at once, its word that it began may not get out.
    assert!((3..=6).contains(&settlement.attempts), "{settlement:?}");
    assert!(matches!(settlement.ending, JobEnding::Abandoned(_)), "{settlement:?}");
    verdict(next(&run, good));
    assert!(pool.stats().respawned >= 2, "the workers died, not only their jobs");
}

#[test]
fn a_crash_a_hang_and_a_hoard_end_the_job_process_and_never_its_supervisor() {
    let timing = Timing { hard: 4_000, ..Timing::test() };
    let pool = with_processes_of(1, timing);
    let run = pool.run(Share::default());
    wait_for("a worker", || pool.stats().workers == 1);
    let before = pool.pids();
    let told = [
        ("die", "signal"),
        ("hang", "over the hard limit"),
        ("hoard", "256 MiB"),
        ("gulp", "256 MiB"),
    ];
    for (solver, words) in told {
        let id = run.open(&job(solver, 1, 60_000));
        let JobEnding::Abandoned(text) = next(&run, id).ending else { panic!("{solver}") };
        assert!(text.contains(words), "{solver}: {text}");
    }
    let good = run.open(&job("echo", 3, 0));
    verdict(next(&run, good));
    assert_eq!((pool.pids(), pool.stats().respawned), (before, 0));
}

#[test]
fn cancellation_reaches_the_solver_within_a_slice_of_a_renewal() {
    let pool = with_processes(1);
    let run = pool.run(Share::default());
    let long = run.open(&job("echo", 1, 60_000));
    wait_for("it runs", || run.stats().running == 1);
    std::thread::sleep(Duration::from_millis(500));
    run.cancel();
    let since = std::time::Instant::now();
    assert_eq!(next(&run, long).ending, JobEnding::Cancelled);
    let short = run.open(&job("echo", 2, 0));
    verdict(next(&run, short));
    // A renewal every 0.3 s, slices of 5 ms: nothing had to be killed.
    assert!(since.elapsed() < Duration::from_millis(1_000), "{:?}", since.elapsed());
}

#[test]
fn a_worker_ends_with_the_parent_that_held_its_input() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let exe = crate::kit::stub();
    let mut child = Command::new(exe)
        .args(["--connect", pool.endpoint(), "--name", "orphan", "--parent-watch"])
        .stdin(Stdio::piped())
        .spawn()
        .expect("a worker process");
    wait_for("it is there", || pool.stats().workers == 1);
    drop(child.stdin.take());
    wait_for("it ends", || child.try_wait().is_ok_and(|status| status.is_some()));
    wait_for("it is missed", || pool.stats().workers == 0);
}

#[test]
fn a_job_given_back_by_a_worker_that_stops_goes_to_another() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let leaving = HiredWorker::hire(&pool, "a", Arc::new(solve));
    let id = run.open(&job("echo", 1, 300));
    wait_for("it runs", || pool.stats().jobs.running == 1);
    leaving.tell();
    let _staying = HiredWorker::hire(&pool, "b", Arc::new(solve));
    let settlement = next(&run, id);
    assert_eq!((settlement.attempts, settlement.worker.as_str()), (2, "b"));
}

#[test]
fn processes_that_never_ask_for_work_are_given_up() {
    let exe = PathBuf::from("false");
    let spawn = SpawnConfig { args: Vec::new(), ..SpawnConfig::new(exe, 2, 1) };
    let pool = Pool::start(PoolConfig { spawn: Some(spawn), ..config() }).expect("a pool");
    let run = pool.run(Share::default());
    let id = run.open(&job("echo", 1, 0));
    let JobEnding::Abandoned(text) = next(&run, id).ending else { panic!("it has a verdict") };
    assert!(text.contains("no worker is left") && text.contains("false ended 6 times"), "{text}");
    let stats = pool.stats();
    assert_eq!((stats.children, stats.respawned), (0, 2 * 5), "it was tried no more and no less");
    // Somebody from elsewhere is as good.
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    wait_for("a worker", || pool.stats().workers == 1);
    let id = run.open(&job("echo", 2, 300));
    verdict(next(&run, id));
}

#[test]
fn a_worker_told_to_stop_leaves_though_its_question_is_held() {
    let timing = Timing { park: 600_000, ..Timing::test() };
    let pool = Pool::start(PoolConfig { timing, ..config() }).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let hired = HiredWorker::hire(&pool, "w", Arc::new(solve));
    // A job done: the next question finds none and is held.
    let id = run.open(&job("echo", 1, 0));
    verdict(next(&run, id));
    std::thread::sleep(Duration::from_millis(500));
    hired.tell();
    wait_for("it is gone", || pool.stats().workers == 0);
    let id = run.open(&job("echo", 2, 0));
    let _other = HiredWorker::hire(&pool, "x", Arc::new(solve));
    assert_eq!(next(&run, id).worker, "x");
}

#[test]
fn a_worker_that_is_idle_for_too_long_leaves_though_its_question_is_held() {
    let timing = Timing { park: 600_000, ..Timing::test() };
    let pool = Pool::start(PoolConfig { timing, ..config() }).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let idle = |limit| WorkerConfig { idle_limit: Some(limit), ..WorkerConfig::default() };
    let limit = Duration::from_millis(800);
    let hired = HiredWorker::hire_as(&pool, "w", Arc::new(solve), idle(limit));
    // A job that takes longer than that is no idleness.
    let id = run.open(&job("echo", 1, 2_000));
    assert_eq!(next(&run, id).worker, "w");
    wait_for("it has left", || hired.has_ended());
    wait_for("it is gone", || pool.stats().workers == 0);
    let id = run.open(&job("echo", 2, 0));
    let _other = HiredWorker::hire(&pool, "x", Arc::new(solve));
    assert_eq!(next(&run, id).worker, "x");
    // One that finds no coordinator ends too.
    let nobody = WorkerConfig { connect: vec!["tcp/127.0.0.1:9".to_owned()], ..idle(limit) };
    cullet_worker::run_with(nobody, Arc::new(solve)).expect("it ends");
}

#[test]
fn a_solver_over_the_hard_limit_is_stopped_and_in_the_end_abandoned() {
    let timing = Timing { hard: 300, ..Timing::test() };
    let pool = Pool::start(PoolConfig { timing, ..config() }).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let id = run.open(&job("echo", 1, 60_000));
    let settlement = next(&run, id);
    assert_eq!(settlement.attempts, 3);
    assert!(matches!(settlement.ending, JobEnding::Abandoned(_)), "{settlement:?}");
}

#[test]
fn a_worker_may_come_before_its_coordinator_and_outlive_it() {
    let first = Pool::start(config()).expect("a pool on loopback");
    let endpoint = first.endpoint().to_owned();
    let hired = HiredWorker::hire(&first, "w", Arc::new(solve));
    let run = first.run(Share::default());
    let id = run.open(&job("echo", 1, 0));
    verdict(next(&run, id));
    first.shutdown();
    std::thread::sleep(Duration::from_millis(300));
    let listen = Some(endpoint);
    let second = Pool::start(PoolConfig { listen, ..config() }).expect("a pool on loopback");
    let run = second.run(Share::default());
    let id = run.open(&job("echo", 2, 0));
    assert_eq!(next(&run, id).worker, "w");
    drop(hired);
}

#[test]
fn a_result_that_cannot_be_sent_is_no_result() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let nonsense = |job: &FractureJob, watch: &JobControl| {
        let Some(Verdict::Solved(outcome)) = solve(job, watch) else {
            return None;
        };
        let mut body = outcome.fracture()?;
        body.fragments[0].velocity.x = f64::NAN;
        Some(body.into())
    };
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(nonsense));
    let id = run.open(&job("echo", 1, 0));
    let settlement = next(&run, id);
    let JobEnding::Abandoned(text) = settlement.ending else { panic!("{settlement:?}") };
    assert!(text.contains("motion is not finite"), "{text}");
}
