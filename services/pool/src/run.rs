//! One run's end of the pool.

use super::Settlement;
use super::shell::{Input, Listener};
use super::skill_table::{self, Skill};
use cullet_dispatch::{Counts, Event, Run, Share};
use cullet_proto::outline::Parted;
use cullet_proto::specimen::SpecimenJob;
use cullet_proto::{FractureJob, JobId, WireError};
use std::collections::{BTreeSet, VecDeque};
use std::sync::mpsc::{Receiver, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What the pool has done and is doing for one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunStats {
    /// Jobs opened.
    pub opened: u64,
    /// Jobs settled.
    pub settled: u64,
    /// Of these, refused by the solvers.
    pub refused: u64,
    /// Of these, failed in the solver.
    pub failed: u64,
    /// Of these, abandoned.
    pub abandoned: u64,
    /// Attempts beyond a job's first.
    pub resent: u64,
    /// Jobs waiting for a worker now.
    pub waiting: u64,
    /// Jobs at workers now.
    pub running: u64,
    /// How far those are, summed \[1/1000\].
    pub permille: u64,
    /// Workers whose link is up.
    pub workers: u64,
    /// Of these, those that take jobs: they were not drained.
    pub ready: u64,
    /// Whether jobs of it wait that none of these can solve.
    pub unable: bool,
}

impl RunStats {
    pub(super) fn of(counts: &Counts, held: u64, permille: i64) -> Self {
        Self {
            opened: counts.opened + held,
            settled: counts.settled,
            refused: counts.refused,
            failed: counts.failed,
            abandoned: counts.abandoned,
            resent: counts.resent,
            waiting: counts.waiting + held,
            running: counts.running,
            permille: permille.max(0) as u64,
            ..Self::default()
        }
    }
}

/// News of attempts that are kept until somebody asks; what is beyond it is told as a job settles.
const MAX_NEWS: usize = 4_096;

/// News of an attempt at a job that has not settled.
#[derive(Clone, Debug)]
pub struct Attempted {
    /// Which job.
    pub job: JobId,
    /// By which grant.
    pub grant: u64,
    /// Whose attempt.
    pub worker: String,
    /// When.
    pub at: Instant,
    /// How the attempt was lost; `None`: the worker was given the job.
    pub lost: Option<String>,
}

/// Where such news is put and found.
#[derive(Clone, Debug, Default)]
pub(super) struct AttemptNews(Arc<Mutex<Vec<Attempted>>>);

impl AttemptNews {
    pub(super) fn put(&self, news: impl IntoIterator<Item = Attempted>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let room = MAX_NEWS - all.len();
        all.extend(news.into_iter().take(room));
    }

    fn take(&self) -> Vec<Attempted> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// A run in the pool: opens jobs and hears of their ends, in opening order. Dropping it cancels
/// what is open.
#[derive(Debug)]
pub struct RunHandle {
    run: Run,
    inputs: SyncSender<Input>,
    settlements: Mutex<Receiver<(JobId, Settlement)>>,
    stats: Arc<Mutex<RunStats>>,
    attempts: AttemptNews,
}

impl RunHandle {
    pub(super) fn begin(run: Run, label: u64, share: Share, inputs: SyncSender<Input>) -> Self {
        let (settle, settlements) = std::sync::mpsc::channel();
        let stats = Arc::<Mutex<RunStats>>::default();
        let attempts = AttemptNews::default();
        let listener = Listener {
            settle,
            stats: Arc::clone(&stats),
            attempts: attempts.clone(),
            over: false,
            label,
            held: VecDeque::new(),
            out: None,
            permille: 0,
            needs: BTreeSet::new(),
        };
        let _closed = inputs.send(Input::Begin(run, share, listener));
        Self { run, inputs, settlements: Mutex::new(settlements), stats, attempts }
    }

    /// The run's number in the pool.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.run.0
    }

    /// Wants a job done; it settles through [`RunHandle::settled`]. A job over a limit of the wire
    /// settles as abandoned.
    pub fn open(&self, job: &FractureJob) -> JobId {
        self.want(Parted::of(job), skill_table::asks(job), job)
    }

    /// As [`RunHandle::open`], for a specimen.
    pub fn open_specimen(&self, job: &SpecimenJob) -> JobId {
        self.want(Parted::of_specimen(job), Vec::new(), job)
    }

    fn want(
        &self,
        parted: Result<Parted, WireError>,
        asks: Vec<Skill>,
        job: &impl std::fmt::Debug,
    ) -> JobId {
        let (id, opening) = match parted {
            Ok(parted) => (parted.id, Ok((parted, asks))),
            Err(error) => {
                // It has no encoding to be named by; its debug text is as good.
                (JobId::of(format!("{job:?}").as_bytes()), Err(error.to_string()))
            }
        };
        let _closed = self.inputs.send(Input::Open(self.run, id, opening));
        id
    }

    /// The next job to settle, in opening order; `None` if none does within `timeout`.
    #[must_use]
    pub fn settled(&self, timeout: Duration) -> Option<(JobId, Settlement)> {
        let settlements = self.settlements.lock().unwrap_or_else(PoisonError::into_inner);
        settlements.recv_timeout(timeout).ok()
    }

    /// Who was given which job since this was asked last, and which attempts were lost.
    #[must_use]
    pub fn attempts(&self) -> Vec<Attempted> {
        self.attempts.take()
    }

    /// What the pool has done and is doing for this run.
    #[must_use]
    pub fn stats(&self) -> RunStats {
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wants nothing any more: every job that is not over settles as cancelled.
    pub fn cancel(&self) {
        self.say(Event::Cancel(self.run));
    }

    /// No further job of this run goes to a worker until it is resumed; those at work go on.
    pub fn pause(&self) {
        self.say(Event::Pause(self.run));
    }

    /// The run goes on.
    pub fn resume(&self) {
        self.say(Event::Resume(self.run));
    }

    /// Changes the run's share of the workers.
    pub fn share(&self, share: Share) {
        self.say(Event::Begin { run: self.run, share });
    }

    fn say(&self, event: Event) {
        let _closed = self.inputs.send(Input::Say(event));
    }
}

impl Drop for RunHandle {
    fn drop(&mut self) {
        self.say(Event::End(self.run));
    }
}
