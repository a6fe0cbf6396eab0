//! What goes wrong with a link.

use crate::election::Conflict;
use cullet_proto::WireError;
use std::path::PathBuf;

/// What went wrong with the link.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The transport does not open.
    #[error("cannot listen on {endpoint}: {text}")]
    Listen {
        /// The address of the link.
        endpoint: String,
        /// The reason, in words.
        text: String,
    },
    /// The transport does not connect.
    #[error("cannot connect to {endpoint}: tried for {seconds} s; {text}")]
    Connect {
        /// The address of the link.
        endpoint: String,
        /// For how long \[s\].
        seconds: f64,
        /// The reason, in words.
        text: String,
    },
    /// A worker process does not start.
    #[error("cannot start the worker {exe}: {source}")]
    Spawn {
        /// Which program.
        exe: PathBuf,
        /// What the system reported.
        source: std::io::Error,
    },
    /// A thread does not start.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
    /// Bytes of one's own that break the wire's rules.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// The coordinator does not answer.
    #[error("the coordinator at {endpoint} has not answered {what} for {seconds} s")]
    Silent {
        /// The address of the link.
        endpoint: String,
        /// What was asked.
        what: &'static str,
        /// For how long \[s\].
        seconds: f64,
    },
    /// The coordinator does not know what was named.
    #[error("the coordinator says: {0}")]
    Unknown(String),
    /// The coordinator is about to end.
    #[error("the coordinator at {endpoint} leaves; run {run} goes on when it is back")]
    Left {
        /// The address of the link.
        endpoint: String,
        /// Which run was followed.
        run: u64,
    },
    /// As many runs wait as may.
    #[error(
        "the queue of the coordinator at {endpoint} is full, and was for {seconds} s: it takes \
         another run when one of those that wait begins"
    )]
    Busy {
        /// The address of the link.
        endpoint: String,
        /// For how long \[s\].
        seconds: f64,
    },
    /// The coordinator refuses.
    #[error("the coordinator refuses: {0}")]
    Refused(String),
    /// The coordinator refuses for as long as something is so.
    #[error("the coordinator cannot take it now: {0}")]
    Later(String),
    /// What the coordinator sends cannot be read, or is not what it says that it is.
    #[error("what the coordinator sends is not sound: {0}")]
    Garbled(String),
    /// Another coordinator has the name.
    #[error(transparent)]
    Conflict(#[from] Conflict),
    /// A path that must not be in a bundle.
    #[error("{path:?} may not be in a bundle: {reason}")]
    Path {
        /// The file concerned.
        path: String,
        /// The reason.
        reason: &'static str,
    },
    /// A folder that another fetch has.
    #[error("{folder}: {why}; name another folder")]
    Occupied {
        /// The folder concerned.
        folder: PathBuf,
        /// By whom.
        why: &'static str,
    },
    /// The disk does not give or take a file.
    #[error("{path}: {}", cullet_files::regular::words(source))]
    File {
        /// The file concerned.
        path: PathBuf,
        /// What the system reported.
        source: std::io::Error,
    },
}
