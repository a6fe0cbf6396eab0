//! Leases: renewed, given back, run out.

use crate::effect::{Effect, Loss, Reason, Receipt, StopReason, Verdict};
use crate::event::{Epoch, Job, Millis, Trouble, Worker};
use crate::inherited::LeaseRenewal;
use crate::job_record::{JobRecord, Phase};
use crate::leases::{Lease, Stage};
use crate::machine::Dispatch;
#[cfg(test)]
use crate::mutant::Mutant;

impl Dispatch {
    pub(crate) fn renew(&mut self, job: Job, renewal: LeaseRenewal, out: &mut Vec<Effect>) {
        let (worker, lease) = (renewal.worker, self.timing.lease);
        let said = match self.prolong(job, renewal, out) {
            Ok(()) => Effect::Renewed { worker, job, lease },
            Err(reason) => Effect::Stop { worker, job, reason },
        };
        out.push(said);
        if renewal.begun {
            self.reach(job, renewal.epoch, Stage::Begun);
        }
    }

    /// An attempt is that far; what comes late takes nothing back.
    pub(crate) fn reach(&mut self, job: Job, epoch: Epoch, stage: Stage) {
        if let Some(lease) = self.jobs.get_mut(&job).and_then(|record| record.leases.find(epoch)) {
            lease.stage = lease.stage.max(stage);
        }
    }

    fn prolong(
        &mut self,
        job: Job,
        renewal: LeaseRenewal,
        out: &mut Vec<Effect>,
    ) -> Result<(), StopReason> {
        let (now, epoch) = (renewal.at, renewal.epoch);
        let expires = now + self.timing.lease;
        let Some(record) = self.jobs.get_mut(&job) else {
            if self.renew_inherited(job, renewal) {
                return Ok(());
            }
            let known = self.past.get(&job).is_some();
            return Err(if known { StopReason::Over } else { StopReason::Unknown });
        };
        if let Phase::Over(_) = record.phase {
            #[cfg(test)]
            if self.mutant == Some(Mutant::DeafToStop) {
                return Ok(());
            }
            return Err(StopReason::Over);
        }
        if let Some(held) = record.leases.find(epoch) {
            (held.expires, held.suspect) = (expires, false);
            self.jobs.set_timer(job, self.timing.lease);
            return Ok(());
        }
        let back = record
            .lapsed
            .as_deref()
            .copied()
            .filter(|last| last.epoch == epoch && record.phase != Phase::Held);
        let Some(back) = back else {
            let gone_on = self.resume(now, job, renewal, out);
            return if gone_on { Ok(()) } else { Err(StopReason::Superseded) };
        };
        record.lapsed = None;
        self.worker_table.back(now, back.worker, self.timing.patience());
        let charged = self.shares.charge(now, back.run, false);
        self.hold(now, job, Lease { expires, suspect: false, slow: false, charged, ..back });
        Ok(())
    }

