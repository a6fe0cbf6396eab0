//! The number of workers and their haste do not show in the results.

use crate::kit::{Hand, answer, config, job, next, solve, verdict};
use cullet_coordinator::link::{Ending, Pool};
use cullet_geometry::{Sheet, Solid, TriMesh, Vec3};
use cullet_proto::{BrokenBody, FractureJob, Fragment, Report, Verdict};
use cullet_worker::Watch;
use std::sync::Arc;
use std::time::Duration;

#[test]
fn thirty_jobs_settle_in_order_with_the_same_results_on_one_two_and_three_workers() {
    // Later jobs are shorter, so that more workers finish them out of order.
    let jobs: Vec<_> = (0..30).map(|k| job("echo", k, 30 - k as u32)).collect();
    let truth: Vec<_> = jobs.iter().map(answer).collect();
    for workers in 1..=3 {
        let pool = Pool::start(config()).expect("a pool on loopback");
        let names: Vec<_> = (0..workers).map(|k| format!("w{k}")).collect();
        let _hands: Vec<_> =
            names.iter().map(|name| Hand::hire(&pool, name, Arc::new(solve))).collect();
        let ids: Vec<_> = jobs.iter().map(|job| pool.open(job)).collect();
        for (id, truth) in ids.iter().zip(&truth) {
            let settlement = next(&pool, *id);
            assert_eq!(settlement.attempts, 1);
            assert!(names.contains(&settlement.worker), "{}", settlement.worker);
            assert_eq!(&verdict(settlement), truth);
        }
        let stats = pool.stats();
        assert_eq!((stats.settled, stats.resent, stats.alarms), (30, 0, 0));
    }
}

#[test]
fn one_problem_opened_twice_is_settled_twice() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let job = job("echo", 3, 20);
    let (first, second) = (pool.open(&job), pool.open(&job));
    assert_eq!(first, second);
    let _hand = Hand::hire(&pool, "w", Arc::new(solve));
    for _ in 0..2 {
        assert_eq!(verdict(next(&pool, first)), answer(&job));
    }
}

#[test]
fn a_job_and_a_result_of_twenty_megabytes_go_over_in_chunks() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let grid: Vec<_> = (0..700_000).map(|k| Vec3::new(f64::from(k), 0.5, -1.0)).collect();
    let triangles = (0..200_000).map(|k| [k, k + 1, k + 2]).collect();
    let solid = Solid::outer(TriMesh { vertices: grid, triangles });
    let mut large = job("large", 1, 0);
    large.solid = solid;
    let back = |job: &FractureJob, _: &Watch| {
        let solid = job.solid.clone();
        let (velocity, spin) = (Vec3::x(), Vec3::y());
        let (hulls, sheet) = (Vec::new(), Sheet::default());
        let fragments = vec![Fragment { solid, hulls, velocity, spin, sheet }];
        let report = Report::default();
        Some(Verdict::Broken(Box::new(BrokenBody { fragments, report, ..BrokenBody::default() })))
    };
    let _hand = Hand::hire(&pool, "w", Arc::new(back));
    let id = pool.open(&large);
    let Verdict::Broken(body) = verdict(next(&pool, id)) else { panic!("another verdict") };
    assert_eq!(body.fragments[0].solid, large.solid);
}

#[test]
fn refusals_failures_and_panics_are_verdicts() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let say = |job: &FractureJob, _: &Watch| {
        let (solver, text) = (job.solver.clone(), "so".to_owned());
        match job.solver.as_str() {
            "no" => Some(Verdict::Refused { solver, text }),
            "bad" => Some(Verdict::Failed { solver, text }),
            _ => panic!("a bug"),
        }
    };
    let _hand = Hand::hire(&pool, "w", Arc::new(say));
    let ids = ["no", "bad", "bug"].map(|solver| pool.open(&job(solver, 0, 0)));
    assert!(matches!(verdict(next(&pool, ids[0])), Verdict::Refused { .. }));
    assert!(matches!(verdict(next(&pool, ids[1])), Verdict::Failed { .. }));
    let Verdict::Failed { text, .. } = verdict(next(&pool, ids[2])) else { panic!("not failed") };
    assert_eq!(text, "the solver panicked: a bug");
    let stats = pool.stats();
    assert_eq!((stats.refused, stats.failed, stats.resent), (1, 2, 0));
}

#[test]
fn a_job_over_a_limit_is_abandoned_with_the_bound_and_holds_up_nothing() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let mut bad = job("echo", 1, 0);
    bad.material.young = f64::NAN;
    let (bad, good) = (pool.open(&bad), pool.open(&job("echo", 2, 0)));
    let _hand = Hand::hire(&pool, "w", Arc::new(solve));
    let Ending::Abandoned(text) = next(&pool, bad).ending else { panic!("not abandoned") };
    assert!(text.contains("material is not finite"), "{text}");
    verdict(next(&pool, good));
}

#[test]
fn what_is_cancelled_settles_so_and_the_worker_is_free_again() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let _hand = Hand::hire(&pool, "w", Arc::new(solve));
    let long = pool.open(&job("echo", 1, 60_000));
    crate::kit::wait_for("the job runs", || pool.stats().running == 1);
    pool.cancel_all();
    assert_eq!(next(&pool, long).ending, Ending::Cancelled);
    let short = pool.open(&job("echo", 2, 0));
    verdict(next(&pool, short));
    assert!(pool.settled(Duration::from_millis(50)).is_none());
}

#[test]
fn a_cleared_pool_owes_nothing_to_the_next_run() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let _hand = Hand::hire(&pool, "w", Arc::new(solve));
    for seed in 1..=3 {
        pool.open(&job("echo", seed, 60_000));
    }
    pool.clear();
    let mine = pool.open(&job("echo", 4, 0));
    verdict(next(&pool, mine));
    pool.clear();
    assert!(pool.settled(Duration::from_millis(50)).is_none());
}
