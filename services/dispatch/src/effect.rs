//! What the machine asks its shell to do.

use crate::event::{Build, Digest, Epoch, Job, Millis, Outcome, Run, Worker};

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A result counts.
    Done {
        /// Of its bytes.
        digest: Digest,
        /// What it came to.
        outcome: Outcome,
        /// Who handed it in; nobody: it was known.
        worker: Option<Worker>,
        /// What that one runs.
        build: Option<Build>,
    },
    /// No attempt is left. Never physics: the run has to stop aloud.
    Abandoned(Reason),
    /// The run did not want it any more.
    Cancelled,
}

/// Why a job was abandoned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Too many processes of workers died or hung under it: it is in quarantine.
    Crashes {
        /// So many; none of one that was in quarantine when it was opened.
        deaths: u32,
        /// Under so many workers.
        workers: u32,
    },
    /// Too many attempts, for whatever cause.
    Attempts,
    /// It cannot be read.
    Invalid,
    /// Nobody is left to work on it.
    Forsaken,
}

/// Why an attempt ended without a result.
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

/// Why a worker gets no more jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Somebody wished it.
    Asked,
    /// So it was in an earlier life.
    Before,
    /// Jobs that others finished had died under it.
    Blamed,
    /// Jobs died under it and under nobody else, it has finished none since, and the others have
    /// been busy.
    Alone,
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
    /// Another build's, and late: it may differ without anybody's fault.
    Fenced,
    /// The job ended without a result.
    TooLate,
    /// No such job here.
    Unknown,
    /// Noted (answer to a job given back, or a leave).
    Noted,
}

/// Why an opening is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// The run has as many unsettled openings as it may have.
    Run,
    /// The pool has.
    Pool,
    /// There is no such run.
    NoRun,
}

/// Something to do, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Answer the poll `seq` of `worker` with a job.
    Grant {
        /// The worker concerned.
        worker: Worker,
        /// Which poll.
        seq: u64,
        /// The job concerned.
        job: Job,
        /// For which run, of those that want it.
        run: Run,
        /// This grant's number.
        epoch: Epoch,
        /// Good for \[ms\].
        lease: Millis,
        /// Limit of the attempt \[ms\].
        hard: Millis,
    },
    /// Hold the poll `seq` of `worker`.
    Park {
        /// The worker concerned.
        worker: Worker,
        /// Which poll.
        seq: u64,
    },
    /// Answer the poll `seq` of `worker`: nothing to do.
    Idle {
        /// The worker concerned.
        worker: Worker,
        /// Which poll.
        seq: u64,
    },
    /// Answer the poll `seq` of `worker`: leave.
    Dismiss {
        /// The worker concerned.
        worker: Worker,
        /// Which poll.
        seq: u64,
    },
    /// A worker gets no more. Say so aloud.
    Drained {
        /// The worker concerned.
        worker: Worker,
        /// The cause.
        cause: Cause,
    },
    /// Jobs that others finish die under the name of a worker: it gets what nobody else can do. Say
    /// so aloud.
    Doubted {
        /// The worker under which the last of them died, or another of its name.
        worker: Worker,
    },
    /// Answer a renewal: go on.
    Renewed {
        /// The worker concerned.
        worker: Worker,
        /// At what.
        job: Job,
        /// Good for \[ms\].
        lease: Millis,
    },
    /// A worker goes on with what an earlier life has granted it.
    Adopted {
        /// The worker concerned.
        worker: Worker,
        /// At what.
        job: Job,
        /// For which run, of those that want it.
        run: Run,
        /// By which grant.
        epoch: Epoch,
    },
    /// Answer a renewal: stop.
    Stop {
        /// The worker concerned.
        worker: Worker,
        /// The job concerned.
        job: Job,
        /// The reason.
        reason: StopReason,
    },
    /// Tell a worker at once that nobody wants what it does by this grant. If that is lost, its
    /// next renewal is answered with [`Effect::Stop`].
    Cancel {
        /// The worker concerned.
        worker: Worker,
        /// The job concerned.
        job: Job,
        /// By which grant.
        epoch: Epoch,
    },
    /// Answer a result, a job given back, or a leave.
    Taken {
        /// The worker concerned.
        worker: Worker,
        /// What became of it.
        receipt: Receipt,
    },
    /// An attempt is over without a result.
    Lost {
        /// At what.
        job: Job,
        /// Whose.
        worker: Worker,
        /// By which grant.
        epoch: Epoch,
        /// How the worker was lost.
        loss: Loss,
        /// Whether it counts against the job.
        charged: bool,
    },
    /// An opening is not taken: the queue is full. It does not settle.
    Busy {
        /// Which run's.
        run: Run,
        /// Of what.
        job: Job,
        /// Which bound is reached.
        bound: Bound,
    },
    /// A job has no attempt left: say so aloud. Its runs hear of it by [`Effect::Settle`].
    Stall {
        /// The job concerned.
        job: Job,
        /// The reason.
        reason: Reason,
        /// Attempts made.
        attempts: u32,
    },
    /// A job killed its workers: keep what reproduces it. [`Effect::Stall`] follows.
    Quarantine {
        /// The job concerned.
        job: Job,
        /// Attempts that died.
        crashes: u32,
    },
    /// Two results of one pure job differ: say so aloud.
    Alarm {
        /// The job concerned.
        job: Job,
        /// The result that counts.
        kept: Digest,
        /// The other one.
        other: Digest,
    },
    /// WorkerMachine the verdict to the run. One for each opening, in the run's opening order.
    Settle {
        /// Which run.
        run: Run,
        /// Which opening of it, counted from zero.
        opening: u64,
        /// Of which job.
        job: Job,
        /// How it ended.
        verdict: Verdict,
        /// Attempts made.
        attempts: u32,
    },
}
