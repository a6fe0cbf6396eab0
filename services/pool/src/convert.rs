//! Between the wire and the state machine.

use cullet_dispatch::Outcome;
use cullet_proto::Verdict;

/// What the machine is to know of a verdict.
pub(super) fn outcome_of(verdict: &Verdict) -> Outcome {
    match verdict {
        Verdict::Solved(_) | Verdict::Measured(_) | Verdict::Moved(_) => Outcome::Broken,
        Verdict::Refused { .. } => Outcome::Refused,
        Verdict::Failed { .. } => Outcome::Failed,
    }
}
