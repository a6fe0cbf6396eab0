//! The worker: asks for jobs, hosts a solver in slices, hands results back.
//!
//! Two halves. The *supervisor* ([`run`]) talks: it polls, fetches, renews and hands in, as its
//! state machine says (`services/dispatch/src/worker_machine.rs`). The *job* runs in a process of
//! its own ([`serve_jobs`]), which may crash, hang or take too much memory: the supervisor ends it,
//! gives the job back and goes on. A panic in a solver is a verdict.
//!
//! Absent on purpose: rigid bodies, scenes, recordings, decisions about who does what.

mod config;
mod error;
pub mod families;
mod job;
mod link;
pub mod memory;
mod meshes;
pub mod solve;
pub mod specimen;
mod supervisor;
mod talk;
mod threads;
mod window;

use cullet_proto::{JobId, Verdict};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

pub use config::WorkerConfig;
pub use error::{EXIT_WEDGED, WorkerError};
pub use families::solvers;
pub use job::{JobCommand, serve_jobs};
pub use solve::{JobControl, SolveFn};

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

/// Solves the job in a file, as the job process would: `job.bin` of one that was given up.
/// The verdict's digest and the verdict.
///
/// # Errors
/// The file cannot be read, is no job, or its verdict cannot be sent.
pub fn replay(path: &Path, threads: usize) -> std::io::Result<(JobId, Verdict)> {
    let pool = threads::start_threads(threads).map_err(std::io::Error::other)?;
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
