//! How a worker ends that cannot go on.

use cullet_proto::WireError;

/// Exit code of a worker whose solver hung past the hard limit.
pub const EXIT_WEDGED: i32 = 71;

/// What went wrong with a worker as a whole.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The transport does not open.
    #[error("cannot open the link to {endpoints}: {text}")]
    Connect {
        /// The addresses of the links.
        endpoints: String,
        /// The reason, in words.
        text: String,
    },
    /// No endpoint was given.
    #[error("no coordinator to connect to was given")]
    NoEndpoint,
    /// Threads do not start.
    #[error("cannot start {threads} threads: {text}")]
    Threads {
        /// How many threads.
        threads: usize,
        /// The reason, in words.
        text: String,
    },
    /// A name that is none.
    #[error(transparent)]
    Wire(#[from] WireError),
}
