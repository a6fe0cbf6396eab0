//! Workers whose question for work waits, in the order in which they came, by what they can do.

use crate::event::{Millis, Skills, Worker};
use std::collections::BTreeMap;

/// Workers of one kind looked at for one under whom a job has not died yet: one more than four
/// processes of each name that it can have died under and still have an attempt left, and of one
/// that is doubted.
const MAX_LOOK: usize = 33;

/// A question that waits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asker {
    pub(crate) worker: Worker,
    pub(crate) seq: u64,
    pub(crate) until: Millis,
}

/// Where a question waits: what its worker can do, and a number that grows.
pub(crate) type Ticket = (Skills, u64);

/// Farms have few kinds of workers: a step looks at each kind, never at each worker.
#[derive(Debug, Default)]
pub(crate) struct ParkedPolls {
    kinds: BTreeMap<Skills, BTreeMap<u64, Asker>>,
    last: u64,
}

impl ParkedPolls {
    pub(crate) fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    pub(crate) fn add(&mut self, skills: Skills, asker: Asker) -> Ticket {
        self.last += 1;
        self.kinds.entry(skills).or_default().insert(self.last, asker);
        (skills, self.last)
    }

    pub(crate) fn take(&mut self, (skills, number): Ticket) -> Option<Asker> {
        let kind = self.kinds.get_mut(&skills)?;
        let asker = kind.remove(&number);
        if kind.is_empty() {
            self.kinds.remove(&skills);
        }
        asker
    }

    /// Whether one of them can do it.
    pub(crate) fn can(&self, need: Skills) -> bool {
        self.kinds.keys().any(|skills| skills.meet(need))
    }

    /// The one that has waited longest, of those that can do it and of which that holds.
    pub(crate) fn first(&self, need: Skills, holds: impl Fn(Worker) -> bool) -> Option<Ticket> {
        let able = self.kinds.iter().filter(|(skills, _)| skills.meet(need));
        let first = |(skills, kind): (&Skills, &BTreeMap<u64, Asker>)| {
            let mut some = kind.iter().take(MAX_LOOK);
            let (number, _) = some.find(|(_, asker)| holds(asker.worker))?;
            Some((*number, *skills))
        };
        able.filter_map(first).min().map(|(number, skills)| (skills, number))
    }

    /// The first whose time is over.
    pub(crate) fn overdue(&self, now: Millis) -> Option<Ticket> {
        let first = |(skills, kind): (&Skills, &BTreeMap<u64, Asker>)| {
            let (number, asker) = kind.first_key_value()?;
            (asker.until <= now).then_some((*number, *skills))
        };
        self.kinds.iter().filter_map(first).min().map(|(number, skills)| (skills, number))
    }
}
