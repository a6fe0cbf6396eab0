//! Questions of workers and clients, from the bytes to the answer.

use super::bulk::{refuse, reply};
use super::inbox::Blob;
use super::shell::{Shell, outcome_of};
use cullet_dispatch::{Digest, Epoch, Event, Job, Outcome, Receipt, Trouble, Worker};
use cullet_proto::codec::MAX_HEADER;
use cullet_proto::envelope::PREFIX;
use cullet_proto::keys::{UserVerb, Verb, WorkerVerb, parse_rpc};
use cullet_proto::pool::{self, CommitAnswer, FetchAnswer, Noted, PollAnswer};
use cullet_proto::pool::{Refusal, RenewAnswer};
use cullet_proto::{Verdict, WireError, WorkerId, chunks};
use serde::Serialize;
use std::sync::Arc;
use std::time::{Duration, Instant};
use zenoh::query::Query;

/// Largest question \[bytes\]: a chunk and its header.
const MAX_QUESTION: usize = chunks::CHUNK + MAX_HEADER + PREFIX;
/// A client that asks how it goes is answered within this even if there is no news.
const WATCH: Duration = Duration::from_secs(2);
/// Clients that may wait for news at one time.
const MAX_WATCHERS: usize = 256;

/// A client that waits for news.
#[derive(Debug)]
pub(super) struct Watcher {
    query: Query,
    status: pool::Status,
    since: Instant,
}

impl Shell {
    /// Answers, refuses or parks a question.
    pub(super) fn question(&mut self, query: Query) {
        let bytes = query.payload().map(|payload| payload.to_bytes().into_owned());
        let bytes = bytes.unwrap_or_default();
        let verb = parse_rpc(query.key_expr().as_str());
        let kept = query.clone();
        let done = if bytes.len() > MAX_QUESTION {
            let (bytes, limit) = (bytes.len() as u64, MAX_QUESTION as u64);
            Err(Refusal::TooLarge { bytes, limit })
        } else {
            match verb {
                Some(Verb::Worker(name, verb)) => self.worker(query, &name, verb, &bytes),
                Some(Verb::User(_, verb)) => self.user(query, verb, &bytes),
                None => Err(Refusal::Malformed("no such question".into())),
            }
        };
        if let Err(refusal) = done {
            self.refusals += 1;
            tracing::warn!("{}: {refusal}", kept.key_expr());
            refuse(&kept, pool::refuse(&refusal));
        }
    }

    fn worker(
        &mut self,
        query: Query,
        name: &WorkerId,
        verb: WorkerVerb,
        bytes: &[u8],
    ) -> Result<(), Refusal> {
        match verb {
            WorkerVerb::Poll => {
                let (poll, _) = pool::read_ask::<pool::Poll>(bytes)?;
                self.poll(query, name, &poll);
                Ok(())
            }
            WorkerVerb::Renew => {
                let (renew, _) = pool::read_ask::<pool::Renew>(bytes)?;
                let (worker, job) = (Worker(renew.session.0), Job(renew.job.0));
                let said = self.step(Event::Renew { worker, job, epoch: Epoch(renew.epoch.0) });
                let said = said.renew.unwrap_or(RenewAnswer::Stop);
                if said != RenewAnswer::Stop {
                    self.progress(renew.job, renew.permille);
                }
                answer(&query, &said)
            }
            WorkerVerb::Fetch => {
                let (fetch, _) = pool::read_ask::<pool::Fetch>(bytes)?;
                let whole =
                    self.ledger.get(Job(fetch.job.0)).map(|wanted| Arc::clone(&wanted.bytes));
                let piece = whole.as_ref().and_then(|bytes| chunks::slice(bytes, fetch.index));
                self.send_piece(query, piece)
            }
            WorkerVerb::Chunk => self.chunk(&query, bytes),
            WorkerVerb::Commit => {
                let (commit, _) = pool::read_ask::<pool::Commit>(bytes)?;
                let said = self.commit(name, &commit)?;
                answer(&query, &said)
            }
            WorkerVerb::Fail => {
                let (fail, _) = pool::read_ask::<pool::Fail>(bytes)?;
                self.fail(name, &fail);
                answer(&query, &Noted)
            }
            WorkerVerb::Bye => {
                let (bye, _) = pool::read_ask::<pool::Bye>(bytes)?;
                let worker = Worker(bye.session.0);
                self.polls.remove(&worker);
                self.step(Event::Bye(worker));
                answer(&query, &Noted)
            }
        }
    }

    fn poll(&mut self, query: Query, name: &WorkerId, poll: &pool::Poll) {
        let worker = Worker(poll.session.0);
        self.know(worker, name);
        // One that asks again has given up the question it asked before.
        if self.polls.get(&worker).is_none_or(|(asked, _)| *asked <= poll.seq) {
            self.polls.insert(worker, (poll.seq, query));
        } else if let Ok(bytes) = pool::answer(&PollAnswer::Idle, &[]) {
            reply(&query, bytes);
        }
        self.step(Event::Poll { worker, seq: poll.seq, slots: poll.slots, park: true });
    }

    fn chunk(&mut self, query: &Query, bytes: &[u8]) -> Result<(), Refusal> {
        let (chunk, bulk) = pool::read_ask::<pool::Chunk>(bytes)?;
        answer(query, &self.inbox.put(&chunk, bulk)?)
    }

