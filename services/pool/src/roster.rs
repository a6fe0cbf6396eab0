//! The workers that are known, for whoever asks about them. Decides nothing.

use super::lives::LiveWorkers;
use super::skill_table;
use cullet_dispatch::Worker;
use cullet_proto::pool::Hello;
use cullet_proto::service::WorkerInfo;
use cullet_proto::{JobId, SessionId, WorkerId};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

/// Jobs of a worker that are listed.
const MAX_JOBS: usize = 64;

/// A worker as the roster lists it.
#[derive(Debug, Default)]
struct RosterRow {
    name: String,
    about: Hello,
    drained: bool,
    jobs: BTreeSet<JobId>,
    done: u64,
}

/// What has been seen of each life of each worker.
#[derive(Debug, Default)]
pub(super) struct Roster {
    rows: BTreeMap<Worker, RosterRow>,
    shown: Arc<Mutex<Vec<WorkerInfo>>>,
    stale: bool,
    /// Workers whose link is up, and how many of these were drained, as they were published last.
    there: u64,
    drained: u64,
}

impl Roster {
    /// What was published last.
    pub(super) fn handle(&self) -> Arc<Mutex<Vec<WorkerInfo>>> {
        Arc::clone(&self.shown)
    }

    /// The row of a worker that has said what it is.
    fn change(&mut self, worker: Worker, change: impl FnOnce(&mut RosterRow)) {
        self.stale = true;
        self.rows.get_mut(&worker).map(change);
    }

    /// A worker has said what it is.
    pub(super) fn introduced(&mut self, worker: Worker, name: &WorkerId, hello: &Hello) {
        self.stale = true;
        let row = self.rows.entry(worker).or_default();
        row.name = name.to_string();
        row.about = hello.clone();
    }

    /// What a worker is, in words.
    pub(super) fn about(&self, worker: Worker) -> String {
        let Some(RosterRow { about, .. }) = self.rows.get(&worker) else {
            return "it has not said what it is".to_owned();
        };
        let Hello { version, threads, cores, .. } = about;
        let (build, mib) = (JobId(about.build).short(), about.memory.map(|bytes| bytes >> 20));
        let memory = mib.map_or_else(|| "any memory".to_owned(), |mib| format!("{mib} MiB"));
        format!("version {version}, build {build}, {threads} threads of {cores} cores, {memory}")
    }

    pub(super) fn took(&mut self, worker: Worker, job: JobId) {
        self.change(worker, |row| row.jobs.extend([job]));
    }

    pub(super) fn left(&mut self, worker: Worker, job: JobId) {
        if let Some(row) = self.rows.get_mut(&worker) {
            self.stale |= row.jobs.remove(&job);
        }
    }

    pub(super) fn done(&mut self, worker: Worker) {
        self.change(worker, |row| row.done += 1);
    }

    pub(super) fn drained(&mut self, worker: Worker) {
        self.change(worker, |row| row.drained = true);
    }

    /// Its process has ended.
    pub(super) fn gone(&mut self, worker: Worker) {
        self.stale |= self.rows.remove(&worker).is_some();
    }

    /// A link came or went.
    pub(super) fn changed(&mut self) {
        self.stale = true;
    }

    /// Workers that are there: a sign of life of one that was not let in counts for nothing.
    pub(super) fn there(&self) -> u64 {
        self.there
    }

    /// Workers that take jobs: all that are there, less those that were drained.
    pub(super) fn ready(&self) -> u64 {
        self.there.saturating_sub(self.drained)
    }

    /// Shows what has changed.
    pub(super) fn publish(&mut self, lives: &LiveWorkers) {
        if !std::mem::take(&mut self.stale) {
            return;
        }
        let up = |(worker, _): &(&Worker, &RosterRow)| lives.up.contains(&SessionId(worker.0));
        self.there = self.rows.iter().filter(up).count() as u64;
        self.drained = self.rows.iter().filter(up).filter(|(_, row)| row.drained).count() as u64;
        let info = |(worker, row): (&Worker, &RosterRow)| WorkerInfo {
            name: row.name.clone(),
            session: SessionId(worker.0).to_string(),
            up: lives.up.contains(&SessionId(worker.0)),
            twin: lives.has_duplicate_name(SessionId(worker.0)),
            drained: row.drained,
            threads: row.about.threads,
            cores: row.about.cores,
            memory: row.about.memory,
            version: row.about.version.clone(),
            build: JobId(row.about.build).short(),
            solvers: row.about.families.as_deref().map(skill_table::words),
            jobs: row.jobs.iter().take(MAX_JOBS).map(ToString::to_string).collect(),
            done: row.done,
        };
        let mut infos: Vec<WorkerInfo> = self.rows.iter().map(info).collect();
        infos.sort_by(|a, b| (&a.name, &a.session).cmp(&(&b.name, &b.session)));
        *self.shown.lock().unwrap_or_else(PoisonError::into_inner) = infos;
    }
}
