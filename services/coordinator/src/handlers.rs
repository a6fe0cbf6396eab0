//! Questions of people and programs, and their answers.

use super::board::{BoardEvent, MAX_KEPT, No, RunEntry, Submission};
use super::clients::Follower;
use super::error::ServiceError;
use super::journal;
use super::service::Service;
use cullet_files::clock::unix_ms;
use cullet_files::regular;
use cullet_pool::bundle;
use cullet_pool::users::{Parcel, UserQuery};
use cullet_proto::codec::WireError;
use cullet_proto::ids::digest;
use cullet_proto::keys::UserVerb;
use cullet_proto::service::{
    About, Drain, Drained, FetchFile, Fetched, Follow, MAX_TICKET, MAX_WAIT_MS, Noted, RunInfo,
    RunUpdate, Runs, State, Submit, SubmitAnswer, Which, WorkerInfo, Workers, digest_of, hex_of,
};
use cullet_proto::{WorkerId, chunks, envelope};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::time::{Duration, Instant};

/// Clients that may wait for news at one time; the oldest is answered at once beyond it.
const MAX_FOLLOWERS: usize = 1_024;
/// Most `path=value` arguments, and most bytes of one.
const MAX_OVERRIDES: usize = 1_024;
const MAX_OVERRIDE: usize = 4_096;
/// Most bytes of all of them: a run that is remembered holds them in memory.
const MAX_OVERRIDDEN: u64 = 65_536;

/// Why a question is not answered.
enum AnswerError {
    Unknown(String),
    Wrong(String),
    /// Not as long as something is so.
    Later(String),
    /// It cannot be read, or goes beyond a bound.
    Garbled(String),
}

impl From<No> for AnswerError {
    fn from(no: No) -> Self {
        match no {
            No::Unknown(_) | No::Gone(_) => Self::Unknown(no.to_string()),
            No::State { .. } | No::Full | No::Priority => Self::Wrong(no.to_string()),
        }
    }
}

impl From<WireError> for AnswerError {
    fn from(error: WireError) -> Self {
        Self::Garbled(error.to_string())
    }
}

impl From<ServiceError> for AnswerError {
    fn from(error: ServiceError) -> Self {
        match error {
            ServiceError::Full { .. } | ServiceError::Long { .. } => Self::Later(error.to_string()),
            _ => Self::Wrong(error.to_string()),
        }
    }
}

