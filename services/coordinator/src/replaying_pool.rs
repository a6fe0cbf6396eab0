//! Between a run and the pool: a job that an earlier attempt of the run, or an earlier run, had
//! settled is answered from what was kept, and every verdict is kept before the run acts on it. A
//! run is deterministic, so that an attempt that begins anew asks for the same jobs in the same
//! order.

use super::run_status::{Clock, RunStatus};
use super::store::Kept;
use super::timeline::{Attempts, JobAttempt, JobFate, JobTimes, RunHistory, Stretch};
use cullet_pool::{Attempted, JobEnding, RunHandle, Settlement, Try};
use cullet_proto::{JobId, Verdict};
use cullet_run::{JobPool, PoolLoad, WantedJob};
use std::cell::RefCell;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::time::Duration;

/// A pool that tells who is at what.
pub(super) trait ReportingPool: JobPool {
    /// Who was given which job since this was asked last, and which attempts were lost.
    fn attempts(&self) -> Vec<Attempted>;
}

impl ReportingPool for RunHandle {
    fn attempts(&self) -> Vec<Attempted> {
        Self::attempts(self)
    }
}

/// Verdicts of settled jobs, for later attempts at a run or for later runs.
pub(super) trait VerdictStore {
    /// The verdict of a job that was settled before, if it is there and sound.
    fn get(&self, job: JobId) -> Option<Verdict>;
    /// Keeps a verdict before anybody acts on it.
    fn put(&self, job: JobId, verdict: &Verdict) -> io::Result<()>;
}

impl VerdictStore for Kept {
    fn get(&self, job: JobId) -> Option<Verdict> {
        Self::get(self, job)
    }

    fn put(&self, job: JobId, verdict: &Verdict) -> io::Result<()> {
        Self::put(self, job, verdict)
    }
}

/// A job that is wanted and has not settled.
struct Due {
    job: JobId,
    opened: f64,
    kept: Option<Verdict>,
}

/// The pool as one attempt sees it.
pub(super) struct ReplayingPool<'a> {
    pool: &'a dyn ReportingPool,
    /// Verdicts of earlier attempts or runs; `None`: there are none, and none is kept.
    kept: Option<&'a dyn VerdictStore>,
    live: &'a RunStatus,
    clock: Clock,
    due: RefCell<VecDeque<Due>>,
    /// The attempts at each job that is due, and how often it is.
    attempts: RefCell<BTreeMap<JobId, (u32, Attempts)>>,
    /// Where it is written down for later attempts; nowhere, where there is none.
    past: Option<&'a RunHistory>,
}

impl<'a> ReplayingPool<'a> {
    pub(super) fn new(
        pool: &'a dyn ReportingPool,
        kept: Option<&'a dyn VerdictStore>,
        live: &'a RunStatus,
    ) -> Self {
        live.begin();
        let (due, attempts) = Default::default();
        Self { pool, kept, live, clock: Clock::start(), due, attempts, past: None }
    }

    /// The same, and what happens is written down for later attempts.
    pub(super) fn noting(self, past: &'a RunHistory) -> Self {
        Self { past: Some(past), ..self }
    }

    /// The run is over: what has not settled will not.
    pub(super) fn close(&self) {
        self.hear();
        let settled = self.clock.now();
        let attempts = self.attempts.take();
        for Due { job, opened, .. } in self.due.borrow_mut().drain(..) {
            let tries = attempts.get(&job).map(|(_, all)| all.stretches(opened, settled));
            let times = (opened, settled);
            let left =
                JobTimes::left(job.short(), times, tries.unwrap_or_default(), JobFate::Unsettled);
            self.live.unsettled(left);
        }
        if let Some(past) = self.past {
            past.ended(settled);
        }
    }

    /// Takes in what has befallen the jobs that are due.
    fn hear(&self) {
        let mut due = self.attempts.borrow_mut();
        for Attempted { job, grant, worker, at, lost } in self.pool.attempts() {
            let (id, at) = (job.short(), self.clock.at(at));
            let news = JobAttempt { job: id, grant, worker, at, lost };
            let taken = due.get_mut(&job).is_some_and(|(_, all)| all.take(&news));
            if let (Some(past), true) = (self.past, taken) {
                past.attempted(&news);
            }
        }
    }

    /// An opening of a job settled.
    fn forget(&self, job: JobId) {
        if let Entry::Occupied(mut due) = self.attempts.borrow_mut().entry(job) {
            due.get_mut().0 -= 1;
            if due.get().0 == 0 {
                due.remove();
            }
        }
    }

