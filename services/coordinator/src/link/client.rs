//! The client's end: hand a scene in, follow it, fetch what came of it.

use super::{LinkError, bundle, net};
use cullet_proto::ids::digest;
use cullet_proto::keys::{self, UserVerb};
use cullet_proto::pool::{self, ChunkAnswer, FetchAnswer, FileEntry, State, Status, StatusAnswer};
use cullet_proto::pool::{Submit, SubmitAnswer};
use cullet_proto::transport::{self, Patience};
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
/// A coordinator that cannot be connected to within this is reported.
const CONNECT: Duration = Duration::from_secs(5);
/// Pause before a question is asked again.
const PAUSE: Duration = Duration::from_millis(200);

/// A client of a coordinator.
pub struct Client {
    session: zenoh::Session,
    endpoint: String,
    coordinator: WorkerId,
    user: WorkerId,
    patience: Duration,
}

/// A submission at a coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Handle {
    /// Its number there.
    pub id: u64,
}

/// How a submission ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// As the process would have returned it.
    pub code: u8,
    /// What can be fetched.
    pub files: Vec<FileEntry>,
}

impl Client {
    /// Connects, within five seconds.
    ///
    /// # Errors
    /// [`LinkError::Connect`], or a name that is none.
    pub fn connect(endpoint: &str) -> Result<Self, LinkError> {
        let (endpoints, timeout) = ([endpoint.to_owned()], CONNECT.as_millis() as u64);
        let settings = transport::client(&endpoints, Patience::production(), timeout);
        let session = net::open(&settings)
            .map_err(|text| LinkError::Connect { endpoint: endpoint.to_owned(), text })?;
        Ok(Self {
            session,
            endpoint: endpoint.to_owned(),
            coordinator: WorkerId::new(keys::DEFAULT_COORDINATOR)?,
            user: WorkerId::new("user")?,
            patience: PATIENCE,
        })
    }

    /// Asks for another coordinator, or for more or less patience than a minute.
    ///
    /// # Errors
    /// A name that is none.
    pub fn with(mut self, coordinator: &str, patience: Duration) -> Result<Self, LinkError> {
        self.coordinator = WorkerId::new(coordinator)?;
        self.patience = patience;
        Ok(self)
    }

    /// Hands in a bundle of files (relative paths, forward slashes). `ticket` names the submission:
    /// handing it in again with the same ticket gives the same submission.
    ///
    /// # Errors
    /// A path or size that may not be, a refusal, or silence.
    pub fn submit(
        &self,
        files: &[(String, Vec<u8>)],
        overrides: &[String],
        ticket: u64,
    ) -> Result<Handle, LinkError> {
        let blob = bundle::encode(files)?;
        let (digest, length) = (digest(&blob), blob.len() as u64);
        let overrides = overrides.to_vec();
        let submit = Submit { ticket, digest, length, overrides };
        let since = Instant::now();
        loop {
            let said: SubmitAnswer = self.ask(UserVerb::Submit, "a submission", &submit, &[])?.0;
            match said {
                SubmitAnswer::Accepted { id } => return Ok(Handle { id }),
                SubmitAnswer::Missing(missing) => self.upload(&blob, digest, &missing)?,
                SubmitAnswer::Damaged => {}
                SubmitAnswer::Busy if since.elapsed() > self.patience => {
                    return Err(LinkError::Refused("its queue is full".into()));
                }
                SubmitAnswer::Busy => std::thread::sleep(PAUSE),
                SubmitAnswer::Invalid(text) => return Err(LinkError::Refused(text)),
            }
        }
    }

    fn upload(&self, blob: &[u8], digest: [u8; 32], missing: &[u32]) -> Result<(), LinkError> {
        for &index in missing {
            let Some(piece) = chunks::slice(blob, index) else {
                continue;
            };
            let (length, sum) = (blob.len() as u64, chunks::sum(piece));
            let chunk = pool::Chunk { digest, length, index, sum };
            let said: ChunkAnswer =
                self.ask(UserVerb::Chunk, "a piece of a bundle", &chunk, piece)?.0;
            if said == ChunkAnswer::Busy {
                std::thread::sleep(PAUSE);
            }
        }
        Ok(())
    }

    /// Follows a submission to its end, a call for each progress line.
    ///
    /// # Errors
    /// A refusal, silence, or a submission that is not known there.
    pub fn follow(&self, handle: Handle, mut line: impl FnMut(&str)) -> Result<Outcome, LinkError> {
        let mut status = Status { id: handle.id, from: 0 };
        loop {
            let answer: StatusAnswer = self.ask(UserVerb::Status, "a status", &status, &[])?.0;
            answer.lines.iter().for_each(|text| line(text));
            status.from += answer.lines.len() as u64;
            match answer.state {
                State::Running => {}
                State::Over { code, files } => return Ok(Outcome { code, files }),
                State::Unknown => {
                    let (endpoint, id) = (self.endpoint.clone(), handle.id);
                    return Err(LinkError::Forgotten { endpoint, id });
                }
            }
        }
    }

