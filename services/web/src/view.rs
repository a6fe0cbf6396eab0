//! What the page shows of a farm at a moment.

use axum::body::Bytes;
use cullet_proto::service::{FileInfo, RunInfo, WorkerInfo};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Longest text of a run, most of its overrides, the longest of them and of other texts. Bytes are
/// those that a text has in JSON, where a control character has six. What is cut ends with [`CUT`];
/// the protocol has the whole.
const MAX_TEXT: usize = 600;
const MAX_OVERRIDES: usize = 12;
const MAX_OVERRIDE: usize = 150;
const MAX_WORD: usize = 400;
const CUT: &str = "…";
/// Most bytes of JSON of all workers that are shown.
const MAX_WORKERS: usize = 1 << 20;

/// What the owner of a farm knows of it, as it is published.
#[derive(Clone, Debug, Default)]
pub struct FarmNews {
    /// The coordinator's name; empty: a run on this machine without one.
    pub name: String,
    /// The version of its program.
    pub version: String,
    /// Its clock \[ms since 1970\].
    pub now_ms: u64,
    /// How long it has been there \[ms\].
    pub up_ms: u64,
    /// Runs that it does at once.
    pub runs_at_once: u32,
    /// Bytes that may still be written where it keeps its runs.
    pub free_bytes: Option<u64>,
    /// Jobs that wait for a worker.
    pub jobs_waiting: u64,
    /// Jobs at workers.
    pub jobs_running: u64,
    /// Every run that is remembered.
    pub runs: Vec<RunNews>,
    /// Every worker that is known.
    pub workers: Vec<WorkerInfo>,
}

/// A run, as it is published.
#[derive(Clone, Debug, PartialEq)]
pub struct RunNews {
    /// What its coordinator tells of it.
    pub info: RunInfo,
    /// Where it records, if it has begun.
    pub folder: Option<PathBuf>,
    /// The last line of its log.
    pub line: String,
}

/// A farm at a moment, as watchers get it. All of them share one, with the JSON of its runs and
/// workers, which is made once.
#[derive(Clone, Debug, Default)]
pub struct FarmView {
    /// What changes all the time.
    pub(crate) clock: ClockView,
    /// Whether it is about to end.
    pub(crate) leaving: bool,
    /// Every run by its number.
    pub(crate) runs: BTreeMap<u64, Arc<RunView>>,
    /// The workers, by name.
    pub(crate) workers: Arc<WorkerViews>,
}

/// The part of a farm that is different at each look.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct ClockView {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) now_ms: u64,
    pub(crate) up_ms: u64,
    pub(crate) runs_at_once: u32,
    pub(crate) free_bytes: Option<u64>,
    pub(crate) jobs_waiting: u64,
    pub(crate) jobs_running: u64,
}

/// A run, as watchers get it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunView {
    /// As its coordinator tells it, with long texts cut.
    #[serde(flatten)]
    pub(crate) info: RunInfo,
    /// The last line of its log.
    pub(crate) line: String,
    /// What it came to, once it is over and that is known.
    pub(crate) figures: Option<RunFigures>,
    /// Which picture there is of it: a word that changes with it.
    pub(crate) picture: Option<String>,
    /// Whether there is a recording of which a report can be made.
    pub(crate) report: bool,
    #[serde(skip)]
    pub(crate) folder: Option<PathBuf>,
    #[serde(skip)]
    pub(crate) files: Vec<FileInfo>,
    /// All of it that is shown, as JSON.
    #[serde(skip)]
    pub(crate) json: Bytes,
}

/// What a run came to: part of its `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RunFigures {
    /// The digest of its results, in hex.
    pub digest: String,
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s\].
    pub sim_seconds: f64,
    /// Wall time \[s\].
    pub wall_seconds: f64,
    /// Replacements of a body by fragments.
    pub fractures: u64,
    /// Fragments made.
    pub fragments: u64,
    /// Grains of debris made.
    pub grains: u64,
    /// Bodies left at the end.
    pub bodies_final: u64,
}

/// A worker, as watchers get it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorkerView {
    /// As its coordinator tells it.
    #[serde(flatten)]
    pub(crate) info: WorkerInfo,
    /// When its link was last seen up \[ms since 1970\]; `null`: it is up.
    pub(crate) gone_ms: Option<u64>,
}

