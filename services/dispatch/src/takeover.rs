//! What becomes of jobs that were at work when an earlier life of the coordinator ended.

use crate::effect::{Effect, Receipt, Verdict};
use crate::event::{Claimant, Epoch, Event, Job, Millis};
use crate::inherited::LeaseRenewal;
use crate::job_record::{JobRecord, Phase};
use crate::leases::{Lease, Stage};
use crate::machine::Dispatch;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::worker_table::WorkerState;
use std::collections::BTreeSet;

impl Dispatch {
    /// Whether this job was at work when the coordinator ended, and no run has it open.
    #[must_use]
    pub fn is_inherited(&self, job: Job) -> bool {
        self.inherited.contains(job)
    }

    /// The runs that will want what was at work when the coordinator ended, each once.
    #[must_use]
    pub fn claimants(&self) -> BTreeSet<Claimant> {
        self.inherited.claimants()
    }

    /// Whether a result of this job by this grant is one of an inherited job.
    pub(crate) fn is_inherited_by(&self, job: Job, epoch: Epoch) -> bool {
        #[cfg(test)]
        if self.is(Mutant::InheritedUnknown) {
            return false;
        }
        self.is_inherited(job) && self.earlier(epoch)
    }

    /// Whether a grant is of an earlier life.
    #[must_use]
    pub fn earlier(&self, epoch: Epoch) -> bool {
        epoch.0 >> 32 < self.next_epoch >> 32
    }

    /// What an earlier life has left, or that a job of it is pardoned.
    pub(crate) fn learn_past(&mut self, now: Millis, event: Event) {
        match event {
            #[cfg(test)]
            Event::Bar(_) if self.is(Mutant::DrainForgotten) => {}
            Event::Bar(worker) => self.worker_table.bar(worker),
            Event::Inherit(job, claimant) if self.jobs.get(&job).is_none() => {
                self.inherited.inherit(job, claimant, now + self.timing.lease);
            }
            #[cfg(test)]
            Event::Isolate(_) if self.is(Mutant::QuarantineForgotten) => {}
            Event::Isolate(job) => drop(self.quarantine.put(job, 1)),
            Event::Pardon(job) => self.quarantine.remove(job),
            _ => {}
        }
    }

    /// A run of an earlier life is over. Who is at what only it wanted is told so, now if it has
    /// been heard, with its next renewal if not.
    pub(crate) fn release_claims(&mut self, claimant: Claimant, out: &mut Vec<Effect>) {
        #[cfg(test)]
        if self.is(Mutant::InheritedKept) {
            return;
        }
        for (job, renewal) in self.inherited.release(claimant) {
            if let Some(LeaseRenewal { worker, epoch, .. }) = renewal {
                out.push(Effect::Cancel { worker, job, epoch });
            }
            self.past.remember(job, Verdict::Cancelled);
        }
    }

    /// The last run that had a job open wants it no more. Where a claimant may yet, and its worker
    /// has it from an earlier life or is still waited for, it is inherited again. Whether it is.
    pub(crate) fn inherit_again(&mut self, now: Millis, job: Job) -> bool {
        #[cfg(test)]
        if self.is(Mutant::ClaimantPassedOver) {
            return false;
        }
        let Some(record) = self.jobs.get(&job).filter(|_| self.inherited.is_claimed(job)) else {
            return false;
        };
        let lease = match record.phase {
            Phase::Waiting(_) | Phase::Ready if record.attempts == 0 => {
                let until = if let Phase::Waiting(until) = record.phase { until } else { now };
                self.inherited.put(job, until, None);
                return true;
            }
            Phase::Held => record.leases.only().copied(),
            Phase::Waiting(_) | Phase::Ready | Phase::Over(_) => None,
        };
        let Some(lease) = lease.filter(|lease| self.earlier(lease.epoch)) else {
            return false;
        };
        let Lease { worker, epoch, expires, stage, .. } = lease;
        let at = expires.saturating_sub(self.timing.lease);
        let renewal = self.worker_table.get(&worker).map(|state| {
            let begun = stage >= Stage::Begun;
            LeaseRenewal { worker, build: state.build, skills: state.skills, epoch, begun, at }
        });
        self.give_back(now, job, &lease);
        self.inherited.put(job, expires, renewal);
        true
    }

