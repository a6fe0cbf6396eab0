//! Openings of jobs by runs: taken as they come, or held here in order until there is room.
//!
//! A run of a scene has at most one opening for each of its bodies
//! (`services/run/src/lib.rs`), and a scene at most as many bodies as may be held.
//! Whoever wants more is turned out, so that what waits here has a bound whatever opens it.

use super::cache::CachedResult;
use super::convert::outcome_of;
use super::input::{Listener, Opening};
use super::settlement::{JobEnding, Settlement};
use super::shell::Shell;
use cullet_dispatch::{Bound, Digest, Event, Job, Prior, Run, Skills};
use cullet_proto::{JobId, Verdict};
use std::time::Duration;

impl Shell {
    /// A run wants a job. Where the machine is full the run waits, and nobody else.
    pub(super) fn want(&mut self, run: Run, id: JobId, opening: Opening) {
        let listener = self.runs.listeners.get(&run);
        if listener.is_some_and(|listener| listener.out.is_some()) {
            return self.end_unopened(run, id);
        }
        if listener.is_some_and(|listener| listener.held.len() >= self.runs.most) {
            return self.turn_out(run, id);
        }
        let first = listener.is_none_or(|listener| listener.held.is_empty());
        match self.dispatch.room(run) {
            Ok(()) if first => self.open(run, id, opening),
            Err(Bound::NoRun) => {}
            Ok(()) | Err(Bound::Run | Bound::Pool) => {
                self.runs.queued += 1;
                if let Some(listener) = self.runs.listeners.get_mut(&run) {
                    listener.held.push_back((id, opening));
                }
            }
        }
    }

    /// A run wants more than may wait: everything that it wants ends now, in order, and it gets
    /// nothing any more. Others go on.
    fn turn_out(&mut self, run: Run, id: JobId) {
        let text = format!("the run is turned out: {} of its jobs wait already", self.runs.most);
        tracing::error!(run = self.label(run), "{text}");
        if let Some(listener) = self.runs.listeners.get_mut(&run) {
            listener.out = Some(text);
        }
        self.hear(Event::Cancel(run));
        self.end_unopened(run, id);
    }

    /// Opens what was held, where there is room now: one of each run in turn.
    pub(super) fn open_held(&mut self) {
        let with = |(run, l): (&Run, &Listener)| (!l.held.is_empty()).then_some(*run);
        let mut runs: Vec<Run> = self.runs.listeners.iter().filter_map(with).collect();
        while !runs.is_empty() {
            runs.retain(|run| {
                let held =
                    self.runs.listeners.get_mut(run).filter(|_| self.dispatch.room(*run).is_ok());
                let Some((id, opening)) = held.and_then(|listener| listener.held.pop_front())
                else {
                    return false;
                };
                self.open(*run, id, opening);
                true
            });
        }
    }

    /// What a run wanted and was not opened yet ends with the rest of it, after the rest.
    pub(super) fn cancel_held(&mut self, run: Run) {
        let held =
            self.runs.listeners.get_mut(&run).map(|listener| std::mem::take(&mut listener.held));
        for (id, _) in held.into_iter().flatten() {
            self.end_unopened(run, id);
        }
    }

    /// How what a run does not get ends.
    pub(super) fn unwanted(&self, run: Run) -> JobEnding {
        let out = self.runs.listeners.get(&run).and_then(|listener| listener.out.clone());
        out.map_or(JobEnding::Cancelled, JobEnding::Abandoned)
    }

    /// An opening ends that the machine never had.
    pub(super) fn end_unopened(&mut self, run: Run, id: JobId) {
        let settlement = Settlement {
            ending: self.unwanted(run),
            attempts: 0,
            worker: String::new(),
            cached: false,
            overdue: false,
            wall: Duration::ZERO,
            tries: Vec::new(),
            reproduction: None,
        };
        self.runs.settled.push((run, id, settlement));
    }

    fn open(&mut self, run: Run, id: JobId, opening: Opening) {
        let job = Job(id.0);
        let (parted, asks) = match opening.content {
            Ok((parted, asks)) => (Ok(parted), asks),
            Err(text) => (Err(text), Vec::new()),
        };
        let fit = parted.is_ok();
        let permille = self.ledger.open(run, id, parted);
        if let Some(listener) = self.runs.listeners.get_mut(&run) {
            listener.permille += i64::from(permille);
            let wanted = self.ledger.get(job);
            listener.attempts.put(wanted.into_iter().flat_map(|wanted| wanted.news(id)));
        }
        let prior = match self.known(id) {
            _ if !fit => Prior::Unfit,
            known => known.unwrap_or(Prior::Nothing),
        };
        let need = if fit { self.workers.skill_table.need(&asks) } else { Skills::NONE };
        if let Some(listener) = self.runs.listeners.get_mut(&run) {
            listener.needs.insert(need);
        }
        let after = opening.after.map(|after| Job(after.0));
        self.step(Event::Open { run, job, need, after, prior });
        if self.kept.at_work.as_ref().is_some_and(|file| file.has(id)) && self.dispatch.wants(job) {
            self.note_at_work(id);
        }
    }

    /// What the cache says of a job that is opened.
    fn known(&mut self, id: JobId) -> Option<Prior> {
        let found = self.kept.cache.get(id)?;
        let (verdict, prior) = prior_of(&found)?;
        self.ledger.keep(id, verdict);
        Some(prior)
    }

    /// What is kept of a job that the machine may not know.
    pub(super) fn kept(&mut self, id: JobId) -> Prior {
        let known = self.dispatch.knows(Job(id.0));
        let found = if known { None } else { self.kept.cache.look(id) };
        found.as_ref().and_then(prior_of).map_or(Prior::Nothing, |(_, prior)| prior)
    }
}

/// What a kept result is, if it can be read.
fn prior_of((bytes, build): &CachedResult) -> Option<(Verdict, Prior)> {
    let verdict = Verdict::decode(bytes).ok()?;
    let (outcome, build) = (outcome_of(&verdict), *build);
    let digest = Digest(cullet_proto::ids::digest(bytes));
    Some((verdict, Prior::Result { digest, outcome, build }))
}
