//! Where a run has its fracture jobs done, and how much there is to do.

use cullet_pool::{RunHandle, RunStats, Settlement};
use cullet_proto::{FractureJob, JobId, WindowJob, WireError};
use std::time::Duration;

/// A job that a run wants done.
#[derive(Clone, Copy, Debug)]
pub enum WantedJob<'a> {
    /// A body to be broken.
    Fracture(&'a FractureJob),
    /// A window of a body that moves as it deforms.
    Window {
        /// The window.
        job: &'a WindowJob,
        /// The window whose outcome is the state that it begins with.
        after: Option<JobId>,
    },
}

impl WantedJob<'_> {
    /// Its canonical bytes.
    ///
    /// # Errors
    /// The limit of the wire that it breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        match self {
            Self::Fracture(job) => job.encode(),
            Self::Window { job, .. } => job.encode(),
        }
    }
}

/// A pool that does the jobs of a run.
pub trait JobPool {
    /// Wants a job done.
    fn open(&self, job: WantedJob<'_>) -> JobId;
    /// The next job to settle, in opening order; `None` if none does within `timeout`.
    fn settled(&self, timeout: Duration) -> Option<(JobId, Settlement)>;
    /// What is wanted, and how far it is.
    fn load(&self) -> PoolLoad;
    /// Nothing is wanted any more.
    fn cancel(&self);
}

/// How much a pool has to do for a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoolLoad {
    /// Jobs that are wanted, at workers or not yet.
    pub jobs: u64,
    /// How far those at workers are, in the mean \[1/1000\].
    pub permille: u16,
    /// Why none of them can be at work, if so.
    pub idle: Option<Idle>,
}

/// Why no job of a run can be at work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Idle {
    /// There is no worker.
    NoWorker,
    /// There are so many, and all of them were drained.
    Drained(u64),
    /// There are so many, and none can solve what is wanted.
    Unable(u64),
}

impl JobPool for RunHandle {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        match job {
            WantedJob::Fracture(job) => RunHandle::open(self, job),
            WantedJob::Window { job, after } => self.open_window(job, after),
        }
    }

    fn settled(&self, timeout: Duration) -> Option<(JobId, Settlement)> {
        RunHandle::settled(self, timeout)
    }

    fn load(&self) -> PoolLoad {
        let stats = self.stats();
        let permille = stats.permille.checked_div(stats.running).unwrap_or(0).min(1000) as u16;
        let idle = match stats {
            RunStats { workers: 0, .. } => Some(Idle::NoWorker),
            RunStats { workers, ready: 0, .. } => Some(Idle::Drained(workers)),
            RunStats { ready, unable: true, .. } => Some(Idle::Unable(ready)),
            _ => None,
        };
        PoolLoad { jobs: stats.waiting + stats.running, permille, idle }
    }

    fn cancel(&self) {
        RunHandle::cancel(self);
    }
}
