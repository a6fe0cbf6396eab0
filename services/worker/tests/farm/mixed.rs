//! Meshes that travel once, workers that differ, and queues that are full.

use crate::kit::{HiredWorker, answer, config, job, next, solve, verdict, wait_for};
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{ContinuumBody, MembranePace, PointPrecision};
use cullet_pool::{JobEnding, Pool, PoolConfig, Share, Timing};
use cullet_proto::outline::LARGE;
use cullet_proto::pool::Family;
use cullet_proto::{FractureJob, Verdict, WindowJob};
use cullet_worker::WorkerConfig;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// Jobs of one body whose mesh does not fit a chunk.
fn large(seed: u64) -> FractureJob {
    let detail = shapes::Detail { edge: Some(0.003), ..shapes::Detail::default() };
    let solid = Solid::outer(shapes::cuboid(Vec3::repeat(0.2), detail).expect("a box"));
    let mut large = job("echo", seed, 0);
    large.problem.body = solid.into();
    large
}

#[test]
fn a_mesh_goes_to_each_worker_once_and_again_to_one_that_keeps_none() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let hired = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let mut sent = Vec::new();
    for seed in 0..3 {
        let id = run.open(&large(seed));
        assert_eq!(verdict(next(&run, id)), answer(&large(seed)));
        sent.push(pool.stats().mesh_bytes);
    }
    assert!(sent[0] > 1 << 20, "{sent:?}: more than a chunk");
    assert_eq!(sent[1..], [sent[0]; 2], "a mesh was sent again");
    drop(hired);
    let poor = WorkerConfig { meshes: 0, ..WorkerConfig::default() };
    let _hand = HiredWorker::hire_as(&pool, "poor", Arc::new(solve), poor);
    for seed in 3..5 {
        let id = run.open(&large(seed));
        verdict(next(&run, id));
    }
    assert_eq!(pool.stats().mesh_bytes, 3 * sent[0]);
}

/// The first window of a square of paper, whose state does not fit an outline.
fn paper() -> WindowJob {
    let mut job = WindowJob::smallest("membrane", 7);
    if let ContinuumBody::Membrane(sheet) = &mut job.setup.body {
        (sheet.pace, sheet.material.fracture_energy) = (MembranePace::Softer(50.0), 60.0);
    }
    job.window.steps = 1;
    job
}

/// The worker that solved the last window asked for work after the other one did: by turns, every
/// state would be sent.
#[test]
fn the_state_of_a_sheet_is_not_sent_while_the_worker_that_made_it_lives() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let mut hands = BTreeMap::from(
        ["a", "b"].map(|name| (name, HiredWorker::hire(&pool, name, Arc::new(solve)))),
    );
    let (mut job, mut after) = (paper(), None);
    let mut solve_next = |workers: u64| {
        wait_for("all of them ask", || pool.stats().asking == workers);
        let id = run.open_window(&job, after);
        let settlement = next(&run, id);
        let solver = settlement.worker.clone();
        let verdict = verdict(settlement);
        let Verdict::Moved(outcome) = verdict else { panic!("no outcome: {verdict:?}") };
        job.window.first_step += u64::from(job.window.steps);
        let before = job.state.replace(Arc::new(outcome.state)).map_or(0, |state| state.len());
        after = Some(id);
        (solver, before as u64)
    };
    let (maker, _) = solve_next(2);
    for _ in 0..5 {
        let (solver, length) = solve_next(2);
        assert!(length >= LARGE as u64, "{length} bytes travel in the outline");
        assert_eq!(solver, maker);
    }
    assert_eq!(pool.stats().mesh_bytes, 0, "a state was sent to its maker");
    // Without its maker it goes to the other, once.
    drop(hands.remove(maker.as_str()));
    wait_for("the maker is gone", || pool.stats().workers == 1);
    let (other, length) = solve_next(1);
    assert_ne!(other, maker);
    assert_eq!(pool.stats().mesh_bytes, length);
    solve_next(1);
    assert_eq!(pool.stats().mesh_bytes, length);
}

