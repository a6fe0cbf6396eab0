//! What must hold, whatever the schedule: kept apart from the machine, by other means.

use crate::*;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Default)]
pub(super) struct Oracle {
    pub(super) opened: Vec<Job>,
    pub(super) settled: u64,
    accepted: BTreeSet<Job>,
    grants: BTreeMap<Job, u32>,
    by_seq: BTreeMap<(Worker, u64), (Job, Epoch)>,
    by_epoch: BTreeMap<Epoch, (Worker, Job)>,
    holders: BTreeSet<(Job, Worker)>,
    crashes: BTreeMap<Job, u32>,
    pub(super) requeued: u64,
}

pub(super) fn result_of(job: Job) -> Digest {
    Digest(job.0.map(|b| b ^ 0x5a))
}

impl Oracle {
    /// A job opened again after it has settled is a new one.
    pub(super) fn open(&mut self, job: Job) {
        if !self.opened.iter().skip(self.settled as usize).any(|j| *j == job) {
            self.accepted.remove(&job);
            self.grants.remove(&job);
            self.crashes.remove(&job);
        }
        self.opened.push(job);
    }

    pub(super) fn watch(
        &mut self,
        event: Event,
        effect: Effect,
        timing: &Timing,
    ) -> Result<(), String> {
        match effect {
            Effect::Grant { worker, seq, job, epoch, .. } => {
                return self.grant((worker, seq), (job, epoch), timing);
            }
            Effect::Taken { receipt: Receipt::Accepted, .. } => {
                let Event::Commit { job, .. } = event else {
                    return Err("accepted what?".into());
                };
                if !self.accepted.insert(job) {
                    return Err("one job accepted twice".into());
                }
            }
            Effect::Lost { job, loss, .. } => {
                self.requeued += 1;
                self.crash(job, loss);
                if let Event::Down(worker) = event
                    && !self.holders.contains(&(job, worker))
                {
                    return Err("the end of one worker took another's lease".into());
                }
            }
            Effect::Settle { opening, job, verdict, .. } => {
                return self.settle(opening, job, verdict);
            }
            Effect::Alarm { .. } => return Err("alarm over equal results".into()),
            Effect::Stall { job, attempts, .. } => {
                if self.grants.get(&job) != Some(&attempts) || attempts < timing.max_crashes {
                    return Err(format!("stalled after {attempts} attempts"));
                }
            }
            Effect::Park { .. }
            | Effect::Idle { .. }
            | Effect::Renewed { .. }
            | Effect::Stop { .. }
            | Effect::Dismiss { .. }
            | Effect::Drained { .. }
            | Effect::Busy { .. }
            | Effect::Quarantine { .. }
            | Effect::Taken { .. } => {}
        }
        Ok(())
    }

    fn grant(
        &mut self,
        (worker, seq): (Worker, u64),
        (job, epoch): (Job, Epoch),
        timing: &Timing,
    ) -> Result<(), String> {
        let first = *self.by_seq.entry((worker, seq)).or_insert((job, epoch));
        if first != (job, epoch) {
            return Err(format!("poll {seq} of {worker:?} was answered twice"));
        }
        match self.by_epoch.insert(epoch, (worker, job)) {
            None => *self.grants.entry(job).or_default() += 1,
            Some(known) if known == (worker, job) => {}
            Some(_) => return Err(format!("{epoch:?} came twice")),
        }
        if self.grants[&job] > timing.max_attempts {
            return Err(format!("{} attempts", self.grants[&job]));
        }
        if *self.crashes.get(&job).unwrap_or(&0) >= timing.max_crashes {
            return Err("granted after its last crash".into());
        }
        self.holders.insert((job, worker));
        Ok(())
    }

    fn crash(&mut self, job: Job, loss: Loss) {
        match loss {
            Loss::Down | Loss::Crashed | Loss::TooLong => {
                *self.crashes.entry(job).or_default() += 1;
            }
            Loss::Dropped | Loss::Silent => {}
        }
    }

    fn settle(&mut self, opening: u64, job: Job, verdict: Verdict) -> Result<(), String> {
        if opening != self.settled || self.opened.get(opening as usize) != Some(&job) {
            return Err(format!("opening {opening} settled when {} was due", self.settled));
        }
        self.settled += 1;
        match verdict {
            Verdict::Done { digest, .. } if digest == result_of(job) => Ok(()),
            Verdict::Done { .. } => Err("a result that nobody computed".into()),
            Verdict::Abandoned(_) => Ok(()),
            Verdict::Cancelled => Err("cancelled by nobody".into()),
        }
    }
}
