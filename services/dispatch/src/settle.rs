//! The ends of openings: in the order of their run, once.

use crate::effect::{Effect, Verdict};
use crate::event::{Job, Millis, Run};
use crate::job_record::{JobRecord, Phase};
use crate::machine::Dispatch;
#[cfg(test)]
use crate::mutant::Mutant;

impl Dispatch {
    /// No run has the job open any more.
    fn withdraw(&mut self, now: Millis, job: Job, out: &mut Vec<Effect>) {
        let inherited = self.inherit_again(now, job);
        self.release(now, job, Verdict::Cancelled, out);
        if let Some(record) = self.jobs.remove(&job) {
            self.counts.stands(record.phase, -1);
        }
        if !inherited {
            self.inherited.drop_claims(job);
            self.past.remember(job, Verdict::Cancelled);
        }
    }

    /// Settles the openings of a run that are over, up to the first that is not.
    pub(crate) fn settle(&mut self, run: Run, out: &mut Vec<Effect>) {
        #[cfg(test)]
        self.settle_as_they_come(run);
        while let Some(&job) = self.shares.get(run).and_then(|account| account.openings.front()) {
            let Some(Phase::Over(verdict)) = self.jobs.get(&job).map(|record| record.phase) else {
                return;
            };
            self.settle_first(run, job, verdict, out);
        }
    }

    /// Every opening of the run settles now, in order: those that are over as they are.
    pub(crate) fn cancel(&mut self, now: Millis, run: Run, out: &mut Vec<Effect>) {
        while let Some(&job) = self.shares.get(run).and_then(|account| account.openings.front()) {
            let verdict = match self.jobs.get(&job).map(|record| record.phase) {
                Some(Phase::Over(verdict)) => verdict,
                Some(Phase::Waiting(_) | Phase::Ready | Phase::Held) | None => Verdict::Cancelled,
            };
            self.settle_first(run, job, verdict, out);
            #[cfg(test)]
            if self.is(Mutant::CancelSpreads) {
                self.end(now, job, Verdict::Cancelled, out);
            }
            if self.jobs.get(&job).is_some_and(|record| record.wants.is_empty()) {
                self.withdraw(now, job, out);
            }
        }
    }

    /// The run's first opening settles.
    fn settle_first(&mut self, run: Run, job: Job, verdict: Verdict, out: &mut Vec<Effect>) {
        let Some(account) = self.shares.get_mut(run) else {
            return;
        };
        account.openings.pop_front();
        let opening = account.counts.settled;
        account.counts.settle(verdict);
        self.counts.settle(verdict);
        let attempts = self.jobs.get(&job).map_or(0, |record| record.attempts);
        out.push(Effect::Settle { run, opening, job, verdict, attempts });
        self.unwant(run, job);
        let spent = |r: &JobRecord| r.wants.is_empty() && matches!(r.phase, Phase::Over(_));
        if self.jobs.get(&job).is_some_and(spent) {
            self.jobs.remove(&job);
            self.past.remember(job, verdict);
        }
    }

    /// The run wants the job once less.
    fn unwant(&mut self, run: Run, job: Job) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let Some(at) = record.wants.iter().position(|want| want.run == run) else {
            return;
        };
        record.wants[at].count -= 1;
        if record.wants[at].count > 0 {
            return;
        }
        let last = record.wants.len() - 1;
        record.wants.swap(at, last);
        let (phase, opening) = (record.phase, record.wants[last].opening);
        self.count_want(job, -1);
        if let Some(record) = self.jobs.get_mut(&job) {
            if phase == Phase::Ready {
                self.shares.unready(run, &record.ask, opening);
            }
            record.wants.pop();
        }
    }

    #[cfg(test)]
    fn settle_as_they_come(&mut self, run: Run) {
        if !self.is(Mutant::SettleAsTheyCome) {
            return;
        }
        let jobs = &self.jobs;
        let open = |job: &Job| !matches!(jobs.get(job).map(|r| r.phase), Some(Phase::Over(_)));
        if let Some(account) = self.shares.get_mut(run) {
            account.openings.make_contiguous().sort_by_key(open);
        }
    }
}
