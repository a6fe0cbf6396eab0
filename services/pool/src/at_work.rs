//! Which jobs are at work and which runs want them, on disk, for the next life of the coordinator:
//! what a worker is at when this one ends goes on in the next, while one of those runs does.
//! Workers that this one keeps end with it, and are not there.
//!
//! A line a job and run, taken up by the system at once and written through when it likes: what is
//! lost with the machine is begun anew, and nothing worse. Written anew with what still counts
//! whenever most of it does not.

use cullet_files::{regular, state};
use cullet_proto::JobId;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};

/// Lines below which nothing is written anew.
const FEW: usize = 1_024;
/// Most bytes that are read of it.
const MAX_BYTES: u64 = 64 << 20;

/// The file, open.
#[derive(Debug)]
pub(super) struct AtWork {
    path: PathBuf,
    file: Option<File>,
    jobs: RunsByJob,
    lines: usize,
    /// Lines beyond which most no longer count.
    many: usize,
}

/// The numbers of the runs that want each job, which they keep in all lives.
type RunsByJob = BTreeMap<JobId, BTreeSet<u64>>;

impl AtWork {
    /// What the last life has left, and a file for this one that begins with those that still
    /// count.
    pub(super) fn open(
        path: &Path,
        mut counts: impl FnMut(&JobId) -> bool,
    ) -> (Self, Vec<(JobId, u64)>) {
        let mut jobs = read(path).unwrap_or_else(|error| {
            tracing::warn!("{}: {error}: what was at work is begun anew", path.display());
            RunsByJob::new()
        });
        jobs.retain(|job, _| counts(job));
        let left = pairs(&jobs).collect();
        let mut at_work = Self { path: path.to_owned(), file: None, jobs, lines: 0, many: 0 };
        at_work.begin();
        (at_work, left)
    }

    /// A job is granted that these runs want. `counts`: whether one may still be at work.
    pub(super) fn took(
        &mut self,
        job: JobId,
        runs: impl IntoIterator<Item = u64>,
        mut counts: impl FnMut(&JobId) -> bool,
    ) {
        let known = self.jobs.entry(job).or_default();
        let new: Vec<u64> = runs.into_iter().filter(|run| known.insert(*run)).collect();
        self.lines += new.len();
        if self.lines > self.many {
            self.jobs.retain(|known, _| *known == job || counts(known));
            return self.begin();
        }
        let text: String = new.into_iter().map(|run| line((job, run))).collect();
        let written = self.file.as_mut().map(|file| file.write_all(text.as_bytes()));
        if let Some(Err(error)) = written {
            self.lose(&error);
        }
    }

    /// Whether a job was granted to somebody who may be at it when this life ends.
    pub(super) fn has(&self, job: JobId) -> bool {
        self.jobs.contains_key(&job)
    }

    /// Writes the file anew.
    fn begin(&mut self) {
        self.lines = pairs(&self.jobs).count();
        self.many = FEW.max(2 * self.lines);
        match write(&self.path, &self.jobs) {
            Ok(file) => self.file = Some(file),
            Err(error) => self.lose(&error),
        }
    }

    /// The disk does not take it: until the file is written anew nothing is kept.
    fn lose(&mut self, error: &std::io::Error) {
        self.file = None;
        tracing::warn!("{}: {error}: a next life begins jobs anew", self.path.display());
    }
}

fn pairs(jobs: &RunsByJob) -> impl Iterator<Item = (JobId, u64)> {
    jobs.iter().flat_map(|(job, runs)| runs.iter().map(|run| (*job, *run)))
}

fn line((job, run): (JobId, u64)) -> String {
    state::line(&format!("{job} {run}"))
}

/// A job and a run that wants it; a line of before there were checksums has none.
fn pair(line: &str) -> Option<(JobId, u64)> {
    let (job, run) = state::read_line(line).ok()?.0.split_once(' ')?;
    Some((JobId::from_hex(job)?, run.parse().ok()?))
}

/// A line that a crash tore says nothing, nor one in which a bit turned.
fn read(path: &Path) -> Result<RunsByJob> {
    let mut text = Vec::new();
    match regular::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(RunsByJob::new()),
        file => file?.take(MAX_BYTES).read_to_end(&mut text)?,
    };
    let (mut jobs, mut bad) = (RunsByJob::new(), 0);
    for line in String::from_utf8_lossy(&text).split_inclusive('\n') {
        match line.strip_suffix('\n').and_then(pair) {
            Some((job, run)) => drop(jobs.entry(job).or_default().insert(run)),
            None => bad += 1,
        }
    }
    if bad > 0 {
        tracing::warn!("{}: {bad} lines are torn or damaged: begun anew", path.display());
        // It is written anew.
        cullet_files::set_aside::damaged(path);
    }
    Ok(jobs)
}

/// Whole or not at all: written beside and renamed.
fn write(path: &Path, jobs: &RunsByJob) -> Result<File> {
    let folder = path.parent().unwrap_or(Path::new("."));
    state::folder(folder)?;
    let mut beside = state::unfinished(folder)?;
    beside.write_all(pairs(jobs).map(line).collect::<String>().as_bytes())?;
    beside.persist(path).map_err(|error| error.error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn job(k: u32) -> JobId {
        JobId(cullet_proto::ids::digest(&k.to_le_bytes()))
    }

    #[test]
    fn what_was_at_work_is_read_back_and_what_is_over_goes() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("at-work");
        let (mut file, left) = AtWork::open(&path, |_| true);
        assert!(left.is_empty());
        for k in 0..5_000 {
            // Of all but every hundredth there is a result before long.
            file.took(job(k), [7], |known| (0..k).step_by(100).any(|kept| job(kept) == *known));
            file.took(job(k), [7], |_| panic!("it is there already"));
        }
        assert!(file.has(job(100)) && !file.has(job(101)));
        file.took(job(100), [7, 8], |_| true);
        file.took(job(4_999), [8], |_| true);
        let kept = fs::read_to_string(&path).expect("the file").lines().count();
        assert!(kept < 2 * FEW, "{kept} lines");
        // The last line is torn.
        let text = fs::read(&path).expect("the file");
        fs::write(&path, &text[..text.len() - 2]).expect("it is torn");
        let (_, left) = AtWork::open(&path, |known| *known != job(0));
        for (k, runs) in [(0, &[][..]), (100, &[7, 8]), (4_998, &[7]), (4_999, &[7])] {
            let of: Vec<_> = left.iter().filter(|(known, _)| *known == job(k)).collect();
            assert_eq!(of.iter().map(|(_, run)| *run).collect::<Vec<u64>>(), runs, "{k}");
        }
    }

    #[test]
    fn a_bit_that_turned_makes_no_other_job_or_run_of_a_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("at-work");
        let sound = line((job(1), 7));
        for at in 0..8 * sound.len() {
            let mut bytes = sound.clone().into_bytes();
            bytes[at / 8] ^= 1 << (at % 8);
            fs::write(&path, bytes).expect("it is damaged");
            assert_eq!(AtWork::open(&path, |_| true).1, [], "bit {at}");
        }
        // Of before there were checksums.
        fs::write(&path, format!("{} 7\n", job(1))).expect("an older one");
        assert_eq!(AtWork::open(&path, |_| true).1, [(job(1), 7)]);
    }

    #[test]
    fn a_disk_that_does_not_take_it_stops_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("file"), "x").expect("a file");
        let (mut file, left) = AtWork::open(&folder.path().join("file/at-work"), |_| true);
        assert!(left.is_empty());
        file.took(job(1), [1], |_| true);
        assert!(file.file.is_none());
    }
}
