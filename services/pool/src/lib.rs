//! The pool of workers: a Zenoh shell around `dispatch`.
//!
//! One thread owns the state machine and everything beside it; Zenoh's callbacks, the run and the
//! clock only put inputs into its queue. Nothing waits inside a callback.

mod at_work;
mod bulk;
pub mod bundle;
mod cache;
mod children;
pub mod client;
mod control;
mod drained;
mod effects;
mod election;
mod fetching;
mod inbox;
mod ledger;
mod lives;
mod net;
mod openings;
mod quarantine;
mod questions;
mod roster;
pub mod router;
mod run;
mod shell;
mod skill_table;
pub mod users;

use crate::shell::{Input, Shell};
use cullet_dispatch::{Event, Heir, Job, Run};
use cullet_proto::pool::Refusal;
use cullet_proto::security::Rules;
use cullet_proto::service::WorkerInfo;
use cullet_proto::transport::Patience;
use cullet_proto::{JobId, Verdict, WireError, WorkerId, keys};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

pub use bundle::{MAX_BUNDLE, check_path, mark};
pub use cache::CacheConfig;
pub use children::SpawnConfig;
pub use cullet_dispatch::Timing;
pub use cullet_dispatch::{Share, Tenant};
pub use election::Conflict;
pub use fetching::Fetching;
pub use run::{Attempted, RunHandle, RunStats};

/// What went wrong with the link.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The transport does not open.
    #[error("cannot listen on {endpoint}: {text}")]
    Listen {
        /// Where.
        endpoint: String,
        /// Why.
        text: String,
    },
    /// The transport does not connect.
    #[error("cannot connect to {endpoint}: tried for {seconds} s; {text}")]
    Connect {
        /// Where.
        endpoint: String,
        /// For how long \[s\].
        seconds: f64,
        /// Why.
        text: String,
    },
    /// A worker process does not start.
    #[error("cannot start the worker {exe}: {source}")]
    Spawn {
        /// Which program.
        exe: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A thread does not start.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
    /// Bytes of one's own that break the wire's rules.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// The coordinator does not answer.
    #[error("the coordinator at {endpoint} has not answered {what} for {seconds} s")]
    Silent {
        /// Where.
        endpoint: String,
        /// What was asked.
        what: &'static str,
        /// For how long \[s\].
        seconds: f64,
    },
    /// The coordinator does not know what was named.
    #[error("the coordinator says: {0}")]
    Unknown(String),
    /// The coordinator is about to end.
    #[error("the coordinator at {endpoint} leaves; run {run} goes on when it is back")]
    Left {
        /// Where.
        endpoint: String,
        /// Which run was followed.
        run: u64,
    },
    /// As many runs wait as may.
    #[error(
        "the queue of the coordinator at {endpoint} is full, and was for {seconds} s: it takes \
         another run when one of those that wait begins"
    )]
    Busy {
        /// Where.
        endpoint: String,
        /// For how long \[s\].
        seconds: f64,
    },
    /// The coordinator refuses.
    #[error("the coordinator refuses: {0}")]
    Refused(String),
    /// The coordinator refuses for as long as something is so.
    #[error("the coordinator cannot take it now: {0}")]
    Later(String),
    /// What the coordinator sends cannot be read, or is not what it says that it is.
    #[error("what the coordinator sends is not sound: {0}")]
    Garbled(String),
    /// Another coordinator has the name.
    #[error(transparent)]
    Conflict(#[from] Conflict),
    /// A path that must not be in a bundle.
    #[error("{path:?} may not be in a bundle: {reason}")]
    Path {
        /// Which.
        path: String,
        /// Why.
        reason: &'static str,
    },
    /// A folder that another fetch has.
    #[error("{folder}: {why}; name another folder")]
    Occupied {
        /// Which.
        folder: PathBuf,
        /// By whom.
        why: &'static str,
    },
    /// The disk does not give or take a file.
    #[error("{path}: {}", cullet_files::regular::words(source))]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// How a pool is set up.
#[derive(Clone, Debug)]
pub struct PoolConfig {
    /// Where to listen; `None` is loopback. Port 0 means a free one.
    pub listen: Option<String>,
    /// The router to connect to instead of listening.
    pub router: Option<String>,
    /// The coordinator's name; `None` is [`keys::DEFAULT_COORDINATOR`].
    pub name: Option<String>,
    /// Worker processes to keep; `None`: they come by themselves.
    pub spawn: Option<SpawnConfig>,
    /// How patient the pool is.
    pub timing: Timing,
    /// How patient its transport is.
    pub patience: Patience,
    /// Further settings of the transport: identity and roles.
    pub rules: Rules,
    /// Which life of the coordinator this is: more than any before, and on disk before the start.
    /// Grants carry it, so that none of an earlier life is taken for one of this. `None`: drawn by
    /// chance, for a coordinator without a journal.
    pub incarnation: Option<u32>,
    /// What is kept of finished jobs, to answer repeats.
    pub cache: CacheConfig,
    /// Folder for what reproduces jobs that killed their workers; `None`: it is not kept.
    pub quarantine: Option<PathBuf>,
    /// File for the workers that were drained, who get nothing in a next life either; `None`: they
    /// would.
    pub drained: Option<PathBuf>,
    /// File for the jobs at work and the runs that want them, which a next life lets go on; `None`:
    /// it begins them anew.
    pub at_work: Option<PathBuf>,
    /// Openings of a run that may wait for room. A run that wants more is turned out: all that it
    /// has open ends, aloud.
    pub held: usize,
}

impl Default for PoolConfig {
    fn default() -> Self {
        Self {
            listen: None,
            router: None,
            name: None,
            spawn: None,
            timing: Timing::production(),
            patience: Patience::production(),
            rules: Rules::new(),
            incarnation: None,
            cache: CacheConfig::default(),
            quarantine: None,
            drained: None,
            at_work: None,
            held: openings::MAX_HELD,
        }
    }
}

/// How a job ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// With a verdict, which is final.
    Verdict(Verdict),
    /// With no attempt left, and why. Never physics: the run has to stop aloud.
    Abandoned(String),
    /// The run did not want it any more.
    Cancelled,
}

