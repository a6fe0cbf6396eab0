//! Questions of workers and clients, from the bytes to the answer.

use super::bulk::{refuse, reply};
use super::convert::outcome_of;
use super::inbox::Blob;
use super::session_names::number;
use super::shell::Shell;
use cullet_dispatch::{
    Build, Digest, Epoch, Event, Job, Outcome, Receipt, Skills, Trouble, Worker, WorkerName,
};
use cullet_proto::codec::MAX_HEADER;
use cullet_proto::envelope::PREFIX;
use cullet_proto::keys::{Verb, WorkerVerb, parse_rpc};
use cullet_proto::pool::{
    self, Acknowledged, CommitAnswer, FetchAnswer, QuestionRefusal, RenewAnswer,
};
use cullet_proto::{SessionId, Verdict, WorkerId, chunks};
use serde::Serialize;
use std::sync::Arc;
use zenoh::query::Query;

/// Largest question \[bytes\]: a chunk and its header.
const MAX_QUESTION: usize = chunks::CHUNK + MAX_HEADER + PREFIX;

impl Shell {
    /// Answers, refuses or parks a question.
    pub(super) fn question(&mut self, query: Query) {
        let bytes = query.payload().map(|payload| payload.to_bytes().into_owned());
        let bytes = bytes.unwrap_or_default();
        let verb = parse_rpc(query.key_expr().as_str());
        let kept = query.clone();
        let done = if bytes.len() > MAX_QUESTION {
            let (bytes, limit) = (bytes.len() as u64, MAX_QUESTION as u64);
            Err(QuestionRefusal::TooLarge { bytes, limit })
        } else {
            match verb {
                Some(Verb::Worker(name, verb)) => self.worker(query, &name, verb, &bytes),
                Some(Verb::User(..)) | None => {
                    Err(QuestionRefusal::Malformed("no such question".into()))
                }
            }
        };
        if let Err(refusal) = done {
            self.transfers.refusals.count(&refusal);
            let (reason, key) = (refusal.name(), kept.key_expr());
            match refusal {
                // The way back to a new life: it introduces itself, and asks again.
                QuestionRefusal::Stranger => tracing::info!(reason, "{key}: {refusal}"),
                _ => tracing::warn!(reason, "{key}: {refusal}"),
            }
            refuse(&kept, pool::refuse(&refusal));
        }
    }

    fn worker(
        &mut self,
        query: Query,
        name: &WorkerId,
        verb: WorkerVerb,
        bytes: &[u8],
    ) -> Result<(), QuestionRefusal> {
        match verb {
            WorkerVerb::Poll => {
                let (poll, _) = pool::read_ask::<pool::Poll>(bytes)?;
                self.poll(query, name, &poll)
            }
            WorkerVerb::Hello => {
                let (hello, _) = pool::read_ask::<pool::Hello>(bytes)?;
                self.introduce(name, &hello)?;
                answer(&query, &Acknowledged)
            }
            WorkerVerb::Renew => {
                let (renew, _) = pool::read_ask::<pool::Renew>(bytes)?;
                answer(&query, &self.renew(name, &renew)?)
            }
            WorkerVerb::Heed => {
                let (heed, _) = pool::read_ask::<pool::Heed>(bytes)?;
                self.watch_cancel(query, name, &heed)
            }
            WorkerVerb::Fetch => {
                let (fetch, _) = pool::read_ask::<pool::FetchBlob>(bytes)?;
                let wanted = self.ledger.get(Job(fetch.blob));
                let outline = wanted.map(|wanted| Arc::clone(&wanted.outline));
                let part = self.ledger.part(&fetch.blob).filter(|_| outline.is_none());
                let whole = outline.as_ref().or(part.as_ref());
                let piece = whole.and_then(|bytes| chunks::slice(bytes, fetch.index));
                if part.is_some() {
                    self.transfers.mesh_bytes += piece.map_or(0, <[u8]>::len) as u64;
                }
                self.send_piece(query, piece)
            }
            WorkerVerb::Chunk => self.chunk(&query, name, bytes),
            WorkerVerb::Commit => {
                let (commit, _) = pool::read_ask::<pool::Commit>(bytes)?;
                let said = self.commit(name, &commit)?;
                answer(&query, &said)
            }
            WorkerVerb::Fail => {
                let (fail, _) = pool::read_ask::<pool::Fail>(bytes)?;
                self.fail(name, &fail)?;
                answer(&query, &Acknowledged)
            }
            WorkerVerb::Bye => {
                let (bye, _) = pool::read_ask::<pool::Bye>(bytes)?;
                match self.who(name, bye.session) {
                    Ok((worker, ..)) => {
                        self.waiting.forget_poll(worker);
                        self.step(Event::Bye(worker));
                    }
                    // One that was not heard in this life leaves nothing.
                    Err(QuestionRefusal::Stranger) => {}
                    Err(refusal) => return Err(refusal),
                }
                answer(&query, &Acknowledged)
            }
        }
    }

