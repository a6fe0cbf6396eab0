//! The desk where clients hand in scenes and fetch what came of them.

use super::bundle;
use super::shell::Input;
use cullet_proto::chunks;
use cullet_proto::ids::digest;
use cullet_proto::pool::{FetchFile, FileEntry, MAX_LINES, State, Status, StatusAnswer};
use cullet_proto::pool::{Submit, SubmitAnswer};
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Submissions that may wait; a further one is told to come again.
const MAX_WAITING: usize = 16;
/// Submissions remembered; the oldest finished one is forgotten first.
const MAX_KEPT: usize = 256;
/// Progress lines kept of each submission; the newest stay.
const MAX_KEPT_LINES: usize = 4_096;
/// Longest progress line \[bytes\]; with [`MAX_LINES`] of them an answer stays under the limit.
const MAX_LINE: usize = 400;

/// A scene that a client wants run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submission {
    /// Its number here.
    pub id: u64,
    /// Its files: relative paths with forward slashes, and their bytes.
    pub bundle: Vec<(String, Vec<u8>)>,
    /// `path=value` over the scene's own.
    pub overrides: Vec<String>,
}

/// A file to fetch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// Its bytes.
    Bytes(Vec<u8>),
    /// Where it lies. It must not change from now on.
    Path(PathBuf),
}

#[derive(Debug, Default)]
struct Entry {
    ticket: u64,
    digest: [u8; 32],
    lines: VecDeque<String>,
    dropped: u64,
    over: Option<(u8, Vec<(FileEntry, Content)>)>,
    /// When its client last asked about it; nothing once the client has all that it wants.
    asked: Option<Instant>,
}

#[derive(Debug, Default)]
struct Board {
    next: u64,
    waiting: VecDeque<Submission>,
    entries: BTreeMap<u64, Entry>,
}

/// The desk; clones are the same desk.
#[derive(Clone, Debug)]
pub struct Submissions {
    board: Arc<Mutex<Board>>,
    inputs: SyncSender<Input>,
}

impl Submissions {
    pub(super) fn new(inputs: SyncSender<Input>) -> Self {
        Self { board: Arc::default(), inputs }
    }

