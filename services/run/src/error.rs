//! Why a run has no end.

use cullet_record::RecordError;
use cullet_world::{BodyId, JointError, WorldError};
use std::path::PathBuf;

/// Why a run could not go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The world broke down or refused a body.
    #[error("the rigid world: {0}")]
    World(#[from] WorldError),
    /// The recording could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The world lost a body that it had.
    #[error("there is no body {0}")]
    Lost(BodyId),
    /// The pool gave a job up after its last attempt.
    #[error("job {job} of `{body}` was abandoned: {reason}")]
    Abandoned {
        /// Digest of the problem.
        job: String,
        /// Whose.
        body: String,
        /// What the pool says.
        reason: String,
    },
    /// The pool answered with a job that is not the next one.
    #[error("the pool settled job {got} where job {due} was due")]
    OutOfOrder {
        /// What came.
        got: String,
        /// What was due.
        due: String,
    },
    /// A window of a sheet came to nothing.
    #[error("{sheet}: window {job} after {time} s came to nothing: {reason}")]
    Window {
        /// The sheet.
        sheet: String,
        /// Digest of the window.
        job: String,
        /// Simulated time at which it was to begin \[s\].
        time: f64,
        /// What the worker or the pool says.
        reason: String,
    },
    /// Too many rigid bodies in reach of a sheet.
    #[error("{sheet}: {bodies} bodies are in its reach; a window holds at most {most}")]
    TooManyNear {
        /// The sheet.
        sheet: String,
        /// How many there are.
        bodies: usize,
        /// The bound.
        most: usize,
    },
    /// A joint or glue of the scene could not be made.
    #[error("{what}: {source}")]
    Joint {
        /// Which of the scene, as it is written.
        what: String,
        /// What the world says.
        source: JointError,
    },
    /// There is no earlier run that this one could take up.
    #[error("{path}: {why}")]
    From {
        /// What was named.
        path: PathBuf,
        /// Why not.
        why: String,
    },
    /// The recording of the earlier run cannot be read.
    #[error(transparent)]
    Trail(RecordError),
    /// The run cannot resume from a step of an earlier one.
    #[error("it cannot resume from step {until}: {why}")]
    FromStep {
        /// The step.
        until: u64,
        /// Why not.
        why: String,
    },
    /// A file could not be written.
    #[error("{path}: {}", cullet_files::regular::words(source))]
    File {
        /// The file concerned.
        path: PathBuf,
        /// What the system reported.
        source: std::io::Error,
    },
}

impl RunError {
    /// Whether a motion of the world is not a number any more.
    #[must_use]
    pub fn is_not_finite(&self) -> bool {
        matches!(self, Self::World(WorldError::NotFinite { .. }))
    }

    /// Whether the run was not to be: what it was to take up is not there, or is not as it has to
    /// be. Nothing is left of it then.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::From { .. } | Self::FromStep { .. } | Self::Trail(_) => true,
            Self::Record(error) => matches!(error, RecordError::Differs { .. }),
            _ => false,
        }
    }
}
