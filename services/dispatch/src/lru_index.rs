//! What a bounded store keeps: the most recently used, as much as fits. The store itself, in memory
//! or on disk, is the shell's.

use crate::event::Job;
use std::collections::BTreeMap;

/// Which results a bounded store keeps: the most recently used.
#[derive(Debug, Default)]
pub struct LruIndex {
    bound: u64,
    held: u64,
    clock: u64,
    kept: BTreeMap<Job, (u64, u64)>,
    oldest: BTreeMap<u64, Job>,
}

impl LruIndex {
    /// An index for so many bytes.
    #[must_use]
    pub fn new(bound: u64) -> Self {
        Self { bound, ..Self::default() }
    }

    /// Bytes on it.
    #[must_use]
    pub fn held(&self) -> u64 {
        self.held
    }

    /// Whether a job's result is on it.
    #[must_use]
    pub fn has(&self, job: Job) -> bool {
        self.kept.contains_key(&job)
    }

    /// Puts a job's result on it: which others have to go. One larger than the index goes itself.
    pub fn put(&mut self, job: Job, bytes: u64) -> Vec<Job> {
        self.remove(job);
        self.clock += 1;
        self.kept.insert(job, (self.clock, bytes));
        self.oldest.insert(self.clock, job);
        self.held += bytes;
        let mut gone = Vec::new();
        while self.held > self.bound
            && let Some((_, &job)) = self.oldest.first_key_value()
        {
            self.remove(job);
            gone.push(job);
        }
        gone
    }

    /// Notes that a job's result was used. Whether it is there.
    pub fn touch(&mut self, job: Job) -> bool {
        let Some((used, _)) = self.kept.get_mut(&job) else {
            return false;
        };
        self.clock += 1;
        self.oldest.remove(used);
        self.oldest.insert(self.clock, job);
        *used = self.clock;
        true
    }

    /// Takes a job's result off it.
    pub fn remove(&mut self, job: Job) {
        if let Some((used, bytes)) = self.kept.remove(&job) {
            self.oldest.remove(&used);
            self.held -= bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_recently_used_goes_first_and_the_bound_holds() {
        let [a, b, c, huge] = [1, 2, 3, 4].map(|k| Job([k; 32]));
        let mut index = LruIndex::new(100);
        assert!(index.put(a, 40).is_empty() && index.put(b, 40).is_empty());
        assert!(index.touch(a));
        assert_eq!(index.put(c, 40), [b]);
        assert_eq!((index.held(), index.touch(b)), (80, false));
        // The same again, of another size, counts once.
        assert_eq!(index.put(c, 60), []);
        assert_eq!(index.put(huge, 101), [a, c, huge]);
        assert_eq!(index.held(), 0);
    }
}
