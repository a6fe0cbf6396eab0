//! Questions about workers, and their answers.

use serde::{Deserialize, Serialize};

/// The answer to `workers`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Workers {
    /// Every worker that is known, by name.
    pub workers: Vec<WorkerInfo>,
}

/// A worker.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkerInfo {
    /// Its name.
    pub name: String,
    /// One life of its process, in hex.
    pub session: String,
    /// Whether its link is up.
    pub up: bool,
    /// Whether another that is there has had the same name for longer than a restart takes.
    #[serde(default)]
    pub twin: bool,
    /// Whether it gets no more jobs.
    pub drained: bool,
    /// Threads that it gives a job.
    pub threads: u32,
    /// Cores of its machine.
    pub cores: u32,
    /// Most memory that a job may hold \[bytes\]; `null`: no limit.
    pub memory: Option<u64>,
    /// The version of its program.
    pub version: String,
    /// The first digits of the digest of its program: results of the same one are the same bits.
    pub build: String,
    /// What it can solve, as `brittle single double`; `null`: whatever it is asked.
    pub solvers: Option<Vec<String>>,
    /// Jobs that it holds, in hex.
    pub jobs: Vec<String>,
    /// Results of it that count.
    pub done: u64,
}

/// Which worker gets no more jobs; of several with the name, all.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drain {
    /// Its name.
    pub worker: String,
}

/// The answer to a [`Drain`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drained {
    /// Always true.
    pub noted: bool,
    /// The lives that are there under the name, in hex: all of them get no more jobs.
    #[serde(default)]
    pub sessions: Vec<String>,
}
