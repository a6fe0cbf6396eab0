//! The number of workers and their haste do not show in the results.

use crate::kit::{
    HiredWorker, answer, config, job, next, parts, solve, verdict, wait_for, with_processes_of,
};
use cullet_geometry::{Sheet, Solid, TriMesh, Vec3};
use cullet_model::{Fragment, Fragmentation, Report};
use cullet_pool::{JobEnding, Pool, PoolConfig, Share, Timing};
use cullet_proto::{FractureJob, Verdict};
use cullet_run::JobPool;
use cullet_worker::JobControl;
use std::sync::Arc;
use std::time::Duration;

#[test]
fn thirty_jobs_settle_in_order_with_the_same_results_on_one_two_and_three_workers() {
    // Later jobs are shorter, so that more workers finish them out of order.
    let jobs: Vec<_> = (0..30).map(|k| job("echo", k, 30 - k as u32)).collect();
    let truth: Vec<_> = jobs.iter().map(answer).collect();
    for workers in 1..=3 {
        let pool = Pool::start(config()).expect("a pool on loopback");
        let run = pool.run(Share::default());
        let names: Vec<_> = (0..workers).map(|k| format!("w{k}")).collect();
        let _hands: Vec<_> =
            names.iter().map(|name| HiredWorker::hire(&pool, name, Arc::new(solve))).collect();
        let ids: Vec<_> = jobs.iter().map(|job| run.open(job)).collect();
        for (id, truth) in ids.iter().zip(&truth) {
            let settlement = next(&run, *id);
            assert_eq!(settlement.attempts, 1);
            assert!(names.contains(&settlement.worker), "{}", settlement.worker);
            assert_eq!(&verdict(settlement), truth);
        }
        let stats = pool.stats();
        assert_eq!((stats.jobs.settled, stats.jobs.resent, stats.alarms), (30, 0, 0));
    }
}

/// What `examples/sleepers.rs` times, of processes.
#[test]
fn a_thousand_jobs_of_no_length_settle_once_and_in_order_through_eight_workers() {
    // As patient as in real runs: nobody is harmed, so nothing may be sent again.
    let pool = with_processes_of(8, Timing::default());
    wait_for("eight workers", || pool.stats().workers == 8);
    let run = pool.run(Share::default());
    let ids: Vec<_> = (0..1_000).map(|seed| run.open(&job("nothing", seed, 0))).collect();
    for (seed, id) in ids.iter().enumerate() {
        let settlement = next(&run, *id);
        assert_eq!((settlement.attempts, settlement.cached), (1, false));
        let body = parts(settlement);
        assert_eq!((body.report.steps, body.fragments.len()), (seed as u64, seed % 7));
    }
    assert!(run.settled(Duration::from_millis(50)).is_none(), "one has settled twice");
    let stats = pool.stats();
    let jobs = stats.jobs;
    assert_eq!((jobs.opened, jobs.settled, jobs.resent), (1_000, 1_000, 0));
    assert_eq!((stats.alarms, stats.hedged, stats.cached), (0, 0, 0));
}

#[test]
fn one_problem_opened_twice_is_settled_twice() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let job = job("echo", 3, 20);
    let (first, second) = (run.open(&job), run.open(&job));
    assert_eq!(first, second);
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    for _ in 0..2 {
        assert_eq!(verdict(next(&run, first)), answer(&job));
    }
}

#[test]
fn a_job_and_a_result_of_twenty_megabytes_go_over_in_chunks() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let grid: Vec<_> = (0..700_000).map(|k| Vec3::new(f64::from(k), 0.5, -1.0)).collect();
    let triangles = (0..200_000).map(|k| [k, k + 1, k + 2]).collect();
    let solid = Solid::outer(TriMesh { vertices: grid, triangles });
    let mut large = job("large", 1, 0);
    large.problem.body = solid.clone().into();
    let back = |job: &FractureJob, _: &JobControl| {
        let solid = (**job.problem.body.solid().expect("a solid")).clone();
        let (velocity, spin) = (Vec3::x(), Vec3::y());
        let (hulls, sheet) = (Vec::new(), Sheet::default());
        let fragments = vec![Fragment { solid, hulls, velocity, spin, sheet }];
        let report = Report::default();
        Some(Fragmentation { fragments, report, ..Fragmentation::default() }.into())
    };
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(back));
    let id = run.open(&large);
    let body = parts(next(&run, id));
    assert_eq!(body.fragments[0].solid, solid);
}

