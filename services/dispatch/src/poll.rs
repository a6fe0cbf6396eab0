//! Questions for work: answered once each, parked, granted, hedged, dismissed.

use crate::ask::Ask;
use crate::effect::{Cause, Effect};
use crate::event::{Build, Epoch, Job, Millis, Run, Skills, Worker};
use crate::job_record::Phase;
use crate::leases::{Lease, Stage};
use crate::machine::Dispatch;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::parked_polls::{Asker, ParkedPolls, Ticket};
use crate::worker_table::WorkerTable;

/// Attempts looked at for one that takes long.
const MAX_SLOW: usize = 8;

impl Dispatch {
    pub(crate) fn poll(
        &mut self,
        now: Millis,
        worker: Worker,
        seq: u64,
        (free, park): (bool, bool),
        out: &mut Vec<Effect>,
    ) {
        let Some(state) = self.worker_table.get_mut(&worker) else {
            return;
        };
        #[cfg(test)]
        if self.mutant == Some(Mutant::PollMintsTwice) {
            state.granted = None;
            state.last_seq = seq.saturating_sub(1);
        }
        if seq < state.last_seq {
            out.push(Effect::Idle { worker, seq });
            return;
        }
        if seq == state.last_seq {
            return self.repeat(now, worker, seq, out);
        }
        (state.last_seq, state.granted) = (seq, None);
        if let Some(ticket) = state.parked.take() {
            self.parked.take(ticket);
        }
        self.worker_table.back(now, worker, self.timing.patience());
        if let Some(cause) = self.doubt(now, worker) {
            self.drain(worker, cause, out);
        }
        let Some(state) = self.worker_table.get_mut(&worker) else {
            return;
        };
        if state.drained {
            out.push(Effect::Dismiss { worker, seq });
            return;
        }
        if !free {
            out.push(Effect::Idle { worker, seq });
            return;
        }
        let until = now + self.timing.park;
        state.parked = Some(self.parked.add(state.skills, Asker { worker, seq, until }));
        self.grant(now, out);
        let Some(state) = self.worker_table.get_mut(&worker).filter(|state| state.parked.is_some())
        else {
            return;
        };
        if park {
            out.push(Effect::Park { worker, seq });
        } else {
            if let Some(ticket) = state.parked.take() {
                self.parked.take(ticket);
            }
            out.push(Effect::Idle { worker, seq });
        }
    }

    /// Answers a poll that was asked before as it was answered then.
    fn repeat(&mut self, now: Millis, worker: Worker, seq: u64, out: &mut Vec<Effect>) {
        let Some(state) = self.worker_table.get(&worker) else {
            return;
        };
        let held = state.granted.and_then(|(job, epoch)| {
            let leases = &self.jobs.get(&job)?.leases;
            let lease = leases.iter().find(|lease| lease.epoch == epoch)?;
            Some((job, lease.run, epoch, lease.hard.saturating_sub(now)))
        });
        out.push(if let Some((job, run, epoch, hard)) = held {
            let lease = self.timing.lease;
            Effect::Grant { worker, seq, job, run, epoch, lease, hard }
        } else if state.parked.is_some() {
            Effect::Park { worker, seq }
        } else if state.drained {
            Effect::Dismiss { worker, seq }
        } else {
            Effect::Idle { worker, seq }
        });
    }

    /// Gives the jobs whose turn it is to the workers that have waited longest.
    pub(crate) fn grant(&mut self, now: Millis, out: &mut Vec<Effect>) {
        let age = self.timing.age;
        #[cfg(test)]
        let age = if self.is(Mutant::NoAgeing) { Millis::MAX } else { age };
        while !self.parked.is_empty() {
            let (parked, worker_table, avoids_killers) =
                (&self.parked, &self.worker_table, self.avoids_killers());
            #[cfg(test)]
            let will = self.mutant == Some(Mutant::AnybodyWill);
            #[cfg(not(test))]
            let will = false;
            let can = |ask: &Ask| {
                let fit = || {
                    ask.killers.is_empty()
                        || asker(parked, worker_table, ask, avoids_killers).is_some()
                };
                will || parked.can(ask.need) && fit()
            };
            let Some((run, job)) = self.shares.pick(now, age, can) else {
                return;
            };
            let Some(ticket) = self.asker_for(job) else {
                return;
            };
            self.lend(now, ticket, run, job, out);
        }
    }

    /// Whom this job goes to, of those that wait.
    fn asker_for(&self, job: Job) -> Option<Ticket> {
        #[cfg(test)]
        if self.is(Mutant::AnybodyWill) {
            return self.parked.overdue(Millis::MAX);
        }
        let record = self.jobs.get(&job)?;
        asker(&self.parked, &self.worker_table, &record.ask, self.avoids_killers())
    }