    /// A worker says what it is: from now on its session is of its name.
    fn introduce(&mut self, name: &WorkerId, hello: &pool::Hello) -> Result<(), QuestionRefusal> {
        hello.check()?;
        let worker = Worker(hello.session.0);
        for old in self.workers.names.bind(worker, name, &self.workers.lives.up)? {
            self.waiting.forget(old);
            self.workers.skill_table.gone(old);
            self.workers.roster.gone(old);
        }
        self.workers.skill_table.introduce(hello);
        self.workers.roster.introduced(worker, name, hello);
        Ok(())
    }

    /// The worker that speaks, and what it has said that it is: nobody speaks for a session of
    /// another name, nor for one that has not said hello.
    fn who(
        &mut self,
        name: &WorkerId,
        session: SessionId,
    ) -> Result<(Worker, Build, Skills), QuestionRefusal> {
        let worker = Worker(session.0);
        self.workers.names.check(worker, name)?;
        let (build, skills) =
            self.workers.skill_table.get(worker).ok_or(QuestionRefusal::Stranger)?;
        if let Some(children) = &mut self.children {
            children.alive(name.as_str());
        }
        Ok((worker, build, skills))
    }

    fn poll(
        &mut self,
        query: Query,
        name: &WorkerId,
        poll: &pool::Poll,
    ) -> Result<(), QuestionRefusal> {
        let (worker, build, skills) = self.who(name, poll.session)?;
        self.waiting.poll(worker, poll.seq, query);
        let (seq, slots) = (poll.seq, poll.slots);
        let name = number(name);
        self.step(Event::Poll { worker, seq, slots, park: true, build, skills, name });
        Ok(())
    }

    fn renew(
        &mut self,
        name: &WorkerId,
        renew: &pool::Renew,
    ) -> Result<RenewAnswer, QuestionRefusal> {
        let (worker, build, skills) = self.who(name, renew.session)?;
        let job = Job(renew.job.0);
        let (epoch, begun) = (Epoch(renew.epoch.0), renew.permille > 0);
        let name = number(name);
        let event = Event::Renew { worker, job, epoch, begun, build, skills, name };
        let said = self.step(event).renew.unwrap_or(RenewAnswer::Stop);
        if said != RenewAnswer::Stop {
            if !self.dispatch.knows(job) {
                self.workers.roster.took(worker, renew.job);
            }
            self.progress(renew.job, renew.permille);
        }
        Ok(said)
    }

    /// A worker wants to hear when its job is not wanted any more.
    fn watch_cancel(
        &mut self,
        query: Query,
        name: &WorkerId,
        heed: &pool::Heed,
    ) -> Result<(), QuestionRefusal> {
        let (worker, ..) = self.who(name, heed.session)?;
        let (job, epoch) = (Job(heed.job.0), Epoch(heed.epoch.0));
        self.waiting.watch(worker, job, epoch, query);
        self.step(Event::WatchCancel { worker, job, epoch });
        Ok(())
    }

    /// What nobody wants any more is said to those, too, who have not renewed in this life.
    pub(super) fn renew_watches(&mut self) {
        let watched = self.waiting.watched();
        let before: Vec<_> = watched.filter(|(.., epoch)| self.dispatch.earlier(*epoch)).collect();
        for (worker, job, epoch) in before {
            self.step(Event::WatchCancel { worker, job, epoch });
        }
    }

    fn chunk(
        &mut self,
        query: &Query,
        name: &WorkerId,
        bytes: &[u8],
    ) -> Result<(), QuestionRefusal> {
        let (chunk, bulk) = pool::read_ask::<pool::Chunk>(bytes)?;
        answer(query, &self.transfers.inbox.put(name.as_str(), &chunk, bulk)?)
    }

