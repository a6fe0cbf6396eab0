//! What the machine says, done.

use super::attempts::Attempted;
use super::ledger::Wanted;
use super::quarantine;
use super::settlement::{JobEnding, Reproduction, Settlement};
use super::shell::{Shell, StepAnswers};
use cullet_dispatch::{
    Cause, Digest, Effect, Epoch as DispatchEpoch, Job, Loss, Millis, Reason, Run,
    Verdict as Decision, Worker,
};
use cullet_proto::pool::{Grant, HeedAnswer, OVERDUE, PollAnswer, RenewAnswer};
use cullet_proto::{Epoch, JobId, SessionId, WorkerId};
use std::time::Instant;

impl Shell {
    pub(super) fn act(&mut self, effect: Effect, answers: &mut StepAnswers) {
        match effect {
            Effect::Grant { worker, seq, job, run, epoch, lease, hard } => {
                let (job, epoch) = (JobId(job.0), Epoch(epoch.0));
                let grant = self.granted((worker, run), job, epoch, (lease, hard));
                if !self.waiting.answer_poll(worker, seq, PollAnswer::Grant(grant)) {
                    answers.grant = Some(grant);
                }
            }
            Effect::Idle { worker, seq } => {
                self.waiting.answer_poll(worker, seq, PollAnswer::Idle);
            }
            Effect::Park { .. } => {}
            Effect::Renewed { lease, .. } => {
                answers.renew = Some(RenewAnswer::Go { lease_ms: lease });
            }
            Effect::Adopted { worker, job, run, epoch } => {
                let (id, run, name) = (JobId(job.0), self.label(run), self.name(worker));
                let news =
                    self.ledger.granted(id, epoch, (&name, self.workers.roster.about(worker)));
                self.notify_runs(news);
                self.workers.roster.took(worker, id);
                let job = id.short();
                tracing::info!(run, job, worker = name, epoch = epoch.0, "goes on from before");
            }
            Effect::Stop { .. } => answers.renew = Some(RenewAnswer::Stop),
            Effect::Cancel { worker, job, epoch } => {
                self.workers.roster.left(worker, JobId(job.0));
                self.waiting.answer_watch(worker, Some(epoch), HeedAnswer::Stop);
            }
            Effect::Taken { receipt, .. } => answers.receipt = Some(receipt),
            Effect::Dismiss { worker, seq } => {
                self.waiting.answer_poll(worker, seq, PollAnswer::Drain);
            }
            Effect::Drained { worker, cause } => {
                self.workers.roster.drained(worker);
                self.workers.lives.leaves(SessionId(worker.0));
                // What the pool found by itself the next life finds again, if it is still so.
                let on_disk = self.kept.drained.as_mut().filter(|_| cause == Cause::Asked);
                on_disk.into_iter().for_each(|file| file.keep(worker));
                let why = why(cause);
                tracing::warn!(
                    worker = self.name(worker),
                    why,
                    "worker drained: it gets no further job"
                );
            }
            Effect::Doubted { worker } => tracing::warn!(
                worker = self.name(worker),
                "jobs that others finished have died under this name: it gets what no other can do"
            ),
            Effect::Lost { job, worker, epoch, loss, charged } => {
                self.lost(job, (worker, epoch), (loss, charged));
            }
            Effect::Busy { run, job, .. } => self.turn_down(run, job),
            Effect::Quarantine { job, crashes } => self.isolate(job, crashes),
            Effect::Stall { job, reason, attempts } => {
                let (id, runs) = (JobId(job.0).short(), self.runs_of(job));
                tracing::error!(run = runs, job = id, attempts, ?reason, "job abandoned");
            }
            Effect::Alarm { job, kept, other } => alarm(job, kept, other),
            Effect::Settle { run, job, verdict, attempts, .. } => {
                self.settle(run, job, verdict, attempts);
            }
        }
    }

    /// What a worker gets to know of its grant.
    fn granted(
        &mut self,
        (worker, run): (Worker, Run),
        job: JobId,
        epoch: Epoch,
        (lease_ms, hard_ms): (Millis, Millis),
    ) -> Grant {
        let outline = self.ledger.get(Job(job.0)).map_or(0, |wanted| wanted.outline.len());
        let (run, name) = (self.label(run), self.name(worker));
        let (grant, by) =
            (DispatchEpoch(epoch.0), (name.as_str(), self.workers.roster.about(worker)));
        let news = self.ledger.granted(job, grant, by);
        self.notify_runs(news);
        self.workers.roster.took(worker, job);
        let own = self.children.as_ref().is_some_and(|children| children.has(&name));
        if !own {
            self.note_at_work(job);
        }
        tracing::info!(run, job = job.short(), worker = name, epoch = epoch.0, "job granted");
        let (length, renew_ms) = (outline as u64, self.timing.renew);
        Grant { job, run, epoch, length, lease_ms, renew_ms, hard_ms }
    }

