//! Workers under which jobs die: who is there beside them, and what they may be given.

use super::{Checker, Oracle, Wrong, wrong};
use crate::*;
use std::collections::BTreeMap;

/// How often the coordinator looks at its clock, and as much again \[ms\].
pub(super) const SLACK: Millis = 200;

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
    /// Jobs that died under it alone since it finished one, and when.
    alone: BTreeMap<Job, Millis>,
    /// When a job that had died under it was finished by another.
    blamed: Vec<Millis>,
}

/// This life's account of the deaths.
#[derive(Default)]
pub(super) struct Deaths {
    there: BTreeMap<Worker, There>,
    rows: BTreeMap<Worker, Row>,
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
        if there.heard.is_none() {
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
    pub(super) fn died(&mut self, now: Millis, (worker, job): (Worker, Job), alone: bool) {
        if alone {
            self.rows.entry(worker).or_default().alone.entry(job).or_insert(now);
        } else {
            self.forget(job);
        }
    }

    /// Whose fault it was is known, or nobody asks any more.
    pub(super) fn forget(&mut self, job: Job) {
        self.rows.values_mut().for_each(|row| row.alone.retain(|known, _| *known != job));
    }

    /// A worker finished a job that had died under these.
    pub(super) fn finished(
        &mut self,
        now: Millis,
        worker: Worker,
        killers: impl Iterator<Item = Worker>,
    ) {
        self.rows.entry(worker).or_default().alone.clear();
        for killer in killers.filter(|killer| *killer != worker) {
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
        but: impl Fn(&Worker) -> bool,
    ) -> bool {
        let lease = self.timing.lease;
        self.deaths.there.iter().any(|(worker, there)| {
            let sure = there.heard.is_some_and(|heard| now - heard <= lease);
            let able = self.skills.get(worker).is_some_and(|skills| skills.meet(need));
            sure && there.since <= since && able && !but(worker) && !self.drained.contains(worker)
        })
    }

    /// A job goes to somebody.
    pub(super) fn spared(&self, now: Millis, worker: Worker, job: Job) -> Result<(), Wrong> {
        if self.drained.contains(&worker) {
            return wrong(Oracle::Drained, "granted to who was drained");
        }
        let killers = self.jobs.get(&job).map(|known| &known.killers);
        if let Some(killers) = killers.filter(|killers| killers.contains(&worker))
            && self.another((now, now), self.plan.need(job), |other| killers.contains(other))
        {
            return wrong(Oracle::Spared, "granted where it died, and another could have it");
        }
        let (Some(row), Some(skills)) = (self.deaths.rows.get(&worker), self.skills.get(&worker))
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
            **died + self.timing.lease <= asked
                && known.is_some_and(|k| !k.over && k.holders.is_empty() && k.last == Some(worker))
        };
        let alone = row.alone.iter().filter(untried).count() >= most;
        let blamed = row.blamed.get(most - 1).is_some_and(|at| *at <= asked);
        if (alone || blamed) && self.another((now, asked), *skills, |other| *other == worker) {
            let text = format!("it goes on, and jobs die under it: alone {alone}, blamed {blamed}");
            return wrong(Oracle::Drained, text);
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
        let row = self.deaths.rows.entry(worker).or_default();
        let guilty = match cause {
            Cause::Asked => event == Event::Drain(worker),
            Cause::Before => !new,
            Cause::Blamed => row.blamed.len() >= most,
            Cause::Alone => row.alone.len() >= most,
        };
        let left = self.deaths.there.iter().any(|(other, there)| {
            let able = self.skills.get(other).is_some_and(|have| have.meet(skills));
            able && !there.gone && !self.drained.contains(other)
        });
        let wished = matches!(cause, Cause::Asked | Cause::Before);
        if guilty && (left || wished) {
            Ok(())
        } else {
            wrong(Oracle::Drained, format!("{cause:?}: guilty {guilty}, others left {left}"))
        }
    }
}
