//! The jobs that are open, by name. Most of a step is about one job, so the place of the last one
//! that was looked up is remembered: among a million it is found once a step.

use crate::event::{Job, Worker};
use crate::machine::Record;
use std::cell::Cell;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};

/// Something by a name that is well mixed already: the digest of a problem, or a number drawn by
/// chance. Found in one look, however many there are; walked through only in the names' order.
#[derive(Debug)]
pub(crate) struct ByName<N, T>(HashMap<N, T, BuildHasherDefault<Mixed>>);

impl<N, T> Default for ByName<N, T> {
    fn default() -> Self {
        Self(HashMap::default())
    }
}

impl<N: Copy + Ord + Hash, T> ByName<N, T> {
    pub(crate) fn get(&self, name: &N) -> Option<&T> {
        self.0.get(name)
    }

    pub(crate) fn get_mut(&mut self, name: &N) -> Option<&mut T> {
        self.0.get_mut(name)
    }

    pub(crate) fn insert(&mut self, name: N, thing: T) -> Option<T> {
        self.0.insert(name, thing)
    }

    pub(crate) fn remove(&mut self, name: &N) -> Option<T> {
        self.0.remove(name)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// In order.
    pub(crate) fn names(&self) -> Vec<N> {
        let mut names: Vec<N> = self.0.keys().copied().collect();
        names.sort_unstable();
        names
    }
}

/// The first eight bytes of a name, spread.
#[derive(Debug, Default)]
pub(crate) struct Mixed(u64);

impl Hasher for Mixed {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        if let Some(first) = bytes.first_chunk() {
            self.write_u64(u64::from_le_bytes(*first));
        }
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = number.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(32);
    }

    /// The length of a digest, which all have.
    fn write_usize(&mut self, _: usize) {}
}

pub(crate) type ByJob<T> = ByName<Job, T>;
pub(crate) type ByWorker<T> = ByName<Worker, T>;

#[derive(Debug, Default)]
pub(crate) struct Jobs {
    places: ByJob<usize>,
    records: Vec<Option<(Job, Record)>>,
    free: Vec<usize>,
    last: Cell<Option<(Job, usize)>>,
}

impl Jobs {
    pub(crate) fn place(&self, job: &Job) -> Option<usize> {
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
        self.records[self.place(job)?].as_ref().map(|(_, record)| record)
    }

    /// What is at a place.
    pub(crate) fn at(&mut self, place: usize) -> Option<(Job, &mut Record)> {
        self.records.get_mut(place)?.as_mut().map(|(job, record)| (*job, record))
    }

    pub(crate) fn get_mut(&mut self, job: &Job) -> Option<&mut Record> {
        let place = self.place(job)?;
        self.records[place].as_mut().map(|(_, record)| record)
    }

    pub(crate) fn insert(&mut self, job: Job, record: Record) {
        let place = self.free.pop().unwrap_or_else(|| {
            self.records.push(None);
            self.records.len() - 1
        });
        self.records[place] = Some((job, record));
        self.places.insert(job, place);
        self.last.set(Some((job, place)));
    }

    pub(crate) fn remove(&mut self, job: &Job) -> Option<Record> {
        self.last.set(None);
        let place = self.places.remove(job)?;
        self.free.push(place);
        self.records[place].take().map(|(_, record)| record)
    }

    pub(crate) fn names(&self) -> Vec<Job> {
        self.places.names()
    }
}
