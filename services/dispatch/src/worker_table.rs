//! The workers: who is there, what each can do, under whom jobs died.

use crate::ask::Ask;
use crate::by_name::ByWorker;
use crate::event::{Build, Epoch, Job, Millis, Skills, Worker};
use crate::parked_polls::Ticket;
use std::collections::{BTreeMap, VecDeque};

/// Workers remembered after their end, so that a late copy of their polls mints no grant.
const MAX_GONE: usize = 4_096;
/// Jobs remembered that died under one worker alone.
const MAX_ALONE: usize = 64;

#[derive(Clone, Debug)]
pub(crate) struct WorkerState {
    pub(crate) build: Build,
    pub(crate) skills: Skills,
    pub(crate) last_seq: u64,
    /// What the last poll was answered with, for its repeats.
    pub(crate) granted: Option<(Job, Epoch)>,
    /// Its place among the parked.
    pub(crate) parked: Option<Ticket>,
    pub(crate) held: Vec<(Job, Epoch)>,
    /// Jobs that died here and that others finished.
    pub(crate) blame: u32,
    /// Jobs that died here since it finished one, and when; of some more is known by now.
    pub(crate) alone: Vec<(Job, Millis)>,
    pub(crate) gone: bool,
    pub(crate) drained: bool,
    /// Of its last question for work, or when a lease of it was over last.
    pub(crate) heard: Millis,
    /// When to see whether it has asked since.
    watch: Option<Millis>,
}

/// All of them. Counted by kind as they come and go, so that no step goes through them.
#[derive(Debug, Default)]
pub(crate) struct WorkerTable {
    workers: ByWorker<WorkerState>,
    /// Those that are there and not drained, by what they can do.
    kinds: BTreeMap<Skills, usize>,
    /// Who is not known yet, and gets nothing when it is.
    barred: ByWorker<()>,
    gone: VecDeque<Worker>,
    /// Who is to be looked after, by time.
    watch: VecDeque<(Millis, Worker)>,
}

impl WorkerTable {
    pub(crate) fn get(&self, worker: &Worker) -> Option<&WorkerState> {
        self.workers.get(worker)
    }

    pub(crate) fn get_mut(&mut self, worker: &Worker) -> Option<&mut WorkerState> {
        self.workers.get_mut(worker)
    }

    #[cfg(test)]
    pub(crate) fn names(&self) -> Vec<Worker> {
        self.workers.names()
    }

    /// Whether nobody is there.
    pub(crate) fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Whether somebody there can do it.
    pub(crate) fn can(&self, need: Skills) -> bool {
        self.kinds.keys().any(|skills| skills.meet(need))
    }

    fn able(&self, need: Skills) -> usize {
        self.kinds.iter().filter(|(skills, _)| skills.meet(need)).map(|(_, count)| count).sum()
    }

    /// Whether somebody is there, busy or not, who can do the job and under whom it has not died.
    pub(crate) fn others(&self, ask: &Ask) -> bool {
        let counts = |worker: &&Worker| {
            self.get(worker).is_some_and(|p| !p.gone && !p.drained && p.skills.meet(ask.need))
        };
        self.able(ask.need) > ask.killers.iter().filter(counts).count()
    }

    /// Whether another is there who can do all that this one can.
    pub(crate) fn spares(&self, worker: Worker) -> bool {
        self.get(&worker).is_some_and(|state| {
            self.able(state.skills) > usize::from(!state.gone && !state.drained)
        })
    }

    /// A worker is there, perhaps for the first time; whether it turns out to be drained.
    pub(crate) fn arrive(&mut self, worker: Worker, build: Build, skills: Skills) -> bool {
        if self.workers.get(&worker).is_some() {
            return false;
        }
        let drained = self.barred.remove(&worker).is_some();
        let state = WorkerState {
            build,
            skills,
            last_seq: 0,
            granted: None,
            parked: None,
            held: Vec::new(),
            blame: 0,
            alone: Vec::new(),
            // Until its question is taken in.
            gone: true,
            drained,
            heard: 0,
            watch: None,
        };
        self.workers.insert(worker, state);
        drained
    }

    /// It gets nothing once it is there.
    pub(crate) fn bar(&mut self, worker: Worker) {
        if self.workers.get(&worker).is_none() {
            self.barred.insert(worker, ());
        }
    }

    /// It asks for work at `now`, or goes on with what it has; it is looked after `patience` later.
    pub(crate) fn back(&mut self, now: Millis, worker: Worker, patience: Millis) {
        let Some(state) = self.workers.get_mut(&worker) else {
            return;
        };
        state.heard = now;
        if state.watch.is_none() {
            state.watch = Some(now + patience);
            self.watch.push_back((now + patience, worker));
        }
        if state.gone {
            state.gone = false;
            let (skills, counts) = (state.skills, !state.drained);
            self.gone.retain(|gone| *gone != worker);
            self.count(skills, counts, 1);
        }
    }

    /// It is gone: remembered for a while; a new question of its own brings it back.
    pub(crate) fn part(&mut self, worker: Worker) {
        if let Some(state) = self.workers.get_mut(&worker).filter(|state| !state.gone) {
            state.gone = true;
            let (skills, counts) = (state.skills, !state.drained);
            self.gone.push_back(worker);
            self.count(skills, counts, -1);
        }
        while self.gone.len() > MAX_GONE {
            let Some(oldest) = self.gone.pop_front() else {
                break;
            };
            if self.workers.get(&oldest).is_some_and(|state| state.gone && state.held.is_empty()) {
                self.workers.remove(&oldest);
            }
        }
    }

    /// It gets no more; whether that is new.
    pub(crate) fn drain(&mut self, worker: Worker) -> bool {
        let Some(state) = self.workers.get_mut(&worker).filter(|state| !state.drained) else {
            return false;
        };
        state.drained = true;
        let (skills, counts) = (state.skills, !state.gone);
        self.count(skills, counts, -1);
        true
    }

    fn count(&mut self, skills: Skills, counts: bool, sign: isize) {
        if counts {
            let count = self.kinds.entry(skills).or_default();
            *count = count.saturating_add_signed(sign);
            if *count == 0 {
                self.kinds.remove(&skills);
            }
        }
    }

    /// A job died under it, and under nobody else.
    pub(crate) fn died_alone(&mut self, now: Millis, worker: Worker, job: Job) {
        if let Some(state) = self.workers.get_mut(&worker)
            && state.alone.iter().all(|(known, _)| *known != job)
            && state.alone.len() < MAX_ALONE
        {
            state.alone.push((job, now));
        }
    }

    /// Those that have neither work nor asked for any for `patience`: each worker is looked at once
    /// in that time, however often it asks.
    pub(crate) fn unheard(&mut self, now: Millis, patience: Millis) -> Vec<Worker> {
        let mut unheard = Vec::new();
        while let Some((at, worker)) = self.watch.front().copied().filter(|(at, _)| *at <= now) {
            self.watch.pop_front();
            let Some(state) = self.workers.get_mut(&worker).filter(|p| p.watch == Some(at)) else {
                continue;
            };
            state.watch = None;
            if state.gone {
                continue;
            }
            if state.held.is_empty() && state.heard + patience <= now {
                unheard.push(worker);
            } else {
                state.watch = Some(now + patience);
                self.watch.push_back((now + patience, worker));
            }
        }
        unheard
    }
}
