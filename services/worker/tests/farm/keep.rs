//! What the pool keeps, and what it tells while it works.

use crate::kit::{HiredWorker, answer, config, job, next, solve, verdict, wait_for};
use cullet_pool::{CacheConfig, JobEnding, Pool, PoolConfig, RunHandle, Share, Timing};
use cullet_proto::{FractureJob, Verdict, WorkerId};
use cullet_run::JobPool;
use cullet_worker::JobControl;
use std::sync::Arc;

#[test]
fn a_repeat_is_answered_without_a_worker_also_by_the_next_life() {
    let folder = tempfile::tempdir().expect("a folder");
    let disk = Some((folder.path().to_owned(), 1 << 20));
    let cache = CacheConfig { memory: 1 << 20, disk };
    let problem = job("echo", 3, 0);
    let start = || Pool::start(PoolConfig { cache: cache.clone(), ..config() }).expect("a pool");
    let pool = start();
    let run = pool.run(Share::default());
    let hired = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let id = run.open(&problem);
    let first = next(&run, id);
    assert!(!first.cached && first.attempts == 1);
    drop(hired);
    for pool in [pool, start()] {
        let run = pool.run(Share::default());
        let id = run.open(&problem);
        let again = next(&run, id);
        assert!(again.cached && again.attempts == 0);
        assert_eq!(verdict(again), answer(&problem));
        assert_eq!(pool.stats().cached, 1);
    }
}

#[test]
fn a_job_that_kills_its_workers_leaves_what_reproduces_it_and_stalls_its_run_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let quarantine = Some(folder.path().to_owned());
    let timing = Timing { hard: 200, ..Timing::test() };
    let pool = Pool::start(PoolConfig { quarantine, timing, ..config() }).expect("a pool");
    let hands = ["a", "b"].map(|name| HiredWorker::hire(&pool, name, Arc::new(solve)));
    let (sick, well) = (pool.run(Share::default()), pool.run(Share::default()));
    let poison = job("echo", 1, 60_000);
    let bad = sick.open(&poison);
    let good: Vec<_> = (10..20).map(|seed| well.open(&job("echo", seed, 10))).collect();
    for id in good {
        verdict(next(&well, id));
    }
    assert!(matches!(next(&sick, bad).ending, JobEnding::Abandoned(_)));
    let bundle = folder.path().join(bad.to_string());
    let bytes = std::fs::read(bundle.join("job.bin")).expect("the job");
    assert_eq!(FractureJob::decode(&bytes).expect("a job"), poison);
    let told = std::fs::read_to_string(bundle.join("attempts.txt")).expect("the attempts");
    let (told, seal) = told.trim_end().rsplit_once('\n').expect("lines and their checksum");
    assert!(seal.starts_with("crc32c "), "{seal}");
    assert_eq!(told.lines().count(), 3, "{told}");
    assert!(told.lines().all(|line| line.contains("over the hard limit")), "{told}");
    // For whom, by what, and when.
    let (version, run) = (env!("CARGO_PKG_VERSION"), sick.number());
    let about = [format!("run {run}, worker "), format!("(version {version}, build ")];
    for words in about.iter().map(String::as_str).chain([", 1 threads of ", " s on for "]) {
        assert!(told.lines().all(|line| line.contains(words)), "{words:?} is not in {told}");
    }
    assert_eq!(told.matches("), from 0.00 s on for ").count(), 1, "{told}");
    // In quarantine it stays: who opens it again hears so at once.
    let again = well.open(&poison);
    assert!(matches!(next(&well, again).ending, JobEnding::Abandoned(_)));
    assert_eq!(pool.stats().quarantined, 1);
    // Also in the next life, until it is pardoned; and then in the one after that, too.
    drop(hands);
    pool.shutdown();
    let start = || {
        let quarantine = Some(folder.path().to_owned());
        Pool::start(PoolConfig { quarantine, timing, ..config() }).expect("a pool")
    };
    let pool = start();
    let run = pool.run(Share::default());
    let again = run.open(&poison);
    let JobEnding::Abandoned(text) = next(&run, again).ending else { panic!("it has a verdict") };
    assert!(text.contains("0 attempts"), "{text}");
    assert_eq!(pool.stats().quarantined, 1);
    pool.pardon(bad);
    wait_for("the pardon", || pool.stats().quarantined == 0);
    pool.shutdown();
    let pool = start();
    let run = pool.run(Share::default());
    let _hand = HiredWorker::hire(&pool, "c", Arc::new(solve));
    run.open(&poison);
    wait_for("it is tried", || pool.stats().jobs.running == 1);
}

#[test]
fn a_drained_worker_finishes_its_job_and_gets_no_other() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let _a = HiredWorker::hire(&pool, "a", Arc::new(solve));
    let first = run.open(&job("echo", 1, 200));
    wait_for("it runs", || pool.stats().jobs.running == 1);
    pool.drain(WorkerId::new("a").expect("a name"));
    let second = run.open(&job("echo", 2, 0));
    assert_eq!(next(&run, first).worker, "a");
    wait_for("it leaves", || pool.stats().workers == 0);
    let _b = HiredWorker::hire(&pool, "b", Arc::new(solve));
    assert_eq!(next(&run, second).worker, "b");
}

#[test]
fn how_far_a_solve_is_streams_back() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let half = |job: &FractureJob, watch: &JobControl| -> Option<Verdict> {
        watch.progress(0.5);
        solve(job, watch)
    };
    let hired = HiredWorker::hire(&pool, "w", Arc::new(half));
    let id = run.open(&job("echo", 1, 10_000));
    let load = |run: &RunHandle| (run.load().jobs, run.load().permille);
    wait_for("half of it", || load(&run) == (1, 500));
    // One that wants it too hears at once how far it is; and one that waits does not count.
    let other = pool.run(Share::default());
    other.open(&job("echo", 1, 10_000));
    wait_for("half of it, for another", || load(&other) == (1, 500));
    other.open(&job("echo", 2, 1_500));
    wait_for("the mean", || load(&other) == (2, 500));
    // It is given back, and begins at the beginning.
    drop(hired);
    wait_for("nobody is at it", || (load(&run), load(&other)) == ((1, 0), (2, 0)));
    run.cancel();
    other.cancel();
    assert_eq!(next(&run, id).ending, JobEnding::Cancelled);
    wait_for("nothing is wanted", || load(&run) == (0, 0));
    let _hand = HiredWorker::hire(&pool, "v", Arc::new(half));
    let id = run.open(&job("echo", 3, 1_500));
    wait_for("half of another", || load(&run) == (1, 500));
    verdict(next(&run, id));
    wait_for("nothing runs", || (load(&run), run.stats().permille) == ((0, 0), 0));
}
