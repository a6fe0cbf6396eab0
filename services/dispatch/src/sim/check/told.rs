//! Who is to be told what at once: a worker that nobody wants what it does, people that two results
//! of one job differ.

use super::{Checker, Oracle, Wrong, wrong};
use crate::*;
use std::collections::BTreeSet;

impl Checker {
    /// The job needs no holder any more, as somebody has found its result, or nobody will.
    pub(super) fn over(&mut self, job: Job, by: Option<Worker>) {
        let known = self.jobs.entry(job).or_default();
        known.over = true;
        self.deaths.forget(job);
        let holders = std::mem::take(&mut known.holders);
        for epoch in &holders {
            if let Some(held) = self.held.get_mut(epoch) {
                held.now = false;
            }
        }
        self.dismiss(holders, by);
    }

    /// These are to be told.
    pub(super) fn dismiss(&mut self, holders: BTreeSet<Epoch>, by: Option<Worker>) {
        for epoch in holders {
            let worker = self.held.get(&epoch).map(|held| held.worker);
            if worker != by && !self.told.remove(&epoch) {
                self.due.insert(epoch);
            }
        }
    }

    /// One is told.
    pub(super) fn tell(&mut self, epoch: Epoch) {
        if !self.due.remove(&epoch) {
            self.told.insert(epoch);
        }
    }

    /// In one step are told all those that are to be, and nobody else.
    pub(super) fn all_told(&self) -> Result<(), Wrong> {
        if !self.due.is_empty() {
            return wrong(Oracle::Told, "goes on with what nobody wants, and is not told");
        }
        if !self.told.is_empty() {
            return wrong(Oracle::Told, "told to stop what somebody wants");
        }
        Ok(())
    }

    /// A result is an alarm if another of the same build counts, whichever life has found that.
    pub(super) fn alarmed(
        &self,
        (job, build, digest): (Job, Build, Digest),
        effects: &[Effect],
    ) -> Result<(), Wrong> {
        let differs = |(kept, by): &(Digest, Build)| *kept != digest && *by == build;
        let due = self.kept.get(&job).is_some_and(differs);
        if due == effects.iter().any(|effect| matches!(effect, Effect::Alarm { .. })) {
            Ok(())
        } else {
            wrong(Oracle::Alarm, format!("an alarm was due: {due}"))
        }
    }
}
