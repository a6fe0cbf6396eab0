//! Questions of people and programs to a coordinator, and its answers: JSON, so that any language
//! can ask them. `docs/protocol.md` says it for those who do not read Rust.
//!
//! A message is one line of JSON; behind the line's end come bulk bytes, if there are any.

mod workers;

pub use workers::{Drain, Drained, WorkerInfo, Workers, WorkersAfter};

use crate::codec::{WireError, limit};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Most bytes of the line of JSON of one message.
pub const MAX_LINE: usize = 4 << 20;
/// Most bytes of a bundle that may come with its [`Submit`]; a larger one is sent in pieces first.
pub const MAX_INLINE: usize = 1 << 20;
/// Longest time that a [`Follow`] waits for news \[ms\], and most lines in its answer.
pub const MAX_WAIT_MS: u64 = 5_000;
/// See [`MAX_WAIT_MS`].
pub const MAX_LINES: usize = 256;
/// Longest ticket, and longest name of a sweep \[bytes\].
pub const MAX_TICKET: usize = 64;
/// Priorities are from minus this to this.
pub const MAX_PRIORITY: i32 = 100;

/// How a run ends, as the exit code of `cullet run` and of `cullet wait`: up to [`codes::UNKEPT`];
/// and how a command ends that could not do its work.
pub mod codes {
    /// It is done.
    pub const DONE: u8 = 0;
    /// Something that was looked at is not well.
    pub const UNWELL: u8 = 1;
    /// Its world broke down.
    pub const FAILED: u8 = 2;
    /// It is done, and an expectation of the scene does not hold.
    pub const UNMET: u8 = 3;
    /// It is done, and a picture could not be drawn.
    pub const UNPICTURED: u8 = 4;
    /// Somebody did not want it any more.
    pub const CANCELLED: u8 = 5;
    /// A job of it was given up by the pool.
    pub const STALLED: u8 = 6;
    /// Its scene is wrong, as the coordinator found.
    pub const UNFIT: u8 = 7;
    /// A file of it could not be read or written, or may not be.
    pub const UNKEPT: u8 = 8;
    /// The arguments, a scene or a mesh are wrong.
    pub const USAGE: u8 = 64;
    /// What was named is not there.
    pub const UNKNOWN: u8 = 66;
    /// No coordinator answers, or it leaves.
    pub const UNREACHABLE: u8 = 69;
    /// The machine gives no thread, process or address, or there is a defect.
    pub const BROKEN: u8 = 70;
    /// A file of the command could not be read or written.
    pub const FILE: u8 = 74;
    /// Not now: the queue or the disk is full, or the run is not over yet.
    pub const LATER: u8 = 75;
    /// What the coordinator sends is not sound.
    pub const GARBLED: u8 = 76;
    /// The coordinator says no.
    pub const REFUSED: u8 = 77;
    /// It was interrupted.
    pub const INTERRUPTED: u8 = 130;
}

/// Why a command could not do its work, where programs go by it: `cause` of an error as JSON.
pub mod causes {
    /// A motion of the world is not a number any more.
    pub const NOT_FINITE: &str = "not-finite";
}

/// Where a run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// It waits for its turn.
    Queued,
    /// It goes on.
    Running,
    /// It waits until somebody says `resume`.
    Paused,
    /// It came to its end.
    Done,
    /// It could not go on.
    Failed,
    /// A job of it was given up by the pool; `retry` puts it back into the queue.
    Stalled,
    /// Somebody did not want it any more.
    Cancelled,
}

impl State {
    /// Whether nothing more happens to it by itself.
    #[must_use]
    pub fn is_over(self) -> bool {
        match self {
            Self::Done | Self::Failed | Self::Stalled | Self::Cancelled => true,
            Self::Queued | Self::Running | Self::Paused => false,
        }
    }

    /// Its word, as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Stalled => "stalled",
            Self::Cancelled => "cancelled",
        }
    }
}

/// A piece of a bundle that is too large for its [`Submit`]; the piece is the bulk.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BundlePiece {
    /// The blake3 digest of the whole bundle, in hex.
    pub digest: String,
    /// Bytes of the whole bundle.
    pub length: u64,
    /// Which piece: bytes from `index` MiB on.
    pub index: u32,
    /// The piece's CRC-32C; without one only the whole is checked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sum: Option<u32>,
}

