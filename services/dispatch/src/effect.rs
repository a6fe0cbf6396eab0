//! What the machine asks its shell to do.

use crate::event::{Digest, Epoch, Job, Millis, Outcome, Worker};

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A result counts.
    Done {
        /// Of its bytes.
        digest: Digest,
        /// What it came to.
        outcome: Outcome,
        /// Who handed it in.
        worker: Worker,
    },
    /// No attempt is left. Never physics: the run has to stop aloud.
    Abandoned(Reason),
    /// The run did not want it any more.
    Cancelled,
}

/// Why a job was abandoned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Too many workers died or hung under it.
    Crashes,
    /// Too many attempts, for whatever cause.
    Attempts,
    /// It cannot be read.
    Invalid,
    /// Nobody is left to work on it.
    Forsaken,
}

/// Why a job goes back to the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The worker's process ended.
    Down,
    /// The worker said that the attempt died.
    Crashed,
    /// The worker gave it back.
    Dropped,
    /// No renewal came in time.
    Silent,
    /// The attempt took longer than the hard limit.
    TooLong,
}

/// Why a worker should stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The job is over.
    Over,
    /// Another worker has it now.
    Superseded,
    /// No such job here.
    Unknown,
}

/// What became of a result that was handed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Receipt {
    /// It counts.
    Accepted,
    /// The same result was there already.
    Duplicate,
    /// A different result was there already.
    Conflict,
    /// The job ended without a result.
    TooLate,
    /// No such job here.
    Unknown,
    /// Noted (answer to a job given back, or a leave).
    Noted,
}

/// Something to do, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Answer the poll `seq` of `worker` with a job.
    Grant {
        /// Who.
        worker: Worker,
        /// Which poll.
        seq: u64,
        /// What.
        job: Job,
        /// This grant's number.
        epoch: Epoch,
        /// Good for \[ms\].
        lease: Millis,
        /// Limit of the attempt \[ms\].
        hard: Millis,
    },
    /// Hold the poll `seq` of `worker`.
    Park {
        /// Who.
        worker: Worker,
        /// Which poll.
        seq: u64,
    },
    /// Answer the poll `seq` of `worker`: nothing to do.
    Idle {
        /// Who.
        worker: Worker,
        /// Which poll.
        seq: u64,
    },
    /// Answer a renewal: go on.
    Renewed {
        /// Who.
        worker: Worker,
        /// At what.
        job: Job,
        /// Good for \[ms\].
        lease: Millis,
    },
    /// Answer a renewal: stop.
    Stop {
        /// Who.
        worker: Worker,
        /// What.
        job: Job,
        /// Why.
        reason: StopReason,
    },
    /// Answer a result, a job given back, or a leave.
    Taken {
        /// Who.
        worker: Worker,
        /// What became of it.
        receipt: Receipt,
    },
    /// A job goes back to the queue.
    Requeue {
        /// Which.
        job: Job,
        /// Why.
        loss: Loss,
    },
    /// A job has no attempt left: say so aloud.
    Stall {
        /// Which.
        job: Job,
        /// Why.
        reason: Reason,
        /// Attempts made.
        attempts: u32,
    },
    /// Two results of one pure job differ: say so aloud.
    Alarm {
        /// Which.
        job: Job,
        /// The result that counts.
        kept: Digest,
        /// The other one.
        other: Digest,
    },
    /// Hand the verdict to the run. One for each opening, in opening order.
    Settle {
        /// Which opening, counted from zero.
        opening: u64,
        /// Of which job.
        job: Job,
        /// How it ended.
        verdict: Verdict,
        /// Attempts made.
        attempts: u32,
    },
}
