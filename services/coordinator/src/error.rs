//! Why the service does not start or go on.

use cullet_pool::LinkError;
use cullet_web::WebError;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Why the service does not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The disk does not give or take a file.
    #[error("{path}: {source}")]
    File {
        /// The file concerned.
        path: PathBuf,
        /// What the system reported.
        source: std::io::Error,
    },
    /// A folder that is not a state folder of this generation.
    #[error(
        "{folder}: not a state folder of this version (it has {text:?}); name another folder, or \
         move this one away"
    )]
    Foreign {
        /// The folder concerned.
        folder: PathBuf,
        /// What is there.
        text: String,
    },
    /// No room for another run.
    #[error(
        "{folder}: {free} bytes of the disk are free{}, and {reserve} are kept for runs that go \
         on (cullet coordinator --reserve): make room, by cullet delete for one, and try again",
        wanted(*more)
    )]
    Full {
        /// The folder concerned.
        folder: PathBuf,
        /// Bytes.
        free: u64,
        /// Bytes that one that is handed in needs; 0: of one that waits.
        more: u64,
        /// Bytes.
        reserve: u64,
    },
    /// A user's runs hold as much of the disk as they may.
    #[error(
        "the runs of {user} hold {used} bytes of the disk here{}",
        beyond(*more, *bound)
    )]
    Quota {
        /// Whose.
        user: String,
        /// Bytes.
        used: u64,
        /// Bytes that one that is handed in needs; 0: of one that goes on.
        more: u64,
        /// Bytes.
        bound: u64,
    },
    /// A state folder in use.
    #[error("{folder}: another coordinator uses this state folder")]
    Taken {
        /// The folder concerned.
        folder: PathBuf,
    },
    /// A journal that cannot be read.
    #[error(
        "{path}, line {line}: {why}. Nothing is changed{}; put a sound copy in its place, or cut \
         the file off before that line to go on with the runs that are told of before it",
        copied(kept.as_deref())
    )]
    Journal {
        /// The file concerned.
        path: PathBuf,
        /// Where, from 1.
        line: usize,
        /// What is wrong.
        why: String,
        /// A copy of it as it is now.
        kept: Option<PathBuf>,
    },
    /// Runs without a journal.
    #[error(
        "{path}: the journal is missing, but {runs} has {lie} runs. Nothing is changed; restore a \
         copy of the journal, or move {runs} away to start with none"
    )]
    NoJournal {
        /// Where it should be.
        path: PathBuf,
        /// Where the runs lie.
        runs: PathBuf,
        /// How many grains lie.
        lie: usize,
    },
    /// What is kept of runs takes as much room as it may.
    #[error(
        "{path}: it holds {length} bytes, this run needs {more}, and it takes at most {bound}: \
         make room, by cullet delete, and try again"
    )]
    Long {
        /// Which journal.
        path: PathBuf,
        /// Bytes.
        length: u64,
        /// Bytes.
        more: u64,
        /// Bytes.
        bound: u64,
    },
    /// A file that is not as it was written.
    #[error("{path} is damaged: {why}. Nothing is changed; {mend}")]
    Damaged {
        /// The file concerned.
        path: PathBuf,
        /// What is wrong.
        why: String,
        /// What to do about it.
        mend: &'static str,
    },
    /// The door does not open.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Nobody can ask for metrics.
    #[error("cannot listen on {address}: {text}")]
    Metrics {
        /// The address that was asked for.
        address: SocketAddr,
        /// The reason, in words.
        text: String,
    },
    /// The page is not served.
    #[error(transparent)]
    Web(#[from] WebError),
}

impl ServiceError {
    pub(super) fn file(path: &Path) -> impl Fn(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::File { path: path.clone(), source }
    }
}

/// Where a copy is, in the middle of a sentence.
fn copied(kept: Option<&Path>) -> String {
    kept.map(|kept| format!(", and a copy is kept as {}", kept.display())).unwrap_or_default()
}

/// What is needed beside, in the middle of a sentence about what there is.
fn wanted(more: u64) -> String {
    match more {
        0 => String::new(),
        _ => format!(", this run needs {more}"),
    }
}

/// How far beyond the bound a user is, at the end of a sentence about what there is.
fn beyond(more: u64, bound: u64) -> String {
    match more {
        0 => format!(", more than the {bound} that a user may hold"),
        _ => format!(", and this one needs {more} more; a user may hold {bound}"),
    }
}
