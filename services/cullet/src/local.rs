//! Runs on this machine, with workers of their own.

use super::build::build_of;
use cullet_coordinator::run_here;
use cullet_files::claim::hold_folder;
use cullet_pool::{Build, LinkError, Pool, PoolConfig, Share, SpawnConfig};
use cullet_proto::keys::DEFAULT_COORDINATOR;
use cullet_proto::service::WorkerInfo;
use cullet_run::{News, Outcome, RunError, RunOptions};
use cullet_scene::Scene;
use cullet_worker::{WorkerConfig, WorkerError};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait for workers on threads of this process, and how often they are counted.
const STARTS: Duration = Duration::from_secs(30);
const LOOK: Duration = Duration::from_millis(2);

/// Where the fracture jobs of a local run are solved. The result is the same, bit for bit, with
/// any number of either kind.
#[derive(Clone, Debug)]
pub enum LocalWorkers {
    /// On threads of this process: nothing else has to be installed. A solver that aborts, or takes
    /// all memory, ends the process; a panic in one is a verdict.
    Threads {
        /// Jobs solved at once.
        workers: usize,
        /// Threads that each job is solved with.
        threads: usize,
    },
    /// In processes of the program `cullet`, as `cullet run` does it: a job that crashes, hangs or
    /// takes too much memory is tried again and harms nothing else.
    Processes(SpawnConfig),
}

impl LocalWorkers {
    /// Processes of the program at `cullet`: so many, each with so many threads.
    #[must_use]
    pub fn processes(cullet: impl Into<PathBuf>, workers: usize, threads: usize) -> Self {
        let mut spawn = SpawnConfig::new(cullet.into(), workers, threads);
        // Whatever the environment says: they work for the pool that started them.
        spawn.args.extend(["--coordinator".to_owned(), DEFAULT_COORDINATOR.to_owned()]);
        Self::Processes(spawn)
    }
}

impl Default for LocalWorkers {
    /// On threads of this process: a worker for every core but one, at least one.
    fn default() -> Self {
        Self::Threads { workers: spare_cores(), threads: 1 }
    }
}

/// Cores less the one that the world is stepped on, at least 1: as many workers as a local run has
/// by default.
#[must_use]
pub fn spare_cores() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (cores - 1).max(1)
}

