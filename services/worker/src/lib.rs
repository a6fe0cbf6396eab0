//! The worker: asks for jobs, hosts a solver in slices, hands results back.
//!
//! Two halves. The *supervisor* ([`run`]) talks: it polls, fetches, renews and hands in, as its
//! state machine says (`services/dispatch/src/worker_machine.rs`). The *job* runs in a process of
//! its own ([`serve_jobs`]), which may crash, hang or take too much memory: the supervisor ends it,
//! gives the job back and goes on. A panic in a solver is a verdict.
//!
//! Absent on purpose: rigid bodies, scenes, recordings, decisions about who does what.

pub mod families;
mod job;
mod link;
pub mod memory;
mod meshes;
pub mod solve;
pub mod specimen;
mod supervisor;
mod talk;
mod window;

use cullet_proto::pool::Family;
use cullet_proto::security::Rules;
use cullet_proto::transport::Patience;
use cullet_proto::{JobId, Verdict, WireError, keys};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

pub use families::solvers;
pub use job::{JobCommand, serve_jobs};
pub use solve::{JobControl, SolveFn};

/// Exit code of a worker whose solver hung past the hard limit.
pub const EXIT_WEDGED: i32 = 71;

/// What went wrong with a worker as a whole.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The transport does not open.
    #[error("cannot open the link to {endpoints}: {text}")]
    Connect {
        /// The addresses of the links.
        endpoints: String,
        /// The reason, in words.
        text: String,
    },
    /// No endpoint was given.
    #[error("no coordinator to connect to was given")]
    NoEndpoint,
    /// Threads do not start.
    #[error("cannot start {threads} threads: {text}")]
    Threads {
        /// How many threads.
        threads: usize,
        /// The reason, in words.
        text: String,
    },
    /// A name that is none.
    #[error(transparent)]
    Wire(#[from] WireError),
}

/// How a worker is set up.
#[derive(Clone, Debug)]
pub struct WorkerConfig {
    /// Endpoints of the coordinator, as `tcp/127.0.0.1:7447`.
    pub connect: Vec<String>,
    /// The worker's name: 1 to 40 of `a-z`, `0-9`, `-`.
    pub name: String,
    /// The coordinator's name.
    pub coordinator: String,
    /// Threads that a job gets.
    pub threads: usize,
    /// End the process when its standard input ends: the parent is gone, however it ended.
    pub parent_watch: bool,
    /// End this process with [`EXIT_WEDGED`] when a solver on a thread of it hangs past the hard
    /// limit. Only that ends such a thread; without this it is left behind.
    pub exit_when_wedged: bool,
    /// The process in which jobs run; `None`: a thread of this one, for tests.
    pub job: Option<JobCommand>,
    /// Families of solvers that it has, as it tells the coordinator; `None`: whatever it is asked.
    pub families: Option<Vec<Family>>,
    /// The digest of the program that solves; `None`: found by reading it.
    pub build: Option<[u8; 32]>,
    /// Most bytes of meshes kept for the next job.
    pub meshes: u64,
    /// How patient the transport is.
    pub patience: Patience,
    /// Further settings of the transport: its identity.
    pub rules: Rules,
    /// The name in the certificate that it shows.
    pub certificate: Option<String>,
    /// Return from [`run`] after this long without a job, also where no coordinator answers;
    /// `None`: stay.
    pub idle_limit: Option<Duration>,
    /// Set to make [`run`] return: the job at hand is given back.
    pub stop: Arc<AtomicBool>,
}

impl Default for WorkerConfig {
    fn default() -> Self {
        Self {
            connect: Vec::new(),
            name: format!("w-{}", std::process::id()),
            coordinator: keys::DEFAULT_COORDINATOR.into(),
            threads: 1,
            parent_watch: false,
            exit_when_wedged: true,
            job: None,
            families: None,
            build: None,
            meshes: 256 << 20,
            patience: Patience::production(),
            rules: Rules::new(),
            certificate: None,
            idle_limit: None,
            stop: Arc::default(),
        }
    }
}

impl WorkerConfig {
    /// A worker of that name for the coordinator at these endpoints, the rest by default.
    #[must_use]
    pub fn new(connect: Vec<String>, name: String) -> Self {
        Self { connect, name, ..Self::default() }
    }
}

/// Works for a coordinator with the families of `cullet-fracture` until asked to stop, drained, or
/// idle for as long as it may be. A coordinator that is not there yet, or is gone for a while, is
/// waited for.
///
/// # Errors
/// What keeps it from starting. Nothing that happens later ends it.
pub fn run(mut config: WorkerConfig) -> Result<(), WorkerError> {
    config.families.get_or_insert_with(solve::families);
    run_with(config, Arc::new(solve::by_table))
}

/// As [`run`], with another way to solve.
///
/// # Errors
/// As [`run`].
pub fn run_with(config: WorkerConfig, solve: SolveFn) -> Result<(), WorkerError> {
    let orphaned = Arc::<AtomicBool>::default();
    if config.parent_watch {
        watch_parent(Arc::clone(&config.stop), Arc::clone(&orphaned));
    }
    if let Some(supervisor) = supervisor::Supervisor::open(config, solve, orphaned)? {
        supervisor.work();
    }
    Ok(())
}

/// Stack of a solver's thread \[bytes\]: recursion over meshes is deeper than the default bears.
const STACK: usize = 16 << 20;

fn start_threads(threads: usize) -> Result<ThreadPool, WorkerError> {
    ThreadPoolBuilder::new()
        .num_threads(threads.max(1))
        .stack_size(STACK)
        .thread_name(|index| format!("cullet-solve-{index}"))
        .build()
        .map_err(|error| WorkerError::Threads { threads, text: error.to_string() })
}

/// Solves the job in a file, as the job process would: `job.bin` of one that was given up.
/// The verdict's digest and the verdict.
///
/// # Errors
/// The file cannot be read, is no job, or its verdict cannot be sent.
pub fn replay(path: &Path, threads: usize) -> std::io::Result<(JobId, Verdict)> {
    let pool = start_threads(threads).map_err(std::io::Error::other)?;
    let bytes = std::fs::read(path)?;
    let solve: SolveFn = Arc::new(solve::by_table);
    match pool.install(|| job::attempt(&bytes, &solve, &JobControl::default())) {
        job::AttemptResult::Solved(blob) => {
            let verdict = Verdict::decode(&blob).map_err(std::io::Error::other)?;
            Ok((JobId::of(&blob), verdict))
        }
        other => Err(std::io::Error::other(format!("{other:?}"))),
    }
}

/// How long a worker whose parent is gone may take to end its job process.
const ORPHANED: Duration = Duration::from_secs(1);

/// The parent holds the other end of our standard input and never writes: reading ends when the
/// parent does, or lets us go. Nothing is given back then, for nobody is there to take it.
fn watch_parent(stop: Arc<AtomicBool>, orphaned: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        let mut sink = [0; 64];
        let mut input = std::io::stdin().lock();
        while input.read(&mut sink).is_ok_and(|count| count > 0) {}
        orphaned.store(true, Ordering::Relaxed);
        stop.store(true, Ordering::Relaxed);
        std::thread::sleep(ORPHANED);
        std::process::exit(0);
    });
}
