//! Why nothing was exported, and the bounds of what can be asked for.

use cullet_record::RecordError;
use std::path::{Path, PathBuf};

/// Frames a second that can be asked for \[1/s\].
pub const FPS: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
/// Most files of a sequence.
pub const MOST_FILES: usize = 10_000;

/// Why nothing was exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The recording cannot be used.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The name asks for a format that is not written.
    #[error("{}: {advice}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What to do instead.
        advice: &'static str,
    },
    /// Frames a second out of bounds.
    #[error("{fps} frames a second: it must be from {} to {}", FPS.start(), FPS.end())]
    Fps {
        /// What was asked for.
        fps: f64,
    },
    /// Moments that the run does not have.
    #[error("there are no moments from {start} s to {end} s: the run goes from 0 to {whole} s")]
    Range {
        /// The first \[s\].
        start: f64,
        /// The last \[s\].
        end: f64,
        /// The run's last one \[s\].
        whole: f64,
    },
    /// A sequence of too many files, or of none.
    #[error("a file each {every} s: that is no sequence of 1 to {MOST_FILES} files")]
    Sequence {
        /// What was asked for \[s\].
        every: f64,
    },
    /// Pieces of a run in which nothing broke.
    #[error("nothing broke in this run: there are no pieces")]
    NoPieces,
    /// A file could not be put together.
    #[error("the file could not be put together: {0}")]
    Encode(String),
    /// A file could not be written.
    #[error("{}: {}", path.display(), cullet_files::regular::words(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// An error of the file system, with the path that it is about.
pub(crate) fn write_error(path: &Path) -> impl FnOnce(std::io::Error) -> ExportError {
    let path = path.to_owned();
    move |source| ExportError::Write { path, source }
}
