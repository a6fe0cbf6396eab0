//! What the runs of the simulated farm open, and when.

use super::super::check::Wrong;
use super::{Farm, Note, number};
use crate::*;

/// Longest that a run takes between the end of a job and the next of its chain \[ms\].
const STRIDE: Millis = 40;

impl Farm {
    /// The next opening of a run, and those after it that are due.
    pub(super) fn open(&mut self, run: usize) -> Result<(), Wrong> {
        while self.machine.is_some() && !self.disk.cancelled.contains(&run) {
            let made = self.check.opened(run);
            let Some((at, job)) = self.plan.runs[run].jobs.get(made).copied() else {
                return Ok(());
            };
            let chain = self.plan.runs[run].chain;
            if chain && self.done[run] < made {
                // The next is opened when this one is done, which it may never be.
                return Ok(());
            }
            // What was open before a crash is opened again at once.
            if at > self.now && made >= self.disk.opened[run] {
                self.post(at - self.now, Note::Open(run));
                return Ok(());
            }
            let prior = self.disk.prior(job);
            let before = made.checked_sub(1).filter(|_| chain);
            let after = before.map(|before| self.plan.runs[run].jobs[before].1);
            let need = self.plan.need(job);
            let event = Event::Open { run: number(run), job, need, after, prior };
            if self.check.full(run, self.plan.max_open) {
                self.step(event)?;
                self.post(200, Note::Open(run));
                return Ok(());
            }
            self.disk.opened[run] = self.disk.opened[run].max(made + 1);
            self.check.open(self.now, run, job)?;
            if let Some(runs) = self.disk.granted.get_mut(&job) {
                runs.insert(run);
            }
            if prior != Prior::Nothing {
                self.check.known(job);
            }
            self.step(event)?;
        }
        Ok(())
    }

    /// A run hears how an opening of it ended: a chain goes on from what is done.
    pub(super) fn settled(&mut self, run: Run, verdict: Verdict) {
        let run = run.0 as usize;
        if let (true, Verdict::Done { .. }) = (self.plan.runs[run].chain, verdict) {
            self.done[run] += 1;
            let after = 1 + self.rng.below(STRIDE);
            self.post(after, Note::Open(run));
        }
    }
}
