//! What the tests share.

use cullet_model::{Fragment, Fragmentation, Report};
use cullet_pool::{JobEnding, Pool, PoolConfig, RunHandle, Settlement, SpawnConfig, Timing};
use cullet_proto::transport::Patience;
use cullet_proto::{FractureJob, JobId, Verdict};
use cullet_worker::{JobControl, SolveFn, WorkerConfig, run_with};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cullet_geometry::{Sheet, Vec3};

/// Longest a test waits for anything.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

pub(crate) fn config() -> PoolConfig {
    let (timing, patience) = (Timing::test(), Patience::test());
    PoolConfig { timing, patience, ..PoolConfig::default() }
}

/// The example `stub`, which `cargo test` builds too unless it is told which targets to test.
pub(crate) fn stub() -> PathBuf {
    let exe = std::env::current_exe().expect("this test has a path");
    let folder = exe.parent().and_then(|deps| deps.parent()).expect("a target folder");
    let stub = folder.join("examples/stub");
    assert!(stub.exists(), "first: cargo build --release --workspace --examples");
    stub
}

/// A pool that keeps worker processes of the example `stub`.
pub(crate) fn with_processes(workers: usize) -> Pool {
    with_processes_of(workers, Timing::test())
}

/// The same, as patient as that.
pub(crate) fn with_processes_of(workers: usize, timing: Timing) -> Pool {
    let spawn = Some(SpawnConfig::new(stub(), workers, 1));
    Pool::start(PoolConfig { spawn, timing, ..config() }).expect("a pool on loopback")
}

/// A job that takes so long \[ms\] and tells itself from others by its seed.
pub(crate) fn job(solver: &str, seed: u64, millis: u32) -> FractureJob {
    let mut job = FractureJob::smallest(solver, seed);
    job.problem.settings.max_steps = millis;
    job
}

/// What [`solve`] makes of a job: a pure function of it.
pub(crate) fn answer(job: &FractureJob) -> Verdict {
    let solid = job.problem.body.solid().expect("a solid");
    let fragment = |k: u64| Fragment {
        hulls: vec![solid.mesh.vertices.clone()],
        solid: (**solid).clone(),
        velocity: Vec3::repeat(k as f64),
        spin: Vec3::zeros(),
        sheet: Sheet::default(),
    };
    let fragments = (0..job.problem.seed % 5).map(fragment).collect();
    let report =
        Report { solver: job.solver.clone(), steps: job.problem.seed, ..Report::default() };
    Fragmentation { fragments, report, ..Fragmentation::default() }.into()
}

pub(crate) fn solve(job: &FractureJob, watch: &JobControl) -> Option<Verdict> {
    let until = Instant::now() + Duration::from_millis(u64::from(job.problem.settings.max_steps));
    while Instant::now() < until {
        if watch.cancelled() {
            return None;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Some(answer(job))
}

/// A worker on a thread of this process.
pub(crate) struct HiredWorker {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl HiredWorker {
    pub(crate) fn hire(pool: &Pool, name: &str, solve: SolveFn) -> Self {
        Self::hire_as(pool, name, solve, WorkerConfig::default())
    }

    /// The same, with more of its own.
    pub(crate) fn hire_as(pool: &Pool, name: &str, solve: SolveFn, own: WorkerConfig) -> Self {
        let stop = Arc::<AtomicBool>::default();
        let config = WorkerConfig {
            connect: vec![pool.endpoint().to_owned()],
            name: name.into(),
            patience: Patience::test(),
            exit_when_wedged: false,
            stop: Arc::clone(&stop),
            ..own
        };
        let thread = std::thread::spawn(move || run_with(config, solve).expect("a worker"));
        Self { stop, thread: Some(thread) }
    }

    /// Whether it has left, by itself or because it was told to.
    pub(crate) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Tells it to stop; dropping waits until it has.
    pub(crate) fn tell(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for HiredWorker {
    fn drop(&mut self) {
        self.tell();
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

/// The next settlement, which must be of this job.
pub(crate) fn next(run: &RunHandle, id: JobId) -> Settlement {
    let (settled, settlement) = run.settled(PATIENCE).expect("a settlement in time");
    assert_eq!(settled, id, "settled out of order");
    settlement
}

/// The verdict of a settlement that must have one.
/// The parts that a settlement brings.
pub(crate) fn parts(settlement: Settlement) -> Fragmentation {
    let Verdict::Solved(outcome) = verdict(settlement) else { panic!("another verdict") };
    outcome.fracture().expect("parts")
}

pub(crate) fn verdict(settlement: Settlement) -> Verdict {
    match settlement.ending {
        JobEnding::Verdict(verdict) => verdict,
        other => panic!("no verdict: {other:?}"),
    }
}

/// Waits until something holds.
pub(crate) fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < PATIENCE, "still waiting: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
