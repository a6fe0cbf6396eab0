//! The workers: who is there, what each can do, under whom jobs died.

use crate::ask::Ask;
use crate::by_name::ByWorker;
use crate::event::{Build, Epoch, Job, Millis, Skills, Worker, WorkerName};
use crate::parked_polls::Ticket;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Workers remembered after their end, so that a late copy of their polls mints no grant.
const MAX_GONE: usize = 4_096;
/// Jobs remembered that died under one name alone.
const MAX_ALONE: usize = 64;
/// A name of which nobody is there is cleared this long after the last job that was held against
/// it, once somebody comes who has it \[ms\]: who drives it may have mended the machine.
const CLEARED: Millis = 60_000;

/// What is held against the workers of one name.
#[derive(Debug, Default)]
pub(crate) struct NameRecord {
    /// All that are remembered.
    workers: BTreeSet<Worker>,
    /// Those that are there.
    pub(crate) there: BTreeSet<Worker>,
    /// Jobs that died under them and that others finished.
    pub(crate) blame: u32,
    /// When a job was last held against them, as one of these or of those.
    pub(crate) blamed_at: Millis,
    /// Jobs that died under them since one of them finished one, and when; of some more is known by
    /// now.
    pub(crate) alone: Vec<(Job, Millis)>,
}

#[derive(Clone, Debug)]
pub(crate) struct WorkerState {
    pub(crate) build: Build,
    pub(crate) skills: Skills,
    pub(crate) name: WorkerName,
    pub(crate) last_seq: u64,
    /// What the last poll was answered with, for its repeats.
    pub(crate) granted: Option<(Job, Epoch)>,
    /// Its place among the parked.
    pub(crate) parked: Option<Ticket>,
    pub(crate) held: Vec<(Job, Epoch)>,
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
    names: BTreeMap<WorkerName, NameRecord>,
    /// Names under which jobs die that others finish: they get what nobody else can do, whatever
    /// they say that they can.
    doubted: BTreeSet<WorkerName>,
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
        self.beside(ask.need, ask.killers.iter())
    }

    /// Whether one of those is not doubted either.
    pub(crate) fn sound_others(&self, ask: &Ask) -> bool {
        let doubted = self.doubted.iter().filter(|name| !ask.killers.contains(name));
        self.beside(ask.need, ask.killers.iter().chain(doubted))
    }

    fn beside<'a>(&self, need: Skills, names: impl Iterator<Item = &'a WorkerName>) -> bool {
        self.able(need) > names.map(|name| self.able_of(*name, need)).sum()
    }

    /// Whether jobs die under workers of this name.
    pub(crate) fn doubts(&self, name: WorkerName) -> bool {
        self.doubted.contains(&name)
    }

    /// Whether some name is doubted.
    pub(crate) fn has_doubts(&self) -> bool {
        !self.doubted.is_empty()
    }

    /// Jobs that others finish die under workers of this name; whether that is new.
    pub(crate) fn doubt(&mut self, name: WorkerName) -> bool {
        self.doubted.insert(name)
    }

    /// How many of a name are there who can do it.
    fn able_of(&self, name: WorkerName, need: Skills) -> usize {
        let counts = |worker: &&Worker| {
            self.get(worker).is_some_and(|p| !p.gone && !p.drained && p.skills.meet(need))
        };
        self.names.get(&name).map_or(0, |record| record.there.iter().filter(counts).count())
    }

    /// Whether one of another name is there who can do all that this one can.
    pub(crate) fn spares(&self, worker: Worker) -> bool {
        self.get(&worker)
            .is_some_and(|state| self.able(state.skills) > self.able_of(state.name, state.skills))
    }

    /// What a worker is called that is remembered.
    pub(crate) fn name(&self, worker: Worker) -> Option<WorkerName> {
        self.get(&worker).map(|state| state.name)
    }

    /// What is held against a name; nothing where nobody is remembered who has it.
    pub(crate) fn record_mut(&mut self, name: WorkerName) -> Option<&mut NameRecord> {
        self.names.get_mut(&name)
    }

    /// A worker is there, perhaps for the first time; whether it turns out to be drained. One that
    /// is remembered keeps the name that it had then.
    pub(crate) fn arrive(
        &mut self,
        now: Millis,
        worker: Worker,
        (build, skills, name): (Build, Skills, WorkerName),
    ) -> bool {
        if self.workers.get(&worker).is_some() {
            return false;
        }
        let drained = self.barred.remove(&worker).is_some();
        let record = self.names.entry(name).or_default();
        if record.there.is_empty() && record.blamed_at + CLEARED <= now {
            (record.blame, record.alone) = (0, Vec::new());
            self.doubted.remove(&name);
        }
        record.workers.insert(worker);
        let state = WorkerState {
            build,
            skills,
            name,
            last_seq: 0,
            granted: None,
            parked: None,
            held: Vec::new(),
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
            if let Some(record) = self.names.get_mut(&state.name) {
                record.there.insert(worker);
            }
            self.gone.retain(|gone| *gone != worker);
            self.count(skills, counts, 1);
        }
    }

    /// It is gone: remembered for a while; a new question of its own brings it back.
    pub(crate) fn part(&mut self, worker: Worker) {
        if let Some(state) = self.workers.get_mut(&worker).filter(|state| !state.gone) {
            state.gone = true;
            let (skills, counts) = (state.skills, !state.drained);
            if let Some(record) = self.names.get_mut(&state.name) {
                record.there.remove(&worker);
            }
            self.gone.push_back(worker);
            self.count(skills, counts, -1);
        }
        while self.gone.len() > MAX_GONE {
            let Some(oldest) = self.gone.pop_front() else {
                break;
            };
            let over = |state: &&WorkerState| state.gone && state.held.is_empty();
            if let Some(name) = self.workers.get(&oldest).filter(over).map(|state| state.name) {
                self.workers.remove(&oldest);
                self.forget(oldest, name);
            }
        }
    }

    /// With the last of a name what is held against it is forgotten.
    fn forget(&mut self, worker: Worker, name: WorkerName) {
        if let Some(record) = self.names.get_mut(&name) {
            record.workers.remove(&worker);
            if record.workers.is_empty() {
                self.names.remove(&name);
                self.doubted.remove(&name);
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

    /// A job died under a name, and under no other.
    pub(crate) fn died_alone(&mut self, now: Millis, name: WorkerName, job: Job) {
        let Some(record) = self.names.get_mut(&name) else {
            return;
        };
        record.blamed_at = now;
        let known = record.alone.iter().any(|(known, _)| *known == job);
        if !known && record.alone.len() < MAX_ALONE {
            record.alone.push((job, now));
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
