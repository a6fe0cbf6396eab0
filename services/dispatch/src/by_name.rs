//! Maps by names that are well mixed already.

use crate::event::{Job, Worker};
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