/// The end of one opening of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Settlement {
    /// How it ended.
    pub ending: Ending,
    /// Attempts made.
    pub attempts: u32,
    /// Name of the worker whose result counts; empty without one.
    pub worker: String,
    /// Whether its result was known before.
    pub cached: bool,
    /// Wall time since the opening.
    pub wall: Duration,
    /// Attempts, the first ones, in the order in which they were granted.
    pub tries: Vec<Try>,
    /// What reproduces a job whose attempts are used up.
    pub reproduction: Option<Reproduction>,
}

/// What reproduces a job that was given up.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reproduction {
    /// Its encoding.
    pub job: Vec<u8>,
    /// Who died how, a line an attempt.
    pub attempts: String,
}

/// An attempt at a job; times are wall times since the opening.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Try {
    /// Whose.
    pub worker: String,
    /// When the worker was given the job.
    pub granted: Duration,
    /// When its result was there, or the attempt was lost; `None`: another's result came first.
    pub ended: Option<Duration>,
    /// How it was lost; empty: it was not.
    pub how: String,
}

/// What a pool has done and is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoolStats {
    /// Of all runs.
    pub jobs: RunStats,
    /// Workers whose link is up now.
    pub workers: u64,
    /// Worker processes started again after they ended.
    pub respawned: u64,
    /// Results of a pure job that contradicted an earlier one: must be zero.
    pub alarms: u64,
    /// Late results of another build than the one that has the job, which do not count.
    pub fenced: u64,
    /// Jobs that wait though workers are here, none of which can do them.
    pub stranded: u64,
    /// Openings that had to wait for room.
    pub queued: u64,
    /// Jobs in quarantine.
    pub quarantined: u64,
    /// Second attempts at jobs that took long.
    pub hedged: u64,
    /// Attempts of an earlier life of the coordinator that went on in this one.
    pub adopted: u64,
    /// Openings answered from the cache.
    pub cached: u64,
    /// Chunks that came damaged and were sent again.
    pub damaged: u64,
    /// Signs of life of workers that went: a worker left, or its link did.
    pub lost: u64,
    /// Signs of life that came back: a link flapped.
    pub back: u64,
    /// Workers that are there under a name that another has too.
    pub twins: u64,
    /// Messages refused at the door.
    pub refusals: Refusals,
    /// Bytes of meshes sent to workers.
    pub mesh_bytes: u64,
    /// Worker processes kept here now; their numbers are [`Pool::pids`].
    pub children: u64,
}