impl Service<'_> {
    /// Answers a question, or keeps it until there is news.
    pub(super) fn answer(&mut self, asked: UserQuery) {
        if asked.verb == UserVerb::Follow {
            self.follow(asked);
            return;
        }
        match self.try_answer(&asked) {
            Ok(()) => {}
            Err(AnswerError::Unknown(what)) => asked.unknown(what),
            Err(AnswerError::Wrong(why)) => asked.refuse(why),
            Err(AnswerError::Later(why)) => asked.later(why),
            Err(AnswerError::Garbled(why)) => self.clients.server.garbled(&asked, why),
        }
    }

    fn try_answer(&mut self, asked: &UserQuery) -> Result<(), AnswerError> {
        match asked.verb {
            UserVerb::About => asked.answer(&self.about()),
            UserVerb::Submit => {
                let said = self.submit(asked)?;
                asked.answer(&said);
            }
            UserVerb::Runs => {
                let entries: Vec<RunEntry> = self.board.entries().cloned().collect();
                let runs = entries.iter().map(|entry| brief(self.info(entry))).collect();
                asked.answer(&Runs { runs });
            }
            UserVerb::Run => {
                let Which { run } = asked.read()?.0;
                let entry = self.board.get(run)?.clone();
                asked.answer(&self.info(&entry));
            }
            UserVerb::Cancel | UserVerb::Pause | UserVerb::Resume | UserVerb::Retry => {
                let Which { run } = asked.read()?.0;
                self.may_control(&asked.user, asked.verb, run)?;
                let said = self.control(asked.verb, run)?;
                let (user, verb) = (asked.user.as_str(), asked.verb.word());
                tracing::info!(run, user, verb, "run controlled");
                asked.answer(&said);
            }
            UserVerb::Delete => {
                let Which { run } = asked.read()?.0;
                self.delete(&asked.user, run)?;
                asked.answer(&Noted { noted: true });
            }
            UserVerb::Fetch => self.fetch(asked)?,
            UserVerb::Bye => {
                let Which { run } = asked.read()?.0;
                self.clients.awaited.remove(&run);
                asked.answer(&Noted { noted: true });
            }
            UserVerb::Workers => {
                let after = asked.read()?.0;
                asked.answer(&Workers::page(self.workers(), &after));
            }
            UserVerb::Drain => {
                let Drain { worker } = asked.read()?.0;
                if !self.operates(&asked.user) {
                    return Err(AnswerError::Wrong("only an operator drains workers".to_owned()));
                }
                let Some(sessions) = self.drain(&worker) else {
                    return Err(AnswerError::Unknown(format!("there is no worker {worker:?}")));
                };
                asked.answer(&Drained { noted: true, sessions });
            }
            // The door takes the one, and [`Service::answer`] the other.
            UserVerb::Piece | UserVerb::Follow => {}
        }
        Ok(())
    }

    fn submit(&mut self, asked: &UserQuery) -> Result<SubmitAnswer, AnswerError> {
        let (submit, inline) = asked.read::<Submit>()?;
        check(&submit)?;
        let user = asked.user.to_string();
        if let Some(run) = self.board.known(&user, &submit.ticket) {
            self.clients.awaited.insert(run, Instant::now());
            return Ok(SubmitAnswer::Accepted { run });
        }
        // Before a bundle that came in pieces is taken out: it need not come again.
        if self.board.is_full(&user) {
            return Ok(SubmitAnswer::Busy);
        }
        let bytes = match &submit.digest {
            None => inline.to_vec(),
            Some(digest) => {
                match self.clients.server.take(&user, &digest_of(digest)?, submit.length)? {
                    Parcel::Whole(bytes) => bytes,
                    Parcel::Missing(pieces) => return Ok(SubmitAnswer::Missing { pieces }),
                    Parcel::Damaged => return Ok(SubmitAnswer::Damaged),
                }
            }
        };
        let bundle = bundle::decode(&bytes, &submit.overrides)
            .map_err(|error| AnswerError::Garbled(error.to_string()))?;
        let Submit { ticket, priority, overrides, sweep, .. } = submit;
        let (name, at) = (bundle.name, unix_ms());
        let digest = hex_of(&digest(&bytes));
        let order =
            Submission { ticket, user, name, sweep, priority, overrides, at, bundle: digest };
        let keep = self.config.keep.unwrap_or(MAX_KEPT);
        let events = self.board.submit(order, keep)?;
        let Some(BoardEvent::Submitted { run, .. }) = events.first() else {
            return Err(AnswerError::Wrong("the board took nothing".to_owned()));
        };
        let run = *run;
        let told = journal::size(&events);
        self.journal.room(told, &self.board)?;
        let need = bytes.len() as u64 + told;
        self.room(need)?;
        let place = (&self.storage.store, self.storage.out.as_path(), &self.journal);
        self.storage.quota.room((asked.user.as_str(), need), &self.board, place)?;
        let kept = self.storage.store.keep_bundle(run, &bytes).and_then(|()| self.record(&events));
        if let Err(error) = kept {
            let _swept_at_the_next_start = self.storage.store.forget(run);
            return Err(error.into());
        }
        self.prune();
        self.clients.awaited.insert(run, Instant::now());
        Ok(SubmitAnswer::Accepted { run })
    }

    /// Whether somebody may do what concerns others.
    fn operates(&self, user: &WorkerId) -> bool {
        self.config.operators.as_ref().is_none_or(|operators| operators.contains(user))
    }

    /// Whether a run is somebody's to control.
    fn may_control(&self, user: &WorkerId, verb: UserVerb, run: u64) -> Result<(), AnswerError> {
        let owner = &self.board.get(run)?.order.user;
        if *owner == user.as_str() || self.operates(user) {
            return Ok(());
        }
        let verb = verb.word();
        Err(AnswerError::Wrong(format!(
            "run {run} is of {owner}: {owner} or an operator may {verb} it"
        )))
    }

    fn control(&mut self, verb: UserVerb, run: u64) -> Result<RunInfo, AnswerError> {
        let at = unix_ms();
        let event = match verb {
            UserVerb::Pause => self.board.pause(run)?,
            UserVerb::Resume => self.board.resume(run)?,
            UserVerb::Retry => {
                let event = self.board.retry(run)?;
                // The pool would turn the job down that it has in quarantine.
                let given_up = self.runs.statuses.get(&run).and_then(|live| live.given_up());
                given_up.into_iter().for_each(|job| self.pool.pardon(job));
                event
            }
            _ => {
                let end = self.cut_short(run, "cancelled before it began");
                self.board.cancel(run, end, at)?
            }
        };
        if let Some(event) = event {
            self.record(std::slice::from_ref(&event))?;
            if let BoardEvent::Wished { .. } = event {
                self.stop_run(run);
            }
        }
        let entry = self.board.get(run)?.clone();
        Ok(self.info(&entry))
    }

    /// Deletes a run that is over; one that went already is nobody's any more.
    fn delete(&mut self, user: &WorkerId, run: u64) -> Result<(), AnswerError> {
        if self.board.get(run).is_ok() {
            self.may_control(user, UserVerb::Delete, run)?;
        }
        if let Some(event) = self.board.delete(run)? {
            self.record(std::slice::from_ref(&event))?;
            tracing::info!(run, %user, "run deleted");
            self.prune();
        }
        Ok(())
    }

    fn fetch(&mut self, asked: &UserQuery) -> Result<(), AnswerError> {
        let FetchFile { run, file, index } = asked.read()?.0;
        self.clients.awaited.insert(run, Instant::now());
        let entry = self.board.get(run)?;
        let listed = entry.end.files.iter().any(|known| known.name == file);
        let Some(folder) = entry.folder.as_ref().filter(|_| listed) else {
            return Err(AnswerError::Unknown(format!("run {run} has no file {file:?}")));
        };
        let path = self.storage.out.join(folder).join(&file);
        let piece = piece(&path, index)
            .map_err(|error| AnswerError::Unknown(format!("{file} is gone: {error}")))?;
        asked.answer_bulk(&Fetched { sum: chunks::sum(&piece) }, &piece);
        Ok(())
    }

    fn follow(&mut self, asked: UserQuery) {
        match asked.read::<Follow>() {
            Ok((follow, _)) => {
                self.clients.awaited.insert(follow.run, Instant::now());
                let wait = Duration::from_millis(follow.wait_ms.min(MAX_WAIT_MS));
                if self.clients.followers.len() >= MAX_FOLLOWERS {
                    self.clients.followers[0].until = Instant::now();
                }
                self.clients.followers.push(Follower {
                    asked,
                    follow,
                    until: Instant::now() + wait,
                });
            }
            Err(error) => self.clients.server.garbled(&asked, error),
        }
    }

    /// Answers those whose run has news, and those that have waited long enough.
    pub(super) fn answer_followers(&mut self) {
        for follower in std::mem::take(&mut self.clients.followers) {
            let Follower { asked, follow, until } = follower;
            let entry = match self.board.get(follow.run) {
                Ok(entry) => entry.clone(),
                Err(no) => {
                    self.clients.awaited.remove(&follow.run);
                    asked.unknown(no);
                    continue;
                }
            };
            let (lines, next, all) = self.status(follow.run).lines(follow.from);
            let end = all && entry.state.is_over();
            let leaving =
                self.leaving && self.storage.store.named().is_some() && !entry.state.is_over();
            if lines.is_empty() && !end && !leaving && Instant::now() < until {
                self.clients.followers.push(Follower { asked, follow, until });
                continue;
            }
            if leaving {
                self.clients.awaited.remove(&follow.run);
            }
            let run = self.info(&entry);
            asked.answer(&RunUpdate { run, lines, next, end, leaving });
        }
    }

    pub(super) fn info(&self, entry: &RunEntry) -> RunInfo {
        let running = entry.state == State::Running;
        let live = self.runs.statuses.get(&entry.run);
        let jobs = if entry.state.is_over() { entry.end.jobs } else { self.jobs(entry.run) };
        let order = &entry.order;
        RunInfo {
            run: entry.run,
            name: order.name.clone(),
            user: order.user.clone(),
            sweep: order.sweep.clone(),
            ticket: order.ticket.clone(),
            overrides: order.overrides.clone(),
            state: entry.state,
            priority: order.priority,
            attempt: entry.attempt,
            code: entry.end.code,
            text: entry.end.text.clone(),
            submitted_ms: order.at,
            started_ms: entry.started,
            ended_ms: entry.ended,
            files: entry.end.files.clone(),
            position: live.filter(|_| running).and_then(|live| live.position()),
            jobs,
        }
    }

    fn workers(&self) -> Vec<WorkerInfo> {
        self.pool.workers()
    }

    /// Those that are there under the name; nothing if nobody ever was.
    fn drain(&self, name: &str) -> Option<Vec<String>> {
        let mut known = self.workers();
        known.retain(|worker| worker.name == name);
        self.pool.drain(WorkerId::new(&known.first()?.name).ok()?);
        let up = known.into_iter().filter(|worker| worker.up);
        Some(up.map(|worker| worker.session).collect())
    }

    pub(super) fn about(&self) -> About {
        let state = self.storage.store.named();
        About {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            wire: envelope::MAJOR,
            now_ms: unix_ms(),
            up_ms: self.times.since.elapsed().as_millis() as u64,
            cores: std::thread::available_parallelism().map_or(1, |n| n.get() as u32),
            runs_at_once: self.config.runs as u32,
            state: state.map(|folder| folder.display().to_string()).unwrap_or_default(),
            free_bytes: self.storage.store.free_bytes(),
            workers: self.pool.stats().workers,
            queued: self.board.count(State::Queued) as u64,
            running: self.runs.going.len() as u64,
        }
    }
}

