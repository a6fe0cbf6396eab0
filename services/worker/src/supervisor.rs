//! The talking half of a worker.

use crate::link::{Line, NoAnswer};
use crate::solve::{SolveFn, Watch, guarded};
use crate::{EXIT_WEDGED, WorkerConfig, WorkerError};
use cullet_proto::ids::digest;
use cullet_proto::keys::WorkerVerb;
use cullet_proto::pool::{self, ChunkAnswer, CommitAnswer, FetchAnswer, Grant, Noted, PollAnswer};
use cullet_proto::pool::{RenewAnswer, Trouble};
use cullet_proto::{FractureJob, JobId, SessionId, Verdict, chunks};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// First pause after silence; doubles up to [`LAST_PAUSE`].
const FIRST_PAUSE: Duration = Duration::from_millis(20);
/// Longest pause after silence.
const LAST_PAUSE: Duration = Duration::from_secs(1);
/// Refusals of one question after which it is not asked again: the next would be refused too.
const MAX_REFUSALS: u32 = 5;
/// How often a waiting supervisor looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(50);
/// Past the hard limit a slice may still end by itself within this.
const GRACE: Duration = Duration::from_secs(5);
/// Stack of a solver's thread \[bytes\]: recursion over meshes is deeper than the default bears.
const STACK: usize = 16 << 20;
/// Longest a leave may wait for its answer.
const FAREWELL: Duration = Duration::from_secs(1);

/// How a job at hand went on.
enum Ended {
    /// With a verdict.
    Solved(Verdict),
    /// Nobody wants it any more.
    Unwanted,
    /// With this trouble.
    Trouble(Trouble, String),
}

pub(crate) struct Supervisor {
    config: WorkerConfig,
    solve: SolveFn,
    line: Line,
    threads: Arc<ThreadPool>,
    seq: u64,
}

impl Supervisor {
    /// Waits for the coordinator; nothing if it is to stop before.
    pub(crate) fn open(config: WorkerConfig, solve: SolveFn) -> Result<Option<Self>, WorkerError> {
        let threads = Arc::new(start_threads(config.threads)?);
        let line = Line::open(&config, draw_session())?;
        Ok(line.map(|line| Self { config, solve, line, threads, seq: 0 }))
    }

    /// Asks for jobs and does them until told to stop or drained.
    pub(crate) fn work(mut self) {
        let mut next = None;
        while !self.stopped() {
            let grant = match next.take() {
                Some(grant) => grant,
                None => match self.poll() {
                    Some(PollAnswer::Grant(grant)) => grant,
                    Some(PollAnswer::Idle) => continue,
                    Some(PollAnswer::Drain) | None => break,
                },
            };
            next = self.serve(grant);
        }
        self.leave();
    }

    fn leave(self) {
        let bye = pool::Bye { session: self.line.session };
        let since = Instant::now();
        while since.elapsed() < FAREWELL {
            if self.line.ask::<_, Noted>(WorkerVerb::Bye, &bye, &[]).is_ok() {
                break;
            }
            thread::sleep(FIRST_PAUSE);
        }
        self.line.close();
    }

    fn stopped(&self) -> bool {
        self.config.stop.load(Ordering::Relaxed)
    }

    fn question(&mut self) -> pool::Poll {
        self.seq += 1;
        let threads = self.config.threads as u32;
        pool::Poll { session: self.line.session, seq: self.seq, slots: 1, threads }
    }

    fn poll(&mut self) -> Option<PollAnswer> {
        let poll = self.question();
        self.insist(WorkerVerb::Poll, &poll, &[]).map(|(answer, _)| answer)
    }