    /// Fetches the files of a finished submission into `folder`. A file appears under its name only
    /// once it is whole and matches its digest.
    ///
    /// # Errors
    /// A path that may not be, a disk that does not take it, a file that does not match, silence.
    pub fn fetch(
        &self,
        handle: Handle,
        outcome: &Outcome,
        folder: &Path,
    ) -> Result<Vec<PathBuf>, LinkError> {
        let mut written = Vec::new();
        for (index, entry) in outcome.files.iter().enumerate() {
            bundle::check_path(&entry.path)?;
            let path = folder.join(&entry.path);
            self.fetch_file(handle, index as u32, entry, &path)?;
            written.push(path);
        }
        Ok(written)
    }

    /// Says that nothing more of a submission is wanted, so that a coordinator that is about to
    /// leave need not wait. If that is not heard, it waits a little longer.
    pub fn enough(&self, handle: Handle) {
        if let Ok(bytes) = pool::ask(&pool::Enough { id: handle.id }, &[]) {
            let _heard = self.ask_once(UserVerb::Bye, bytes, false);
        }
    }

    fn fetch_file(
        &self,
        handle: Handle,
        file: u32,
        entry: &FileEntry,
        path: &Path,
    ) -> Result<(), LinkError> {
        let failed = |source| LinkError::File { path: path.to_owned(), source };
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(failed)?;
        }
        let mut name = path.as_os_str().to_owned();
        name.push(".partial");
        let partial = PathBuf::from(name);
        let mut out = std::fs::File::create(&partial).map_err(failed)?;
        let mut hasher = blake3::Hasher::new();
        for index in 0..chunks::count(entry.length) {
            let piece = self.fetch_piece(handle.id, file, index, &entry.path)?;
            hasher.update(&piece);
            out.write_all(&piece).map_err(failed)?;
        }
        if *hasher.finalize().as_bytes() != entry.digest {
            let _gone_already = std::fs::remove_file(&partial);
            return Err(LinkError::Refused(format!("{} does not match its digest", entry.path)));
        }
        out.sync_all().map_err(failed)?;
        std::fs::rename(&partial, path).map_err(failed)
    }

    fn fetch_piece(
        &self,
        id: u64,
        file: u32,
        index: u32,
        path: &str,
    ) -> Result<Vec<u8>, LinkError> {
        let fetch = pool::FetchFile { id, file, index };
        let since = Instant::now();
        loop {
            let (said, piece) =
                self.ask::<_, FetchAnswer>(UserVerb::Fetch, "a file", &fetch, &[])?;
            match said {
                FetchAnswer::Chunk { sum } if sum == chunks::sum(&piece) => return Ok(piece),
                FetchAnswer::Chunk { .. } if since.elapsed() < self.patience => {}
                FetchAnswer::Chunk { .. } => {
                    return Err(LinkError::Refused(format!("{path} only comes damaged")));
                }
                FetchAnswer::Gone => {
                    return Err(LinkError::Refused(format!("{path} is gone there")));
                }
            }
        }
    }

    /// Asks until there is an answer: silence means anything, also "not connected yet".
    fn ask<Q: Serialize, A: DeserializeOwned>(
        &self,
        verb: UserVerb,
        what: &'static str,
        question: &Q,
        bulk: &[u8],
    ) -> Result<(A, Vec<u8>), LinkError> {
        let bytes = pool::ask(question, bulk)?;
        let since = Instant::now();
        while since.elapsed() < self.patience {
            match self.ask_once(verb, bytes.clone(), !bulk.is_empty()) {
                Some(Ok(bytes)) => {
                    let (answer, bulk) = pool::read_answer::<A>(&bytes)?;
                    return Ok((answer, bulk.to_vec()));
                }
                Some(Err(bytes)) => {
                    // A refusal that is none of ours is Zenoh's own: a timeout.
                    if let Ok(refusal) = pool::read_refusal(&bytes) {
                        return Err(LinkError::Refused(refusal.to_string()));
                    }
                }
                None => {}
            }
            std::thread::sleep(PAUSE);
        }
        let (endpoint, seconds) = (self.endpoint.clone(), self.patience.as_secs());
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
        let replies = self
            .session
            .get(key)
            .payload(bytes)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(priority)
            .timeout(ASK)
            .wait()
            .ok()?;
        let reply = replies.recv().ok()?;
        Some(match reply.into_result() {
            Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
            Err(error) => Err(error.payload().to_bytes().into_owned()),
        })
    }
}

/// Connects and hands in a bundle; see [`Client::submit`].
///
/// # Errors
/// As [`Client::connect`] and [`Client::submit`].
pub fn submit(
    endpoint: &str,
    files: &[(String, Vec<u8>)],
    overrides: &[String],
    ticket: u64,
) -> Result<(Client, Handle), LinkError> {
    let client = Client::connect(endpoint)?;
    let handle = client.submit(files, overrides, ticket)?;
    Ok((client, handle))
}