/// Why a local run has no result.
#[derive(Debug, thiserror::Error)]
pub enum LocalRunError {
    /// The pool, or a worker process, does not start.
    #[error(transparent)]
    Pool(#[from] LinkError),
    /// A worker on a thread of this process does not start.
    #[error(transparent)]
    Worker(#[from] WorkerError),
    /// The run could not go on.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Workers on this machine that are kept for several runs. Dropping it ends them.
#[derive(Debug)]
pub struct LocalPool {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<Result<(), WorkerError>>>,
    pool: Pool,
    /// What its workers are.
    build: Build,
}

impl LocalPool {
    /// Starts workers. Those on threads are ready when it returns.
    ///
    /// # Errors
    /// [`LocalRunError::Pool`], [`LocalRunError::Worker`].
    pub fn start(workers: &LocalWorkers) -> Result<Self, LocalRunError> {
        let spawn = match workers {
            LocalWorkers::Processes(spawn) => Some(spawn.clone()),
            LocalWorkers::Threads { .. } => None,
        };
        // Before the workers are started: whoever replaces the program later changes none of them.
        let build = build_of(spawn.as_ref().map(|spawn| &*spawn.exe));
        let pool = Pool::start(PoolConfig { spawn, ..PoolConfig::default() })?;
        let mut local = Self { stop: Arc::default(), threads: Vec::new(), pool, build };
        if let LocalWorkers::Threads { workers, threads } = *workers {
            local.hire(workers.max(1), threads)?;
        }
        Ok(local)
    }

    /// Starts workers on threads of this process and waits until the pool has them.
    fn hire(&mut self, workers: usize, threads: usize) -> Result<(), LocalRunError> {
        for number in 1..=workers {
            let endpoint = self.pool.endpoint().to_owned();
            let config = WorkerConfig {
                threads,
                exit_when_wedged: false,
                stop: Arc::clone(&self.stop),
                ..WorkerConfig::new(vec![endpoint], format!("w{number}"))
            };
            let thread = std::thread::Builder::new()
                .name(format!("cullet-w{number}"))
                .spawn(move || cullet_worker::run(config))
                .map_err(LinkError::Thread)?;
            self.threads.push(thread);
        }
        let since = Instant::now();
        while self.pool.stats().workers < workers as u64 && since.elapsed() < STARTS {
            if let Some(ended) = self.threads.iter().position(JoinHandle::is_finished)
                && let Ok(ended) = self.threads.swap_remove(ended).join()
            {
                ended?;
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// The workers, by name.
    #[must_use]
    pub fn workers(&self) -> Vec<WorkerInfo> {
        self.pool.workers()
    }

    /// Jobs that wait for a worker, and jobs at workers.
    #[must_use]
    pub fn jobs(&self) -> (u64, u64) {
        let jobs = self.pool.stats().jobs;
        (jobs.waiting, jobs.running)
    }

    /// Runs a scene to its end, or until `options.stop` is set. Writes `run.mcap`, `summary.json`
    /// and a timeline into `options.out`, which is made if it is not there. `progress` is called
    /// after each step and while the run waits for jobs.
    ///
    /// # Errors
    /// The world breaks down, a job is abandoned, or a file cannot be written; the recording so far
    /// is then in `run.mcap.partial`. Another run is being written into that folder.
    pub fn run(
        &self,
        scene: &Scene,
        options: &RunOptions<'_>,
        progress: &mut dyn FnMut(&News),
    ) -> Result<Outcome, RunError> {
        let failed = |source| RunError::File { path: options.out.to_owned(), source };
        std::fs::create_dir_all(options.out).map_err(failed)?;
        let _held = hold_folder(options.out).map_err(failed)?;
        run_here(scene, &self.pool.run(Share::default()), options, self.build, progress)
    }
}

impl Drop for LocalPool {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _ended_somehow = thread.join();
        }
    }
}

/// Runs a scene on this machine, with workers that are started for it and end with it: see
/// [`LocalPool::run`]. To run several scenes, keep a [`LocalPool`].
///
/// # Example
///
/// ```
/// use cullet::{LocalWorkers, News, RunOptions, Scene, run};
/// use std::sync::atomic::AtomicBool;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// // A plaster ball falls onto granite; its fragments are sampled, which takes no time.
/// let scene = Scene::parse("ball", r#"
///     world = { duration = 0.05, impulse_threshold = 0.05 }
///     fracture = { solver = "geometric" }
///     [[body]]
///     name = "floor"
///     shape = { kind = "box", size = [4, 4, "20 cm"] }
///     position = [0, 0, "-10 cm"]
///     material = "granite"
///     fixed = true
///     [[body]]
///     name = "ball"
///     shape = { kind = "sphere", radius = "6 cm" }
///     position = [0, 0, "16 cm"]
///     velocity = [0, 0, -8]
///     material = "plaster"
/// "#, &[])?;
///
/// # let folder = tempfile::tempdir()?;
/// # let out = folder.path();
/// let stop = AtomicBool::new(false); // another thread may set it
/// let options = RunOptions::new(out, &stop);
/// let outcome = run(&scene, &LocalWorkers::default(), &options, &mut |news| match news {
///     News::At(position) => println!("{:.3} of {:.3} s", position.time, position.end),
///     News::Line(line) | News::Results(line) => println!("{line}"),
/// })?;
///
/// assert!(!outcome.interrupted);
/// assert_eq!(outcome.summary.fractures, 1);
/// assert!(outcome.summary.fragments > 10);
/// assert!(out.join("run.mcap").is_file() && out.join("summary.json").is_file());
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// The workers do not start, or as [`LocalPool::run`].
pub fn run(
    scene: &Scene,
    workers: &LocalWorkers,
    options: &RunOptions<'_>,
    progress: &mut dyn FnMut(&News),
) -> Result<Outcome, LocalRunError> {
    Ok(LocalPool::start(workers)?.run(scene, options, progress)?)
}

#[cfg(test)]
mod tests {
    use super::{LocalPool, LocalWorkers};
    use cullet_run::{News, RunOptions};
    use cullet_scene::Scene;
    use std::path::Path;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn ball() -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/corpus/ball.toml");
        let set = ["fracture.solver=geometric", "world.duration=0.04"].map(str::to_owned);
        Scene::load(path, &set).expect("a scene")
    }

    #[test]
    fn runs_share_a_pool_and_any_number_of_workers_gives_the_same_digest() {
        let folder = tempfile::tempdir().expect("a folder");
        let stop = AtomicBool::new(false);
        let mut digests = Vec::new();
        for (workers, runs) in [(1, 2), (3, 1)] {
            let pool = LocalPool::start(&LocalWorkers::Threads { workers, threads: 1 });
            let pool = pool.expect("a pool");
            for run in 0..runs {
                let out = folder.path().join(format!("{workers}/{run}"));
                let options = RunOptions::new(&out, &stop);
                let outcome = pool.run(&ball(), &options, &mut |_| {}).expect("a run");
                assert_eq!(outcome.summary.fractures, 1, "{:?}", outcome.summary);
                digests.push(outcome.summary.digest);
            }
        }
        digests.dedup();
        assert_eq!(digests.len(), 1, "{digests:?}");
    }

    #[test]
    fn a_folder_takes_one_run_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let stop = AtomicBool::new(false);
        let workers = LocalWorkers::Threads { workers: 1, threads: 1 };
        let options = RunOptions::new(folder.path(), &stop);
        let mut second = None;
        let mut meanwhile = |_: &News| {
            second.get_or_insert_with(|| super::run(&ball(), &workers, &options, &mut |_| {}));
        };
        super::run(&ball(), &workers, &options, &mut meanwhile).expect("the first");
        let refused = second.expect("some news").expect_err("while the first is written");
        assert!(refused.to_string().contains("another run is being written"), "{refused}");
        let whole = cullet_record::Recording::open(&folder.path().join("run.mcap"));
        assert!(whole.expect("a recording").holes.is_empty());
    }

    #[test]
    fn without_drawings_a_run_has_the_same_digest_and_its_pictures_and_exports() {
        let folder = tempfile::tempdir().expect("a folder");
        let stop = AtomicBool::new(false);
        let pool = LocalPool::start(&LocalWorkers::Threads { workers: 1, threads: 1 });
        let pool = pool.expect("a pool");
        let has_drawings = |path: &Path| {
            let bytes = std::fs::read(path).expect("a recording");
            bytes.windows(7).any(|part| part == b"/scene/")
        };
        let run = |drawings: bool| {
            let mut scene = ball();
            assert!(scene.recording.drawings, "unless the scene says otherwise");
            scene.recording.drawings = drawings;
            let out = folder.path().join(drawings.to_string());
            let options = RunOptions::new(&out, &stop);
            let outcome = pool.run(&scene, &options, &mut |_| {}).expect("a run");
            assert_eq!(has_drawings(&outcome.recording), drawings);
            cullet_picture::from_recording(&outcome.recording, &out).expect("pictures");
            let picture = std::fs::read(out.join("preview.png")).expect("a picture");
            (outcome.summary.digest, picture)
        };
        assert!(run(true) == run(false));
    }

    #[test]
    fn a_run_ends_early_when_stopped_from_its_progress() {
        let folder = tempfile::tempdir().expect("a folder");
        let stop = AtomicBool::new(false);
        let options = RunOptions::new(folder.path(), &stop);
        let workers = LocalWorkers::Threads { workers: 1, threads: 1 };
        let mut halfway = |news: &News| {
            if let News::At(position) = news {
                stop.fetch_or(position.time > 0.5 * position.end, Ordering::Relaxed);
            }
        };
        let outcome = super::run(&ball(), &workers, &options, &mut halfway).expect("a run");
        assert!(outcome.interrupted);
        let time = outcome.summary.sim_seconds;
        assert!((0.02..0.04).contains(&time), "stopped after {time} s");
        assert!(folder.path().join("run.mcap").is_file(), "the recording is finished");
    }
}