    /// Asks until there is an answer; `None` once told to stop, or refused for good: then the lease
    /// runs out and another worker takes the job. A poll is never given up: the coordinator behind
    /// the name may change.
    fn insist<Q: Serialize, A: DeserializeOwned>(
        &self,
        verb: WorkerVerb,
        question: &Q,
        bulk: &[u8],
    ) -> Option<(A, Vec<u8>)> {
        let (mut pause, mut refused) = (FIRST_PAUSE, 0);
        let poll = verb == WorkerVerb::Poll;
        // A question for work may be held for long and is nothing to wait for when leaving.
        let go_on = AtomicBool::new(false);
        let stop = if poll { &*self.config.stop } else { &go_on };
        while !self.stopped() && (refused < MAX_REFUSALS || poll) {
            match self.line.ask_unless(stop, verb, question, bulk) {
                Ok(answer) => return Some(answer),
                Err(NoAnswer::Silence) => {}
                Err(NoAnswer::Refused(refusal)) => {
                    tracing::error!("{}: {refusal}", verb.word());
                    (pause, refused) = (LAST_PAUSE, refused + 1);
                }
                Err(NoAnswer::Unreadable(text)) => {
                    tracing::error!("the answer to {} is unreadable: {text}", verb.word());
                    (pause, refused) = (LAST_PAUSE, refused + 1);
                }
            }
            thread::sleep(pause);
            pause = (pause * 2).min(LAST_PAUSE);
        }
        None
    }

    /// Does one job; the next one may come with the receipt.
    fn serve(&mut self, grant: Grant) -> Option<Grant> {
        let next = self.question();
        let this = &*self;
        let watch = Watch::default();
        thread::scope(|scope| {
            // Renewals go on, also while the result is handed in, until this end is dropped.
            let (_end, ended) = channel::<()>();
            let seen = watch.clone();
            scope.spawn(move || this.renew(&grant, &seen, &ended));
            let (trouble, text) = match this.solve(&grant, &watch) {
                Ended::Solved(verdict) => match verdict.encode() {
                    Ok(blob) => return this.hand_in(&grant, &blob, next),
                    Err(e) => (Trouble::Invalid, format!("its verdict cannot be sent: {e}")),
                },
                Ended::Unwanted => return None,
                Ended::Trouble(trouble, text) => (trouble, text),
            };
            this.give_back(&grant, trouble, text);
            None
        })
    }

    fn renew(&self, grant: &Grant, watch: &Watch, ended: &Receiver<()>) {
        let every = Duration::from_millis(grant.renew_ms.max(1));
        while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(every) {
            let (session, permille) = (self.line.session, watch.permille());
            let renew = pool::Renew { session, job: grant.job, epoch: grant.epoch, permille };
            match self.line.ask(WorkerVerb::Renew, &renew, &[]) {
                Ok((RenewAnswer::Stop, _)) => return watch.cancel(),
                // Silence is nothing to act on: the result will be handed in in any case.
                Ok((RenewAnswer::Go { .. }, _)) | Err(_) => {}
            }
        }
    }

    fn solve(&self, grant: &Grant, watch: &Watch) -> Ended {
        let deadline = Instant::now() + Duration::from_millis(grant.hard_ms);
        let job = match self.fetch(grant, watch) {
            Ok(job) => job,
            Err(ended) => return ended,
        };
        let (send, receive) = channel();
        let (solve, threads, seen) =
            (Arc::clone(&self.solve), Arc::clone(&self.threads), watch.clone());
        let spawned = thread::Builder::new().name("cullet-job".into()).spawn(move || {
            // Nobody listens if the job was given up meanwhile.
            let _given_up = send.send(threads.install(|| guarded(&solve, &job, &seen)));
        });
        if let Err(error) = spawned {
            return Ended::Trouble(Trouble::Dropped, format!("no thread: {error}"));
        }
        self.wait(&receive, watch, deadline)
    }