    /// A job comes under a lease.
    pub(crate) fn hold(&mut self, now: Millis, job: Job, lease: Lease) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        record.leases.push(lease);
        let alone = record.leases.only().is_some();
        #[cfg(test)]
        let alone = alone || self.mutant == Some(Mutant::HedgedAgain);
        let hedged: Vec<_> = record
            .leases
            .iter()
            .filter(|held| held.slow && !alone)
            .map(|held| held.granted)
            .collect();
        for granted in hedged {
            self.jobs.forget_slow(granted, job);
        }
        if let Some(state) = self.worker_table.get_mut(&lease.worker) {
            state.held.push((job, lease.epoch));
        }
        self.set_phase(now, job, Phase::Held);
    }

    /// A lease is over, however: it is charged what it took.
    fn drop_lease(&mut self, now: Millis, job: Job, lease: &Lease, whole: bool) {
        let took = now.saturating_sub(lease.granted);
        self.shares.took(lease.run, lease.charged, took, whole);
        if lease.slow {
            self.jobs.forget_slow(lease.granted, job);
        }
        if let Some(state) = self.worker_table.get_mut(&lease.worker) {
            state.held.retain(|held| *held != (job, lease.epoch));
            state.heard = now;
        }
    }

    /// A lease of a job is nobody's any more, and who has it goes on.
    pub(crate) fn give_back(&mut self, now: Millis, job: Job, lease: &Lease) {
        if let Some(record) = self.jobs.get_mut(&job) {
            record.leases.take(|held| held.epoch == lease.epoch);
        }
        self.drop_lease(now, job, lease, false);
    }

    /// All leases of a job are over, with this verdict; who has one is told, but who found it.
    pub(crate) fn release(
        &mut self,
        now: Millis,
        job: Job,
        verdict: Verdict,
        out: &mut Vec<Effect>,
    ) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let by = match verdict {
            Verdict::Done { worker, .. } => worker,
            Verdict::Abandoned(_) | Verdict::Cancelled => None,
        };
        for lease in std::mem::take(&mut record.leases) {
            let Lease { worker, epoch, .. } = lease;
            self.drop_lease(now, job, &lease, by == Some(worker));
            #[cfg(test)]
            if self.is(Mutant::CancelUnsaid) {
                continue;
            }
            if by != Some(worker) {
                out.push(Effect::Cancel { worker, job, epoch });
            }
        }
    }

    /// One that has a job wants to hear when nobody wants it any more: perhaps that is so already.
    /// Of a grant of an earlier life nothing is known: that is for a renewal to say.
    pub(crate) fn watch_cancel(
        &self,
        (worker, job, epoch): (Worker, Job, Epoch),
        out: &mut Vec<Effect>,
    ) {
        let over = match self.jobs.get(&job) {
            None => self.past.get(&job).is_some(),
            Some(record) => match record.phase {
                Phase::Over(_) => true,
                Phase::Held => record.leases.iter().all(|lease| lease.epoch != epoch),
                Phase::Waiting(_) | Phase::Ready => false,
            },
        };
        if over {
            out.push(Effect::Cancel { worker, job, epoch });
        }
    }

    pub(crate) fn fail(
        &mut self,
        now: Millis,
        (worker, job, epoch): (Worker, Job, Epoch),
        trouble: Trouble,
        out: &mut Vec<Effect>,
    ) {
        let held = |r: &JobRecord| r.leases.iter().any(|lease| lease.epoch == epoch);
        if self.jobs.get(&job).is_some_and(held) {
            match trouble {
                Trouble::Crashed => self.lose(now, job, epoch, Loss::Crashed, out),
                Trouble::Dropped => self.lose(now, job, epoch, Loss::Dropped, out),
                Trouble::Invalid => self.abandon(now, job, Reason::Invalid, out),
            }
        } else {
            self.give_up(now, job, epoch);
        }
        out.push(Effect::Taken { worker, receipt: Receipt::Noted });
    }

    pub(crate) fn suspect(&mut self, now: Millis, worker: Worker) {
        let until = now + self.timing.suspect;
        let held = self.held_by(worker);
        if held.is_empty() {
            self.part(worker);
        } else {
            self.unpark(worker);
        }
        for (job, epoch) in held {
            let record = self.jobs.get_mut(&job);
            if let Some(lease) = record.and_then(|record| record.leases.find(epoch)) {
                lease.expires = lease.expires.min(until);
                lease.suspect = true;
            }
            self.jobs.set_timer(job, self.timing.lease);
        }
    }

    pub(crate) fn leave(&mut self, now: Millis, worker: Worker, loss: Loss, out: &mut Vec<Effect>) {
        self.part(worker);
        self.inherited.forget_worker(worker);
        for (job, epoch) in self.held_by(worker) {
            self.lose(now, job, epoch, loss, out);
        }
    }

    /// It is gone.
    fn part(&mut self, worker: Worker) {
        self.unpark(worker);
        self.worker_table.part(worker);
    }

    /// Its question is not answered any more.
    fn unpark(&mut self, worker: Worker) {
        let ticket = self.worker_table.get_mut(&worker).and_then(|state| state.parked.take());
        ticket.and_then(|ticket| self.parked.take(ticket));
    }

    /// Those whose end nobody has noticed, and who would be waited for in vain.
    fn unheard(&mut self, now: Millis) -> Vec<Worker> {
        #[cfg(test)]
        if self.is(Mutant::GhostAwaited) {
            return Vec::new();
        }
        self.worker_table.unheard(now, self.timing.patience())
    }

    fn held_by(&self, worker: Worker) -> Vec<(Job, Epoch)> {
        #[cfg(test)]
        if self.is(Mutant::DownTakesAll) {
            let all = self
                .worker_table
                .names()
                .into_iter()
                .filter_map(|name| self.worker_table.get(&name));
            return all.flat_map(|state| state.held.iter().copied()).collect();
        }
        self.worker_table.get(&worker).map(|state| state.held.clone()).unwrap_or_default()
    }

    pub(crate) fn tick(&mut self, now: Millis, out: &mut Vec<Effect>) {
        for job in self.jobs.due(now) {
            self.look_at(now, job, out);
        }
        while let Some(asker) = self.parked.overdue(now).and_then(|t| self.parked.take(t)) {
            if let Some(state) = self.worker_table.get_mut(&asker.worker) {
                state.parked = None;
            }
            out.push(Effect::Idle { worker: asker.worker, seq: asker.seq });
        }
        for worker in self.unheard(now) {
            self.part(worker);
        }
        self.hedge(now, out);
    }

    /// A job whose time has come: its pause is over, or a lease of it.
    fn look_at(&mut self, now: Millis, job: Job, out: &mut Vec<Effect>) {
        if let Some(Phase::Waiting(_)) = self.jobs.get(&job).map(|record| record.phase) {
            return self.set_phase(now, job, Phase::Ready);
        }
        self.jobs.note_slow(now, job, self.timing.lease);
        self.jobs.set_timer(job, self.timing.lease);
        #[cfg(test)]
        if self.is(Mutant::NoExpiry) {
            // The lease stays as it is, and nobody looks any more.
            return self.jobs.get_mut(&job).into_iter().for_each(|record| record.timer = None);
        }
        let Some(record) = self.jobs.get(&job) else {
            return;
        };
        let lost = |lease: &Lease| match (lease.hard <= now, lease.expires <= now, lease.suspect) {
            (true, _, _) => Some(Loss::TooLong),
            (false, true, true) => Some(Loss::Down),
            (false, true, false) => Some(Loss::Silent),
            (false, false, _) => None,
        };
        let ended: Vec<_> =
            record.leases.iter().filter_map(|l| lost(l).map(|loss| (l.epoch, loss))).collect();
        for (epoch, loss) in ended {
            self.lose(now, job, epoch, loss, out);
        }
    }

    /// A lease is over without a result.
    fn lose(&mut self, now: Millis, job: Job, epoch: Epoch, loss: Loss, out: &mut Vec<Effect>) {
        let timing = self.timing;
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let Some(lease) = record.leases.take(|lease| lease.epoch == epoch) else {
            return;
        };
        let worker = lease.worker;
        let charged = match loss {
            Loss::Crashed => true,
            // Nobody says what it died of: of the job only if a solver had the job.
            Loss::Down | Loss::TooLong => lease.stage == Stage::Begun,
            Loss::Dropped | Loss::Silent => false,
        };
        #[cfg(test)]
        let charged = self.mutant.map_or(charged, |mutant| mutant.charges(charged, loss));
        if charged {
            record.crashes += 1;
            record.ask.died(worker);
            if record.ask.killers == [worker] {
                self.worker_table.died_alone(now, worker, job);
            }
        }
        if loss == Loss::Silent {
            record.lapsed = Some(Box::new(lease));
        }
        #[cfg(test)]
        if self.mutant == Some(Mutant::NoLimit) {
            (record.crashes, record.attempts) = (0, 1);
        }
        let (crashes, attempts) = (record.crashes, record.attempts);
        let killers = record.ask.killers.len();
        let alone = record.leases.is_empty();
        record.leases.iter_mut().for_each(|other| other.slow = false);
        self.jobs.note_slow(now, job, self.timing.lease);
        self.drop_lease(now, job, &lease, false);
        let idle =
            self.worker_table.get(&worker).is_some_and(|p| p.held.is_empty() && p.parked.is_none());
        if matches!(loss, Loss::Silent | Loss::Down) && idle {
            // Nobody may have noticed its end: one that is not heard of does not count as there.
            self.part(worker);
        }
        out.push(Effect::Lost { job, worker, epoch, loss, charged });
        let died = Reason::Crashes { deaths: crashes, workers: killers as u32 };
        // Where there is nobody else, no second one can clear it.
        let others = || self.jobs.get(&job).is_some_and(|r| self.worker_table.others(&r.ask));
        if crashes >= timing.max_crashes && (killers >= timing.min_killers as usize || !others()) {
            self.abandon(now, job, died, out);
        } else if !alone {
            self.jobs.set_timer(job, self.timing.lease);
        } else if attempts >= timing.max_attempts {
            let enough = crashes >= timing.max_crashes;
            let reason = if enough { died } else { Reason::Attempts };
            self.abandon(now, job, reason, out);
        } else {
            let doublings = attempts.saturating_sub(1).min(16);
            let pause = (timing.backoff << doublings).min(timing.lease);
            self.set_phase(now, job, Phase::Waiting(now + pause));
        }
    }
}
