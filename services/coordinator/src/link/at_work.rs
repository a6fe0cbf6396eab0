//! Which jobs are at work, on disk, for the next life of the coordinator: what a worker is at when
//! this one ends goes on in the next. Workers that this one keeps end with it, and are not there.
//!
//! A line a grant, taken up by the system at once and written through when it likes: what is lost
//! with the machine is begun anew, and nothing worse. Written anew with what still counts whenever
//! most of it does not.

use cullet_proto::JobId;
use std::collections::BTreeSet;
use std::fs::{self, File};
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
    jobs: BTreeSet<JobId>,
    /// Lines beyond which most no longer count.
    many: usize,
}

impl AtWork {
    /// What the last life has left, and a file for this one that begins with those that still
    /// count.
    pub(super) fn open(path: &Path, counts: impl FnMut(&JobId) -> bool) -> (Self, Vec<JobId>) {
        let mut jobs = read(path).unwrap_or_else(|error| {
            tracing::warn!("{}: {error}: what was at work is begun anew", path.display());
            BTreeSet::new()
        });
        jobs.retain(counts);
        let left = jobs.iter().copied().collect();
        let mut at_work = Self { path: path.to_owned(), file: None, jobs, many: 0 };
        at_work.begin();
        (at_work, left)
    }

    /// A job is granted. `counts`: whether one may still be at work.
    pub(super) fn took(&mut self, job: JobId, counts: impl FnMut(&JobId) -> bool) {
        if !self.jobs.insert(job) {
            return;
        }
        if self.jobs.len() > self.many {
            self.jobs.retain(counts);
            self.jobs.insert(job);
            return self.begin();
        }
        let written = self.file.as_mut().map(|file| file.write_all(line(&job).as_bytes()));
        if let Some(Err(error)) = written {
            self.lose(&error);
        }
    }

    /// Writes the file anew.
    fn begin(&mut self) {
        self.many = FEW.max(2 * self.jobs.len());
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

fn line(job: &JobId) -> String {
    format!("{job}\n")
}

/// A line that a crash tore says nothing.
fn read(path: &Path) -> Result<BTreeSet<JobId>> {
    let mut text = Vec::new();
    match File::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(BTreeSet::new()),
        file => file?.take(MAX_BYTES).read_to_end(&mut text)?,
    };
    Ok(String::from_utf8_lossy(&text).lines().filter_map(JobId::from_hex).collect())
}

/// Whole or not at all: written beside and renamed.
fn write(path: &Path, jobs: &BTreeSet<JobId>) -> Result<File> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let mut beside = tempfile::NamedTempFile::new_in(folder)?;
    beside.write_all(jobs.iter().map(line).collect::<String>().as_bytes())?;
    beside.persist(path).map_err(|error| error.error)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            file.took(job(k), |known| (0..k).step_by(100).any(|kept| job(kept) == *known));
            file.took(job(k), |_| panic!("it is there already"));
        }
        let kept = fs::read_to_string(&path).expect("the file").lines().count();
        assert!(kept < 2 * FEW, "{kept} lines");
        // The last line is torn.
        let text = fs::read(&path).expect("the file");
        fs::write(&path, &text[..text.len() - 2]).expect("it is torn");
        let (_, left) = AtWork::open(&path, |known| *known != job(0));
        assert!(left.contains(&job(100)) && left.contains(&job(4_998)));
        assert!(!left.contains(&job(0)) && !left.contains(&job(4_999)));
    }

    #[test]
    fn a_disk_that_does_not_take_it_stops_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("file"), "x").expect("a file");
        let (mut file, left) = AtWork::open(&folder.path().join("file/at-work"), |_| true);
        assert!(left.is_empty());
        file.took(job(1), |_| true);
        assert!(file.file.is_none());
    }
}
