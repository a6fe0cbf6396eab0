//! What must hold of the ends of attempts, jobs and openings.

use super::super::farm::number;
use super::{Checker, Known, Oracle, Wrong, result_of, twin_of, wrong};
use crate::*;

impl Checker {
    pub(super) fn lost(
        &mut self,
        now: Millis,
        event: Event,
        (job, worker, epoch): (Job, Worker, Epoch),
        (loss, charged): (Loss, bool),
    ) -> Result<(), Wrong> {
        let Some(held) = self.held.get_mut(&epoch).filter(|h| h.worker == worker && h.now) else {
            return wrong(Oracle::Healthy, "lost what nobody held");
        };
        held.now = false;
        let timing = self.timing;
        let quiet = now - held.heard;
        let fair = match loss {
            Loss::Silent => quiet >= timing.lease,
            Loss::TooLong => now - held.granted >= timing.hard,
            Loss::Down => {
                let gone = held.suspect.is_some_and(|since| now - since >= timing.suspect);
                event == Event::Down(worker)
                    || gone
                    || (held.suspect.is_some() && quiet >= timing.lease)
            }
            Loss::Crashed | Loss::Dropped => {
                matches!(event, Event::Fail { epoch: e, .. } if e == epoch)
                    || event == Event::Bye(worker)
            }
        };
        if !fair || self.calm {
            return wrong(Oracle::Healthy, format!("{loss:?} after {quiet} ms of silence"));
        }
        if charged && !self.began.contains(&epoch) {
            return wrong(Oracle::Innocent, format!("{loss:?} is charged, and nobody had begun"));
        }
        let guilty = match loss {
            Loss::Crashed => true,
            Loss::Down | Loss::TooLong => held.begun && !held.offered,
            Loss::Dropped | Loss::Silent => false,
        };
        if matches!(loss, Loss::Silent | Loss::Down) {
            self.deaths.doubt(worker, false);
        }
        let name = self.name(worker);
        let known = self.jobs.entry(job).or_default();
        known.holders.remove(&epoch);
        if guilty {
            known.crashes += 1;
            known.killers.insert(name);
            self.deaths.died(now, (name, job), known.killers.len() == 1);
        }
        Ok(())
    }

    pub(super) fn stall(
        &mut self,
        now: Millis,
        (job, reason, attempts): (Job, Reason, u32),
    ) -> Result<(), Wrong> {
        if let Reason::Crashes { deaths, workers } = reason {
            self.poisoned(now, job, (deaths, workers))?;
        }
        let timing = self.timing;
        let known = self.jobs.entry(job).or_default();
        let again = std::mem::replace(&mut known.stalled, true);
        let fair = match reason {
            Reason::Crashes { .. } => {
                let known = known.crashes >= timing.max_crashes || again;
                known || self.isolated.contains(&job)
            }
            Reason::Attempts => known.grants >= timing.max_attempts,
            Reason::Invalid | Reason::Forsaken => false,
        };
        if !fair {
            let text = format!("given up after {attempts} attempts: {reason:?}");
            return wrong(Oracle::Truth, text);
        }
        self.over(job, None);
        Ok(())
    }

    pub(super) fn settle(
        &mut self,
        (run, opening): (Run, u64),
        job: Job,
        verdict: Verdict,
    ) -> Result<(), Wrong> {
        let index = run.0 as usize;
        let course = &mut self.runs[index];
        let due = course.settled;
        if opening != due as u64 || due >= course.opened || course.jobs[due] != job {
            let text = format!("opening {opening} of run {index} when {due} was due");
            return wrong(Oracle::Order, text);
        }
        course.settled += 1;
        course.ended |= matches!(verdict, Verdict::Abandoned(_));
        let known = self.jobs.entry(job).or_default();
        let fair = match verdict {
            Verdict::Done { digest, .. } => {
                let same = *course.truth.entry(due).or_insert(digest) == digest;
                let flaky = self.plan.chaos.flaky > 0;
                let builds = if self.plan.mixed { 0..2 } else { 0..1 };
                let mut found = builds.map(|build| result_of(job, Build([build; 32])));
                let fits = |found| digest == found || (flaky && digest == twin_of(found));
                same && found.any(fits) && known.over
            }
            Verdict::Abandoned(_) => known.stalled,
            Verdict::Cancelled => course.cancelled,
        };
        if !fair {
            return wrong(Oracle::Truth, format!("run {:?}: {verdict:?}", number(index)));
        }
        let count = known.wants.entry(index).or_insert(1);
        *count -= 1;
        if *count == 0 {
            known.wants.remove(&index);
        }
        if known.wants.is_empty() {
            self.deaths.forget(job);
            // Opened again, it is a new job; only quarantine is remembered.
            let stalled = known.stalled;
            let left = self.jobs.insert(job, Known { stalled, ..Known::default() });
            let left = left.unwrap_or_default();
            if !self.handed_on(job, &left) {
                self.buried(job);
                self.dismiss(left.holders, None);
            }
        }
        Ok(())
    }

    pub(super) fn renewed(
        &mut self,
        now: Millis,
        event: Event,
        worker: Worker,
        job: Job,
    ) -> Result<(), Wrong> {
        let Event::Renew { epoch, begun, .. } = event else {
            return wrong(Oracle::Stop, "renewed what?");
        };
        if self.is_inherited(job) {
            return Ok(());
        }
        let known = self.jobs.entry(job).or_default();
        let Some(held) = self.held.get_mut(&epoch).filter(|held| held.worker == worker) else {
            return wrong(Oracle::Stop, "renewed what was never granted");
        };
        if !held.now && !known.holders.is_empty() {
            return wrong(Oracle::Stop, "renewed beside another holder");
        }
        (held.heard, held.suspect, held.now) = (now, None, true);
        self.deaths.hear(now, worker);
        held.begun |= begun;
        known.holders.insert(epoch);
        Ok(())
    }
}