    /// What a job that is opened waits for first.
    pub(crate) fn awaited(&self, now: Millis, job: Job) -> Phase {
        #[cfg(test)]
        if self.is(Mutant::InheritedUnawaited) {
            return Phase::Ready;
        }
        self.inherited.until(job).filter(|until| *until > now).map_or(Phase::Ready, Phase::Waiting)
    }

    /// A run has opened the job: who was heard to be at it goes on.
    pub(crate) fn adopt(&mut self, now: Millis, job: Job, out: &mut Vec<Effect>) {
        let heard = self.inherited.open(job);
        if let Some(renewal) = heard.filter(|heard| heard.at + self.timing.lease > now) {
            self.resume(now, job, renewal, out);
        }
    }

    /// Remembers a renewal of a job that no run has opened yet; whether it is an inherited one.
    pub(crate) fn renew_inherited(&mut self, job: Job, renewal: LeaseRenewal) -> bool {
        let inherited = self.is_inherited_by(job, renewal.epoch);
        if inherited {
            self.inherited.renew(job, renewal);
        }
        inherited
    }

    /// A result of a job that no run has opened yet counts for whoever opens it.
    pub(crate) fn complete_unclaimed(&mut self, job: Job, done: Verdict) -> Receipt {
        self.inherited.forget(job);
        self.past.remember(job, done);
        Receipt::Accepted
    }

    /// Gives a job that nobody has been granted in this life back to who has it from an earlier
    /// one; whether it does. After that a late copy of a renewal takes nothing up.
    pub(crate) fn resume(
        &mut self,
        now: Millis,
        job: Job,
        renewal: LeaseRenewal,
        out: &mut Vec<Effect>,
    ) -> bool {
        #[cfg(test)]
        if self.is(Mutant::InheritedSuperseded) {
            return false;
        }
        let LeaseRenewal { worker, build, skills, epoch, begun, at } = renewal;
        // Who asks for work, or has some, is not at this any more.
        let at_else = |state: &WorkerState| state.parked.is_some() || !state.held.is_empty();
        if !self.earlier(epoch) || self.worker_table.get(&worker).is_some_and(at_else) {
            return false;
        }
        let Some(record) = self.jobs.get_mut(&job).filter(|_| self.past.get(&job).is_none()) else {
            return false;
        };
        let waits = matches!(record.phase, Phase::Waiting(_) | Phase::Ready);
        let free = waits && record.attempts == 0 && skills.meet(record.ask.need);
        let Some(run) = record.wants.first().map(|want| want.run).filter(|_| free) else {
            return false;
        };
        record.attempts += 1;
        record.last = Some(worker);
        self.arrive(worker, build, skills, out);
        self.worker_table.back(now, worker, self.timing.patience());
        let charged = self.shares.charge(now, run, false);
        let (expires, hard) = (at + self.timing.lease, now + self.timing.hard);
        let stage = if begun { Stage::Begun } else { Stage::Granted };
        let (granted, suspect, slow) = (now, false, false);
        let lease =
            Lease { worker, epoch, granted, expires, hard, suspect, stage, slow, run, charged };
        self.hold(now, job, lease);
        self.counts.adopted += 1;
        out.push(Effect::Adopted { worker, job, run, epoch });
        true
    }

    /// Who was at an inherited job gives it back, or leaves: nothing is left to wait for.
    pub(crate) fn give_up(&mut self, now: Millis, job: Job, epoch: Epoch) {
        if !self.earlier(epoch) {
            return;
        }
        self.inherited.forget(job);
        let awaited = |r: &JobRecord| r.attempts == 0 && matches!(r.phase, Phase::Waiting(_));
        if self.jobs.get(&job).is_some_and(awaited) {
            self.set_phase(now, job, Phase::Ready);
        }
    }
}
