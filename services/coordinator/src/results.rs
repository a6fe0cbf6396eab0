//! The results of the jobs of one run, in a folder beside its recording. A later run takes those
//! whose problem is the same: a job is pure, so that its result is what a worker would find again.

use super::replaying_pool::VerdictStore;
use cullet_pool::{Build, ResultFile};
use cullet_proto::service::JobCounts;
use cullet_proto::{JobId, Verdict};
use cullet_run::{RESULTS, RunAgain, RunError};
use std::cell::{Cell, RefCell};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What became of results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct ResultCounts {
    /// Taken from the earlier run.
    taken: u64,
    /// There, and not as they were written.
    damaged: u64,
    /// There, and not to be read.
    unreadable: u64,
    /// There, and found by another build.
    foreign: u64,
    /// Not kept, for want of room.
    over: u64,
}

/// The results of an earlier run, as they are taken, and of this one, as they are kept.
pub(super) struct RunResults<'a> {
    /// Where those of this run are kept.
    own: PathBuf,
    /// Where those of the earlier one are, and what that is called.
    from: Option<(PathBuf, &'a Path)>,
    /// What solves the jobs of this run.
    build: Build,
    /// Most bytes that are kept.
    most: u64,
    /// How many of them are left; not known before the first one.
    left: Cell<Option<u64>>,
    /// Whether this run made the folder for them, and which it wrote.
    made: Cell<bool>,
    written: RefCell<Vec<JobId>>,
    counts: RefCell<ResultCounts>,
}

impl<'a> RunResults<'a> {
    /// Of a run into the folder `out`.
    ///
    /// # Errors
    /// [`RunError::From`]: there is no earlier run, or it is the one in that folder.
    pub(super) fn open(out: &Path, again: &RunAgain<'a>, build: Build) -> Result<Self, RunError> {
        let from = again.results(out)?.zip(again.from);
        let (own, most, left) = (out.join(RESULTS), again.keep, Cell::new(None));
        let (made, written, counts) = Default::default();
        Ok(Self { own, from, build, most, left, made, written, counts })
    }

    /// What is to be known before the run.
    pub(super) fn warning(&self) -> Option<String> {
        let (results, from) = self.from.as_ref().filter(|(results, _)| !results.is_dir())?;
        let (from, results) = (from.display(), results.display());
        Some(format!("warning: {from} kept no results ({results} is not there): all is solved"))
    }

    /// What became of the results, in words; `jobs`: of this run.
    pub(super) fn lines(&self, jobs: &JobCounts) -> Vec<String> {
        let ResultCounts { taken, damaged, unreadable, foreign, over } = *self.counts.borrow();
        let mut lines = Vec::new();
        if let Some((_, from)) = &self.from {
            let (all, from) = (jobs.settled, from.display());
            let word = if all == 1 { "job" } else { "jobs" };
            // The pool knows what it solved for another run of this process.
            let known = match jobs.kept.saturating_sub(taken) {
                0 => String::new(),
                known => format!(", {known} known to the pool"),
            };
            let solved = all.saturating_sub(jobs.kept);
            lines.push(format!("{all} {word}: {taken} taken from {from}{known}, {solved} solved"));
        }
        let mut warn = |count: u64, what: &str| {
            if count > 0 {
                lines.push(format!("warning: {what}: {count}"));
            }
        };
        warn(damaged, "damaged results of the earlier run, whose jobs were solved again");
        warn(unreadable, "results that cannot be read, whose jobs were solved again");
        warn(foreign, "results of another build of Cullet, whose jobs were solved again");
        let most = self.most >> 20;
        warn(over, &format!("results that are not kept, as {most} MiB are full"));
        lines
    }

    /// Deletes what this run kept, as it is refused, and nothing else.
    pub(super) fn discard(&self) {
        for job in self.written.borrow_mut().drain(..) {
            let path = ResultFile::path(&self.own, job);
            if let Err(error) = fs::remove_file(&path) {
                tracing::warn!("{}: {error}", path.display());
            }
        }
        if self.made.replace(false) {
            // Something of somebody's may be in it by now.
            let _it_stays = fs::remove_dir(&self.own);
        }
    }

