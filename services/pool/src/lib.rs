//! The pool of workers: a Zenoh shell around `dispatch`.
//!
//! One thread owns the state machine and everything beside it; Zenoh's callbacks, the run and the
//! clock only put inputs into its queue. Nothing waits inside a callback.

mod at_work;
mod attempts;
mod bulk;
pub mod bundle;
mod cache;
mod children;
pub mod client;
mod config;
mod control;
mod convert;
mod drained;
mod effects;
mod election;
mod error;
mod fetching;
mod inbox;
mod input;
mod ledger;
mod lives;
mod net;
mod openings;
mod quarantine;
mod questions;
mod result_file;
mod roster;
pub mod router;
mod run;
mod session_names;
mod settlement;
mod shell;
mod skill_table;
mod stats;
pub mod users;
mod waiting;

use crate::input::PoolInput;
use crate::shell::Shell;
use cullet_dispatch::{Claimant, Event, Job, Run};
use cullet_proto::service::WorkerInfo;
use cullet_proto::{JobId, WorkerId, keys};
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

pub use attempts::Attempted;
pub use bundle::{MAX_BUNDLE, check_path, mark};
pub use cache::CacheConfig;
pub use children::SpawnConfig;
pub use config::PoolConfig;
pub use cullet_dispatch::{Build, Share, Tenant, Timing};
pub use election::Conflict;
pub use error::LinkError;
pub use fetching::Fetching;
pub use result_file::ResultFile;
pub use run::RunHandle;
pub use settlement::{JobEnding, Reproduction, Settlement, Try};
pub use stats::{PoolStats, Refusals, RunStats};

/// A pool of workers. Dropping it ends its worker processes.
#[derive(Debug)]
pub struct Pool {
    endpoint: String,
    name: WorkerId,
    session: zenoh::Session,
    inputs: SyncSender<PoolInput>,
    runs: AtomicU64,
    stats: Arc<Mutex<PoolStats>>,
    pids: Arc<Mutex<Vec<u32>>>,
    workers: Arc<Mutex<Vec<WorkerInfo>>>,
    announcement: election::Announcement,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Pool {
    /// Opens the transport, looks whether another coordinator has the name, takes questions, starts
    /// the worker processes.
    ///
    /// # Errors
    /// [`LinkError::Listen`], [`LinkError::Spawn`], [`LinkError::Thread`], [`LinkError::Conflict`],
    /// or a name that is none.
    pub fn start(config: PoolConfig) -> Result<Self, LinkError> {
        let name = config.name.as_deref().unwrap_or(keys::DEFAULT_COORDINATOR);
        let coordinator = WorkerId::new(name)?;
        let (inputs, queue) = std::sync::mpsc::sync_channel(shell::QUEUE);
        let net = net::Transport::listen(&config, &coordinator, &inputs)?;
        let endpoint = net.endpoint().to_owned();
        let (session, announcement) = (net.session().clone(), net.announcement());
        let shell = Shell::new(&config, net)?;
        let (stats, pids) = (shell.stats_handle(), shell.pids_handle());
        let workers = shell.workers_handle();
        let thread = std::thread::Builder::new()
            .name("cullet-pool".into())
            .spawn(move || shell.run(&queue))
            .map_err(LinkError::Thread)?;
        let (runs, thread) = (AtomicU64::new(0), Mutex::new(Some(thread)));
        let name = coordinator;
        Ok(Self {
            endpoint,
            name,
            session,
            inputs,
            runs,
            stats,
            pids,
            workers,
            announcement,
            thread,
        })
    }

    /// Another coordinator of this name, which was there first: workers are not answered here any
    /// more, and whoever owns this pool is to leave.
    #[must_use]
    pub fn conflict(&self) -> Option<Conflict> {
        self.announcement.conflict()
    }

    /// Where workers and clients connect.
    #[must_use]
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// As [`Pool::run`], with a number for people, which log lines of the pool and of its workers
    /// carry, and which it keeps in all lives of the coordinator.
    #[must_use]
    pub fn run_as(&self, label: u64, share: Share) -> RunHandle {
        let run = Run(self.runs.fetch_add(1, Ordering::Relaxed) + 1);
        RunHandle::begin(run, label, share, self.inputs.clone())
    }

    /// Begins a run: a stream of jobs that settles in its own order, beside other runs, with this
    /// share of the workers.
    #[must_use]
    pub fn run(&self, share: Share) -> RunHandle {
        let run = Run(self.runs.fetch_add(1, Ordering::Relaxed) + 1);
        RunHandle::begin(run, run.0, share, self.inputs.clone())
    }

    /// What the pool has done and is doing.
    #[must_use]
    pub fn stats(&self) -> PoolStats {
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Process numbers of the worker processes kept here.
    #[must_use]
    pub fn pids(&self) -> Vec<u32> {
        self.pids.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The workers that are known, by name.
    #[must_use]
    pub fn workers(&self) -> Vec<WorkerInfo> {
        self.workers.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The coordinator's name.
    #[must_use]
    pub fn name(&self) -> &WorkerId {
        &self.name
    }

    /// The transport, for others who answer questions over it.
    pub fn session(&self) -> &zenoh::Session {
        &self.session
    }

    /// The workers of that name finish what they have and get no further job, in a next life of the
    /// coordinator neither: once this returns it is so. No worker: no effect.
    pub fn drain(&self, worker: WorkerId) {
        let (done, heard) = std::sync::mpsc::channel();
        let _closed = self.inputs.send(PoolInput::Drain(worker, done));
        let _closed = heard.recv();
    }

    /// Answers no worker any more: what each is at goes on for whoever has this name next.
    pub fn stop_answering(&self) {
        let _closed = self.inputs.send(PoolInput::Leave);
    }

    /// Of what was at work when the last life ended, only what these runs want goes on, by the
    /// numbers that [`Pool::run_as`] gave them then.
    pub fn retain_claimants(&self, runs: BTreeSet<u64>) {
        let _closed = self.inputs.send(PoolInput::Claimants(runs));
    }

    /// A run that was not begun in this life wants nothing of what is at work from the last one.
    pub fn release(&self, run: u64) {
        let _closed = self.inputs.send(PoolInput::Say(Event::Release(Claimant(run))));
    }

    /// A job in quarantine may be tried again.
    pub fn pardon(&self, job: JobId) {
        let _closed = self.inputs.send(PoolInput::Say(Event::Pardon(Job(job.0))));
    }

    /// Ends the worker processes and the transport; leaves nothing behind. Runs that are still held
    /// somewhere hear of no further job.
    pub fn shutdown(&self) {
        let _closed = self.inputs.send(PoolInput::Quit);
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(thread) = thread {
            let _panicked = thread.join();
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.shutdown();
    }
}