    fn board(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next submission to run, if there is one.
    #[must_use]
    pub fn next(&self) -> Option<Submission> {
        self.board().waiting.pop_front()
    }

    /// Adds a progress line for the client that follows.
    pub fn progress(&self, id: u64, line: &str) {
        if let Some(entry) = self.board().entries.get_mut(&id) {
            let end = line.floor_char_boundary(MAX_LINE);
            entry.lines.push_back(line[..end].to_owned());
            while entry.lines.len() > MAX_KEPT_LINES {
                entry.lines.pop_front();
                entry.dropped += 1;
            }
        }
        // A full queue is looked through soon in any case.
        let _full = self.inputs.try_send(Input::News);
    }

    /// Ends a submission: exit code, and the files to fetch (name, content). A file that cannot be
    /// read is left out, with a line that says so.
    pub fn finish(&self, id: u64, files: Vec<(String, Content)>, code: u8) {
        let mut listed = Vec::new();
        for (path, content) in files.into_iter().take(cullet_proto::pool::MAX_FILES) {
            match bundle::check_path(&path).map_err(|e| e.to_string()).and_then(|()| sum(&content))
            {
                Ok((length, digest)) => listed.push((FileEntry { path, length, digest }, content)),
                Err(why) => self.progress(id, &format!("{path} is left out: {why}")),
            }
        }
        if let Some(entry) = self.board().entries.get_mut(&id) {
            entry.over = Some((code, listed));
        }
        let _full = self.inputs.try_send(Input::News);
    }

    /// Whether a client that asked within that time has not yet got all that it wants.
    #[must_use]
    pub fn awaited(&self, within: Duration) -> bool {
        let lately = |entry: &Entry| entry.asked.is_some_and(|asked| asked.elapsed() < within);
        self.board().entries.values().any(lately)
    }

    /// A client asks about its submission.
    pub(super) fn asked(&self, id: u64) {
        if let Some(entry) = self.board().entries.get_mut(&id) {
            entry.asked = Some(Instant::now());
        }
    }

    /// A client has all that it wants.
    pub(super) fn enough(&self, id: u64) {
        if let Some(entry) = self.board().entries.get_mut(&id) {
            entry.asked = None;
        }
    }

    /// The number of a submission that was handed in before.
    pub(super) fn known(&self, ticket: u64, digest: &[u8; 32]) -> Option<u64> {
        let board = self.board();
        let same = |entry: &Entry| entry.ticket == ticket && entry.digest == *digest;
        board.entries.iter().find(|(_, entry)| same(entry)).map(|(id, _)| *id)
    }

    /// Takes a submission in.
    pub(super) fn submit(&self, submit: Submit, bytes: &[u8]) -> SubmitAnswer {
        let bundle = match bundle::decode(bytes) {
            Ok(bundle) => bundle,
            Err(error) => return SubmitAnswer::Invalid(error.to_string()),
        };
        let mut board = self.board();
        if board.waiting.len() >= MAX_WAITING {
            return SubmitAnswer::Busy;
        }
        board.next += 1;
        let id = board.next;
        board.waiting.push_back(Submission { id, bundle, overrides: submit.overrides });
        let (ticket, digest) = (submit.ticket, submit.digest);
        let asked = Some(Instant::now());
        board.entries.insert(id, Entry { ticket, digest, asked, ..Entry::default() });
        while board.entries.len() > MAX_KEPT {
            let oldest = board.entries.iter().find(|(_, entry)| entry.over.is_some());
            let Some(oldest) = oldest.map(|(id, _)| *id) else {
                break;
            };
            board.entries.remove(&oldest);
        }
        SubmitAnswer::Accepted { id }
    }

    /// How a submission stands, if that is news to the client or `late`.
    pub(super) fn status(&self, status: &Status, late: bool) -> Option<StatusAnswer> {
        let board = self.board();
        let Some(entry) = board.entries.get(&status.id) else {
            return Some(StatusAnswer { state: State::Unknown, lines: Vec::new() });
        };
        let skip = status.from.saturating_sub(entry.dropped) as usize;
        let lines: Vec<_> = entry.lines.iter().skip(skip).take(MAX_LINES).cloned().collect();
        let seen = skip + lines.len() >= entry.lines.len();
        let state = match &entry.over {
            Some((code, files)) if seen => {
                let files = files.iter().map(|(entry, _)| entry.clone()).collect();
                State::Over { code: *code, files }
            }
            Some(_) | None => State::Running,
        };
        let news = late || !lines.is_empty() || state != State::Running;
        news.then_some(StatusAnswer { state, lines })
    }

    /// A piece of a file of a finished submission.
    pub(super) fn piece(&self, fetch: &FetchFile) -> Option<Vec<u8>> {
        let (entry, content) = {
            let board = self.board();
            let (_, files) = board.entries.get(&fetch.id)?.over.as_ref()?;
            files.get(fetch.file as usize)?.clone()
        };
        match content {
            Content::Bytes(bytes) => chunks::slice(&bytes, fetch.index).map(<[u8]>::to_vec),
            Content::Path(path) => {
                let from = u64::from(fetch.index) * chunks::CHUNK as u64;
                if from >= entry.length {
                    return (fetch.index == 0).then(Vec::new);
                }
                let mut file = File::open(path).ok()?;
                file.seek(SeekFrom::Start(from)).ok()?;
                let mut piece = Vec::new();
                file.take(chunks::CHUNK as u64).read_to_end(&mut piece).ok()?;
                Some(piece)
            }
        }
    }
}

fn sum(content: &Content) -> Result<(u64, [u8; 32]), String> {
    match content {
        Content::Bytes(bytes) => Ok((bytes.len() as u64, digest(bytes))),
        Content::Path(path) => {
            let mut hasher = blake3::Hasher::new();
            let file = File::open(path).map_err(|e| e.to_string())?;
            let length = std::io::copy(&mut std::io::BufReader::new(file), &mut hasher)
                .map_err(|e| e.to_string())?;
            Ok((length, *hasher.finalize().as_bytes()))
        }
    }
}
