//! What a worker asks, one question at a time, and what it makes of the answers.

use crate::link::{CoordinatorLink, NoAnswer};
use crate::meshes::{Fetcher, Meshes};
use crate::solve::JobControl;
use cullet_dispatch::{Digest, Epoch, Job, Question, Trouble, Work, WorkerInput};
use cullet_proto::keys::WorkerVerb;
use cullet_proto::pool::{
    self, Acknowledged, ChunkAnswer, CommitAnswer, Grant, PollAnswer, QuestionRefusal,
};
use cullet_proto::pool::{GiveBackReason as Told, HeedAnswer, RenewAnswer};
use cullet_proto::{JobId, chunks, window};
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender};
use std::thread;
use std::time::{Duration, Instant};

/// Pause before a piece is sent again to a coordinator that has no room.
const BUSY: Duration = Duration::from_secs(1);

/// Silence of this length on a link that is up is worth a word.
const UNHEARD: Duration = Duration::from_secs(5);

/// A task for the thread that talks to the coordinator.
pub(crate) enum TalkerTask {
    /// Ask this; the text goes with a job given back, the blob with a commit.
    Ask(Question, String, Arc<Vec<u8>>),
    /// Get a job's bytes.
    Fetch(Grant, JobControl),
}

/// The result of a [`TalkerTask`].
pub(crate) struct TalkerResult {
    pub(crate) heard: WorkerInput,
    /// The grant that was heard of.
    pub(crate) grant: Option<Grant>,
    /// A job's bytes, or a verdict's.
    pub(crate) bytes: Vec<u8>,
    /// Words about trouble.
    pub(crate) text: String,
}

impl TalkerResult {
    pub(crate) fn of(heard: WorkerInput) -> Self {
        Self { heard, grant: None, bytes: Vec::new(), text: String::new() }
    }

    fn trouble(epoch: Epoch, trouble: Trouble, text: String) -> Self {
        Self { text, ..Self::of(WorkerInput::Trouble { epoch, trouble }) }
    }
}

pub(crate) fn work_of(grant: &Grant) -> Work {
    let (job, epoch) = (Job(grant.job.0), Epoch(grant.epoch.0));
    Work { job, epoch, renew: grant.renew_ms.max(1), hard: grant.hard_ms }
}

/// The talker's thread: until the orders end.
pub(crate) struct Talker {
    pub(crate) line: Arc<CoordinatorLink>,
    /// What it says first.
    pub(crate) hello: Arc<pool::Hello>,
    /// Whether it has.
    pub(crate) known: Cell<bool>,
    /// Since when nobody has answered; whether that was logged.
    pub(crate) unheard: Cell<Option<(Instant, bool)>>,
    pub(crate) stop: Arc<AtomicBool>,
    pub(crate) news: Sender<TalkerResult>,
}

impl Talker {
    pub(crate) fn run(&self, orders: &Receiver<TalkerTask>, mut meshes: Meshes) {
        for order in orders {
            let news = match order {
                TalkerTask::Ask(question, text, blob) => {
                    let news = self.ask(question, text, &blob);
                    if let WorkerInput::Receipt { .. } = news.heard
                        && let Some(state) = window::state_of(&blob)
                    {
                        meshes.keep(state);
                    }
                    news
                }
                TalkerTask::Fetch(grant, watch) => self.fetch(&grant, &watch, &mut meshes),
            };
            if self.news.send(news).is_err() {
                return;
            }
        }
    }

    fn poll_of(&self, seq: u64) -> pool::Poll {
        pool::Poll { session: self.line.session, seq, slots: 1, threads: self.hello.threads }
    }

