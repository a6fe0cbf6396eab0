//! What a worker was at when the coordinator ended: the next life lets it go on.

use super::deaths::SLACK;
use super::{Checker, Held, Known, Oracle, Wrong, wrong};
use crate::*;
use std::collections::{BTreeMap, BTreeSet};

/// This life's account of the last one's grants.
#[derive(Default)]
pub(super) struct Lives {
    /// Jobs that were at work, as the disk has it, and until when nobody else may have them.
    inherited: BTreeMap<Job, Millis>,
    /// Those of them that no run has open.
    unopened: BTreeSet<Job>,
    /// The runs that will want what was at work and is not over.
    claimants: BTreeMap<Job, BTreeSet<usize>>,
    /// Who was heard last to be at one of those.
    at: BTreeMap<Job, (Worker, Epoch)>,
    /// Those that have been over in this life.
    over: BTreeSet<Job>,
    /// The last renewal by each grant of an earlier life, and whether a solver has the job.
    renewals: BTreeMap<Epoch, (Millis, bool)>,
    /// Who has asked for work.
    asked: BTreeSet<Worker>,
}

impl Lives {
    /// Whether a job waits for its worker, or did until the coordinator looks at its clock again.
    pub(super) fn waits(&self, now: Millis, job: &Job) -> bool {
        self.inherited.get(job).is_some_and(|until| now <= until + SLACK)
    }
}

impl Checker {
    /// The disk has it that this job was at work, and that this run wants it.
    pub(in super::super) fn inherits(&mut self, now: Millis, job: Job, run: usize) {
        self.lives.inherited.insert(job, now + self.timing.lease);
        self.lives.unopened.insert(job);
        self.lives.claimants.entry(job).or_default().insert(run);
    }

    /// A run is over: what nobody else will want is to end.
    pub(super) fn released(&mut self, run: usize) {
        let claimants = std::mem::take(&mut self.lives.claimants);
        for (job, mut runs) in claimants {
            runs.remove(&run);
            if !runs.is_empty() {
                self.lives.claimants.insert(job, runs);
            } else if self.is_inherited(job) {
                if let Some((_, epoch)) = self.lives.at.remove(&job) {
                    self.due.insert(epoch);
                }
                self.buried(job);
            }
        }
    }

    /// The last run that had a job open wants it no more: whether somebody who may be at it since
    /// an earlier life goes on for a run that will want it.
    pub(super) fn handed_on(&mut self, job: Job, left: &Known) -> bool {
        if left.over || !self.lives.claimants.contains_key(&job) {
            return false;
        }
        let holders: Vec<Epoch> = left.holders.iter().copied().collect();
        match holders[..] {
            // Who was heard before the run had opened it was silent for longer than a lease since.
            [] if left.grants == 0 => drop(self.lives.at.remove(&job)),
            [epoch] if self.lives.renewals.contains_key(&epoch) => {
                let Some(held) = self.held.remove(&epoch) else { return false };
                let suspected = held.suspect.map(|since| since + self.timing.suspect);
                let until = held.heard + self.timing.lease;
                self.lives.inherited.insert(job, suspected.map_or(until, |at| at.min(until)));
                self.lives.renewals.insert(epoch, (held.heard, held.begun));
                self.lives.at.insert(job, (held.worker, epoch));
            }
            _ => return false,
        }
        self.lives.unopened.insert(job);
        true
    }

    /// A worker is gone.
    pub(super) fn silenced(&mut self, worker: Worker) {
        self.lives.at.retain(|_, (at, _)| *at != worker);
    }

    pub(super) fn asked(&mut self, worker: Worker) {
        self.lives.asked.insert(worker);
    }

    /// No run has it open, and somebody may be at it since an earlier life.
    pub(super) fn is_inherited(&self, job: Job) -> bool {
        self.lives.unopened.contains(&job)
    }

    pub(super) fn opened_now(&mut self, job: Job) {
        self.lives.unopened.remove(&job);
    }

    /// Nothing is to be waited for any more.
    pub(super) fn mourned(&mut self, job: Job) {
        self.lives.inherited.remove(&job);
        self.lives.unopened.remove(&job);
    }

    /// The job is over, and may be opened again: who is still at it is stopped.
    pub(super) fn buried(&mut self, job: Job) {
        self.lives.over.insert(job);
        self.lives.claimants.remove(&job);
        self.mourned(job);
    }

