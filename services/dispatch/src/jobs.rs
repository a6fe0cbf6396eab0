//! The jobs that are open, by name, and when to look at which. Most of a step is about one job, so
//! the place of the last one that was looked up is remembered: among a million it is found once a
//! step.

use crate::by_name::ByJob;
use crate::event::{Job, Millis, Skills};
use crate::job_record::{JobRecord, Phase};
use crate::leases::Lease;
use crate::timers::Timers;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug, Default)]
pub(crate) struct Jobs {
    places: ByJob<usize>,
    records: Vec<Option<(Job, JobRecord)>>,
    free: Vec<usize>,
    last: Cell<Option<(Job, usize)>>,
    /// When to look at which job: its pause is over, or a lease of it.
    timers: Timers,
    /// Attempts older than a lease lasts and without a duplicate, oldest first.
    slow: BTreeSet<(Millis, Job)>,
    /// How many wait for a worker, by what they ask of it; no zero.
    ready: BTreeMap<Skills, u64>,
}

impl Jobs {
    fn place(&self, job: &Job) -> Option<usize> {
        if let Some((last, place)) = self.last.get()
            && last == *job
        {
            return Some(place);
        }
        let place = *self.places.get(job)?;
        self.last.set(Some((*job, place)));
        Some(place)
    }

    pub(crate) fn get(&self, job: &Job) -> Option<&JobRecord> {
        self.records[self.place(job)?].as_ref().map(|(_, record)| record)
    }

    pub(crate) fn get_mut(&mut self, job: &Job) -> Option<&mut JobRecord> {
        let place = self.place(job)?;
        self.records[place].as_mut().map(|(_, record)| record)
    }

    pub(crate) fn insert(&mut self, job: Job, record: JobRecord) {
        let place = self.free.pop().unwrap_or_else(|| {
            self.records.push(None);
            self.records.len() - 1
        });
        self.records[place] = Some((job, record));
        self.places.insert(job, place);
        self.last.set(Some((job, place)));
    }

    /// Takes a job out, with its timer and its count among those that are ready.
    pub(crate) fn remove(&mut self, job: &Job) -> Option<JobRecord> {
        self.last.set(None);
        let place = self.places.remove(job)?;
        self.timers.set(place, None);
        self.free.push(place);
        let (_, record) = self.records[place].take()?;
        self.count_ready(record.ask.need, -i64::from(record.phase == Phase::Ready));
        Some(record)
    }

    pub(crate) fn names(&self) -> Vec<Job> {
        self.places.names()
    }

    /// So many jobs more, or fewer, wait for a worker.
    pub(crate) fn count_ready(&mut self, need: Skills, more: i64) {
        if more != 0 {
            let jobs = self.ready.entry(need).or_default();
            *jobs = jobs.saturating_add_signed(more);
            if *jobs == 0 {
                self.ready.remove(&need);
            }
        }
    }

    /// How many wait for a worker, by what they ask of it.
    pub(crate) fn ready(&self) -> &BTreeMap<Skills, u64> {
        &self.ready
    }

    /// Sets when a job is to be looked at: its pause is over, a lease of it runs out, or the only
    /// one is older than a lease lasts, which is `lasts` \[ms\].
    pub(crate) fn set_timer(&mut self, job: Job, lasts: Millis) {
        let Some(place) = self.place(&job) else {
            return;
        };
        let Some(record) = self.get_mut(&job) else {
            return;
        };
        let next = match record.phase {
            Phase::Waiting(until) => Some(until),
            Phase::Held => {
                let ends = record.leases.iter().map(|lease| lease.expires.min(lease.hard)).min();
                let young = record.leases.only().filter(|only| !only.slow);
                let slow = young.map(|only| only.granted + lasts);
                ends.map(|ends| slow.map_or(ends, |slow| slow.min(ends)))
            }
            Phase::Ready | Phase::Over(_) => None,
        };
        if record.timer != next {
            record.timer = next;
            self.timers.set(place, next);
        }
    }

    /// The jobs whose time has come, in order of time and name. One that was woken too soon, as its
    /// time was put off, sleeps on.
    pub(crate) fn due(&mut self, now: Millis) -> Vec<Job> {
        let mut due = Vec::new();
        for place in self.timers.due(now) {
            let Some((job, record)) = self.records.get_mut(place).and_then(Option::as_mut) else {
                continue;
            };
            match record.timer {
                Some(at) if at <= now => {
                    record.timer = None;
                    due.push((at, *job));
                }
                later => self.timers.set(place, later),
            }
        }
        due.sort_unstable();
        due.into_iter().map(|(_, job)| job).collect()
    }

    /// Counts an attempt among the slow ones once it is older than a lease lasts \[ms\].
    pub(crate) fn note_slow(&mut self, now: Millis, job: Job, lasts: Millis) {
        let Some(record) = self.get_mut(&job).filter(|r| r.leases.only().is_some()) else {
            return;
        };
        let old = |lease: &&mut Lease| !lease.slow && lease.granted + lasts <= now;
        let found = record.leases.iter_mut().find(old).map(|lease| {
            lease.slow = true;
            (lease.granted, job)
        });
        self.slow.extend(found);
    }

    /// An attempt does not count among the slow ones any more.
    pub(crate) fn forget_slow(&mut self, granted: Millis, job: Job) {
        self.slow.remove(&(granted, job));
    }

    /// The attempts that have taken longest, at most so many: when each was granted, and its job.
    pub(crate) fn slowest(&self, most: usize) -> Vec<(Millis, Job)> {
        self.slow.iter().take(most).copied().collect()
    }
}