    fn ask(&self, question: Question, text: String, blob: &[u8]) -> TalkerResult {
        let session = self.line.session;
        let answer = match question {
            Question::Poll { seq } => self.poll(seq),
            Question::Renew { job, epoch, begun } => self.renew((job, epoch), u16::from(begun)),
            Question::Commit { job, epoch, digest, next } => {
                self.commit((job, epoch), digest, blob, next)
            }
            Question::Fail { job, epoch, trouble } => {
                let trouble = match trouble {
                    Trouble::Crashed => Told::Crashed,
                    Trouble::Dropped => Told::Dropped,
                    Trouble::Invalid => Told::Invalid,
                };
                let (job, epoch) = (JobId(job.0), cullet_proto::Epoch(epoch.0));
                let fail = pool::Fail { session, job, epoch, trouble, text };
                let ask = || self.line.ask::<_, Acknowledged>(WorkerVerb::Fail, &fail, &[]);
                self.again(ask).map(|_| TalkerResult::of(WorkerInput::Noted))
            }
            Question::Bye => {
                let said =
                    self.line.ask::<_, Acknowledged>(WorkerVerb::Bye, &pool::Bye { session }, &[]);
                said.map(|_| TalkerResult::of(WorkerInput::Noted))
            }
        };
        if !matches!(answer, Err(NoAnswer::Silence)) {
            self.unheard.set(None);
        }
        answer.unwrap_or_else(|error| match error {
            NoAnswer::Silence => {
                self.tell_silence();
                TalkerResult::of(WorkerInput::Silence(question))
            }
            NoAnswer::Refused(refusal) => {
                tracing::error!("refused: {refusal}");
                TalkerResult::of(WorkerInput::Refused(question))
            }
            NoAnswer::Unreadable(text) => {
                tracing::error!("an answer is unreadable: {text}");
                TalkerResult::of(WorkerInput::Refused(question))
            }
        })
    }

    /// Says once that nobody answers on a link that is up.
    fn tell_silence(&self) {
        let (since, told) = self.unheard.get().unwrap_or((Instant::now(), false));
        self.unheard.set(Some((since, told)));
        if !told
            && since.elapsed() >= UNHEARD
            && let Some(text) = self.line.unheard()
        {
            self.unheard.set(Some((since, true)));
            tracing::warn!("{text}");
        }
    }

    /// Tells the coordinator who asks.
    fn introduce(&self) -> Result<(), NoAnswer> {
        let said = self.line.ask::<_, Acknowledged>(WorkerVerb::Hello, self.hello.as_ref(), &[]);
        said.map(|_| self.known.set(true))
    }

    /// Asks, once the coordinator knows who does.
    fn introduced<A>(&self, ask: impl Fn() -> Result<A, NoAnswer>) -> Result<A, NoAnswer> {
        if !self.known.get() {
            self.introduce()?;
        }
        self.again(ask)
    }

    /// Asks; if the coordinator has forgotten who does, tells it and asks again.
    fn again<A>(&self, ask: impl Fn() -> Result<A, NoAnswer>) -> Result<A, NoAnswer> {
        match ask() {
            Err(NoAnswer::Refused(QuestionRefusal::Stranger)) => {
                self.introduce().and_then(|()| ask())
            }
            said => said,
        }
    }

    fn poll(&self, seq: u64) -> Result<TalkerResult, NoAnswer> {
        let poll = self.poll_of(seq);
        // A question for work may be held for long and is nothing to wait for when leaving.
        let ask = || self.line.ask_unless(&self.stop, WorkerVerb::Poll, &poll, &[]);
        let (said, _) = self.introduced(ask)?;
        Ok(match said {
            PollAnswer::Grant(grant) => {
                let heard = WorkerInput::Grant { seq, work: work_of(&grant) };
                TalkerResult { grant: Some(grant), ..TalkerResult::of(heard) }
            }
            PollAnswer::Idle => TalkerResult::of(WorkerInput::Idle { seq }),
            PollAnswer::Drain => TalkerResult::of(WorkerInput::Dismiss { seq }),
        })
    }