    fn commit(&mut self, name: &WorkerId, commit: &pool::Commit) -> Result<CommitAnswer, Refusal> {
        self.know(Worker(commit.session.0), name);
        if !self.dispatch.wants(Job(commit.job.0)) {
            self.inbox.forget(&commit.digest);
            // Over already: the machine compares the digests and may raise an alarm.
            return Ok(self.count(commit, Outcome::Broken));
        }
        let bytes = match self.inbox.take(&commit.digest, commit.length)? {
            Blob::Whole(bytes) => bytes,
            Blob::Missing(missing) => return Ok(CommitAnswer::Missing(missing)),
            Blob::Damaged => return Ok(CommitAnswer::Damaged),
        };
        let verdict = match Verdict::decode(&bytes) {
            Ok(verdict) => verdict,
            Err(error) => return Ok(CommitAnswer::Unreadable(error.to_string())),
        };
        let outcome = outcome_of(&verdict);
        self.ledger.keep(commit.job, verdict);
        self.cache.put(commit.job, bytes);
        Ok(self.count(commit, outcome))
    }

    fn count(&mut self, commit: &pool::Commit, outcome: Outcome) -> CommitAnswer {
        let event = Event::Commit {
            worker: Worker(commit.session.0),
            job: Job(commit.job.0),
            epoch: Epoch(commit.epoch.0),
            digest: Digest(commit.digest),
            outcome,
        };
        let receipt = self.step(event).receipt;
        let short = commit.job.short();
        match receipt {
            Some(Receipt::Accepted | Receipt::Noted) => {}
            other => tracing::info!("a result of job {short} is not needed: {other:?}"),
        }
        let next = commit.next.and_then(|poll| {
            let worker = Worker(poll.session.0);
            let (seq, slots) = (poll.seq, poll.slots);
            self.step(Event::Poll { worker, seq, slots, park: false }).grant
        });
        CommitAnswer::Done(next)
    }

    fn fail(&mut self, name: &WorkerId, fail: &pool::Fail) {
        let trouble = match fail.trouble {
            pool::Trouble::Crashed => Trouble::Crashed,
            pool::Trouble::Dropped => Trouble::Dropped,
            pool::Trouble::Invalid => Trouble::Invalid,
        };
        tracing::warn!("worker {name} gives job {} back: {}", fail.job.short(), fail.text);
        self.ledger.note_trouble(fail.job, &fail.text);
        let (worker, job) = (Worker(fail.session.0), Job(fail.job.0));
        self.step(Event::Fail { worker, job, epoch: Epoch(fail.epoch.0), trouble });
    }

    fn user(&mut self, query: Query, verb: UserVerb, bytes: &[u8]) -> Result<(), Refusal> {
        match verb {
            UserVerb::Chunk => self.chunk(&query, bytes),
            UserVerb::Submit => {
                let (submit, _) = pool::read_ask::<pool::Submit>(bytes)?;
                let said = self.submit(submit)?;
                answer(&query, &said)
            }
            UserVerb::Status => {
                let (status, _) = pool::read_ask::<pool::Status>(bytes)?;
                self.submissions.asked(status.id);
                self.watchers.truncate(MAX_WATCHERS);
                self.watchers.push(Watcher { query, status, since: Instant::now() });
                self.news();
                Ok(())
            }
            UserVerb::Fetch => {
                let (fetch, _) = pool::read_ask::<pool::FetchFile>(bytes)?;
                self.submissions.asked(fetch.id);
                let piece = self.submissions.piece(&fetch);
                self.send_piece(query, piece.as_deref())
            }
            UserVerb::Bye => {
                let (enough, _) = pool::read_ask::<pool::Enough>(bytes)?;
                self.submissions.enough(enough.id);
                answer(&query, &Noted)
            }
        }
    }

    fn submit(&mut self, submit: pool::Submit) -> Result<pool::SubmitAnswer, WireError> {
        if let Some(known) = self.submissions.known(submit.ticket, &submit.digest) {
            return Ok(pool::SubmitAnswer::Accepted { id: known });
        }
        let bytes = match self.inbox.take(&submit.digest, submit.length)? {
            Blob::Whole(bytes) => bytes,
            Blob::Missing(missing) => return Ok(pool::SubmitAnswer::Missing(missing)),
            Blob::Damaged => return Ok(pool::SubmitAnswer::Damaged),
        };
        Ok(self.submissions.submit(submit, &bytes))
    }

    /// Answers the clients whose submission has news, and those that have waited long.
    pub(super) fn news(&mut self) {
        for watcher in std::mem::take(&mut self.watchers) {
            let late = watcher.since.elapsed() >= WATCH;
            match self.submissions.status(&watcher.status, late) {
                Some(status) => {
                    let _too_large = answer(&watcher.query, &status);
                }
                None => self.watchers.push(watcher),
            }
        }
    }

    fn send_piece(&self, query: Query, piece: Option<&[u8]>) -> Result<(), Refusal> {
        let Some(piece) = piece else {
            return answer(&query, &FetchAnswer::Gone);
        };
        let head = FetchAnswer::Chunk { sum: chunks::sum(piece) };
        self.bulk.send(query, pool::answer(&head, piece)?);
        Ok(())
    }
}

fn answer<T: Serialize>(query: &Query, said: &T) -> Result<(), Refusal> {
    reply(query, pool::answer(said, &[])?);
    Ok(())
}