/// A run as a list of all has it: as many as are remembered fit into one line.
fn brief(mut info: RunInfo) -> RunInfo {
    info.ticket.clear();
    info.overrides.clear();
    info.files.clear();
    info.text.clear();
    info
}

fn check(submit: &Submit) -> Result<(), WireError> {
    use cullet_proto::codec::limit;
    let longest = submit.overrides.iter().map(String::len).max().unwrap_or(0);
    limit("a ticket's length", submit.ticket.len() as u64, MAX_TICKET as u64)?;
    limit("a sweep's name", submit.sweep.len() as u64, MAX_TICKET as u64)?;
    limit("overrides", submit.overrides.len() as u64, MAX_OVERRIDES as u64)?;
    limit("an override's length", longest as u64, MAX_OVERRIDE as u64)?;
    let all: usize = submit.overrides.iter().map(String::len).sum();
    limit("the overrides' length", all as u64, MAX_OVERRIDDEN)?;
    match submit.ticket.is_empty() {
        true => Err(WireError::Short { what: "a ticket", have: 0, need: 1 }),
        false => Ok(()),
    }
}

/// A piece of a file; beyond its end it is empty.
fn piece(path: &Path, index: u32) -> io::Result<Vec<u8>> {
    let mut file = regular::open(path)?;
    // Not every place is one that a disk can look for.
    let from = u64::from(index) * chunks::CHUNK as u64;
    file.seek(SeekFrom::Start(from.min(file.metadata()?.len())))?;
    let mut piece = Vec::new();
    file.take(chunks::CHUNK as u64).read_to_end(&mut piece)?;
    Ok(piece)
}