    fn commit(
        &mut self,
        name: &WorkerId,
        commit: &pool::Commit,
    ) -> Result<CommitAnswer, QuestionRefusal> {
        let (_, build, _) = self.who(name, commit.session)?;
        let (job, epoch) = (Job(commit.job.0), Epoch(commit.epoch.0));
        if !self.dispatch.takes(job, epoch, build) {
            self.transfers.inbox.forget(name.as_str(), &commit.digest);
            // Over already: the machine compares the digests and may raise an alarm.
            return Ok(self.count(number(name), commit, Outcome::Broken));
        }
        let bytes = match self.transfers.inbox.take(name.as_str(), &commit.digest, commit.length)? {
            Blob::Whole(bytes) => bytes,
            Blob::Missing(missing) => {
                self.step(Event::Offer { job, epoch });
                return Ok(CommitAnswer::Missing(missing));
            }
            Blob::Damaged => return Ok(CommitAnswer::Damaged),
        };
        let verdict = match Verdict::decode(&bytes) {
            Ok(verdict) => verdict,
            Err(error) => return Ok(CommitAnswer::Unreadable(error.to_string())),
        };
        let outcome = outcome_of(&verdict);
        self.ledger.keep(commit.job, verdict);
        self.kept.cache.put(commit.job, bytes, build);
        self.ledger.ended(commit.job, epoch, "");
        Ok(self.count(number(name), commit, outcome))
    }

    fn count(&mut self, name: WorkerName, commit: &pool::Commit, outcome: Outcome) -> CommitAnswer {
        let (worker, job) = (Worker(commit.session.0), Job(commit.job.0));
        let (epoch, digest) = (Epoch(commit.epoch.0), Digest(commit.digest));
        let Some((build, skills)) = self.workers.skill_table.get(worker) else {
            return CommitAnswer::Done(None);
        };
        self.workers.roster.left(worker, commit.job);
        let (short, runs, called) = (commit.job.short(), self.runs_of(job), self.name(worker));
        let prior = self.kept(commit.job);
        let event = Event::Commit { worker, name, job, epoch, build, digest, outcome, prior };
        match self.step(event).receipt {
            Some(Receipt::Accepted) => {
                let epoch = epoch.0;
                tracing::debug!(run = runs, job = short, worker = called, epoch, "result taken");
            }
            Some(Receipt::Noted) => {}
            Some(receipt) => {
                tracing::info!(
                    run = runs,
                    job = short,
                    worker = called,
                    ?receipt,
                    "result not needed"
                );
            }
            None => {}
        }
        let next = commit.next.and_then(|poll| {
            let (seq, slots) = (poll.seq, poll.slots);
            let park = false;
            self.step(Event::Poll { worker, seq, slots, park, build, skills, name }).grant
        });
        CommitAnswer::Done(next)
    }

    fn fail(&mut self, name: &WorkerId, fail: &pool::Fail) -> Result<(), QuestionRefusal> {
        let (worker, ..) = self.who(name, fail.session)?;
        let trouble = match fail.trouble {
            pool::GiveBackReason::Crashed => Trouble::Crashed,
            pool::GiveBackReason::Dropped => Trouble::Dropped,
            pool::GiveBackReason::Invalid => Trouble::Invalid,
        };
        let (job, runs) = (fail.job.short(), self.runs_of(Job(fail.job.0)));
        tracing::warn!(run = runs, job, worker = %name, text = fail.text, "job given back");
        self.ledger.note_trouble(fail.job, &fail.text);
        self.workers.roster.left(worker, fail.job);
        let (job, epoch) = (Job(fail.job.0), Epoch(fail.epoch.0));
        self.step(Event::Fail { worker, job, epoch, trouble });
        Ok(())
    }

    fn send_piece(&self, query: Query, piece: Option<&[u8]>) -> Result<(), QuestionRefusal> {
        let Some(piece) = piece else {
            return answer(&query, &FetchAnswer::Gone);
        };
        let head = FetchAnswer::Chunk { sum: chunks::sum(piece) };
        self.transfers.bulk.send(query, pool::answer(&head, piece)?);
        Ok(())
    }
}

fn answer<T: Serialize>(query: &Query, said: &T) -> Result<(), QuestionRefusal> {
    reply(query, pool::answer(said, &[])?);
    Ok(())
}
