//! Workers under which jobs die: who is there beside them, and what they may be given.

use super::{Checker, Oracle, Wrong, wrong};
use crate::*;
use std::collections::BTreeMap;

/// How often the coordinator looks at its clock, and as much again \[ms\].
pub(super) const SLACK: Millis = 200;

/// A name is cleared that long after a job was last held against it, at the earliest \[ms\].
const CLEARED: Millis = 60_000;

/// One that has asked for work in this life of the coordinator.
#[derive(Clone, Copy, Default)]
struct There {
    seq: u64,
    since: Millis,
    /// Nothing: perhaps it is gone.
    heard: Option<Millis>,
    /// It is known to be gone.
    gone: bool,
}

#[derive(Default)]
struct Row {
    /// Jobs that died under the name alone since it finished one, and when.
    alone: BTreeMap<Job, Millis>,
    /// When a job that had died under it was finished by another.
    blamed: Vec<Millis>,
}

impl Row {
    /// The blame that no pause has cleared, whoever came after it.
    fn standing(&self, now: Millis) -> &[Millis] {
        let next = |at: usize| self.blamed.get(at + 1).copied().unwrap_or(now);
        let paused = |at: &usize| self.blamed[*at] + CLEARED <= next(*at);
        let from = (0..self.blamed.len()).rev().find(paused).map_or(0, |at| at + 1);
        &self.blamed[from..]
    }
}

/// This life's account of the deaths.
#[derive(Default)]
pub(super) struct Deaths {
    there: BTreeMap<Worker, There>,
    rows: BTreeMap<WorkerName, Row>,
}

impl Deaths {
    /// A worker asks for work; a copy of an old question says nothing.
    pub(super) fn asks(&mut self, now: Millis, worker: Worker, seq: u64) {
        let there = self.there.entry(worker).or_default();
        if seq > there.seq {
            there.seq = seq;
            self.hear(now, worker);
        }
    }

    pub(super) fn hear(&mut self, now: Millis, worker: Worker) {
        let there = self.there.entry(worker).or_default();
        // One that was silent for so long may have counted as gone.
        let patience = Timing::test().patience();
        if there.heard.is_none_or(|heard| heard + patience <= now) {
            there.since = now;
        }
        (there.heard, there.gone) = (Some(now), false);
    }

    pub(super) fn doubt(&mut self, worker: Worker, gone: bool) {
        if let Some(there) = self.there.get_mut(&worker) {
            (there.heard, there.gone) = (None, there.gone || gone);
        }
    }

    /// An attempt died.
    pub(super) fn died(&mut self, now: Millis, (name, job): (WorkerName, Job), alone: bool) {
        if alone {
            self.rows.entry(name).or_default().alone.entry(job).or_insert(now);
        } else {
            self.forget(job);
        }
    }

    /// Whose fault it was is known, or nobody asks any more.
    pub(super) fn forget(&mut self, job: Job) {
        self.rows.values_mut().for_each(|row| row.alone.retain(|known, _| *known != job));
    }

    /// A worker of this name finished a job that had died under these.
    pub(super) fn finished(
        &mut self,
        now: Millis,
        name: WorkerName,
        killers: impl Iterator<Item = WorkerName>,
    ) {
        self.rows.entry(name).or_default().alone.clear();
        for killer in killers.filter(|killer| *killer != name) {
            self.rows.entry(killer).or_default().blamed.push(now);
        }
    }
}

impl Checker {
    /// Whether another can do that, and is there beyond doubt since `since` at least.
    fn another(
        &self,
        (now, since): (Millis, Millis),
        need: Skills,
        but: impl Fn(&WorkerName) -> bool,
    ) -> bool {
        let lease = self.timing.lease;
        self.deaths.there.iter().any(|(worker, there)| {
            let sure = there.heard.is_some_and(|heard| now - heard <= lease);
            let able = self.skills.get(worker).is_some_and(|skills| skills.meet(need));
            let other = !but(&self.name(*worker)) && !self.drained.contains(worker);
            sure && there.since <= since && able && other
        })
    }

    /// Whether jobs died under this name so often that it may count as doubted.
    pub(super) fn doubtful(&self, name: WorkerName) -> bool {
        let row = self.deaths.rows.get(&name);
        let most = self.timing.max_blame as usize;
        row.is_some_and(|row| row.blamed.len() >= most)
    }