    /// Whether a job is held back from those under whom it died.
    fn avoids_killers(&self) -> bool {
        #[cfg(test)]
        return !self.is(Mutant::KillerAgain);
        #[cfg(not(test))]
        true
    }

    /// Answers a parked worker's poll with a job.
    fn lend(&mut self, now: Millis, ticket: Ticket, run: Run, job: Job, out: &mut Vec<Effect>) {
        let Some(Asker { worker, seq, .. }) = self.parked.take(ticket) else {
            return;
        };
        self.next_epoch += 1;
        let epoch = Epoch(self.next_epoch);
        if let Some(state) = self.worker_table.get_mut(&worker) {
            state.parked = None;
            state.granted = Some((job, epoch));
        }
        let resent = self.jobs.get_mut(&job).is_some_and(|record| {
            record.attempts += 1;
            record.last = Some(worker);
            record.attempts > 1
        });
        let fresh = self.jobs.get(&job).is_some_and(|record| record.leases.is_empty());
        let charged = self.shares.charge(now, run, fresh);
        self.counts.resent += u64::from(resent);
        if let Some(account) = self.shares.get_mut(run) {
            account.counts.resent += u64::from(resent);
        }
        let (expires, hard) = (now + self.timing.lease, now + self.timing.hard);
        let (granted, suspect, stage, slow) = (now, false, Stage::Granted, false);
        let lease =
            Lease { worker, epoch, granted, expires, hard, suspect, stage, slow, run, charged };
        self.hold(now, job, lease);
        let (lease, hard) = (self.timing.lease, self.timing.hard);
        out.push(Effect::Grant { worker, seq, job, run, epoch, lease, hard });
    }

    /// Gives a second worker a job that takes much longer than its run's jobs do, while workers
    /// have nothing else to do. The first result counts.
    pub(crate) fn hedge(&mut self, now: Millis, out: &mut Vec<Effect>) {
        self.grant(now, out);
        if self.parked.is_empty() {
            return;
        }
        for (granted, job) in self.jobs.slowest(MAX_SLOW) {
            let Some(record) = self.jobs.get(&job).filter(|r| r.phase == Phase::Held) else {
                continue;
            };
            let Some(lease) = record.leases.first().copied() else {
                continue;
            };
            let spent = record.attempts >= self.timing.max_attempts || record.crashes > 0;
            let usual = self.shares.median(lease.run);
            let long = usual.is_some_and(|usual| {
                now - granted > (usual * self.timing.hedge_factor).max(self.timing.lease)
            });
            // Another build may find other bits: then which came first would show.
            let build = self.build_of(lease.worker);
            let other = |worker| worker != lease.worker && self.build_of(worker) == build;
            let Some(ticket) = self.parked.first(record.ask.need, other) else {
                continue;
            };
            if long && !spent {
                self.counts.hedged += 1;
                self.lend(now, ticket, lease.run, job, out);
            }
        }
    }

    /// A worker is there; one that an earlier life has drained stays so.
    pub(crate) fn arrive(
        &mut self,
        worker: Worker,
        build: Build,
        skills: Skills,
        out: &mut Vec<Effect>,
    ) {
        if self.worker_table.arrive(worker, build, skills) {
            out.push(Effect::Drained { worker, cause: Cause::Before });
        }
    }

    /// No further job for this worker.
    pub(crate) fn drain(&mut self, worker: Worker, cause: Cause, out: &mut Vec<Effect>) {
        if !self.worker_table.drain(worker) {
            return;
        }
        let ticket = self.worker_table.get_mut(&worker).and_then(|state| state.parked.take());
        out.push(Effect::Drained { worker, cause });
        if let Some(Asker { worker, seq, .. }) = ticket.and_then(|t| self.parked.take(t)) {
            out.push(Effect::Dismiss { worker, seq });
        }
    }
}

/// The worker that has waited longest, of those under whom the job has not died. One under whom it
/// has gets it only if there is nobody else, not even a busy one: else the job waits for that one.
fn asker(
    parked: &ParkedPolls,
    worker_table: &WorkerTable,
    ask: &Ask,
    avoids_killers: bool,
) -> Option<Ticket> {
    if ask.killers.is_empty() {
        return parked.first(ask.need, |_| true);
    }
    let clean = parked.first(ask.need, |worker| !ask.killers.contains(&worker));
    clean.or_else(|| {
        let nobody = !avoids_killers || !worker_table.others(ask);
        parked.first(ask.need, |_| nobody)
    })
}
