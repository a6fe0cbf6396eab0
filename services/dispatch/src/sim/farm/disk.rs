//! What the simulated coordinator keeps.

use super::super::plan::Rng;
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
    /// Jobs that were granted, and the runs that want them.
    pub(super) granted: BTreeMap<Job, BTreeSet<usize>>,
    /// Runs that were cancelled.
    pub(super) cancelled: BTreeSet<usize>,
    /// Openings that each run has made: it makes them again after a crash.
    pub(super) opened: Vec<usize>,
}

impl Disk {
    /// What is kept of a job.
    pub(super) fn prior(&self, job: Job) -> Prior {
        let known = self.results.get(&job).copied();
        known.map_or(Prior::Nothing, |(digest, outcome, build)| {
            let build = Some(build);
            Prior::Result { digest, outcome, build }
        })
    }

    /// What was granted and has no result, and the runs that want it and are not over, as far as
    /// that was written.
    pub(super) fn at_work(&mut self, rng: &mut Rng) -> Vec<(Job, usize)> {
        let Self { granted, results, quarantine, cancelled, .. } = self;
        granted.retain(|job, runs| {
            runs.retain(|run| !cancelled.contains(run) && !rng.chance(5));
            !results.contains_key(job) && !quarantine.contains(job) && !runs.is_empty()
        });
        let each =
            |(job, runs): (Job, BTreeSet<usize>)| runs.into_iter().map(move |run| (job, run));
        granted.clone().into_iter().flat_map(each).collect()
    }
}