    /// A job goes to somebody.
    pub(super) fn spared(&self, now: Millis, worker: Worker, job: Job) -> Result<(), Wrong> {
        if self.drained.contains(&worker) {
            return wrong(Oracle::Drained, "granted to who was drained");
        }
        let name = self.name(worker);
        let killers = self.jobs.get(&job).map(|known| &known.killers);
        if let Some(killers) = killers.filter(|killers| killers.contains(&name))
            && self.another((now, now), self.plan.need(job), |other| killers.contains(other))
        {
            return wrong(Oracle::Spared, "granted where it died, and another could have it");
        }
        let (Some(row), Some(skills)) = (self.deaths.rows.get(&name), self.skills.get(&worker))
        else {
            return Ok(());
        };
        // It may have asked so long ago.
        let most = self.timing.max_blame as usize;
        let Some(asked) = now.checked_sub(self.timing.park + SLACK) else {
            return Ok(());
        };
        let untried = |(job, died): &(&Job, &Millis)| {
            let known = self.jobs.get(job);
            let own = |by: Option<Worker>| by.is_some_and(|by| self.name(by) == name);
            **died + self.timing.lease <= asked
                && now < **died + CLEARED
                && known.is_some_and(|k| !k.over && k.holders.is_empty() && own(k.last))
        };
        let alone = row.alone.iter().filter(untried).count() >= most;
        let blamed = row.standing(now).get(most - 1).is_some_and(|at| *at <= asked);
        if (alone || blamed) && self.another((now, asked), *skills, |other| *other == name) {
            let text = format!("it goes on, and jobs die under it: alone {alone}, blamed {blamed}");
            return wrong(Oracle::Drained, text);
        }
        // Whatever it says that it can do beside.
        let died = |other: &WorkerName| killers.is_some_and(|killers| killers.contains(other));
        let unfit = |other: &WorkerName| *other == name || self.doubtful(*other) || died(other);
        if blamed && self.another((now, asked), self.plan.need(job), unfit) {
            return wrong(
                Oracle::Doubted,
                "granted under a doubted name, and another could have it",
            );
        }
        Ok(())
    }

    /// A job is given up as that many processes died of it.
    pub(super) fn poisoned(
        &self,
        now: Millis,
        job: Job,
        (deaths, workers): (u32, u32),
    ) -> Result<(), Wrong> {
        let Some(known) = self.jobs.get(&job).filter(|_| deaths > 0) else {
            return Ok(());
        };
        if (known.crashes, known.killers.len()) != (deaths, workers as usize) {
            let text = format!("{deaths} deaths under {workers} workers were told");
            return wrong(Oracle::Truth, text);
        }
        let alone = workers < self.timing.min_killers && known.grants < self.timing.max_attempts;
        let need = self.plan.need(job);
        if alone && self.another((now, now), need, |other| known.killers.contains(other)) {
            return wrong(Oracle::Spared, "given up under one worker, and another could have it");
        }
        Ok(())
    }

    /// A worker gets no more.
    pub(super) fn sent_away(
        &mut self,
        event: Event,
        worker: Worker,
        cause: Cause,
    ) -> Result<(), Wrong> {
        let new = self.drained.insert(worker);
        let most = self.timing.max_blame as usize;
        let skills = self.skills.get(&worker).copied().unwrap_or(Skills::NONE);
        let name = self.name(worker);
        if cause == Cause::Asked {
            self.by_hand.insert(worker);
        }
        let row = self.deaths.rows.entry(name).or_default();
        let guilty = match cause {
            Cause::Asked => event == Event::Drain(worker),
            Cause::Before => !new,
            Cause::Blamed => row.blamed.len() >= most,
            Cause::Alone => row.alone.len() >= most,
        };
        let left = self.deaths.there.iter().any(|(other, there)| {
            let able = self.skills.get(other).is_some_and(|have| have.meet(skills));
            able && !there.gone && self.name(*other) != name && !self.drained.contains(other)
        });
        let wished = matches!(cause, Cause::Asked | Cause::Before);
        if guilty && (left || wished) {
            Ok(())
        } else {
            wrong(Oracle::Drained, format!("{cause:?}: guilty {guilty}, others left {left}"))
        }
    }
}
