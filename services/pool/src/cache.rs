//! Results of finished jobs, by the digest of the problem: a repeat is answered without a worker.
//!
//! In memory and, if there is a folder, on disk; both bounded, the least recently used goes first
//! (`services/dispatch/src/lru_index.rs`). What a file holds is in `result_file.rs`.

use super::result_file::ResultFile;
use cullet_dispatch::{Build, Job, LruIndex};
use cullet_files::state;
use cullet_proto::JobId;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A result's bytes, and what found it, if that is known.
pub(super) type CachedResult = (Arc<Vec<u8>>, Option<Build>);

/// Where finished jobs are kept, and how much of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheConfig {
    /// Most bytes in memory.
    pub memory: u64,
    /// Folder and most bytes in it; `None`: nothing on disk.
    pub disk: Option<(PathBuf, u64)>,
}

impl Default for CacheConfig {
    fn default() -> Self {
        Self { memory: 256 << 20, disk: None }
    }
}

pub(super) struct Cache {
    memory: LruIndex,
    results: BTreeMap<Job, CachedResult>,
    disk: Option<(PathBuf, LruIndex)>,
    pub(super) hits: u64,
}

impl Cache {
    /// Takes in what a folder holds, the oldest file first.
    pub(super) fn open(config: &CacheConfig) -> Self {
        let disk = config.disk.as_ref().and_then(|(folder, bound)| {
            let found = listed(folder)
                .map_err(|error| {
                    tracing::warn!("no cache on disk: {}: {error}", folder.display());
                })
                .ok()?;
            let mut index = LruIndex::new(*bound);
            for (job, bytes) in found {
                for gone in index.put(job, bytes) {
                    discard(folder, gone);
                }
            }
            Some((folder.clone(), index))
        });
        let (memory, results) = (LruIndex::new(config.memory), BTreeMap::new());
        Self { memory, results, disk, hits: 0 }
    }

    /// A job's result, which answers an opening.
    pub(super) fn get(&mut self, id: JobId) -> Option<CachedResult> {
        let found = self.look(id);
        self.hits += u64::from(found.is_some());
        found
    }

    /// Whether a job's result is kept.
    pub(super) fn has(&self, id: JobId) -> bool {
        let on_disk = self.disk.as_ref().is_some_and(|(_, index)| index.has(Job(id.0)));
        on_disk || self.results.contains_key(&Job(id.0))
    }

    /// A job's result.
    pub(super) fn look(&mut self, id: JobId) -> Option<CachedResult> {
        let job = Job(id.0);
        if self.memory.touch(job) { self.results.get(&job).cloned() } else { self.read(job) }
    }

    fn read(&mut self, job: Job) -> Option<CachedResult> {
        let (folder, index) = self.disk.as_mut()?;
        if !index.touch(job) {
            return None;
        }
        let (verdict, build) = match ResultFile::read(folder, JobId(job.0)) {
            ResultFile::Sound { verdict, build } => (verdict, build),
            other => {
                let why = match other {
                    ResultFile::Unreadable(why) => why,
                    _ => "it is damaged".to_owned(),
                };
                let path = file(folder, job);
                tracing::warn!("{}: {why}: the job is done again", path.display());
                index.remove(job);
                discard(folder, job);
                return None;
            }
        };
        let found = (Arc::new(verdict), build);
        self.hold(job, &found);
        Some(found)
    }

    /// Keeps the bytes of a job's result, and what found it.
    pub(super) fn put(&mut self, id: JobId, bytes: Vec<u8>, build: Build) {
        let (job, bytes) = (Job(id.0), Arc::new(bytes));
        self.hold(job, &(Arc::clone(&bytes), Some(build)));
        let Some((folder, index)) = self.disk.as_mut() else {
            return;
        };
        if let Err(error) = ResultFile::write(folder, id, &bytes, build) {
            tracing::warn!("a result is not cached on disk: {error}");
            return;
        }
        for gone in index.put(job, ResultFile::size_of(&bytes)) {
            discard(folder, gone);
        }
    }

    fn hold(&mut self, job: Job, found: &CachedResult) {
        self.results.insert(job, found.clone());
        for gone in self.memory.put(job, found.0.len() as u64) {
            self.results.remove(&gone);
        }
    }
}

fn file(folder: &Path, job: Job) -> PathBuf {
    ResultFile::path(folder, JobId(job.0))
}

fn discard(folder: &Path, job: Job) {
    if let Err(error) = fs::remove_file(file(folder, job)) {
        tracing::warn!("a cached result stays on disk: {error}");
    }
}

/// What a folder holds, the oldest file first.
fn listed(folder: &Path) -> std::io::Result<Vec<(Job, u64)>> {
    state::folder(folder)?;
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if let Some(job) = ResultFile::job_of(&entry.path()) {
            let about = entry.metadata()?;
            found.push((about.modified()?, Job(job.0), about.len()));
        }
    }
    found.sort();
    Ok(found.into_iter().map(|(_, job, bytes)| (job, bytes)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result_file::HEAD;
    use cullet_proto::ids::digest;

    #[test]
    fn results_come_back_from_disk_and_damaged_ones_do_not() -> std::io::Result<()> {
        let folder = tempfile::tempdir()?;
        let disk = Some((folder.path().to_owned(), 170));
        let config = CacheConfig { memory: 100, disk };
        let [a, b, c] = [1, 2, 3].map(|k| JobId([k; 32]));
        let by = Build([3; 32]);
        let mut cache = Cache::open(&config);
        cache.put(a, vec![7; 10], by);
        cache.put(b, vec![8; 10], by);
        // A new life, which remembers only what is on disk.
        let mut cache = Cache::open(&config);
        assert_eq!(cache.get(a), Some((Arc::new(vec![7; 10]), Some(by))));
        let path = file(folder.path(), Job(b.0));
        let mut bytes = fs::read(&path)?;
        // The result's, or the build's.
        bytes[HEAD + 3] ^= 1;
        fs::write(&path, bytes)?;
        assert_eq!(cache.get(b), None);
        assert!(!path.exists());
        // No room for all: the least recently used goes, in memory and on disk.
        cache.put(c, vec![9; 40], by);
        assert!(cache.get(c).is_some() && cache.get(a).is_some());
        assert!(!file(folder.path(), Job(a.0)).exists());
        // One of before builds were kept is a result of nobody known.
        let old = [&digest(b"CULT")[..], b"CULT"].concat();
        fs::write(file(folder.path(), Job(a.0)), old)?;
        let mut cache = Cache::open(&config);
        assert_eq!(cache.get(a), Some((Arc::new(b"CULT".to_vec()), None)));
        assert_eq!((cache.look(c).and_then(|(_, build)| build), cache.hits), (Some(by), 1));
        let mut small = Cache::open(&CacheConfig { memory: 100, ..CacheConfig::default() });
        for k in 0..20 {
            small.put(JobId([k; 32]), vec![k; 10], by);
        }
        assert!(small.get(JobId([0; 32])).is_none() && small.get(JobId([19; 32])).is_some());
        assert_eq!((small.memory.held(), small.results.len()), (100, 10));
        Ok(())
    }
}
