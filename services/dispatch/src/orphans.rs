//! What an earlier life of the coordinator had granted: who is at it goes on.
//!
//! The shell keeps on disk which jobs are at work and which runs want them, their *heirs*, and
//! names them to the next life before any run begins ([`Event::Inherit`](crate::Event::Inherit)).
//! Such a job, an *orphan*, waits for its worker for a lease before another gets it. A renewal by a
//! grant of an earlier life takes it up again; where no run has opened it yet, as runs are done
//! again from their beginning, the renewal is remembered until one does, and so is a result. Where
//! the run that has opened it does not want it any more and another heir may, it is an orphan
//! again. An orphan whose heirs are all over is as a job that is cancelled
//! ([`Event::Renounce`](crate::Event::Renounce)).

use crate::effect::{Effect, Receipt, Verdict};
use crate::event::{Build, Epoch, Event, Heir, Job, Millis, Skills, Worker};
use crate::machine::{Dispatch, Lease, Phase, Stage};
#[cfg(test)]
use crate::mutant::Mutant;
use std::collections::BTreeSet;

/// A renewal by a grant of an earlier life.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Word {
    pub(crate) worker: Worker,
    pub(crate) build: Build,
    pub(crate) skills: Skills,
    pub(crate) epoch: Epoch,
    pub(crate) begun: bool,
    pub(crate) at: Millis,
}

/// A job that was at work when the coordinator ended, and that no run has open.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Orphan {
    /// Until then it waits for its worker.
    until: Millis,
    /// The last word of it.
    word: Option<Word>,
}

impl Dispatch {
    /// Whether this job was at work when the coordinator ended, and no run has it open.
    #[must_use]
    pub fn orphaned(&self, job: Job) -> bool {
        self.orphans.get(&job).is_some()
    }

    /// The runs that will want what was at work when the coordinator ended, each once.
    #[must_use]
    pub fn heirs(&self) -> BTreeSet<Heir> {
        let jobs = self.heirs.names();
        jobs.iter().filter_map(|job| self.heirs.get(job)).flatten().copied().collect()
    }

    /// Whether a result of this job by this grant is an orphan's.
    pub(crate) fn bequeathed(&self, job: Job, epoch: Epoch) -> bool {
        #[cfg(test)]
        if self.is(Mutant::OrphanUnknown) {
            return false;
        }
        self.orphaned(job) && self.earlier(epoch)
    }

    /// Whether a grant is of an earlier life.
    #[must_use]
    pub fn earlier(&self, epoch: Epoch) -> bool {
        epoch.0 >> 32 < self.next_epoch >> 32
    }

