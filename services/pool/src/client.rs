//! The client's end: hand a scene in, follow it, fetch what came of it.

use super::error::LinkError;
use super::fetching::{Fetching, beside};
use super::{bundle, net};
use cullet_document::Bundle;
use cullet_proto::ids::digest;
use cullet_proto::keys::{self, UserVerb};
use cullet_proto::security::Rules;
use cullet_proto::service::{
    self, BundlePiece, ErrorReply, FetchFile, Fetched, FileInfo, Follow, MAX_INLINE, PieceAnswer,
    RunInfo, RunUpdate, Submit, SubmitAnswer, Which,
};
use cullet_proto::transport::Patience;
use cullet_proto::{WorkerId, chunks};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::ConsolidationMode;

/// A question is given up and asked again after this.
const ASK: Duration = Duration::from_secs(10);
/// A coordinator that has not answered for this long is reported as silent.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause before a question is asked again.
const PAUSE: Duration = Duration::from_millis(200);
/// Longest pause before a full queue is asked again: each time a small bundle goes along.
const LONG_PAUSE: Duration = Duration::from_secs(2);
/// Answers in a row that cannot be read, after which it is not the link that damages them.
const UNREAD: u32 = 3;
/// Longest wait for news of a run \[ms\].
const NEWS_MS: u64 = 1_000;

/// A client of a coordinator.
pub struct Client {
    session: zenoh::Session,
    endpoint: String,
    coordinator: WorkerId,
    user: WorkerId,
    patience: Duration,
}

/// What a submission is beside its bundle.
#[derive(Clone, Debug, Default)]
pub struct Terms {
    /// The sender's own name for it: the same ticket is the same run.
    pub ticket: String,
    /// Higher ones go first.
    pub priority: i32,
    /// The sweep that it belongs to.
    pub sweep: String,
    /// How long a full queue is asked for room; `None`: as long as the client is patient.
    pub room: Option<Duration>,
}

impl Client {
    /// Connects, with the patience of a minute.
    ///
    /// # Errors
    /// As [`Client::connect_as`].
    pub fn connect(endpoint: &str) -> Result<Self, LinkError> {
        Self::connect_as(endpoint, &Rules::new(), PATIENCE)
    }

    /// Connects with an identity. `patience`: for how long it tries to, and then for how long it
    /// asks for each answer.
    ///
    /// # Errors
    /// [`LinkError::Connect`].
    pub fn connect_as(
        endpoint: &str,
        identity: &Rules,
        patience: Duration,
    ) -> Result<Self, LinkError> {
        Ok(Self {
            session: net::connected(endpoint, Patience::production(), identity, patience)?,
            endpoint: endpoint.to_owned(),
            coordinator: WorkerId::new(keys::DEFAULT_COORDINATOR)?,
            user: WorkerId::new("user")?,
            patience,
        })
    }

    /// Asks another coordinator, or under another name.
    ///
    /// # Errors
    /// A name that is none.
    pub fn with(mut self, coordinator: &str, user: &str) -> Result<Self, LinkError> {
        self.coordinator = WorkerId::new(coordinator)?;
        self.user = WorkerId::new(user)?;
        Ok(self)
    }

    /// Who asks.
    #[must_use]
    pub fn user(&self) -> &str {
        self.user.as_str()
    }

    /// Hands in a scene with its files. Handed in again with the same ticket, it is the same run.
    ///
    /// # Errors
    /// A path or size that may not be, a refusal, silence, or [`LinkError::Busy`] where the queue
    /// stays full.
    pub fn submit(&self, bundle: &Bundle, terms: &Terms) -> Result<u64, LinkError> {
        let blob = bundle::encode(bundle)?;
        let name = (blob.len() > MAX_INLINE).then(|| digest(&blob));
        let Terms { ticket, priority, sweep, room } = terms.clone();
        let room = room.unwrap_or(self.patience);
        let submit = Submit {
            ticket,
            priority,
            overrides: bundle.overrides.clone(),
            sweep,
            digest: name.as_ref().map(service::hex_of),
            length: blob.len() as u64,
        };
        let inline = if name.is_none() { &blob[..] } else { &[] };
        let (since, mut pause) = (Instant::now(), PAUSE);
        loop {
            match self.ask(UserVerb::Submit, "a submission", &submit, inline)?.0 {
                SubmitAnswer::Accepted { run } => return Ok(run),
                SubmitAnswer::Missing { pieces } => {
                    for index in pieces {
                        self.upload(&blob, submit.digest.as_deref().unwrap_or_default(), index)?;
                    }
                }
                SubmitAnswer::Damaged => {}
                SubmitAnswer::Busy => {
                    let left = room.saturating_sub(since.elapsed());
                    if left.is_zero() {
                        let (endpoint, seconds) = (self.endpoint.clone(), room.as_secs_f64());
                        return Err(LinkError::Busy { endpoint, seconds });
                    }
                    std::thread::sleep(pause.min(left));
                    pause = (pause * 2).min(LONG_PAUSE);
                }
            }
        }
    }

