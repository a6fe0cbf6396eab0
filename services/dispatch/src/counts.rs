//! How much there is of everything.

use crate::effect::Verdict;
use crate::event::Outcome;
use crate::job_record::Phase;

/// How many of each there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Openings so far.
    pub opened: u64,
    /// Openings settled.
    pub settled: u64,
    /// Of these, refused by the solvers.
    pub refused: u64,
    /// Of these, failed in the solver.
    pub failed: u64,
    /// Of these, abandoned.
    pub abandoned: u64,
    /// Attempts beyond the first.
    pub resent: u64,
    /// Of these, duplicates of attempts that took long.
    pub hedged: u64,
    /// Attempts of an earlier life that went on in this one.
    pub adopted: u64,
    /// Jobs in the queue now.
    pub waiting: u64,
    /// Jobs under lease now.
    pub running: u64,
    /// Results that contradicted an earlier one.
    pub alarms: u64,
    /// Late results of another build than the one that has the job now, or had it last.
    pub fenced: u64,
    /// Jobs that wait though workers are there: none of these can do them.
    pub unschedulable: u64,
    /// Jobs in quarantine.
    pub quarantined: u64,
}

impl Counts {
    /// A job goes from one phase into another.
    pub(crate) fn moved(&mut self, old: Phase, new: Phase) {
        self.stands(old, -1);
        self.stands(new, 1);
    }

    /// One job more (`1`) or less (`-1`) is in this phase.
    pub(crate) fn stands(&mut self, phase: Phase, sign: i64) {
        match phase {
            Phase::Waiting(_) | Phase::Ready => {
                self.waiting = self.waiting.saturating_add_signed(sign);
            }
            Phase::Held => self.running = self.running.saturating_add_signed(sign),
            Phase::Over(_) => {}
        }
    }

    /// Openings whose verdict is still out, or waits for that of one before it.
    pub(crate) fn unsettled(&self) -> u64 {
        self.opened - self.settled
    }

    /// An opening settles.
    pub(crate) fn settle(&mut self, verdict: Verdict) {
        self.settled += 1;
        match verdict {
            Verdict::Done { outcome: Outcome::Refused, .. } => self.refused += 1,
            Verdict::Done { outcome: Outcome::Failed, .. } => self.failed += 1,
            Verdict::Abandoned(_) => self.abandoned += 1,
            Verdict::Done { outcome: Outcome::Broken, .. } | Verdict::Cancelled => {}
        }
    }
}