    /// A worker gives a job back; another that is at it goes on.
    pub(super) fn returned(&mut self, now: Millis, (worker, job, epoch): (Worker, Job, Epoch)) {
        let held = self.jobs.get(&job).is_some_and(|known| !known.holders.is_empty());
        if !self.held.contains_key(&epoch) && !held && !self.is_at(now, worker, job) {
            self.mourned(job);
            self.lives.claimants.remove(&job);
        }
    }

    /// Whether another than this worker is heard to be at a job that no run has opened.
    fn is_at(&self, now: Millis, worker: Worker, job: Job) -> bool {
        self.lives.at.get(&job).filter(|(at, _)| *at != worker).is_some_and(|(_, epoch)| {
            let heard = self.lives.renewals.get(epoch).map(|(heard, _)| *heard);
            heard.is_some_and(|heard| now < heard + self.timing.lease)
        })
    }

    /// A renewal by a grant of an earlier life.
    pub(super) fn inherited_renewal(
        &mut self,
        now: Millis,
        (worker, job, epoch): (Worker, Job, Epoch),
        begun: bool,
        effects: &[Effect],
    ) -> Result<(), Wrong> {
        if self.held.contains_key(&epoch) || !self.epochs.contains_key(&epoch) {
            return Ok(());
        }
        let gone_on = effects.iter().any(|e| matches!(e, Effect::Renewed { .. }));
        if self.is_inherited(job) && !gone_on {
            return wrong(Oracle::Anew, "stopped before any run has opened what it is at");
        }
        let elsewhere = self.lives.asked.contains(&worker)
            || self.held.values().any(|held| held.worker == worker && held.now);
        let free = self.jobs.get(&job).is_some_and(|known| {
            let wanted = !known.over && !known.wants.is_empty();
            wanted && known.grants == 0 && !self.lives.over.contains(&job)
        });
        if free && !elsewhere && !gone_on {
            return wrong(Oracle::Anew, "stopped at what nobody else has");
        }
        self.lives.renewals.insert(epoch, (now, begun));
        if self.is_inherited(job) && !self.is_at(now, worker, job) {
            self.lives.at.insert(job, (worker, epoch));
        }
        Ok(())
    }

    /// A result of a job that is not known.
    pub(super) fn unknown(&self, event: Event) -> Result<(), Wrong> {
        match event {
            Event::Commit { job, .. } if self.is_inherited(job) => {
                wrong(Oracle::Anew, "a result is thrown away before any run has opened its job")
            }
            _ => Ok(()),
        }
    }

    /// A job is granted: nobody may be waited for.
    pub(super) fn granted_anew(&self, now: Millis, job: Job) -> Result<(), Wrong> {
        match self.lives.inherited.get(&job) {
            Some(until) if now < *until => {
                wrong(Oracle::Anew, "begun anew before its worker could be heard")
            }
            _ => Ok(()),
        }
    }

    /// A worker goes on with what an earlier life has granted it.
    pub(super) fn adopted(
        &mut self,
        now: Millis,
        (worker, job, epoch): (Worker, Job, Epoch),
    ) -> Result<(), Wrong> {
        let known = self.epochs.get(&epoch);
        if known.is_none_or(|(by, _, what)| (*by, *what) != (worker, job)) {
            return wrong(Oracle::Epoch, "goes on with what it was never granted");
        }
        let Some((heard, begun)) = self.lives.renewals.get(&epoch).copied() else {
            return wrong(Oracle::Anew, "goes on, and nobody has heard it");
        };
        if self.held.contains_key(&epoch) || now - heard >= self.timing.lease {
            return wrong(Oracle::Anew, "goes on with what is over");
        }
        self.mourned(job);
        self.deaths.hear(now, worker);
        let known = self.jobs.entry(job).or_default();
        if !known.holders.is_empty() || known.over || known.wants.is_empty() {
            return wrong(Oracle::Anew, "goes on beside another, or with what nobody wants");
        }
        known.grants += 1;
        known.holders.insert(epoch);
        known.last = Some(worker);
        let (granted, suspect, offered) = (now, None, false);
        let held = Held { worker, granted, heard, suspect, now: true, begun, offered };
        self.held.insert(epoch, held);
        Ok(())
    }

    /// Another life begins.
    pub(super) fn forget_lives(&mut self) {
        self.lives = Lives::default();
    }
}