/// Workers, as watchers get them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WorkerViews {
    pub(crate) all: Vec<WorkerView>,
    /// The same as JSON.
    pub(crate) json: Bytes,
}

impl Default for WorkerViews {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl WorkerViews {
    /// As many as have room; those that are there come before those that are gone.
    pub(crate) fn new(mut all: Vec<WorkerView>) -> Self {
        all.sort_by_key(|worker| worker.gone_ms.is_some());
        let mut bytes = 0;
        let size = |worker: &WorkerView| serde_json::to_vec(worker).map_or(0, |text| text.len());
        let room = all.iter().take_while(|worker| {
            bytes += size(worker);
            bytes <= MAX_WORKERS
        });
        let count = room.count();
        all.truncate(count);
        let key = |worker: &WorkerView| (worker.info.name.clone(), worker.info.session.clone());
        all.sort_by_cached_key(key);
        let json = serde_json::to_vec(&all).unwrap_or_else(|_| b"[]".to_vec()).into();
        Self { all, json }
    }
}

/// The bytes of a picture.
pub(crate) type Png = Arc<Vec<u8>>;

/// What is known of a run beside what is published of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct RunExtras {
    /// Of which attempt and end it is known.
    pub(crate) of: (u32, Option<u64>),
    pub(crate) figures: Option<RunFigures>,
    /// The newest picture of the run while it goes on, and its number.
    pub(crate) still: Option<(u64, Png)>,
}

/// The picture of a run that is over.
pub(crate) const SHEET: &str = "preview.png";
/// A recording that is complete.
pub(crate) const RECORDING: &str = "run.mcap";

impl RunView {
    pub(crate) fn new(news: RunNews, extras: Option<&RunExtras>) -> Self {
        let RunNews { mut info, folder, mut line } = news;
        let files = std::mem::take(&mut info.files);
        let has = |name: &str| files.iter().any(|file| file.name == name);
        let extras = extras.filter(|extras| extras.of == (info.attempt, info.ended_ms));
        let still = extras.and_then(|extras| extras.still.as_ref());
        let still = still.map(|(number, _)| format!("{}-{number}", info.attempt));
        let sheet = || format!("end-{}", info.ended_ms.unwrap_or_default());
        let picture = if has(SHEET) { Some(sheet()) } else { still };
        let report = info.state.is_over() && has(RECORDING);
        let figures = extras.and_then(|extras| extras.figures.clone());
        info.ticket.clear();
        cut(&mut info.text, MAX_TEXT);
        for text in [&mut info.name, &mut info.sweep, &mut line] {
            cut(text, MAX_WORD);
        }
        info.overrides.iter_mut().for_each(|text| cut(text, MAX_OVERRIDE));
        if info.overrides.len() > MAX_OVERRIDES {
            info.overrides.truncate(MAX_OVERRIDES - 1);
            info.overrides.push(CUT.to_owned());
        }
        let json = Bytes::new();
        let mut view = Self { info, line, figures, picture, report, folder, files, json };
        view.json = serde_json::to_vec(&view).unwrap_or_else(|_| b"null".to_vec()).into();
        view
    }
}

/// Cuts a text to that many bytes of JSON, and marks the cut.
fn cut(text: &mut String, most: usize) {
    let (mut bytes, mut end) = (0, 0);
    for (at, c) in text.char_indices() {
        if bytes <= most - CUT.len() {
            end = at;
        }
        bytes += match c {
            '"' | '\\' | '\n' | '\r' | '\t' | '\u{8}' | '\u{c}' => 2,
            '\0'..' ' => 6,
            _ => c.len_utf8(),
        };
        if bytes > most {
            text.truncate(end);
            text.push_str(CUT);
            return;
        }
    }
}

/// JSON of several things in one list, of which each is JSON.
pub(crate) fn list<'a>(all: impl IntoIterator<Item = &'a Bytes>) -> Vec<u8> {
    let mut text = vec![b'['];
    for (at, one) in all.into_iter().enumerate() {
        if at > 0 {
            text.push(b',');
        }
        text.extend_from_slice(one);
    }
    text.push(b']');
    text
}
