//! Jobs that were at work when an earlier life of the coordinator ended: who is at one goes on.
//!
//! The shell keeps on disk which jobs are at work and which runs want them, their *claimants*, and
//! names them to the next life before any run begins ([`Event::Inherit`](crate::Event::Inherit)).
//! Such a job, an *inherited* one, waits for its worker for a lease before another gets it. A
//! renewal by a grant of an earlier life takes it up again; where no run has opened it yet, as runs
//! are done again from their beginning, the renewal is remembered until one does, and so is a
//! result. Where the run that has opened it does not want it any more and another claimant may, it
//! is inherited again. One whose claimants are all over is as a job that is cancelled
//! ([`Event::Release`](crate::Event::Release)). What becomes of them is in `takeover`.

use crate::by_name::ByJob;
use crate::event::{Build, Claimant, Epoch, Job, Millis, Skills, Worker, WorkerName};
use std::collections::BTreeSet;

/// A worker renews its lease of a job.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeaseRenewal {
    pub(crate) worker: Worker,
    pub(crate) build: Build,
    pub(crate) skills: Skills,
    pub(crate) name: WorkerName,
    pub(crate) epoch: Epoch,
    pub(crate) begun: bool,
    pub(crate) at: Millis,
}

/// A job that was at work when the coordinator ended, and that no run has open.
#[derive(Clone, Copy, Debug)]
struct InheritedJob {
    /// Until then it waits for its worker.
    until: Millis,
    /// The last that was heard of it.
    renewal: Option<LeaseRenewal>,
}

/// All of them, and who will want them.
#[derive(Debug, Default)]
pub(crate) struct InheritedJobs {
    unopened: ByJob<InheritedJob>,
    /// Of those that a run has opened again, too, until they are over.
    claimants: ByJob<Vec<Claimant>>,
}

impl InheritedJobs {
    /// Whether no run has opened this one yet.
    pub(crate) fn contains(&self, job: Job) -> bool {
        self.unopened.get(&job).is_some()
    }

    /// Whether an earlier life's run may still want this job.
    pub(crate) fn is_claimed(&self, job: Job) -> bool {
        self.claimants.get(&job).is_some()
    }

    /// Every claimant, once.
    pub(crate) fn claimants(&self) -> BTreeSet<Claimant> {
        let jobs = self.claimants.names();
        jobs.iter().filter_map(|job| self.claimants.get(job)).flatten().copied().collect()
    }

    /// An earlier life leaves a job to a run; it waits for its worker until then.
    pub(crate) fn inherit(&mut self, job: Job, claimant: Claimant, until: Millis) {
        if let Some(claimants) = self.claimants.get_mut(&job) {
            claimants.push(claimant);
            return;
        }
        self.claimants.insert(job, vec![claimant]);
        self.put(job, until, None);
    }

    /// No run has the job open, and it waits for its worker until then.
    pub(crate) fn put(&mut self, job: Job, until: Millis, renewal: Option<LeaseRenewal>) {
        self.unopened.insert(job, InheritedJob { until, renewal });
    }

    /// Until when a job waits for its worker.
    pub(crate) fn until(&self, job: Job) -> Option<Millis> {
        self.unopened.get(&job).map(|inherited| inherited.until)
    }

    /// A run opens a job: what was heard of it.
    pub(crate) fn open(&mut self, job: Job) -> Option<LeaseRenewal> {
        self.unopened.remove(&job).and_then(|inherited| inherited.renewal)
    }

    /// Remembers a renewal until a run opens the job, unless another is heard to be at it.
    pub(crate) fn renew(&mut self, job: Job, renewal: LeaseRenewal, lease: Millis) {
        let elsewhere = self.is_anothers((renewal.at, lease), job, renewal.worker);
        if let Some(inherited) = self.unopened.get_mut(&job).filter(|_| !elsewhere) {
            inherited.renewal = Some(renewal);
        }
    }

    /// Whether another than this worker is heard to be at a job that no run has opened yet.
    pub(crate) fn is_anothers(
        &self,
        (now, lease): (Millis, Millis),
        job: Job,
        worker: Worker,
    ) -> bool {
        let heard = self.unopened.get(&job).and_then(|inherited| inherited.renewal);
        heard.is_some_and(|heard| heard.worker != worker && heard.at + lease > now)
    }

    /// A run wants nothing any more: the jobs that only it wanted and nobody has opened, and what
    /// was heard of each.
    pub(crate) fn release(&mut self, claimant: Claimant) -> Vec<(Job, Option<LeaseRenewal>)> {
        let mut released = Vec::new();
        for job in self.claimants.names() {
            let Some(claimants) = self.claimants.get_mut(&job) else {
                continue;
            };
            claimants.retain(|of| *of != claimant);
            if !claimants.is_empty() {
                continue;
            }
            self.claimants.remove(&job);
            if let Some(inherited) = self.unopened.remove(&job) {
                released.push((job, inherited.renewal));
            }
        }
        released
    }

    /// Nobody of an earlier life wants this job any more.
    pub(crate) fn drop_claims(&mut self, job: Job) {
        self.claimants.remove(&job);
    }

    /// The job is over, or nobody is at it.
    pub(crate) fn forget(&mut self, job: Job) {
        self.unopened.remove(&job);
        self.claimants.remove(&job);
    }

    /// A worker is gone, and with it what it was at.
    pub(crate) fn forget_worker(&mut self, worker: Worker) {
        if self.unopened.is_empty() {
            return;
        }
        for job in self.unopened.names() {
            if let Some(inherited) = self.unopened.get_mut(&job)
                && inherited.renewal.is_some_and(|renewal| renewal.worker == worker)
            {
                inherited.renewal = None;
            }
        }
    }
}
