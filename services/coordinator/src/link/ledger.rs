//! The jobs that runs want: their bytes, their results, who waits for them.

use cullet_dispatch::{Job, Run};
use cullet_proto::{JobId, Verdict};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Instant;

/// Words about lost attempts that are kept of a job.
const MAX_ATTEMPTS: usize = 16;

/// What is known of a job that has openings to settle.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    /// When each opening was, by run.
    pub(super) openings: BTreeMap<Run, VecDeque<Instant>>,
    /// Its encoding.
    pub(super) bytes: Arc<Vec<u8>>,
    /// Its last trouble.
    pub(super) trouble: String,
    /// Lost attempts, a line each.
    pub(super) attempts: Vec<String>,
    /// Its verdict, before it settles.
    pub(super) result: Option<Verdict>,
    /// How far it is \[1/1000\].
    pub(super) permille: u16,
}

/// The jobs that are wanted.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    jobs: BTreeMap<Job, Wanted>,
}

impl Ledger {
    pub(super) fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// A run wants a job.
    pub(super) fn open(&mut self, run: Run, id: JobId, bytes: Vec<u8>, trouble: String) {
        let fresh = || Wanted {
            openings: BTreeMap::new(),
            bytes: Arc::new(bytes),
            trouble,
            attempts: Vec::new(),
            result: None,
            permille: 0,
        };
        let wanted = self.jobs.entry(Job(id.0)).or_insert_with(fresh);
        wanted.openings.entry(run).or_default().push_back(Instant::now());
    }

    /// One opening of a job is over: what is known of the job, which is forgotten with the last.
    pub(super) fn close(&mut self, run: Run, job: Job) -> Option<(Wanted, Instant)> {
        let wanted = self.jobs.get_mut(&job)?;
        let openings = wanted.openings.get_mut(&run)?;
        let opened = openings.pop_front()?;
        if openings.is_empty() {
            wanted.openings.remove(&run);
        }
        let last = wanted.openings.is_empty();
        let kept = if last { self.jobs.remove(&job)? } else { wanted.clone() };
        Some((kept, opened))
    }

    pub(super) fn get(&self, job: Job) -> Option<&Wanted> {
        self.jobs.get(&job)
    }

    /// Keeps words about a job's last trouble, for the message if it is abandoned.
    pub(super) fn note_trouble(&mut self, id: JobId, text: &str) {
        if let Some(wanted) = self.jobs.get_mut(&Job(id.0)) {
            wanted.trouble = cullet_proto::verdict::cut(text);
        }
    }

    /// The same trouble for every job.
    pub(super) fn trouble_all(&mut self, text: &str) {
        self.jobs.values_mut().for_each(|wanted| wanted.trouble = text.to_owned());
    }

    /// Keeps a line about a lost attempt.
    pub(super) fn note_attempt(&mut self, job: Job, line: &str) {
        if let Some(wanted) = self.jobs.get_mut(&job)
            && wanted.attempts.len() < MAX_ATTEMPTS
        {
            let trouble = &wanted.trouble;
            let colon = if trouble.is_empty() { "" } else { ": " };
            wanted.attempts.push(format!("{line}{colon}{trouble}"));
        }
    }

    /// Keeps a verdict whose bytes were checked, for when the machine settles the job.
    pub(super) fn keep(&mut self, id: JobId, verdict: Verdict) {
        if let Some(wanted) = self.jobs.get_mut(&Job(id.0)) {
            wanted.result.get_or_insert(verdict);
        }
    }

    /// A worker says how far it is: how much further that is than before, for each run.
    pub(super) fn progress(&mut self, id: JobId, permille: u16) -> Vec<(Run, i64)> {
        let Some(wanted) = self.jobs.get_mut(&Job(id.0)) else {
            return Vec::new();
        };
        let gain = i64::from(permille) - i64::from(wanted.permille);
        wanted.permille = permille;
        wanted.openings.keys().map(|run| (*run, gain)).collect()
    }
}