    /// What an earlier life has left, or that a job of it is pardoned.
    pub(crate) fn recall(&mut self, now: Millis, event: Event) {
        match event {
            #[cfg(test)]
            Event::Bar(_) if self.is(Mutant::DrainForgotten) => {}
            Event::Bar(worker) => self.worker_table.bar(worker),
            Event::Inherit(job, heir) if self.jobs.get(&job).is_none() => {
                if let Some(heirs) = self.heirs.get_mut(&job) {
                    heirs.push(heir);
                    return;
                }
                self.heirs.insert(job, vec![heir]);
                let until = now + self.timing.lease;
                self.orphans.insert(job, Orphan { until, word: None });
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
    pub(crate) fn renounce(&mut self, heir: Heir, out: &mut Vec<Effect>) {
        #[cfg(test)]
        if self.is(Mutant::OrphanKept) {
            return;
        }
        for job in self.heirs.names() {
            let Some(heirs) = self.heirs.get_mut(&job) else {
                continue;
            };
            heirs.retain(|of| *of != heir);
            if !heirs.is_empty() {
                continue;
            }
            self.heirs.remove(&job);
            let Some(orphan) = self.orphans.remove(&job) else {
                continue;
            };
            if let Some(Word { worker, epoch, .. }) = orphan.word {
                out.push(Effect::Cancel { worker, job, epoch });
            }
            self.remember(job, Verdict::Cancelled);
        }
    }

    /// The last run that had a job open wants it no more, but an heir may yet, and whoever is at it
    /// has it from an earlier life, or is still waited for: it is an orphan again. Whether it is.
    pub(crate) fn hand_on(&mut self, now: Millis, job: Job) -> bool {
        #[cfg(test)]
        if self.is(Mutant::HeirPassedOver) {
            return false;
        }
        let (Some(_), Some(record)) = (self.heirs.get(&job), self.jobs.get_mut(&job)) else {
            return false;
        };
        let lease = match record.phase {
            Phase::Waiting(_) | Phase::Ready if record.attempts == 0 => {
                let until = if let Phase::Waiting(until) = record.phase { until } else { now };
                self.orphans.insert(job, Orphan { until, word: None });
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
        let word = self.worker_table.get(&worker).map(|state| {
            let begun = stage >= Stage::Begun;
            Word { worker, build: state.build, skills: state.skills, epoch, begun, at }
        });
        self.give_back(now, job, &lease);
        self.orphans.insert(job, Orphan { until: expires, word });
        true
    }

    /// What a job that is opened waits for first.
    pub(crate) fn awaited(&self, now: Millis, job: Job) -> Phase {
        #[cfg(test)]
        if self.is(Mutant::OrphanUnawaited) {
            return Phase::Ready;
        }
        let until = self.orphans.get(&job).map(|orphan| orphan.until);
        until.filter(|until| *until > now).map_or(Phase::Ready, Phase::Waiting)
    }

    /// A run has opened the job: who was heard to be at it goes on.
    pub(crate) fn adopt(&mut self, now: Millis, job: Job, out: &mut Vec<Effect>) {
        let word = self.orphans.remove(&job).and_then(|orphan| orphan.word);
        if let Some(word) = word.filter(|word| word.at + self.timing.lease > now) {
            self.take_up(now, job, word, out);
        }
    }

    /// Remembers a renewal of a job that no run has opened yet; whether it is an orphan's.
    pub(crate) fn remember_word(&mut self, job: Job, word: Word) -> bool {
        if !self.bequeathed(job, word.epoch) {
            return false;
        }
        if let Some(orphan) = self.orphans.get_mut(&job) {
            orphan.word = Some(word);
        }
        true
    }

    /// A result of a job that no run has opened yet counts for whoever opens it.
    pub(crate) fn bury(&mut self, job: Job, done: Verdict) -> Receipt {
        self.orphans.remove(&job);
        self.heirs.remove(&job);
        self.remember(job, done);
        Receipt::Accepted
    }

    /// Gives a job that nobody has been granted in this life back to who has it from an earlier
    /// one; whether it does. After that a late copy of a renewal takes nothing up.
    pub(crate) fn take_up(
        &mut self,
        now: Millis,
        job: Job,
        word: Word,
        out: &mut Vec<Effect>,
    ) -> bool {
        #[cfg(test)]
        if self.is(Mutant::OrphanSuperseded) {
            return false;
        }
        let Word { worker, build, skills, epoch, begun, at } = word;
        // Who asks for work, or has some, is not at this any more.
        let at_else = |state: &crate::worker_table::WorkerState| {
            state.parked.is_some() || !state.held.is_empty()
        };
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

    /// Who was at an orphan gives it back, or leaves: nothing is left to wait for.
    pub(crate) fn give_up(&mut self, now: Millis, job: Job, epoch: Epoch) {
        if !self.earlier(epoch) {
            return;
        }
        self.orphans.remove(&job);
        self.heirs.remove(&job);
        let awaited =
            |r: &crate::machine::Record| r.attempts == 0 && matches!(r.phase, Phase::Waiting(_));
        if self.jobs.get(&job).is_some_and(awaited) {
            self.turn(now, job, Phase::Ready);
        }
    }

    /// A worker is gone, and with it what it was at.
    pub(crate) fn forget_words(&mut self, worker: Worker) {
        if self.orphans.is_empty() {
            return;
        }
        for job in self.orphans.names() {
            if let Some(orphan) = self.orphans.get_mut(&job)
                && orphan.word.is_some_and(|word| word.worker == worker)
            {
                orphan.word = None;
            }
        }
    }
}
