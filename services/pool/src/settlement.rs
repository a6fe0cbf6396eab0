//! How jobs end.

use cullet_proto::Verdict;
use std::time::Duration;

/// How a job ended.
#[derive(Clone, Debug, PartialEq)]
pub enum JobEnding {
    /// With a verdict, which is final.
    Verdict(Verdict),
    /// With no attempt left, and why. Never physics: the run has to stop aloud.
    Abandoned(String),
    /// The run did not want it any more.
    Cancelled,
}

/// The end of one opening of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Settlement {
    /// How it ended.
    pub ending: JobEnding,
    /// Attempts made.
    pub attempts: u32,
    /// Name of the worker whose result counts; empty without one.
    pub worker: String,
    /// Whether its result was known before.
    pub cached: bool,
    /// Whether it was given up after an attempt that was ended for the time that it took.
    pub overdue: bool,
    /// Wall time since the opening.
    pub wall: Duration,
    /// Attempts, the first ones, in the order in which they were granted.
    pub tries: Vec<Try>,
    /// What reproduces a job whose attempts are used up.
    pub reproduction: Option<Reproduction>,
}

/// What reproduces a job that was given up.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reproduction {
    /// Its encoding.
    pub job: Vec<u8>,
    /// Who died how, a line an attempt.
    pub attempts: String,
}

/// An attempt at a job; times are wall times since the opening.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Try {
    /// Whose.
    pub worker: String,
    /// When the worker was given the job.
    pub granted: Duration,
    /// When its result was there, or the attempt was lost; `None`: another's result came first.
    pub ended: Option<Duration>,
    /// How it was lost; empty: it was not.
    pub how: String,
}