    fn note(&self, due: &Due, settlement: &Settlement) {
        let ending = match &settlement.ending {
            JobEnding::Verdict(Verdict::Solved(_) | Verdict::Measured(_) | Verdict::Moved(_)) => {
                JobFate::Solved
            }
            JobEnding::Verdict(Verdict::Refused { .. }) => JobFate::Refused,
            JobEnding::Verdict(Verdict::Failed { .. }) => JobFate::Failed,
            JobEnding::Abandoned(_) => JobFate::Abandoned,
            JobEnding::Cancelled => JobFate::Cancelled,
        };
        let settled = self.clock.now();
        let at = |since: Duration| due.opened + since.as_secs_f64();
        let stretch = |tried: &Try| Stretch {
            worker: tried.worker.clone(),
            from: at(tried.granted),
            to: tried.ended.map_or(settled, at),
            lost: tried.how.clone(),
        };
        let job = JobTimes {
            job: due.job.short(),
            tries: settlement.tries.iter().map(stretch).collect(),
            worker: settlement.worker.clone(),
            opened: due.opened,
            settled,
            attempts: settlement.attempts,
            kept: due.kept.is_some() || settlement.cached,
            ending,
        };
        // What was kept is written down where it was found.
        if due.kept.is_none() {
            self.forget(due.job);
            self.past.into_iter().for_each(|past| past.settled(&job));
        }
        self.live.settled(job);
        if let JobEnding::Abandoned(_) = settlement.ending {
            self.live.give_up(due.job, settlement.reproduction.clone());
        }
        let (job, worker) = (due.job.short(), &settlement.worker);
        let (attempts, kept) = (settlement.attempts, due.kept.is_some() || settlement.cached);
        let fragments = match &settlement.ending {
            JobEnding::Verdict(Verdict::Solved(outcome)) => outcome.bodies(),
            _ => 0,
        };
        let (ending, seconds) = (ending.word(), settled - due.opened);
        tracing::info!(job, worker, attempts, kept, ending, fragments, seconds, "job settled");
    }
}

impl JobPool for ReplayingPool<'_> {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let known = job.encode().ok().map(|bytes| JobId::of(&bytes));
        let kept = known.and_then(|job| self.kept?.get(job));
        let say = |job: JobId| {
            tracing::info!(job = %job.short(), kept = kept.is_some(), "job opened");
        };
        // Before the pool has it, whose lines come after this one.
        known.into_iter().for_each(say);
        let opened = self.clock.now();
        let job = known.filter(|_| kept.is_some()).unwrap_or_else(|| self.pool.open(job));
        if known.is_none() {
            say(job);
        }
        self.live.opened();
        if kept.is_none() {
            self.attempts.borrow_mut().entry(job).or_default().0 += 1;
            self.past.into_iter().for_each(|past| past.opened(&job.short(), opened));
        }
        self.due.borrow_mut().push_back(Due { job, opened, kept });
        job
    }

    fn settled(&self, timeout: Duration) -> Option<(JobId, Settlement)> {
        self.hear();
        let first = self.due.borrow_mut().pop_front();
        let Some(due) = first else {
            return self.pool.settled(timeout);
        };
        let settlement = match &due.kept {
            Some(verdict) => Settlement {
                ending: JobEnding::Verdict(verdict.clone()),
                attempts: 0,
                worker: String::new(),
                wall: Duration::ZERO,
                cached: true,
                overdue: false,
                tries: Vec::new(),
                reproduction: None,
            },
            None => match self.pool.settled(timeout) {
                Some((job, settlement)) if job == due.job => settlement,
                // Not the next one: the run finds out.
                Some(other) => return Some(other),
                None => {
                    self.due.borrow_mut().push_front(due);
                    return None;
                }
            },
        };
        if let (None, JobEnding::Verdict(verdict)) = (&due.kept, &settlement.ending)
            && let Some(Err(error)) = self.kept.map(|kept| kept.put(due.job, verdict))
        {
            tracing::warn!(job = %due.job.short(), "a verdict is not kept: {error}");
        }
        self.note(&due, &settlement);
        Some((due.job, settlement))
    }

    fn load(&self) -> PoolLoad {
        self.pool.load()
    }

    fn cancel(&self) {
        self.pool.cancel();
    }
}

#[cfg(test)]
mod tests;
