//! Questions of workers that wait for their answers: for work, and for the end of a job.

use super::bulk::reply;
use cullet_dispatch::{Epoch, Job, Worker};
use cullet_proto::pool::{self, HeedAnswer, PollAnswer};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};
use zenoh::query::Query;

/// A worker waits to hear that its job is not wanted any more.
struct CancelWatch {
    job: Job,
    /// By which grant it has it.
    epoch: Epoch,
    since: Instant,
    query: Query,
}

/// At most one question of each kind of each worker.
#[derive(Default)]
pub(super) struct WaitingQuestions {
    polls: BTreeMap<Worker, (u64, Query)>,
    watches: BTreeMap<Worker, CancelWatch>,
}

impl WaitingQuestions {
    /// Holds a question for work. One that asks again has given up the question it asked before.
    pub(super) fn poll(&mut self, worker: Worker, seq: u64, query: Query) {
        if self.polls.get(&worker).is_none_or(|(asked, _)| *asked <= seq) {
            self.polls.insert(worker, (seq, query));
        } else if let Ok(bytes) = pool::answer(&PollAnswer::Idle, &[]) {
            reply(&query, bytes);
        }
    }

    /// How many questions for work wait.
    pub(super) fn polls(&self) -> usize {
        self.polls.len()
    }

    /// Answers a worker's question for work, if this is the one that waits.
    pub(super) fn answer_poll(&mut self, worker: Worker, seq: u64, answer: PollAnswer) -> bool {
        if self.polls.get(&worker).is_none_or(|(asked, _)| *asked != seq) {
            return false;
        }
        if let Some((_, query)) = self.polls.remove(&worker)
            && let Ok(bytes) = pool::answer(&answer, &[])
        {
            reply(&query, bytes);
        }
        true
    }

    /// The worker does not ask for work any more.
    pub(super) fn forget_poll(&mut self, worker: Worker) {
        self.polls.remove(&worker);
    }

    /// Holds a question about the end of a job, in the place of the one before.
    pub(super) fn watch(&mut self, worker: Worker, job: Job, epoch: Epoch, query: Query) {
        self.answer_watch(worker, None, HeedAnswer::Go);
        let since = Instant::now();
        self.watches.insert(worker, CancelWatch { job, epoch, since, query });
    }

    /// Answers what a worker asked about the end of the job of this grant, or of any.
    pub(super) fn answer_watch(&mut self, worker: Worker, of: Option<Epoch>, answer: HeedAnswer) {
        let asked =
            self.watches.get(&worker).is_some_and(|watch| of.is_none_or(|e| e == watch.epoch));
        if asked
            && let Some(CancelWatch { query, .. }) = self.watches.remove(&worker)
            && let Ok(bytes) = pool::answer(&answer, &[])
        {
            reply(&query, bytes);
        }
    }

    /// Answers those that have waited for the end of a job for so long.
    pub(super) fn answer_old_watches(&mut self, held: Duration) {
        let old = |(worker, watch): (&Worker, &CancelWatch)| {
            (watch.since.elapsed() >= held).then_some(*worker)
        };
        for worker in self.watches.iter().filter_map(old).collect::<Vec<_>>() {
            self.answer_watch(worker, None, HeedAnswer::Go);
        }
    }

    /// Who waits for the end of which job, by which grant.
    pub(super) fn watched(&self) -> impl Iterator<Item = (Worker, Job, Epoch)> {
        self.watches.iter().map(|(worker, watch)| (*worker, watch.job, watch.epoch))
    }

    /// A worker is gone.
    pub(super) fn forget(&mut self, worker: Worker) {
        self.polls.remove(&worker);
        self.watches.remove(&worker);
    }

    /// Nobody is answered any more.
    pub(super) fn clear(&mut self) {
        self.polls.clear();
        self.watches.clear();
    }
}
