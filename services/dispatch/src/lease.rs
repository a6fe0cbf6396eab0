//! Leases: renewed, given back, run out.

use crate::effect::{Effect, Loss, Reason, Receipt, StopReason};
use crate::event::{Epoch, Job, Millis, Trouble, Worker};
#[cfg(test)]
use crate::machine::Mutant;
use crate::machine::{Dispatch, Lease, MAX_GONE, Phase, Record};

impl Dispatch {
    pub(crate) fn renew(
        &mut self,
        now: Millis,
        worker: Worker,
        job: Job,
        epoch: Epoch,
        out: &mut Vec<Effect>,
    ) {
        let lease = self.timing.lease;
        let answer = match self.jobs.get_mut(&job) {
            None if self.past.contains_key(&job) => Err(StopReason::Over),
            None => Err(StopReason::Unknown),
            Some(record) => match &mut record.phase {
                Phase::Over(_) => Err(StopReason::Over),
                Phase::Leased(held) if held.epoch == epoch => {
                    held.expires = now + lease;
                    held.suspect = false;
                    Ok(())
                }
                Phase::Leased(_) => Err(StopReason::Superseded),
                Phase::Queued { last: Some(last), .. } if last.epoch == epoch => {
                    let back = Lease { expires: now + lease, suspect: false, ..*last };
                    self.queue.remove(&(record.opening, job));
                    record.phase = Phase::Leased(back);
                    Ok(())
                }
                Phase::Queued { .. } => Err(StopReason::Superseded),
            },
        };
        out.push(match answer {
            Ok(()) => Effect::Renewed { worker, job, lease },
            Err(reason) => Effect::Stop { worker, job, reason },
        });
    }

    pub(crate) fn fail(
        &mut self,
        now: Millis,
        worker: Worker,
        job: Job,
        epoch: Epoch,
        trouble: Trouble,
        out: &mut Vec<Effect>,
    ) {
        let current = self.lease_mut(job).is_some_and(|lease| lease.epoch == epoch);
        if current {
            match trouble {
                Trouble::Crashed => self.lose(now, job, Loss::Crashed, out),
                Trouble::Dropped => self.lose(now, job, Loss::Dropped, out),
                Trouble::Invalid => self.abandon(job, Reason::Invalid, out),
            }
        }
        out.push(Effect::Taken { worker, receipt: Receipt::Noted });
    }

    pub(crate) fn suspect(&mut self, now: Millis, worker: Worker) {
        let until = now + self.timing.suspect;
        self.part(worker);
        for record in self.jobs.values_mut() {
            if let Phase::Leased(lease) = &mut record.phase
                && lease.worker == worker
            {
                lease.expires = lease.expires.min(until);
                lease.suspect = true;
            }
        }
    }

    pub(crate) fn leave(&mut self, now: Millis, worker: Worker, loss: Loss, out: &mut Vec<Effect>) {
        self.part(worker);
        for job in self.held_by(worker) {
            self.lose(now, job, loss, out);
        }
    }

    /// Remembers one that is gone, for a while; a new question of its own brings it back.
    fn part(&mut self, worker: Worker) {
        self.parked.retain(|p| p.worker != worker);
        if let Some(peer) = self.peers.get_mut(&worker)
            && !peer.gone
        {
            peer.gone = true;
            self.gone.push_back(worker);
        }
        while self.gone.len() > MAX_GONE {
            let Some(oldest) = self.gone.pop_front() else {
                break;
            };
            if self.peers.get(&oldest).is_some_and(|peer| peer.gone) {
                self.peers.remove(&oldest);
            }
        }
    }

    fn held_by(&self, worker: Worker) -> Vec<Job> {
        #[cfg(test)]
        let all = self.mutant == Some(Mutant::DownTakesAll);
        #[cfg(not(test))]
        let all = false;
        let held = |record: &Record| match record.phase {
            Phase::Leased(lease) => lease.worker == worker || all,
            Phase::Queued { .. } | Phase::Over(_) => false,
        };
        self.jobs.iter().filter(|(_, r)| held(r)).map(|(job, _)| *job).collect()
    }

    pub(crate) fn tick(&mut self, now: Millis, out: &mut Vec<Effect>) {
        #[cfg(test)]
        if self.mutant == Some(Mutant::NoExpiry) {
            return;
        }
        let lost = |record: &Record| match record.phase {
            Phase::Leased(lease) if lease.hard <= now => Some(Loss::TooLong),
            Phase::Leased(lease) if lease.expires <= now && lease.suspect => Some(Loss::Down),
            Phase::Leased(lease) if lease.expires <= now => Some(Loss::Silent),
            Phase::Leased(_) | Phase::Queued { .. } | Phase::Over(_) => None,
        };
        let ended: Vec<_> =
            self.jobs.iter().filter_map(|(job, r)| lost(r).map(|loss| (*job, loss))).collect();
        for (job, loss) in ended {
            self.lose(now, job, loss, out);
        }
        while let Some(index) = self.parked.iter().position(|p| p.until <= now) {
            if let Some(p) = self.parked.remove(index) {
                out.push(Effect::Idle { worker: p.worker, seq: p.seq });
            }
        }
    }

    /// The present lease is over without a result.
    fn lose(&mut self, now: Millis, job: Job, loss: Loss, out: &mut Vec<Effect>) {
        let timing = self.timing;
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let Phase::Leased(lease) = record.phase else {
            return;
        };
        let (crash, last) = match loss {
            Loss::Down | Loss::Crashed | Loss::TooLong => (1, None),
            Loss::Dropped => (0, None),
            Loss::Silent => (0, Some(lease)),
        };
        record.crashes += crash;
        #[cfg(test)]
        if self.mutant == Some(Mutant::NoLimit) {
            (record.crashes, record.attempts) = (0, 1);
        }
        if record.crashes >= timing.max_crashes {
            self.abandon(job, Reason::Crashes, out);
        } else if record.attempts >= timing.max_attempts {
            self.abandon(job, Reason::Attempts, out);
        } else {
            let doublings = record.attempts.saturating_sub(1).min(16);
            let pause = (timing.backoff << doublings).min(timing.lease);
            record.phase = Phase::Queued { not_before: now + pause, last };
            self.queue.insert((record.opening, job));
            out.push(Effect::Requeue { job, loss });
        }
    }

    pub(crate) fn lease_mut(&mut self, job: Job) -> Option<&mut Lease> {
        match &mut self.jobs.get_mut(&job)?.phase {
            Phase::Leased(lease) => Some(lease),
            Phase::Queued { .. } | Phase::Over(_) => None,
        }
    }
}
