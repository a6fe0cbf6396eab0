//! The jobs that are open, by name. Most of a step is about one job, so the place of the last one
//! that was looked up is remembered: among a million it is found once a step.

use crate::event::Job;
use crate::machine::Record;
use std::cell::Cell;
use std::collections::BTreeMap;

#[derive(Debug, Default)]
pub(crate) struct Jobs {
    places: BTreeMap<Job, usize>,
    records: Vec<Option<Record>>,
    free: Vec<usize>,
    last: Cell<Option<(Job, usize)>>,
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

    pub(crate) fn get(&self, job: &Job) -> Option<&Record> {
        self.records[self.place(job)?].as_ref()
    }

    pub(crate) fn get_mut(&mut self, job: &Job) -> Option<&mut Record> {
        let place = self.place(job)?;
        self.records[place].as_mut()
    }

    pub(crate) fn insert(&mut self, job: Job, record: Record) {
        let place = self.free.pop().unwrap_or_else(|| {
            self.records.push(None);
            self.records.len() - 1
        });
        self.records[place] = Some(record);
        self.places.insert(job, place);
        self.last.set(Some((job, place)));
    }

    pub(crate) fn remove(&mut self, job: &Job) -> Option<Record> {
        self.last.set(None);
        let place = self.places.remove(job)?;
        self.free.push(place);
        self.records[place].take()
    }

    pub(crate) fn names(&self) -> Vec<Job> {
        self.places.keys().copied().collect()
    }
}