    /// Says how far a job is; the answer is "stop", or nothing.
    pub(crate) fn renew(
        &self,
        (job, epoch): (Job, Epoch),
        permille: u16,
    ) -> Result<TalkerResult, NoAnswer> {
        let (session, told) = (self.line.session, cullet_proto::Epoch(epoch.0));
        let renew = pool::Renew { session, job: JobId(job.0), epoch: told, permille };
        let (said, _) = self.again(|| self.line.ask(WorkerVerb::Renew, &renew, &[]))?;
        Ok(TalkerResult::of(match said {
            RenewAnswer::Stop => WorkerInput::Stop { epoch },
            RenewAnswer::Go { .. } => WorkerInput::Tick,
        }))
    }

    /// Asks to be told when a job is not wanted any more, until `over`: whether it is so. Nothing
    /// where there was no answer, and an error where asking again is of no use.
    pub(crate) fn watch_for_cancel(
        &self,
        (job, epoch): (Job, Epoch),
        over: &AtomicBool,
    ) -> Result<Option<bool>, NoAnswer> {
        let (session, epoch) = (self.line.session, cullet_proto::Epoch(epoch.0));
        let heed = pool::Heed { session, job: JobId(job.0), epoch };
        match self.again(|| self.line.ask_unless(over, WorkerVerb::Heed, &heed, &[])) {
            Ok((HeedAnswer::Stop, _)) => Ok(Some(true)),
            Ok((HeedAnswer::Go, _)) => Ok(Some(false)),
            Err(NoAnswer::Silence | NoAnswer::Refused(QuestionRefusal::Stranger)) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// Hands a result in. What the coordinator lacks is sent when it says so, so nothing is sent
    /// that is not needed.
    fn commit(
        &self,
        (job, epoch): (Job, Epoch),
        digest: Digest,
        blob: &[u8],
        next: u64,
    ) -> Result<TalkerResult, NoAnswer> {
        let commit = pool::Commit {
            session: self.line.session,
            job: JobId(job.0),
            epoch: cullet_proto::Epoch(epoch.0),
            digest: digest.0,
            length: blob.len() as u64,
            next: Some(self.poll_of(next)),
        };
        loop {
            let ask = || self.line.ask(WorkerVerb::Commit, &commit, &[]);
            match self.introduced(ask)?.0 {
                CommitAnswer::Done(grant) => {
                    let next = grant.as_ref().map(work_of);
                    return Ok(TalkerResult {
                        grant,
                        ..TalkerResult::of(WorkerInput::Receipt { epoch, next })
                    });
                }
                CommitAnswer::Missing(missing) => self.send(blob, digest.0, &missing)?,
                CommitAnswer::Damaged => tracing::warn!("a result came over damaged"),
                CommitAnswer::Unreadable(text) => {
                    return Ok(TalkerResult::trouble(epoch, Trouble::Crashed, text));
                }
            }
        }
    }

    fn send(&self, blob: &[u8], name: [u8; 32], indices: &[u32]) -> Result<(), NoAnswer> {
        for &index in indices {
            let Some(piece) = chunks::slice(blob, index) else {
                continue;
            };
            let (length, sum) = (blob.len() as u64, chunks::sum(piece));
            let chunk = pool::Chunk { digest: name, length, index, sum };
            loop {
                let (said, _) = self.line.ask(WorkerVerb::Chunk, &chunk, piece)?;
                match said {
                    ChunkAnswer::Have => break,
                    ChunkAnswer::Damaged => {}
                    ChunkAnswer::Busy => thread::sleep(BUSY),
                }
                if self.stop.load(Ordering::Relaxed) {
                    return Err(NoAnswer::Silence);
                }
            }
        }
        Ok(())
    }

    fn fetch(&self, grant: &Grant, watch: &JobControl, meshes: &mut Meshes) -> TalkerResult {
        let epoch = Epoch(grant.epoch.0);
        let ask = |fetch: pool::FetchBlob| self.line.ask(WorkerVerb::Fetch, &fetch, &[]);
        let stop = || watch.cancelled();
        match (Fetcher { meshes, ask: &ask, stop: &stop }).job(grant) {
            Ok(bytes) => TalkerResult { bytes, ..TalkerResult::of(WorkerInput::Fetched { epoch }) },
            Err((trouble, text)) => TalkerResult::trouble(epoch, trouble, text),
        }
    }
}