    /// The bytes that are left, before the first result: the folder is made, with the rights of
    /// the run's, what is in it is counted, and what a kill left half-written goes.
    fn prepared(&self) -> io::Result<u64> {
        if let Some(left) = self.left.get() {
            return Ok(left);
        }
        match fs::create_dir(&self.own) {
            Ok(()) => {
                self.made.set(true);
                let run = self.own.parent().filter(|run| !run.as_os_str().is_empty());
                let run = run.unwrap_or(Path::new("."));
                fs::set_permissions(&self.own, fs::metadata(run)?.permissions())?;
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
        let mut left = self.most;
        for file in fs::read_dir(&self.own)? {
            let path = file?.path();
            if ResultFile::is_unfinished(&path) {
                fs::remove_file(&path)?;
            } else if ResultFile::job_of(&path).is_some() {
                left = left.saturating_sub(fs::symlink_metadata(&path)?.len());
            }
        }
        self.left.set(Some(left));
        Ok(left)
    }

    /// Whether a result of that size is to be kept, which it then has room for. What is there of
    /// the job stays only if it is sound and of this build.
    fn fits(&self, job: JobId, bytes: u64) -> io::Result<bool> {
        if self.most == 0 {
            return Ok(false);
        }
        let mut left = self.prepared()?;
        let path = ResultFile::path(&self.own, job);
        match ResultFile::read(&self.own, job) {
            ResultFile::Missing => {}
            ResultFile::Sound { build, .. } if build == Some(self.build) => return Ok(false),
            _ => {
                let freed = fs::symlink_metadata(&path)?.len();
                fs::remove_file(&path)?;
                left = left.saturating_add(freed).min(self.most);
            }
        }
        let rest = left.checked_sub(bytes);
        self.counts.borrow_mut().over += u64::from(rest.is_none());
        self.left.set(Some(rest.unwrap_or(left)));
        Ok(rest.is_some())
    }

    /// Keeps a result of the earlier run as one of this: as the same file, where that can be.
    fn share(&self, results: &Path, job: JobId, verdict: &[u8]) -> io::Result<()> {
        let (theirs, own) = (ResultFile::path(results, job), ResultFile::path(&self.own, job));
        if !self.fits(job, fs::metadata(&theirs)?.len())? {
            return Ok(());
        }
        if fs::hard_link(&theirs, &own).is_err() {
            ResultFile::write(&self.own, job, verdict, self.build)?;
        }
        self.written.borrow_mut().push(job);
        Ok(())
    }
}

impl VerdictStore for RunResults<'_> {
    fn get(&self, job: JobId) -> Option<Verdict> {
        let (results, _) = self.from.as_ref()?;
        let damaged = || {
            let path = ResultFile::path(results, job);
            tracing::warn!("{} is damaged: the job is solved again", path.display());
            self.counts.borrow_mut().damaged += 1;
        };
        match ResultFile::read(results, job) {
            ResultFile::Missing => None,
            ResultFile::Damaged => {
                damaged();
                None
            }
            ResultFile::Unreadable(why) => {
                let path = ResultFile::path(results, job);
                tracing::warn!("{}: {why}: the job is solved again", path.display());
                self.counts.borrow_mut().unreadable += 1;
                None
            }
            ResultFile::Sound { build, .. } if build != Some(self.build) => {
                self.counts.borrow_mut().foreign += 1;
                None
            }
            ResultFile::Sound { verdict: bytes, .. } => {
                let Ok(verdict) = Verdict::decode(&bytes) else {
                    damaged();
                    return None;
                };
                self.counts.borrow_mut().taken += 1;
                if let Err(error) = self.share(results, job, &bytes) {
                    tracing::warn!(job = %job.short(), "a result is not kept: {error}");
                }
                Some(verdict)
            }
        }
    }

    fn put(&self, job: JobId, verdict: &Verdict) -> io::Result<()> {
        if self.most == 0 {
            return Ok(());
        }
        let verdict = verdict.encode().map_err(|error| io::Error::other(error.to_string()))?;
        if self.fits(job, ResultFile::size_of(&verdict))? {
            ResultFile::write(&self.own, job, &verdict, self.build)?;
            self.written.borrow_mut().push(job);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
