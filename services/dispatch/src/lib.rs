//! The pool as a state machine: events in, effects out; time is an argument.
//!
//! A shell feeds [`Dispatch::step`] what it heard and does, in order, what comes back. Read
//! [`event`] first, then [`machine`].
//!
//! The rules that the machine keeps:
//! - every opening of a job settles exactly once, in opening order;
//! - a grant only ever answers a worker's poll, and a repeated poll gets the same grant;
//! - a lease that runs out does not stop the computation behind it: jobs are pure, so a late result
//!   of a job that is not over yet counts, and a second one is acknowledged and dropped;
//! - two different results of one job raise an alarm;
//! - a job whose attempts are used up stalls aloud; it is never given a made-up result.
//!
//! Absent on purpose: clocks, wires, threads, entropy, names of workers, contents of jobs.

pub mod counts;
pub mod effect;
pub mod event;
pub mod hand;
mod lease;
pub mod machine;
#[cfg(test)]
mod mutant;
mod poll;
mod settle;
mod share;
mod shelf;
pub mod timing;

#[cfg(test)]
mod sim;

pub use counts::Counts;
pub use effect::{Bound, Effect, Loss, Reason, Receipt, StopReason, Verdict};
pub use event::{Digest, Epoch, Event, Job, Millis, Outcome, Prior, Run, Share, Tenant};
pub use event::{Trouble, Worker};
pub use hand::{Act, Hand, Heard, Question, Work};
pub use machine::Dispatch;
pub use shelf::Shelf;
pub use timing::Timing;
