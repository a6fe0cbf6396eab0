//! What is kept of a job that is open.

use crate::ask::Ask;
use crate::effect::Verdict;
use crate::event::{Millis, Run, Worker};
use crate::leases::{Lease, Leases};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Not before then.
    Waiting(Millis),
    /// In the lines of its runs.
    Ready,
    /// Under one lease, or two.
    Held,
    Over(Verdict),
}

/// What a run wants of a job.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Want {
    pub(crate) run: Run,
    /// The run's first opening of it.
    pub(crate) opening: u64,
    /// Unsettled openings.
    pub(crate) count: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct JobRecord {
    pub(crate) wants: Vec<Want>,
    /// Whom it may be given to; under whom it died.
    pub(crate) ask: Ask,
    pub(crate) phase: Phase,
    pub(crate) leases: Leases,
    /// The grant that ran silent last, which a late renewal may take up again.
    pub(crate) lapsed: Option<Box<Lease>>,
    /// Who found the result that it starts from.
    pub(crate) maker: Option<Worker>,
    /// To whom it was granted last.
    pub(crate) last: Option<Worker>,
    pub(crate) attempts: u32,
    /// How often it died, or its worker did after a solver had it.
    pub(crate) crashes: u32,
    /// When it is to be looked at next; a timer wakes it by then.
    pub(crate) timer: Option<Millis>,
}
