//! Reports of runs that are over: made when first asked for, one at a time, and kept for a while.

use crate::pictures::Illustrator;
use crate::view::{RECORDING, RunView};
use std::collections::VecDeque;
use std::fs::{self, File};
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::TempDir;

/// Reports kept; the oldest makes room for the next.
const KEPT: usize = 16;
/// A recording of more bytes has no report here: it would be a page of hundreds of megabytes, made
/// in as much memory.
const MAX_RECORDING: u64 = 1 << 30;
/// Most bytes of a page.
pub(crate) const MAX_PAGE: u64 = 256 << 20;

/// Which report: of a run and an attempt that ended then.
type ReportKey = (u64, u32, Option<u64>);

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoReport {
    #[error("run {run} is {state}: there is a report of a run that has ended with a recording")]
    Unfinished { run: u64, state: &'static str },
    #[error(
        "the recording of run {run} has {length} bytes, and reports are made here up to \
         {MAX_RECORDING}: fetch it, and use `cullet report`"
    )]
    Large { run: u64, length: u64 },
    #[error("the report of run {run} has {length} bytes, and {MAX_PAGE} are sent at most")]
    LargePage { run: u64, length: u64 },
    #[error("run {run} has no report: {text}")]
    Failed { run: u64, text: String },
}

/// Reports that were made.
#[derive(Debug)]
pub(crate) struct Reports {
    illustrator: Arc<dyn Illustrator>,
    folder: TempDir,
    made: Mutex<VecDeque<(ReportKey, PathBuf)>>,
    stop: AtomicBool,
}

impl Reports {
    pub(crate) fn new(illustrator: Arc<dyn Illustrator>) -> io::Result<Self> {
        let (folder, made) = (tempfile::tempdir()?, Mutex::default());
        Ok(Self { illustrator, folder, made, stop: AtomicBool::new(false) })
    }

    /// Nothing is made any more.
    pub(crate) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// The page of a run, as a file. It waits while another is made.
    pub(crate) fn page(&self, view: &RunView) -> Result<File, NoReport> {
        let run = view.info.run;
        let failed = |text: String| NoReport::Failed { run, text };
        let Some(folder) = view.folder.as_ref().filter(|_| view.report) else {
            return Err(NoReport::Unfinished { run, state: view.info.state.word() });
        };
        // Held while it is made: one at a time, and who asks for the same has it then.
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (run, view.info.attempt, view.info.ended_ms);
        let known = made.iter().find(|(of, _)| *of == key).map(|(_, path)| path.clone());
        let path = match known {
            Some(path) => path,
            None => {
                let length = fs::metadata(folder.join(RECORDING)).map_or(0, |known| known.len());
                if length > MAX_RECORDING {
                    return Err(NoReport::Large { run, length });
                }
                let path = self.folder.path().join(format!("{run}-{}.html", view.info.attempt));
                self.illustrator.report(folder, &path, &self.stop).map_err(failed)?;
                if made.len() >= KEPT
                    && let Some((_, oldest)) = made.pop_front()
                {
                    let _gone_already = fs::remove_file(oldest);
                }
                made.push_back((key, path.clone()));
                path
            }
        };
        let length = fs::metadata(&path).map_or(0, |known| known.len());
        if length > MAX_PAGE {
            return Err(NoReport::LargePage { run, length });
        }
        File::open(&path).map_err(|error| failed(error.to_string()))
    }
}
