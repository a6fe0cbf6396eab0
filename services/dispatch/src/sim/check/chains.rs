//! Chains of jobs, each of which starts from the result of the one before: who made what, whose
//! question waits, and who is preferred for it.

use super::{Checker, Oracle, Wrong, wrong};
use crate::*;
use std::collections::BTreeMap;

/// This life's account of makers and of questions for work.
#[derive(Default)]
pub(super) struct Chains {
    /// Who found the result of a job that counts.
    found: BTreeMap<Job, Worker>,
    /// The latest question of each worker.
    asked: BTreeMap<Worker, u64>,
    /// Questions that wait, of workers that may have something.
    parked: BTreeMap<Worker, u64>,
}

impl Checker {
    /// A run opens the next of its jobs: who has what it starts from, if it is one of a chain.
    pub(super) fn look_for_maker(&self, run: usize) -> Result<Option<Worker>, Wrong> {
        let course = &self.runs[run];
        let before = course.opened.checked_sub(1).filter(|_| self.plan.runs[run].chain);
        let Some(before) = before else { return Ok(None) };
        if course.settled != course.opened || course.ended {
            return wrong(Oracle::Chain, "opened before what it starts from is done")
                .map(|()| None);
        }
        Ok(self.chains.found.get(&course.jobs[before]).copied())
    }

    pub(super) fn found(&mut self, job: Job, worker: Worker) {
        self.chains.found.insert(job, worker);
    }

    /// A worker asks for work; a copy of an old question says nothing.
    pub(super) fn questioned(&mut self, worker: Worker, seq: u64) {
        let asked = self.chains.asked.entry(worker).or_default();
        if seq <= *asked {
            return;
        }
        *asked = seq;
        if self.drained.contains(&worker) {
            self.chains.parked.remove(&worker);
        } else {
            self.chains.parked.insert(worker, seq);
        }
    }

    /// This question has its answer.
    pub(super) fn answered(&mut self, worker: Worker, seq: u64) {
        if self.chains.parked.get(&worker) == Some(&seq) {
            self.chains.parked.remove(&worker);
        }
    }

    /// No question of this worker is answered with a job any more.
    pub(super) fn unparked(&mut self, worker: Worker) {
        self.chains.parked.remove(&worker);
    }

    /// A job goes to somebody, and nobody else has it: to who made what it starts from, if that one
    /// waits and may have it.
    pub(super) fn preferred(&self, worker: Worker, job: Job) -> Result<(), Wrong> {
        let known = self.jobs.get(&job);
        let Some((known, maker)) = known.and_then(|known| Some((known, known.maker?))) else {
            return Ok(());
        };
        let waits = self.chains.parked.contains_key(&maker);
        let name = self.name(maker);
        let innocent = !known.killers.contains(&name) && !self.doubtful(name);
        if maker != worker && waits && self.able(maker, job) && innocent {
            return wrong(Oracle::Maker, "granted past the worker that made what it starts from");
        }
        Ok(())
    }

    fn able(&self, worker: Worker, job: Job) -> bool {
        self.skills.get(&worker).is_some_and(|skills| skills.meet(self.plan.need(job)))
    }

    /// Between two events no job that nobody has had yet waits while a worker that can do it does.
    pub(super) fn nothing_waits(&self, now: Millis) -> Result<(), Wrong> {
        for (index, run) in self.runs.iter().enumerate().filter(|(_, run)| !run.paused) {
            for job in &run.jobs[run.settled..run.opened] {
                let known = &self.jobs[job];
                let fresh = known.grants == 0 && !known.over && known.wants.contains_key(&index);
                let sound = |worker| self.able(worker, *job) && !self.doubtful(self.name(worker));
                let free = || self.chains.parked.keys().any(|worker| sound(*worker));
                if fresh && !self.lives.waits(now, job) && free() {
                    return wrong(Oracle::Idle, "a job waits, and a worker that can do it, too");
                }
            }
        }
        Ok(())
    }
}
