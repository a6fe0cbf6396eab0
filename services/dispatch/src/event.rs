//! What the machine can hear.

/// Milliseconds on the shell's own steady clock; only differences matter.
pub type Millis = u64;

/// A job, named by the digest of its problem: same problem, same job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Job(pub [u8; 32]);

/// The digest of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

/// A worker process, by the number it drew at its start: it lasts one process lifetime.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Worker(pub u64);

/// The number of one grant. Never reused, so an old holder is told from the present one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Epoch(pub u64);

/// What a finished solve came to. All three are final.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Fragments (one fragment: nothing separated).
    Broken,
    /// No solver asked took the problem.
    Refused,
    /// Numerics went wrong.
    Failed,
}

/// Why a worker gives a job back without a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The attempt died or hung: counts as a crash, another attempt may do better.
    Crashed,
    /// The worker could not take it up (input gone, shutting down): nobody's fault.
    Dropped,
    /// The job itself cannot be read: no attempt will do better.
    Invalid,
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The run needs this job done. Opening the same job again is allowed: each opening settles.
    Open(Job),
    /// A worker asks for one job.
    Poll {
        /// Who asks.
        worker: Worker,
        /// Its poll number: a repeat carries the same one.
        seq: u64,
        /// Jobs that it could take now; zero gets "idle".
        slots: u32,
        /// Whether the question may wait for a job to be opened.
        park: bool,
    },
    /// A worker is still at it.
    Renew {
        /// Who.
        worker: Worker,
        /// At what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
    },
    /// A worker hands in a result; the shell has checked its bytes against `digest`.
    Commit {
        /// Who.
        worker: Worker,
        /// Of what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// Of the result's bytes.
        digest: Digest,
        /// What it came to.
        outcome: Outcome,
    },
    /// A worker gives a job back.
    Fail {
        /// Who.
        worker: Worker,
        /// What.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// Why.
        trouble: Trouble,
    },
    /// The link to a worker is gone; links flap, so it may be back.
    Suspect(Worker),
    /// A worker's process is known to have ended.
    Down(Worker),
    /// A worker takes its leave.
    Bye(Worker),
    /// The run no longer needs this job.
    Cancel(Job),
    /// The run no longer needs anything.
    CancelAll,
    /// Nobody can take this job (it is over a limit of the wire).
    Reject(Job),
    /// Nobody is left to work, and nobody will come.
    Forsaken,
    /// Time has passed. Leases run out only here, after everything that was heard before.
    Tick,
}