    /// A job is, or may be, at work where it outlives this process: the next life is to know, and
    /// which runs want it.
    pub(super) fn note_at_work(&mut self, job: JobId) {
        let wanted = self.ledger.get(Job(job.0)).map(|wanted| wanted.openings.keys());
        let runs: Vec<u64> = wanted.into_iter().flatten().map(|run| self.label(*run)).collect();
        let dispatch = &self.dispatch;
        let counts = |id: &JobId| dispatch.wants(Job(id.0)) || dispatch.is_inherited(Job(id.0));
        if let Some(file) = &mut self.kept.at_work {
            file.took(job, runs, counts);
        }
    }

    pub(super) fn name(&self, worker: Worker) -> String {
        self.workers.names.name(worker).map_or_else(String::new, WorkerId::to_string)
    }

    /// A run's number for people.
    pub(super) fn label(&self, run: Run) -> u64 {
        self.runs.listeners.get(&run).map_or(run.0, |listener| listener.label)
    }

    /// The runs that want a job, for a line of the log.
    pub(super) fn runs_of(&self, job: Job) -> String {
        let runs = self.ledger.get(job).map(|wanted| wanted.openings.keys());
        let labels = runs.into_iter().flatten().map(|run| self.label(*run).to_string());
        labels.collect::<Vec<_>>().join(" ")
    }

    fn lost(
        &mut self,
        job: Job,
        (worker, epoch): (Worker, DispatchEpoch),
        (loss, charged): (Loss, bool),
    ) {
        self.workers.roster.left(worker, JobId(job.0));
        let (id, runs, name) = (JobId(job.0).short(), self.runs_of(job), self.name(worker));
        tracing::warn!(run = runs, job = id, worker = name, ?loss, charged, "attempt lost");
        // The next attempt begins at the beginning.
        self.progress(JobId(job.0), 0);
        if loss == Loss::TooLong {
            self.ledger.note_trouble(JobId(job.0), OVERDUE);
        }
        let spared = !charged && matches!(loss, Loss::Down | Loss::TooLong);
        let how = if spared { " (no solver had the job)" } else { "" };
        let news = self.ledger.ended(JobId(job.0), epoch, &format!("{loss:?}{how}"));
        self.notify_runs(news);
    }

    /// Runs that want a job hear what befalls an attempt at it.
    fn notify_runs(&self, news: Option<Attempted>) {
        let wanted = news.as_ref().and_then(|news| self.ledger.get(Job(news.job.0)));
        for run in wanted.into_iter().flat_map(|wanted| wanted.openings.keys()) {
            if let Some(listener) = self.runs.listeners.get(run) {
                listener.attempts.put(news.clone());
            }
        }
    }

    /// Keeps what reproduces a job that killed its workers.
    fn isolate(&self, job: Job, crashes: u32) {
        let (id, runs) = (JobId(job.0), self.runs_of(job));
        tracing::error!(run = &runs, job = id.short(), crashes, "job put in quarantine");
        let (Some(folder), Some(bytes)) = (&self.kept.quarantine, self.ledger.whole(job)) else {
            return;
        };
        match quarantine::write(folder, id, &bytes, &self.ledger.lines(job, &runs)) {
            Ok(own) => tracing::error!("what reproduces it is in {}", own.display()),
            Err(error) => tracing::error!("what reproduces it is not kept: {error}"),
        }
    }

    /// A job may be tried again, in later lives too.
    pub(super) fn pardon(&self, id: JobId) {
        if let Some(folder) = &self.kept.quarantine
            && let Err(error) = quarantine::release(folder, id)
        {
            tracing::error!(job = id.short(), "its quarantine outlives this pool: {error}");
        }
    }

