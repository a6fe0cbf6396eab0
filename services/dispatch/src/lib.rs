//! The pool as a state machine: events in, effects out; time is an argument.
//!
//! A shell feeds [`Dispatch::step`] what it heard and does, in order, what comes back; a worker's
//! shell does the same with [`WorkerMachine::step`]. Read [`event`] first, then [`machine`], which
//! leads from each event to the file that handles it, and [`worker_machine`].
//!
//! What the machines keep to, each held by an oracle of the simulation (`docs/pool.md`), and how
//! much each tenant and run gets by `tests/fast/machine.rs`:
//! - every opening of a job settles exactly once, in the opening order of its run; runs do not wait
//!   for each other;
//! - a job opened by several runs is computed once and settles in each;
//! - a grant only ever answers a worker's poll, and a repeated poll gets the same grant;
//! - a grant's number, the epoch, never comes again: its upper half is the coordinator's
//!   incarnation, which whoever keeps the journal raises on disk before the first grant of a life;
//! - a lease ends by a result, by its worker's word or end, or by time; one that is renewed is
//!   never taken away;
//! - what a worker is at when the coordinator ends goes on: the next life takes its renewals and
//!   its result, and gives the job to nobody else before the worker has had a lease to be heard;
//!   if the runs that wanted it are over before they come that far again, it is as any other that
//!   nobody wants;
//! - a lease that runs out does not stop the computation behind it. A job's name is the digest of
//!   its problem, and a worker checks what it solves against the name: so a zombie's late result is
//!   of the same problem. It counts while the job is open and nobody of another build has been
//!   granted the job since; otherwise it is fenced: another build may find other bits, and the one
//!   that has the job now will say which count. Of a job that is over it is compared and dropped,
//!   of a job that nobody opened it is refused;
//! - two different results of one build of one job raise an alarm, and the first stays, in
//!   whichever life it was found; a duplicate goes to the same build;
//! - a job goes to a worker that meets what it asks; one that nobody there meets waits, is counted,
//!   and holds up nobody else;
//! - trouble in the pool never becomes a result: a job whose attempts are used up, or that died
//!   three times, under two workers if there are two, stalls aloud, goes into quarantine, and
//!   holds up only the runs that want it; what earlier lives have put there stays there until it
//!   is pardoned;
//! - a death counts against a job if a living worker reports it, or if the worker itself is gone,
//!   or out of time, after it said that a solver has the job and before it said that it has a
//!   result: what takes its worker with it is found as well, and a worker that is killed with a
//!   job that it only fetches, or has done, costs an attempt and nothing more;
//! - a job does not go back to a worker under which it died while another that can do it is
//!   there, busy or not: it waits for that one, and others pass it. When the last such one is
//!   gone, it goes to whoever is there;
//! - a job that starts from the result of another goes to the worker that found that result, which
//!   has it already, if that one's question is parked and it may have the job. Nobody waits for
//!   it: the preference says who gets a job, not which job is next;
//! - under whom a job died is a name, whatever the number of processes that have it, and a job and
//!   its duplicate go to two names; a name of which no process is there is cleared by the next that
//!   comes a minute or more after the last job that was held against it, so that a machine that was
//!   mended gets jobs;
//! - a worker gets no more if jobs died under it that others finished; or that died under it and
//!   nowhere else, one after another, and that nobody else has been free to try for a lease. A job
//!   that dies elsewhere too is no longer held against it, and the last worker that can do what it
//!   can stays, in the first case for what nobody else can do; who was drained by hand is drained
//!   in the next life too;
//! - the workers are shared evenly between tenants, and within a tenant by priority; a run that has
//!   waited too long lets one other pass and goes next, so none starves;
//! - a job that takes much longer than its run's others gets one duplicate, if a worker is idle;
//! - queues are bounded, and a full one answers "busy": the shell holds what a run wants further
//!   until there is room;
//! - who has a job that nobody wants any more is told at once, and again at the next renewal;
//! - a worker keeps a result until there is a receipt, and kills a solve that outlasts its limit.
//!
//! Absent on purpose: clocks, wires, threads, entropy, spelling of names, contents of jobs.

mod ask;
mod blame;
mod by_name;
pub mod counts;
pub mod effect;
mod ending;
pub mod event;
mod grants;
mod inherited;
mod job_record;
mod jobs;
mod leases;
mod loss;
mod lru_index;
pub mod machine;
#[cfg(test)]
mod mutant;
mod opening;
mod parked_polls;
mod past;
mod poll;
mod renewal;
mod settle;
mod share;
mod state;
mod takeover;
mod timers;
pub mod timing;
pub mod worker_machine;
mod worker_table;
mod workers;

#[cfg(test)]
mod sim;

pub use counts::Counts;
pub use effect::{Bound, Cause, Effect, Loss, Reason, Receipt, StopReason, Verdict};
pub use event::{Build, Claimant, Digest, Epoch, Event, Job, Millis, Outcome, Prior, Run};
pub use event::{Share, Skills, Tenant, Trouble, Worker, WorkerName};
pub use lru_index::LruIndex;
pub use machine::Dispatch;
pub use timing::Timing;
pub use worker_machine::{Question, Work, WorkerInput, WorkerMachine, WorkerOutput};