/// The answer to a [`BundlePiece`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "piece", rename_all = "lowercase")]
pub enum PieceAnswer {
    /// It is here.
    Have,
    /// It was damaged on the way: send it again.
    Damaged,
    /// There is no room now: try later.
    Busy,
}

/// A scene to run. Without `digest` the bundle is the bulk.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Submit {
    /// The sender's own name for it: the same ticket of the same user is the same run.
    pub ticket: String,
    /// Higher ones go first.
    #[serde(default)]
    pub priority: i32,
    /// `path=value` over the scene's own.
    #[serde(default)]
    pub overrides: Vec<String>,
    /// The sweep that it belongs to.
    #[serde(default)]
    pub sweep: String,
    /// The blake3 digest, in hex, of a bundle that came in pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
    /// Its bytes.
    #[serde(default)]
    pub length: u64,
}

/// The answer to a [`Submit`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "submit", rename_all = "lowercase")]
pub enum SubmitAnswer {
    /// It is kept, under this number.
    Accepted {
        /// The number.
        run: u64,
    },
    /// These pieces are not here (perhaps more).
    Missing {
        /// The pieces concerned.
        pieces: Vec<u32>,
    },
    /// The bundle does not match its digest: send all of it again.
    Damaged,
    /// The queue is full: try later.
    Busy,
}

/// What is in a bundle: the line of JSON in front of the bytes of its files, one after another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BundleTable {
    /// What the scene is called: part of a folder's name.
    pub name: String,
    /// The key of the scene file.
    pub main: String,
    /// Every file.
    pub files: Vec<BundleFile>,
}

/// A file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BundleFile {
    /// What the scene calls it.
    pub key: String,
    /// Its bytes.
    pub length: u64,
}

/// Which run. Asked with `run`, `cancel`, `pause`, `resume`, `retry`, `delete` and `bye`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// Its number.
    pub run: u64,
}

/// How a run goes on: answered as soon as there is news, or after `wait_ms`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Follow {
    /// Its number.
    pub run: u64,
    /// The first line not yet seen.
    #[serde(default)]
    pub from: u64,
    /// Longest wait \[ms\], at most [`MAX_WAIT_MS`].
    #[serde(default)]
    pub wait_ms: u64,
}

/// The answer to a [`Follow`]: where the run stands, and its next lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunUpdate {
    /// The run.
    pub run: RunInfo,
    /// Lines from the one asked for on.
    pub lines: Vec<String>,
    /// What to ask for next.
    pub next: u64,
    /// There is nothing after `next`, and nothing more will come unless the run is taken up again.
    pub end: bool,
    /// The coordinator is about to end; a run that is not over goes on when it is back.
    pub leaving: bool,
}

/// A run, as its coordinator knows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunInfo {
    /// Its number.
    pub run: u64,
    /// The scene's name.
    pub name: String,
    /// Whose it is.
    pub user: String,
    /// The sweep that it belongs to; empty without one.
    pub sweep: String,
    /// The sender's own name for the submission.
    #[serde(default)]
    pub ticket: String,
    /// `path=value` over the scene's own.
    pub overrides: Vec<String>,
    /// Where it stands.
    pub state: State,
    /// Its priority.
    pub priority: i32,
    /// How often it was started.
    pub attempt: u32,
    /// As `cullet run` would have ended, once it is over.
    pub code: Option<u8>,
    /// Why it is not done, if it is over and is not.
    pub text: String,
    /// When it was handed in \[ms since 1970\].
    pub submitted_ms: u64,
    /// When it was last started \[ms since 1970\].
    pub started_ms: Option<u64>,
    /// When it ended \[ms since 1970\].
    pub ended_ms: Option<u64>,
    /// What can be fetched, once it is over.
    pub files: Vec<FileInfo>,
    /// How far it is, while it runs.
    pub position: Option<Position>,
    /// Its fracture jobs, of the attempt at hand.
    pub jobs: JobCounts,
}

/// A file to fetch.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileInfo {
    /// Its name.
    pub name: String,
    /// Its bytes.
    pub length: u64,
    /// Their blake3 digest, in hex.
    pub digest: String,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Simulated time \[s\].
    pub time: f64,
    /// Simulated time at which it ends \[s\].
    pub end: f64,
    /// Bodies in the world.
    pub bodies: u64,
    /// Fractures so far.
    pub fractures: u64,
    /// Fracture jobs that it waits for, at workers or not yet.
    #[serde(default)]
    pub jobs: u64,
    /// How far those at workers are, in the mean \[1/1000\]; 0 where none is.
    #[serde(default)]
    pub permille: u16,
    /// Steps of the world that are taken.
    #[serde(default)]
    pub step: u64,
    /// Steps until its end; 0 where that is not told.
    #[serde(default)]
    pub steps: u64,
}