#[cfg(test)]
mod tests {
    use super::brief;
    use crate::board::MAX_KEPT;
    use cullet_proto::service::{
        FileInfo, JobCounts, MAX_LINE, MAX_TICKET, Position, RunInfo, Runs, State,
    };

    #[test]
    fn all_runs_that_are_remembered_fit_into_one_answer() {
        let file =
            |name: &str| FileInfo { name: name.into(), length: 1 << 40, digest: "f".repeat(64) };
        let run = RunInfo {
            run: u64::MAX,
            name: "n".repeat(200),
            user: "u".repeat(40),
            sweep: "\u{1}".repeat(MAX_TICKET),
            ticket: "\u{1}".repeat(MAX_TICKET),
            overrides: vec!["o".repeat(4_096); 16],
            state: State::Cancelled,
            priority: -100,
            attempt: u32::MAX,
            code: Some(130),
            text: "t".repeat(10_000),
            submitted_ms: 1 << 41,
            started_ms: Some(1 << 41),
            ended_ms: Some(1 << 41),
            files: vec![file("timeline.trace.json"); 8],
            position: None,
            jobs: JobCounts { opened: 1 << 20, settled: 1 << 20, kept: 1 << 20, resent: 1 << 20 },
        };
        let (time, many) = (1.0 / 3.0, 1 << 20);
        let permille = 1_000;
        let at = Position {
            time,
            end: time,
            bodies: many,
            fractures: many,
            jobs: many,
            permille,
            step: many,
            steps: many,
        };
        let all = Runs { runs: vec![brief(run.clone()); MAX_KEPT] };
        let length = serde_json::to_string(&all).expect("JSON").len();
        let going = brief(RunInfo { position: Some(at), ..run });
        // At most 64 go on.
        let more = 64 * serde_json::to_string(&going).expect("JSON").len();
        assert!(length + more <= MAX_LINE, "{length} and {more} bytes of {MAX_LINE}");
    }
}