    fn wait(&self, job: &Receiver<Option<Verdict>>, watch: &Watch, deadline: Instant) -> Ended {
        loop {
            match job.recv_timeout(LOOK) {
                Ok(Some(verdict)) => return Ended::Solved(verdict),
                Ok(None) if Instant::now() < deadline => return Ended::Unwanted,
                Ok(None) => {
                    return Ended::Trouble(Trouble::Crashed, "over the hard limit".into());
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Ended::Trouble(Trouble::Crashed, "the job's thread died".into());
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            let now = Instant::now();
            if self.stopped() {
                // The slice at hand may take long; it ends with the process.
                watch.cancel();
                return Ended::Trouble(Trouble::Dropped, "the worker stops".into());
            }
            if now >= deadline {
                watch.cancel();
            }
            if now >= deadline + GRACE {
                return self.wedged();
            }
        }
    }

    fn wedged(&self) -> Ended {
        tracing::error!("the solver hangs past the hard limit");
        if self.config.exit_when_wedged {
            std::process::exit(EXIT_WEDGED);
        }
        Ended::Trouble(Trouble::Crashed, "the solver hangs past the hard limit".into())
    }

    fn fetch(&self, grant: &Grant, watch: &Watch) -> Result<FractureJob, Ended> {
        let dropped = |text: &str| Ended::Trouble(Trouble::Dropped, text.to_owned());
        if grant.length > chunks::MAX_BLOB {
            return Err(Ended::Trouble(Trouble::Invalid, "it is too long".into()));
        }
        let mut bytes = Vec::new();
        for index in 0..chunks::count(grant.length) {
            loop {
                if watch.cancelled() {
                    return Err(Ended::Unwanted);
                }
                let fetch = pool::Fetch { job: grant.job, index };
                let Some((answer, piece)) = self.insist(WorkerVerb::Fetch, &fetch, &[]) else {
                    return Err(dropped("the worker stops"));
                };
                match answer {
                    FetchAnswer::Chunk { sum } if sum == chunks::sum(&piece) => {
                        bytes.extend_from_slice(&piece);
                        break;
                    }
                    FetchAnswer::Chunk { .. } => {}
                    FetchAnswer::Gone => return Err(dropped("its bytes are gone")),
                }
            }
        }
        if JobId::of(&bytes) != grant.job {
            return Err(dropped("its bytes do not match its id"));
        }
        FractureJob::decode(&bytes)
            .map_err(|error| Ended::Trouble(Trouble::Invalid, error.to_string()))
    }

    fn send(&self, blob: &[u8], name: [u8; 32], indices: &[u32]) {
        for &index in indices {
            let Some(piece) = chunks::slice(blob, index) else {
                continue;
            };
            let (length, sum) = (blob.len() as u64, chunks::sum(piece));
            let chunk = pool::Chunk { digest: name, length, index, sum };
            loop {
                let Some((answer, _)) = self.insist(WorkerVerb::Chunk, &chunk, piece) else {
                    return;
                };
                match answer {
                    ChunkAnswer::Have => break,
                    ChunkAnswer::Damaged => {}
                    ChunkAnswer::Busy => thread::sleep(LAST_PAUSE),
                }
            }
        }
    }

    /// Hands the result in until it has a receipt: however long the coordinator is away. What the
    /// coordinator lacks is sent when it says so, so nothing is sent that is not needed.
    fn hand_in(&self, grant: &Grant, blob: &[u8], next: pool::Poll) -> Option<Grant> {
        let name = digest(blob);
        let commit = pool::Commit {
            session: self.line.session,
            job: grant.job,
            epoch: grant.epoch,
            digest: name,
            length: blob.len() as u64,
            next: Some(next),
        };
        loop {
            let (answer, _) = self.insist::<_, CommitAnswer>(WorkerVerb::Commit, &commit, &[])?;
            match answer {
                CommitAnswer::Done(next) => return next,
                CommitAnswer::Missing(missing) => self.send(blob, name, &missing),
                CommitAnswer::Damaged => tracing::warn!("a result came over damaged"),
                CommitAnswer::Unreadable(text) => {
                    self.give_back(grant, Trouble::Crashed, text);
                    return None;
                }
            }
        }
    }

    fn give_back(&self, grant: &Grant, trouble: Trouble, text: String) {
        tracing::warn!("job {} is given back: {text}", grant.job.short());
        let (session, job, epoch) = (self.line.session, grant.job, grant.epoch);
        let fail = pool::Fail { session, job, epoch, trouble, text };
        let once = self.stopped();
        while self.line.ask::<_, Noted>(WorkerVerb::Fail, &fail, &[]).is_err() {
            if once || self.stopped() {
                return;
            }
            thread::sleep(LAST_PAUSE);
        }
    }
}

fn start_threads(threads: usize) -> Result<ThreadPool, WorkerError> {
    ThreadPoolBuilder::new()
        .num_threads(threads.max(1))
        .stack_size(STACK)
        .thread_name(|index| format!("cullet-solve-{index}"))
        .build()
        .map_err(|error| WorkerError::Threads { threads, text: error.to_string() })
}

/// A number that no other life of a worker has: time, process and a counter, well mixed.
fn draw_session() -> SessionId {
    use std::hash::{BuildHasher, Hasher, RandomState};
    let mut hasher = RandomState::new().build_hasher();
    hasher.write_u32(std::process::id());
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    hasher.write_u128(since.map_or(0, |since| since.as_nanos()));
    SessionId(hasher.finish())
}