    /// What reproduces a job whose attempts are used up; of one that was in quarantine when it was
    /// opened, what is kept there tells of its attempts.
    fn reproduction(&self, job: Job, decision: Decision) -> Option<Reproduction> {
        let Decision::Abandoned(Reason::Crashes { .. } | Reason::Attempts) = decision else {
            return None;
        };
        let (bytes, told) = (self.ledger.whole(job)?, self.ledger.lines(job, &self.runs_of(job)));
        let kept = self.kept.quarantine.as_deref().filter(|_| told.is_empty());
        let kept = kept.and_then(|folder| quarantine::attempts(folder, JobId(job.0)));
        Some(Reproduction { job: bytes, attempts: kept.unwrap_or(told) })
    }

    fn settle(&mut self, run: Run, job: Job, decision: Decision, attempts: u32) {
        let reproduction = self.reproduction(job, decision);
        let Some((wanted, opened)) = self.close(run, job) else {
            return;
        };
        let (cached, tries) =
            (matches!(decision, Decision::Done { worker: None, .. }), wanted.tries(opened));
        let overdue = matches!(decision, Decision::Abandoned(_)) && wanted.trouble == OVERDUE;
        let (ending, worker) = match (decision, wanted.result) {
            (Decision::Done { worker, .. }, Some(verdict)) => {
                worker.into_iter().for_each(|worker| self.workers.roster.done(worker));
                let name = worker.and_then(|worker| self.workers.names.name(worker));
                (JobEnding::Verdict(verdict), name.map(WorkerId::to_string).unwrap_or_default())
            }
            (Decision::Done { .. }, None) => {
                (JobEnding::Abandoned("its result was lost here".into()), String::new())
            }
            (Decision::Abandoned(reason), _) => {
                (JobEnding::Abandoned(words(reason, attempts, &wanted.trouble)), String::new())
            }
            (Decision::Cancelled, _) => (self.unwanted(run), String::new()),
        };
        let wall = opened.elapsed();
        let settlement =
            Settlement { ending, attempts, worker, cached, overdue, wall, tries, reproduction };
        // Sent once the counts that go with it can be read.
        self.runs.settled.push((run, JobId(job.0), settlement));
    }

    fn close(&mut self, run: Run, job: Job) -> Option<(Wanted, Instant)> {
        let (wanted, opened) = self.ledger.close(run, job)?;
        if let Some(listener) = self.runs.listeners.get_mut(&run)
            && !wanted.openings.contains_key(&run)
        {
            listener.permille -= i64::from(wanted.permille);
        }
        Some((wanted, opened))
    }

    /// An opening that the machine did not take ends here: its run is over.
    fn turn_down(&mut self, run: Run, job: Job) {
        if self.close(run, job).is_some() {
            self.end_unopened(run, JobId(job.0));
        }
    }
}

fn alarm(job: Job, kept: Digest, other: Digest) {
    let (job, kept, other) = (JobId(job.0).short(), JobId(kept.0), JobId(other.0));
    tracing::error!("job {job} is not deterministic: results {kept} and {other}");
}

fn why(cause: Cause) -> &'static str {
    match cause {
        Cause::Asked => "a user drained it",
        Cause::Before => "it was drained before the coordinator started",
        Cause::Blamed => "jobs died under it that others finished",
        Cause::Alone => "one job after another died under it and nowhere else",
    }
}

fn words(reason: Reason, attempts: u32, trouble: &str) -> String {
    let many = |n: u32, one: &str, more: &str| format!("{n} {}", if n == 1 { one } else { more });
    let what = match reason {
        Reason::Crashes { deaths: 0, .. } => "it is in quarantine".to_owned(),
        Reason::Crashes { deaths, workers } => {
            let deaths = many(deaths, "process", "processes");
            format!("it ended {deaths} under {}", many(workers, "worker", "workers"))
        }
        Reason::Attempts => "too many attempts".to_owned(),
        Reason::Invalid => "it cannot be read".to_owned(),
        Reason::Forsaken => "no worker is left".to_owned(),
    };
    let colon = if trouble.is_empty() { "" } else { ": " };
    format!("{what} ({}){colon}{trouble}", many(attempts, "attempt", "attempts"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_that_is_given_up_says_how_many_processes_of_how_many_workers_it_ended() {
        let told = |deaths, workers, attempts| {
            words(Reason::Crashes { deaths, workers }, attempts, "signal: 9")
        };
        assert_eq!(told(3, 2, 4), "it ended 3 processes under 2 workers (4 attempts): signal: 9");
        assert_eq!(told(3, 1, 3), "it ended 3 processes under 1 worker (3 attempts): signal: 9");
        assert_eq!(words(Reason::Forsaken, 1, ""), "no worker is left (1 attempt)");
    }
}