#[test]
fn a_job_waits_aloud_for_a_worker_that_has_its_family() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let with = |single| {
        let family = Family { name: "echo".into(), single, double: true };
        WorkerConfig { families: Some(vec![family]), ..WorkerConfig::default() }
    };
    let _plain = HiredWorker::hire_as(&pool, "plain", Arc::new(solve), with(false));
    let mut hard = job("echo", 1, 0);
    hard.problem.settings.precision = PointPrecision::Single;
    // One that can be done shows that the worker is there, and passes the other.
    let (first, second) = (run.open(&hard), run.open(&job("echo", 2, 0)));
    wait_for("the second is done", || pool.stats().jobs.waiting == 1);
    wait_for("the first waits aloud", || pool.stats().unschedulable == 1);
    assert!(run.settled(Duration::from_millis(100)).is_none());
    let _full = HiredWorker::hire_as(&pool, "full", Arc::new(solve), with(true));
    assert_eq!(next(&run, first).worker, "full");
    assert_eq!(next(&run, second).worker, "plain");
    assert_eq!(pool.stats().unschedulable, 0);
    let shown: Vec<_> = pool.workers().into_iter().map(|w| (w.name, w.solvers)).collect();
    let solvers = |text: &str| Some(vec![text.to_owned()]);
    let due = [
        ("full".to_owned(), solvers("echo single double")),
        ("plain".to_owned(), solvers("echo double")),
    ];
    assert_eq!(shown, due);
    let about = &pool.workers()[0];
    assert!(about.cores > 0 && about.build.len() == 8 && !about.version.is_empty(), "{about:?}");
}

#[test]
fn a_run_at_its_bound_waits_and_goes_on_in_order() {
    let timing = Timing { max_open: 3, ..Timing::test() };
    let pool = Pool::start(PoolConfig { timing, ..config() }).expect("a pool on loopback");
    let (run, other) = (pool.run(Share::default()), pool.run(Share::default()));
    let jobs: Vec<_> = (0..20).map(|seed| job("echo", seed, 1)).collect();
    let ids: Vec<_> = jobs.iter().map(|job| run.open(job)).collect();
    wait_for("they are heard of", || run.stats().opened == 20);
    assert_eq!((run.stats().waiting, pool.stats().queued), (20, 17));
    // Others have room of their own.
    let another = other.open(&job("echo", 77, 0));
    let hired = HiredWorker::hire(&pool, "w", Arc::new(solve));
    verdict(next(&other, another));
    for (id, job) in ids.iter().zip(&jobs) {
        assert_eq!(verdict(next(&run, *id)), answer(job));
    }
    drop(hired);
    // What waits for room is cancelled with the rest, after the rest.
    let ids: Vec<_> = jobs.iter().map(|job| other.open(job)).collect();
    let fresh: Vec<_> = (100..110).map(|seed| other.open(&job("echo", seed, 0))).collect();
    for id in &ids {
        assert!(next(&other, *id).cached);
    }
    other.cancel();
    for id in fresh {
        assert_eq!(next(&other, id).ending, JobEnding::Cancelled);
    }
}

#[test]
fn a_run_that_wants_more_than_may_wait_is_turned_out_and_others_go_on() {
    let timing = Timing { max_open: 3, ..Timing::test() };
    let pool = Pool::start(PoolConfig { timing, held: 4, ..config() }).expect("a pool");
    let (run, other) = (pool.run(Share::default()), pool.run(Share::default()));
    let fine = other.open(&job("echo", 50, 0));
    let full: Vec<_> = (0..6).map(|seed| other.open(&job("echo", seed, 0))).collect();
    // The eighth is one too many; what comes after that is not held either.
    let ids: Vec<_> = (0..20).map(|seed| run.open(&job("echo", seed, 0))).collect();
    for id in ids {
        let JobEnding::Abandoned(text) = next(&run, id).ending else { panic!("it is not over") };
        assert!(text.contains("turned out: 4 of its jobs wait already"), "{text}");
    }
    let (now, all) = (run.stats(), other.stats());
    assert_eq!((now.waiting, all.waiting, pool.stats().jobs.waiting), (0, 7, 7));
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    for id in [fine].into_iter().chain(full) {
        verdict(next(&other, id));
    }
}

#[test]
fn a_settlement_tells_who_had_the_job_and_when() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run_as(7, Share::default());
    let id = run.open(&job("echo", 1, 300));
    std::thread::sleep(Duration::from_millis(200));
    let leaving = HiredWorker::hire(&pool, "a", Arc::new(solve));
    wait_for("it runs", || pool.stats().jobs.running == 1);
    leaving.tell();
    let _staying = HiredWorker::hire(&pool, "b", Arc::new(solve));
    let settlement = next(&run, id);
    let [first, second] = &settlement.tries[..] else { panic!("{settlement:?}") };
    assert_eq!((first.worker.as_str(), second.worker.as_str()), ("a", "b"));
    assert!(first.granted >= Duration::from_millis(200), "it waited: {first:?}");
    assert!(first.how.contains("Dropped") && second.how.is_empty(), "{settlement:?}");
    let (lost, done) = (first.ended.expect("lost"), second.ended.expect("done"));
    assert!(lost <= second.granted && done <= settlement.wall, "{settlement:?}");
    assert!(done - second.granted >= Duration::from_millis(300), "{second:?}");
}
