//! What the simulated coordinator keeps.

use super::Farm;
use crate::*;
use std::collections::{BTreeMap, BTreeSet};

/// A result, and what found it.
pub(super) type Found = (Digest, Outcome, Build);

/// What the coordinator's disk holds: it outlives a crash.
#[derive(Default)]
pub(super) struct Disk {
    pub(super) incarnation: u32,
    pub(super) results: BTreeMap<Job, Found>,
    pub(super) quarantine: BTreeSet<Job>,
    pub(super) drained: BTreeSet<Worker>,
    /// Jobs that were granted.
    pub(super) granted: BTreeSet<Job>,
    /// Runs that were cancelled.
    pub(super) cancelled: BTreeSet<usize>,
    /// Openings that each run has made: it makes them again after a crash.
    pub(super) opened: Vec<usize>,
}

impl Farm {
    /// What the disk has of a job.
    pub(super) fn prior(&self, job: Job) -> Prior {
        let known = self.disk.results.get(&job).copied();
        known.map_or(Prior::Nothing, |(digest, outcome, build)| {
            let build = Some(build);
            Prior::Result { digest, outcome, build }
        })
    }

    pub(super) fn keep(&mut self, job: Job, found: Found) {
        self.disk.results.insert(job, found);
        self.check.keeps(job, (found.0, found.2));
    }

    /// What was granted and has no result, as far as that was written.
    pub(super) fn at_work(&mut self) -> Vec<Job> {
        let mut granted = std::mem::take(&mut self.disk.granted);
        granted.retain(|job| {
            let (results, held) = (&self.disk.results, &self.disk.quarantine);
            !results.contains_key(job) && !held.contains(job) && !self.rng.chance(5)
        });
        self.disk.granted = granted.clone();
        granted.into_iter().collect()
    }
}
