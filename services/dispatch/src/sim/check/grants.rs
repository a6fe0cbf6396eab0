//! What must hold of a grant.

use super::{Checker, Held, Oracle, Wrong, wrong};
use crate::*;

impl Checker {
    pub(super) fn grant(
        &mut self,
        now: Millis,
        (worker, seq): (Worker, u64),
        (job, epoch): (Job, Epoch),
    ) -> Result<(), Wrong> {
        let first = *self.by_seq.entry((worker, seq)).or_insert((job, epoch));
        if first != (job, epoch) {
            return wrong(Oracle::Poll, format!("poll {seq} was answered twice"));
        }
        match self.epochs.insert(epoch, (worker, seq, job)) {
            Some(known) if known == (worker, seq, job) && self.held.contains_key(&epoch) => {
                return Ok(());
            }
            Some(_) => return wrong(Oracle::Epoch, format!("{epoch:?} came twice")),
            None => {}
        }
        let skills = self.skills.get(&worker).copied().unwrap_or(Skills::NONE);
        if !skills.meet(self.plan.need(job)) {
            return wrong(Oracle::Skill, "granted to who cannot do it");
        }
        if self.isolated.contains(&job) {
            return wrong(Oracle::Poison, "granted out of quarantine");
        }
        if self.acknowledged.contains(&job) {
            return wrong(Oracle::Kept, "an acknowledged result is computed again");
        }
        self.spared(now, worker, job)?;
        self.granted_anew(now, job)?;
        let timing = self.timing;
        let known = self.jobs.entry(job).or_default();
        let oldest = known.holders.iter().filter_map(|e| self.held.get(e)).map(|h| h.granted).min();
        if let Some(oldest) = oldest
            && (known.holders.len() > 1 || now - oldest < timing.lease)
        {
            return wrong(Oracle::Hedge, format!("{} hold it already", known.holders.len()));
        }
        let (own, mut held) = (self.names.get(&worker), known.holders.iter());
        if held.any(|e| self.held.get(e).is_some_and(|h| self.names.get(&h.worker) == own)) {
            return wrong(Oracle::Hedge, "the same name holds it already");
        }
        known.grants += 1;
        known.holders.insert(epoch);
        known.last = Some(worker);
        let killed = known.crashes >= timing.max_crashes
            && known.killers.len() >= timing.min_killers as usize;
        if known.grants > timing.max_attempts || killed {
            let text = format!("attempt {} after {} crashes", known.grants, known.crashes);
            return wrong(Oracle::Poison, text);
        }
        if oldest.is_none() {
            self.preferred(worker, job)?;
        }
        let known = &self.jobs[&job];
        let awake = |run: &usize| !self.runs[*run].paused;
        if oldest.is_none() && !known.wants.keys().any(awake) {
            return wrong(Oracle::Pause, "granted for runs that are paused");
        }
        let (granted, heard, suspect, begun, offered) = (now, now, None, false, false);
        let held = Held { worker, granted, heard, suspect, now: true, begun, offered };
        self.held.insert(epoch, held);
        if oldest.is_none() { self.starve(now, job, skills) } else { Ok(()) }
    }

    /// A grant of one job makes the runs wait that do not want it and have some for its worker.
    fn starve(&mut self, now: Millis, job: Job, skills: Skills) -> Result<(), Wrong> {
        let most = 2 * self.runs.len() + 2;
        for (index, run) in self.runs.iter_mut().enumerate() {
            let open = &run.jobs[run.settled..run.opened];
            let fits = |job: &Job| {
                let known = &self.jobs[job];
                let fresh = known.grants == 0 && !known.over && known.wants.contains_key(&index);
                fresh && skills.meet(self.plan.need(*job)) && !self.lives.waits(now, job)
            };
            if self.jobs[&job].wants.contains_key(&index) {
                (run.waiting, run.overdue) = (None, 0);
            } else if run.waiting.is_some_and(|since| now - since > self.timing.age)
                && open.iter().any(fits)
            {
                run.overdue += 1;
                if run.overdue > most {
                    return wrong(Oracle::Starved, format!("run {index} waits for ever"));
                }
            }
        }
        Ok(())
    }
}
