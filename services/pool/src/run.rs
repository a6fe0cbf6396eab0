//! One run's end of the pool.

use super::attempts::{AttemptNews, Attempted};
use super::input::{Listener, Opening, PoolInput};
use super::settlement::Settlement;
use super::skill_table::{self, Skill};
use super::stats::RunStats;
use cullet_dispatch::{Event, Run, Share};
use cullet_proto::outline::Parted;
use cullet_proto::specimen::SpecimenJob;
use cullet_proto::{FractureJob, JobId, WindowJob, WireError};
use std::collections::{BTreeSet, VecDeque};
use std::sync::mpsc::{Receiver, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A run in the pool: opens jobs and hears of their ends, in opening order. Dropping it cancels
/// what is open.
#[derive(Debug)]
pub struct RunHandle {
    run: Run,
    inputs: SyncSender<PoolInput>,
    settlements: Mutex<Receiver<(JobId, Settlement)>>,
    stats: Arc<Mutex<RunStats>>,
    attempts: AttemptNews,
}

impl RunHandle {
    pub(super) fn begin(run: Run, label: u64, share: Share, inputs: SyncSender<PoolInput>) -> Self {
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
        let _closed = inputs.send(PoolInput::Begin(run, share, listener));
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
        self.want(Parted::of(job), skill_table::asks(job), None, job)
    }

    /// As [`RunHandle::open`], for a specimen.
    pub fn open_specimen(&self, job: &SpecimenJob) -> JobId {
        self.want(Parted::of_specimen(job), Vec::new(), None, job)
    }

    /// As [`RunHandle::open`], for a window of a body that moves as it deforms. `after` is the
    /// window whose outcome is the state that it begins with: the worker that solved that one has
    /// the state already, and is preferred if it is free.
    pub fn open_window(&self, job: &WindowJob, after: Option<JobId>) -> JobId {
        self.want(Parted::of_window(job), skill_table::asks_window(job), after, job)
    }

    fn want(
        &self,
        parted: Result<Parted, WireError>,
        asks: Vec<Skill>,
        after: Option<JobId>,
        job: &impl std::fmt::Debug,
    ) -> JobId {
        let (id, content) = match parted {
            Ok(parted) => (parted.id, Ok((parted, asks))),
            Err(error) => {
                // It has no encoding to be named by; its debug text is as good.
                (JobId::of(format!("{job:?}").as_bytes()), Err(error.to_string()))
            }
        };
        let opening = Opening { content, after };
        let _closed = self.inputs.send(PoolInput::Open(self.run, id, opening));
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
        self.send(Event::Cancel(self.run));
    }

    /// No further job of this run goes to a worker until it is resumed; those at work go on.
    pub fn pause(&self) {
        self.send(Event::Pause(self.run));
    }

    /// The run goes on.
    pub fn resume(&self) {
        self.send(Event::Resume(self.run));
    }

    /// Changes the run's share of the workers.
    pub fn share(&self, share: Share) {
        self.send(Event::Begin { run: self.run, share });
    }

    fn send(&self, event: Event) {
        let _closed = self.inputs.send(PoolInput::Say(event));
    }
}

impl Drop for RunHandle {
    fn drop(&mut self) {
        self.send(Event::End(self.run));
    }
}
