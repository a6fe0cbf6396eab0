//! How runs of specimens are run.

use std::path::PathBuf;
use std::time::Duration;

/// How runs are run.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The program whose `worker` command solves.
    pub exe: PathBuf,
    /// More words for the command of each worker.
    pub words: Vec<String>,
    /// How many runs at once.
    pub workers: usize,
    /// Longest wall time of a run.
    pub time: Duration,
}

impl Limits {
    /// What is said of a run that took too long.
    pub(super) fn late(&self) -> String {
        format!("ended after {} s, the limit", self.time.as_secs_f64())
    }
}
