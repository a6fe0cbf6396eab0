//! Verdicts of jobs that are over, the latest.

use crate::by_name::ByJob;
use crate::effect::Verdict;
use crate::event::Job;
use std::collections::VecDeque;

/// Settled jobs whose results are remembered, to tell a duplicate from a stranger. Beyond it the
/// oldest are forgotten, and a result that comes that late is answered "unknown".
const MAX_PAST: usize = 65_536;

#[derive(Debug, Default)]
pub(crate) struct PastVerdicts {
    verdicts: ByJob<Verdict>,
    order: VecDeque<Job>,
}

impl PastVerdicts {
    pub(crate) fn get(&self, job: &Job) -> Option<Verdict> {
        self.verdicts.get(job).copied()
    }

    /// A cancellation does not overwrite a result; nor does the same result from a cache, which
    /// does not say who found it.
    pub(crate) fn remember(&mut self, job: Job, verdict: Verdict) {
        match (self.get(&job), verdict) {
            (Some(_), Verdict::Cancelled) => return,
            (
                Some(Verdict::Done { digest: known, worker: Some(_), .. }),
                Verdict::Done { digest, worker: None, .. },
            ) if known == digest => return,
            _ => {}
        }
        if self.verdicts.insert(job, verdict).is_none() {
            self.order.push_back(job);
        }
        while self.order.len() > MAX_PAST {
            if let Some(oldest) = self.order.pop_front() {
                self.verdicts.remove(&oldest);
            }
        }
    }
}