    fn upload(&self, blob: &[u8], digest: &str, index: u32) -> Result<(), LinkError> {
        let Some(bytes) = chunks::slice(blob, index) else {
            return Ok(());
        };
        let (digest, length) = (digest.to_owned(), blob.len() as u64);
        let piece = BundlePiece { digest, length, index, sum: Some(chunks::sum(bytes)) };
        let said: PieceAnswer = self.ask(UserVerb::Piece, "a piece of a bundle", &piece, bytes)?.0;
        if said == PieceAnswer::Busy {
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    /// Asks something that has no bulk.
    ///
    /// # Errors
    /// A refusal or silence.
    pub fn question<Q: Serialize, A: DeserializeOwned>(
        &self,
        verb: UserVerb,
        question: &Q,
    ) -> Result<A, LinkError> {
        Ok(self.ask(verb, verb.word(), question, &[])?.0)
    }

    /// What is known of a run.
    ///
    /// # Errors
    /// A refusal or silence.
    pub fn run(&self, run: u64) -> Result<RunInfo, LinkError> {
        self.question(UserVerb::Run, &Which { run })
    }

    /// News of a run from a line on; waits a second for them.
    ///
    /// # Errors
    /// A refusal, silence, or a run that is not known there.
    pub fn news(&self, run: u64, from: u64) -> Result<RunUpdate, LinkError> {
        self.question(UserVerb::Follow, &Follow { run, from, wait_ms: NEWS_MS })
    }

    /// Follows a run from a line on until it is over or paused, a call for each piece of news.
    ///
    /// # Errors
    /// As [`Client::news`]; [`LinkError::Left`] if the coordinator is about to end.
    pub fn follow(
        &self,
        run: u64,
        mut from: u64,
        mut tell: impl FnMut(&RunUpdate),
    ) -> Result<RunInfo, LinkError> {
        loop {
            let news = self.news(run, from)?;
            tell(&news);
            from = news.next;
            if news.end {
                return Ok(news.run);
            }
            if news.leaving {
                return Err(LinkError::Left { endpoint: self.endpoint.clone(), run });
            }
        }
    }

    /// Fetches the files of a run that is over into `folder`. A file appears under its name only
    /// once it is whole and matches its digest. Where that was broken off it goes on with what is
    /// not there yet.
    ///
    /// # Errors
    /// A path that may not be, a disk that does not take it, a file that does not match, silence, a
    /// folder that has another run.
    pub fn fetch(&self, run: &RunInfo, folder: &Path) -> Result<Vec<PathBuf>, LinkError> {
        let mut written = Vec::new();
        let row = |file: &FileInfo| format!("{} {}\n", file.digest, file.name);
        let rows: String = run.files.iter().map(row).collect();
        let fetching = Fetching::begin(folder, &format!("run {}\n{rows}", run.run))?;
        for file in &run.files {
            bundle::check_path(&file.name).map_err(|error| garbled(&error))?;
            let path = folder.join(&file.name);
            if !is_there(file, &path) {
                self.fetch_file(run.run, file, &path)?;
            }
            written.push(path);
        }
        fetching.done()?;
        Ok(written)
    }

    /// Says that nothing more of a run is wanted, so that a coordinator that is about to leave need
    /// not wait. If that is not heard, it waits a little longer.
    pub fn enough(&self, run: u64) {
        if let Ok(bytes) = service::seal(&Which { run }, &[]) {
            let _heard = self.ask_once(UserVerb::Bye, bytes, false);
        }
    }

    fn fetch_file(&self, run: u64, file: &FileInfo, path: &Path) -> Result<(), LinkError> {
        let failed = |source| LinkError::File { path: path.to_owned(), source };
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(failed)?;
        }
        let partial = beside(path);
        let mut out = std::fs::File::create(&partial).map_err(failed)?;
        let mut hasher = blake3::Hasher::new();
        for index in 0..chunks::count(file.length) {
            let piece = self.fetch_piece(run, file, index)?;
            hasher.update(&piece);
            out.write_all(&piece).map_err(failed)?;
        }
        let digest = service::digest_of(&file.digest).map_err(|error| garbled(&error))?;
        if digest != *hasher.finalize().as_bytes() {
            let _gone_already = std::fs::remove_file(&partial);
            return Err(LinkError::Garbled(format!("{} does not match its digest", file.name)));
        }
        out.sync_all().map_err(failed)?;
        std::fs::rename(&partial, path).map_err(failed)
    }

    fn fetch_piece(&self, run: u64, file: &FileInfo, index: u32) -> Result<Vec<u8>, LinkError> {
        let fetch = FetchFile { run, file: file.name.clone(), index };
        let since = Instant::now();
        while since.elapsed() < self.patience {
            let (said, piece) = self.ask::<_, Fetched>(UserVerb::Fetch, "a file", &fetch, &[])?;
            if said.sum == chunks::sum(&piece) {
                return Ok(piece);
            }
        }
        Err(LinkError::Garbled(format!("{} only comes damaged", file.name)))
    }

    /// Asks until there is an answer: silence means anything, also "not connected yet".
    fn ask<Q: Serialize, A: DeserializeOwned>(
        &self,
        verb: UserVerb,
        what: &'static str,
        question: &Q,
        bulk: &[u8],
    ) -> Result<(A, Vec<u8>), LinkError> {
        let bytes = service::seal(question, bulk)?;
        let (since, mut unread) = (Instant::now(), 0);
        while since.elapsed() < self.patience {
            match self.ask_once(verb, bytes.clone(), !bulk.is_empty()) {
                Some(Ok(bytes)) => match service::open::<A>(&bytes) {
                    Ok((answer, bulk)) => return Ok((answer, bulk.to_vec())),
                    Err(error) if unread + 1 == UNREAD => return Err(garbled(&error)),
                    Err(_) => unread += 1,
                },
                Some(Err(bytes)) => {
                    // A refusal that is none of ours is Zenoh's own: a timeout.
                    if let Ok((ErrorReply { error, unknown, later }, _)) = service::open(&bytes) {
                        return Err(match (unknown, later) {
                            (true, _) => LinkError::Unknown(error),
                            (false, true) => LinkError::Later(error),
                            (false, false) => LinkError::Refused(error),
                        });
                    }
                }
                None => {}
            }
            std::thread::sleep(PAUSE);
        }
        let (endpoint, seconds) = (self.endpoint.clone(), self.patience.as_secs_f64());
        Err(LinkError::Silent { endpoint, what, seconds })
    }

    fn ask_once(
        &self,
        verb: UserVerb,
        bytes: Vec<u8>,
        bulk: bool,
    ) -> Option<Result<Vec<u8>, Vec<u8>>> {
        let key = keys::user_rpc(&self.coordinator, &self.user, verb);
        let fetch = verb == UserVerb::Fetch;
        let priority = if bulk || fetch { Priority::DataLow } else { Priority::InteractiveHigh };
        // The transport's own channel calls it an error if nobody takes a second answer.
        let (send, replies) = std::sync::mpsc::channel();
        self.session
            .get(key)
            .payload(bytes)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(priority)
            .timeout(ASK)
            .callback(move |reply| drop(send.send(reply)))
            .wait()
            .ok()?;
        let reply = replies.recv().ok()?;
        Some(match reply.into_result() {
            Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
            Err(error) => Err(error.payload().to_bytes().into_owned()),
        })
    }
}

/// Whether a file is there and what it should be.
fn is_there(file: &FileInfo, path: &Path) -> bool {
    let mut hasher = blake3::Hasher::new();
    let read = std::fs::File::open(path).and_then(|bytes| hasher.update_reader(bytes).map(drop));
    read.is_ok() && service::hex_of(hasher.finalize().as_bytes()) == file.digest
}

fn garbled(error: &impl std::fmt::Display) -> LinkError {
    LinkError::Garbled(error.to_string())
}