/// Messages refused at the door, by why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refusals {
    /// Of another generation of the wire.
    pub unsupported: u64,
    /// Larger than a message may be.
    pub too_large: u64,
    /// Not what a message is, or not to any question that there is.
    pub malformed: u64,
    /// Of a worker that has not said who it is.
    pub stranger: u64,
}

impl Refusals {
    fn count(&mut self, refusal: &Refusal) {
        *match refusal {
            Refusal::Unsupported { .. } => &mut self.unsupported,
            Refusal::TooLarge { .. } => &mut self.too_large,
            Refusal::Malformed(_) => &mut self.malformed,
            Refusal::Stranger => &mut self.stranger,
        } += 1;
    }

    /// Each with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, u64); 4] {
        let Self { unsupported, too_large, malformed, stranger } = *self;
        [
            ("unsupported", unsupported),
            ("too_large", too_large),
            ("malformed", malformed),
            ("stranger", stranger),
        ]
    }
}

/// A pool of workers. Dropping it ends its worker processes.
#[derive(Debug)]
pub struct Pool {
    endpoint: String,
    name: WorkerId,
    session: zenoh::Session,
    inputs: SyncSender<Input>,
    runs: AtomicU64,
    stats: Arc<Mutex<PoolStats>>,
    pids: Arc<Mutex<Vec<u32>>>,
    workers: Arc<Mutex<Vec<WorkerInfo>>>,
    herald: election::Announcement,
    thread: Option<JoinHandle<()>>,
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
        let net = net::Net::listen(&config, &coordinator, &inputs)?;
        let endpoint = net.endpoint().to_owned();
        let (session, herald) = (net.session().clone(), net.herald());
        let shell = Shell::new(&config, net)?;
        let (stats, pids) = (shell.stats_handle(), shell.pids_handle());
        let workers = shell.roster.handle();
        let thread = std::thread::Builder::new()
            .name("cullet-pool".into())
            .spawn(move || shell.run(&queue))
            .map_err(LinkError::Thread)?;
        let (runs, thread) = (AtomicU64::new(0), Some(thread));
        let name = coordinator;
        Ok(Self { endpoint, name, session, inputs, runs, stats, pids, workers, herald, thread })
    }

    /// Another coordinator of this name, which was there first: workers are not answered here any
    /// more, and whoever owns this pool is to leave.
    #[must_use]
    pub fn rival(&self) -> Option<Conflict> {
        self.herald.rival()
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
        let _closed = self.inputs.send(Input::Drain(worker, done));
        let _closed = heard.recv();
    }

    /// Answers no worker any more: what each is at goes on for whoever has this name next.
    pub fn hush(&self) {
        let _closed = self.inputs.send(Input::Leave);
    }

    /// Of what was at work when the last life ended, only what these runs want goes on, by the
    /// numbers that [`Pool::run_as`] gave them then.
    pub fn heirs(&self, runs: BTreeSet<u64>) {
        let _closed = self.inputs.send(Input::Heirs(runs));
    }

    /// A run that was not begun in this life wants nothing of what is at work from the last one.
    pub fn renounce(&self, run: u64) {
        let _closed = self.inputs.send(Input::Say(Event::Renounce(Heir(run))));
    }

    /// A job in quarantine may be tried again.
    pub fn pardon(&self, job: JobId) {
        let _closed = self.inputs.send(Input::Say(Event::Pardon(Job(job.0))));
    }

    /// Ends the worker processes and the transport; leaves nothing behind.
    pub fn shutdown(mut self) {
        self.close();
    }

    fn close(&mut self) {
        let _closed = self.inputs.send(Input::Quit);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.close();
    }
}