#[test]
fn refusals_failures_and_panics_are_verdicts() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let say = |job: &FractureJob, _: &JobControl| {
        let (solver, text) = (job.solver.clone(), "so".to_owned());
        match job.solver.as_str() {
            "no" => Some(Verdict::Refused { solver, text }),
            "bad" => Some(Verdict::Failed { solver, text }),
            _ => panic!("a bug"),
        }
    };
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(say));
    let ids = ["no", "bad", "bug"].map(|solver| run.open(&job(solver, 0, 0)));
    assert!(matches!(verdict(next(&run, ids[0])), Verdict::Refused { .. }));
    assert!(matches!(verdict(next(&run, ids[1])), Verdict::Failed { .. }));
    let Verdict::Failed { text, .. } = verdict(next(&run, ids[2])) else { panic!("not failed") };
    assert_eq!(text, "the solver panicked: a bug");
    let stats = pool.stats();
    assert_eq!((stats.jobs.refused, stats.jobs.failed, stats.jobs.resent), (1, 2, 0));
}

#[test]
fn a_job_over_a_limit_is_abandoned_with_the_bound_and_holds_up_nothing() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let mut bad = job("echo", 1, 0);
    bad.problem.impacts[0].energy = f64::NAN;
    let (bad, good) = (run.open(&bad), run.open(&job("echo", 2, 0)));
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let JobEnding::Abandoned(text) = next(&run, bad).ending else { panic!("not abandoned") };
    assert!(text.contains("impacts is not finite"), "{text}");
    verdict(next(&run, good));
}

#[test]
fn what_is_cancelled_settles_so_and_the_worker_is_free_again() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let long = run.open(&job("echo", 1, 60_000));
    crate::kit::wait_for("the job runs", || pool.stats().jobs.running == 1);
    run.cancel();
    assert_eq!(next(&run, long).ending, JobEnding::Cancelled);
    let short = run.open(&job("echo", 2, 0));
    verdict(next(&run, short));
    assert!(run.settled(Duration::from_millis(50)).is_none());
}

/// Nobody renews while the test lasts: what frees the worker is that it is told at once.
#[test]
fn a_worker_whose_job_is_cancelled_is_told_long_before_it_renews() {
    let hour = 3_600_000;
    let timing = Timing { renew: hour, lease: 2 * hour, hard: 2 * hour, ..Timing::test() };
    let on_thread = Pool::start(PoolConfig { timing, ..config() }).expect("a pool on loopback");
    let _hand = HiredWorker::hire(&on_thread, "w", Arc::new(solve));
    for pool in [on_thread, with_processes_of(1, timing)] {
        let (run, other) = (pool.run(Share::default()), pool.run(Share::default()));
        let long = job("echo", 1, hour as u32);
        let id = run.open(&long);
        // Once before its question is there, and once while it is held.
        for pause in [0, 600] {
            wait_for("a solver has the job", || run.load().permille > 0);
            std::thread::sleep(Duration::from_millis(pause));
            let pids = pool.pids();
            run.cancel();
            assert_eq!(next(&run, id).ending, JobEnding::Cancelled);
            let free = other.open(&job("echo", 2 + pause, 0));
            verdict(next(&other, free));
            assert_eq!((pool.pids(), pool.stats().jobs.resent), (pids, 0));
            assert_eq!(run.open(&long), id);
        }
        run.cancel();
    }
}

#[test]
fn runs_share_a_pool_and_settle_each_in_its_own_order() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let _hands = ["a", "b"].map(|name| HiredWorker::hire(&pool, name, Arc::new(solve)));
    let (one, two) = (pool.run(Share::default()), pool.run(Share::default()));
    let common = job("echo", 99, 20);
    let of = |run: u64| (0..10).map(move |k| job("echo", 100 * run + k, 10 - k as u32));
    let mut ids = Vec::new();
    for (a, b) in of(1).zip(of(2)) {
        ids.push((one.open(&a), two.open(&b)));
    }
    // One problem of both is computed once.
    assert_eq!(one.open(&common), two.open(&common));
    for (a, b) in &ids {
        verdict(next(&one, *a));
        verdict(next(&two, *b));
    }
    let last = [&one, &two].map(|run| run.settled(crate::kit::PATIENCE).expect("the common one"));
    assert_eq!(last[0].0, last[1].0);
    for (_, settlement) in last {
        assert_eq!(verdict(settlement), answer(&common));
    }
    let stats = pool.stats();
    assert_eq!((stats.jobs.opened, stats.jobs.settled, stats.jobs.resent), (22, 22, 0));
    assert_eq!(one.stats().settled, 11);
}

#[test]
fn one_run_is_paused_or_dropped_and_the_others_go_on() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let (idle, busy) = (pool.run(Share::default()), pool.run(Share::default()));
    idle.pause();
    let waiting = idle.open(&job("echo", 1, 0));
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let id = busy.open(&job("echo", 2, 0));
    verdict(next(&busy, id));
    assert!(idle.settled(Duration::from_millis(100)).is_none());
    let long = busy.open(&job("echo", 3, 60_000));
    crate::kit::wait_for("the job runs", || busy.stats().running == 1);
    drop(busy);
    idle.resume();
    verdict(next(&idle, waiting));
    assert_ne!(long, waiting);
    assert_eq!(pool.stats().jobs.running, 0);
}