/// Fracture jobs of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobCounts {
    /// Wanted so far.
    pub opened: u64,
    /// Of these, over.
    pub settled: u64,
    /// Of these, answered from what an earlier attempt had kept, or from the pool's cache.
    pub kept: u64,
    /// Attempts beyond a job's first.
    pub resent: u64,
}

/// A question without words: `about`, `runs` and `workers`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Nothing {}

/// The answer to `runs`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Runs {
    /// Every run that is remembered, by number.
    pub runs: Vec<RunInfo>,
}

/// A request for a piece of a file of a run that is over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FetchFile {
    /// Of which run.
    pub run: u64,
    /// The file concerned.
    pub file: String,
    /// Which piece: bytes from `index` MiB on.
    pub index: u32,
}

/// The answer to a [`FetchFile`]; the piece is the bulk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fetched {
    /// The piece's CRC-32C.
    pub sum: u32,
}

/// The answer to `delete` and to `bye`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Noted {
    /// Always true.
    pub noted: bool,
}

/// The answer to `about`: what a coordinator is and has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Its version.
    pub version: String,
    /// The generation of the wire that it speaks.
    pub wire: u16,
    /// Its clock \[ms since 1970\].
    pub now_ms: u64,
    /// How long it has been there \[ms\].
    pub up_ms: u64,
    /// Its cores.
    pub cores: u32,
    /// Runs that it runs at once.
    pub runs_at_once: u32,
    /// Where it keeps its state; empty if it forgets everything when it ends.
    pub state: String,
    /// Bytes that may still be written there, if it can tell.
    pub free_bytes: Option<u64>,
    /// Workers whose link is up.
    pub workers: u64,
    /// Runs that wait.
    pub queued: u64,
    /// Runs that go on.
    pub running: u64,
}

/// Why a question was not answered: the error reply's line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ErrorReply {
    /// In words.
    pub error: String,
    /// Whether what was named is not there.
    #[serde(default)]
    pub unknown: bool,
    /// Whether the same may be answered otherwise later.
    #[serde(default)]
    pub later: bool,
}

/// The bytes of a message.
///
/// # Errors
/// [`WireError::Header`] if it cannot be written, [`WireError::Limit`] over [`MAX_LINE`].
pub fn seal<T: Serialize>(head: &T, bulk: &[u8]) -> Result<Vec<u8>, WireError> {
    let mut out = serde_json::to_vec(head).map_err(|e| WireError::Header(e.to_string()))?;
    limit("a line of JSON", out.len() as u64, MAX_LINE as u64)?;
    out.reserve_exact(bulk.len() + 1);
    if !bulk.is_empty() {
        out.push(b'\n');
        out.extend_from_slice(bulk);
    }
    Ok(out)
}

/// The head and the bulk of a message; no bytes at all are an empty head.
///
/// # Errors
/// [`WireError::Limit`] over [`MAX_LINE`], [`WireError::Header`] with what is wrong with the line.
pub fn open<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), WireError> {
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    limit("a line of JSON", end as u64, MAX_LINE as u64)?;
    let line = if end == 0 { b"{}" } else { &bytes[..end] };
    let head = serde_json::from_slice(line).map_err(|e| WireError::Header(e.to_string()))?;
    Ok((head, bytes.get(end + 1..).unwrap_or_default()))
}

/// The digest in this text.
///
/// # Errors
/// [`WireError::Header`] where there are not 64 hex digits.
pub fn digest_of(hex: &str) -> Result<[u8; 32], WireError> {
    let wrong = || WireError::Header("a digest is 64 hex digits".to_owned());
    let mut out = [0; 32];
    if hex.len() != 64 || !hex.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return Err(wrong());
    }
    for (index, byte) in out.iter_mut().enumerate() {
        *byte = u8::from_str_radix(&hex[2 * index..2 * index + 2], 16).map_err(|_| wrong())?;
    }
    Ok(out)
}

/// The text of a digest.
#[must_use]
pub fn hex_of(digest: &[u8; 32]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
