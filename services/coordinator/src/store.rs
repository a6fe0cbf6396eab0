//! The state folder:
//!
//! ```text
//! DIR/cullet-state          what this folder is, and its generation
//! DIR/lock                  held by the coordinator that uses it
//! DIR/incarnation           how often it was opened: tells grants of an earlier life apart
//! DIR/journal               what happened
//! DIR/at-work               jobs at workers, which the next life lets go on
//! DIR/drained               workers that get no further job
//! DIR/numbers               up to which number runs have been, whose folders are gone
//! DIR/runs/7/bundle         the scene with its files
//! DIR/runs/7/log            what it said
//! DIR/runs/7/kept/<job>     verdicts of settled jobs, until the run is done
//! DIR/runs/7/reached        how far it came
//! DIR/runs/7/timeline       who had which job when in each of its attempts, until it is done
//! DIR/cache/                results of finished jobs, for any run, bounded
//! DIR/quarantine/           what reproduces a job that killed its workers
//! DIR/recordings/pot-1/     what it recorded, unless --out says elsewhere
//! DIR/set-aside/            what a start found and nobody knew of
//! ```
//!
//! A file is whole or not there: it is written beside its place, written through, and renamed. The
//! folder and its files are their owner's alone. A bit that turned is found wherever it is read:
//! the journal has the digest of each bundle, and the other files have checksums
//! (`cullet_files::state`). A folder of the first generation has none, and is read as it is; the
//! first start makes it one of the second, which a program of before does not open.

use super::error::ServiceError;
use cullet_files::output::UNFINISHED;
use cullet_files::state::{self, put, sync};
use cullet_files::{regular, set_aside};
use cullet_pool::PoolConfig;
use cullet_proto::ids::digest;
use cullet_proto::service::hex_of;
use cullet_proto::{JobId, Verdict};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const MARK: &str = "cullet-state";
const TITLE: &str = "cullet state 2\n";
/// Of folders whose files have no checksums yet.
const OLD_TITLE: &str = "cullet state 1\n";
const NUMBERS: &str = "numbers";
/// A coordinator that was killed may take this long to be gone.
const DYING: Duration = Duration::from_secs(5);

/// The state folder of one coordinator.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    incarnation: Option<u32>,
    lock: File,
    /// Gone with the store, where nobody named a folder.
    own: Option<tempfile::TempDir>,
}

impl Store {
    /// Opens or begins a state folder; `None` is one that is gone in the end.
    ///
    /// # Errors
    /// The disk says no, it is no such folder, or another coordinator uses it.
    pub fn open(asked: Option<&Path>) -> Result<Self, ServiceError> {
        let own = match asked {
            Some(_) => None,
            None => Some(tempfile::tempdir().map_err(ServiceError::file(&std::env::temp_dir()))?),
        };
        let given = asked.map(Path::to_owned);
        let folder = given.or_else(|| own.as_ref().map(|own| own.path().to_owned()));
        let folder = folder.unwrap_or_default();
        state::folder(&folder).map_err(ServiceError::file(&folder))?;
        let old = marked(&folder)?;
        let lock = locked(&folder)?;
        let fail = ServiceError::file(&folder);
        state::hide(&folder).map_err(&fail)?;
        state::folder(&folder.join("runs")).map_err(&fail)?;
        if old {
            put(&folder.join(MARK), TITLE.as_bytes()).map_err(&fail)?;
        }
        let mut store = Self { folder, incarnation: None, lock, own };
        if asked.is_some() {
            store.incarnation = Some(store.next_life()?);
        }
        Ok(store)
    }

    /// Counts the lives of this folder, before anything is done in this one.
    fn next_life(&self) -> Result<u32, ServiceError> {
        let path = self.folder.join("incarnation");
        let mend = "write a number into it that is larger than any before";
        let last = read_number(&path, mend)?.unwrap_or(0);
        let wide = |_| damaged(&path, "it is larger than 4294967295", mend);
        let next = u32::try_from(last).map_err(wide)?.wrapping_add(1);
        let text = state::number(next.into());
        put(&path, text.as_bytes()).map_err(ServiceError::file(&path))?;
        Ok(next)
    }

    /// Keeps the folder locked until the process ends: something in it may still write there.
    pub(super) fn keep_locked(&self) {
        match self.lock.try_clone() {
            Ok(lock) => std::mem::forget(lock),
            Err(error) => tracing::error!("{}: {error}: unlocked", self.folder.display()),
        }
    }

    /// Where it is, if somebody named it.
    #[must_use]
    pub fn named(&self) -> Option<&Path> {
        self.own.is_none().then_some(&self.folder)
    }

    /// The settings of a pool whose results and epochs outlive it, as far as this folder does.
    /// `cache`: most bytes of results kept on disk; 0 is none.
    #[must_use]
    pub fn pool(&self, mut config: PoolConfig, cache: u64) -> PoolConfig {
        if self.named().is_some() {
            config.incarnation = self.incarnation;
            config.quarantine = Some(self.folder.join("quarantine"));
            config.drained = Some(self.folder.join("drained"));
            config.at_work = Some(self.folder.join("at-work"));
            config.cache.disk = (cache > 0).then(|| (self.folder.join("cache"), cache));
        }
        config
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    pub(super) fn run(&self, run: u64) -> PathBuf {
        self.folder.join("runs").join(run.to_string())
    }

    /// Up to which number runs have been here: that of the journal, which a hand may have cut, or
    /// a higher one that is noted or that a folder has.
    ///
    /// # Errors
    /// What is noted cannot be read.
    pub(super) fn given(&self, last: u64) -> Result<u64, ServiceError> {
        let mend = "write the number of the last run into it, or delete it where none was deleted";
        let noted = read_number(&self.folder.join(NUMBERS), mend)?;
        let folders = fs::read_dir(self.folder.join("runs")).into_iter().flatten().flatten();
        let numbers = folders.filter_map(|folder| folder.file_name().to_str()?.parse().ok());
        Ok(numbers.chain(noted).fold(last, u64::max))
    }

    /// Notes up to which number runs have been.
    pub(super) fn give(&self, last: u64) -> Result<(), ServiceError> {
        let path = self.folder.join(NUMBERS);
        put(&path, state::number(last).as_bytes()).map_err(ServiceError::file(&path))
    }

    /// Keeps the scene of a run that is about to be written into the journal.
    pub(super) fn keep_bundle(&self, run: u64, bytes: &[u8]) -> Result<(), ServiceError> {
        let folder = self.run(run);
        // One that was never written into the journal may have left something.
        match fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(ServiceError::file(&folder)(error));
            }
            _ => {}
        }
        state::folder(&folder).map_err(ServiceError::file(&folder))?;
        let path = folder.join("bundle");
        let written = put(&path, bytes).and_then(|()| sync(&self.folder.join("runs")));
        written.map_err(ServiceError::file(&path))
    }

    /// The scene of a run. `told`: its digest, as the journal has it; empty where that is older.
    pub(super) fn bundle(&self, run: u64, told: &str) -> Result<Vec<u8>, ServiceError> {
        let path = self.run(run).join("bundle");
        let bytes = regular::read(&path).map_err(ServiceError::file(&path))?;
        let found = hex_of(&digest(&bytes));
        if told.is_empty() || told == found {
            return Ok(bytes);
        }
        let why = format!("its digest is {found}, and that of what was handed in {told}");
        let mend = "put a sound copy in its place and retry the run, or hand the scene in again";
        Err(damaged(&path, &why, mend))
    }

    /// The verdicts of a run.
    pub(super) fn kept(&self, run: u64) -> Kept {
        Kept { folder: self.run(run).join("kept") }
    }

    /// Sets aside all but these runs, and what a crash left unfinished.
    pub(super) fn sweep(&self, known: &dyn Fn(u64) -> bool) {
        let aside = |path: &Path, why| set_aside::tell(&self.folder, path, why);
        let unfinished = |folder: &Path| {
            let files = fs::read_dir(folder).into_iter().flatten().flatten();
            for file in files.filter(|f| f.file_name().to_string_lossy().starts_with(UNFINISHED)) {
                aside(&file.path(), "a crash left it unfinished");
            }
        };
        unfinished(&self.folder);
        let runs = fs::read_dir(self.folder.join("runs")).into_iter().flatten().flatten();
        for folder in runs {
            let number = folder.file_name().to_str().and_then(|name| name.parse().ok());
            match number {
                Some(run) if !known(run) => {
                    aside(&folder.path(), "the journal knows of no such run, or of none any more");
                }
                _ => unfinished(&folder.path()),
            }
        }
    }

    /// Removes what is kept of a run.
    pub(super) fn forget(&self, run: u64) -> io::Result<()> {
        match fs::remove_dir_all(self.run(run)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    /// Bytes that may still be written here.
    pub(super) fn free_bytes(&self) -> Option<u64> {
        free(&self.folder)
    }
}

/// Verdicts of one run, by job.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    folder: PathBuf,
}

impl Kept {
    /// The verdict of a job that was settled before, if it is there and sound.
    pub(super) fn get(&self, job: JobId) -> Option<Verdict> {
        let path = self.folder.join(job.to_string());
        let bytes = match regular::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
            bytes => {
                bytes.inspect_err(|error| tracing::warn!("{}: {error}", path.display())).ok()?
            }
        };
        let sound = bytes.split_at_checked(32).filter(|(told, verdict)| *told == digest(verdict));
        let verdict = sound.and_then(|(_, verdict)| Verdict::decode(verdict).ok());
        if verdict.is_none() {
            tracing::warn!("{} is damaged: the job is done again", path.display());
        }
        verdict
    }

    /// Keeps a verdict before anybody acts on it.
    pub(super) fn put(&self, job: JobId, verdict: &Verdict) -> io::Result<()> {
        let verdict = verdict.encode().map_err(|error| io::Error::other(error.to_string()))?;
        state::folder(&self.folder)?;
        let bytes = [&digest(&verdict)[..], &verdict].concat();
        put(&self.folder.join(job.to_string()), &bytes)
    }

    pub(super) fn forget(&self) {
        remove(&self.folder);
    }
}

/// Bytes that may still be written into a folder, where the system tells.
#[must_use]
pub fn free(folder: &Path) -> Option<u64> {
    #[cfg(unix)]
    let room = rustix::fs::statvfs(folder).ok().map(|disk| disk.f_bavail * disk.f_frsize);
    #[cfg(not(unix))]
    let room = folder.exists().then_some(u64::MAX);
    room
}

/// Bytes of the disk that a folder is on, where the system tells.
#[must_use]
pub fn total(folder: &Path) -> Option<u64> {
    #[cfg(unix)]
    let size = rustix::fs::statvfs(folder).ok().map(|disk| disk.f_blocks * disk.f_frsize);
    #[cfg(not(unix))]
    let size = None;
    size
}

/// Whether a state folder is one of the first generation. One that is empty becomes one of this.
fn marked(folder: &Path) -> Result<bool, ServiceError> {
    let mark = folder.join(MARK);
    match regular::read_text(&mark) {
        Ok(text) if text == TITLE || text == OLD_TITLE => Ok(text == OLD_TITLE),
        Ok(text) => {
            let text = text.lines().next().unwrap_or_default().to_owned();
            Err(ServiceError::Foreign { folder: folder.to_owned(), text })
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let all = fs::read_dir(folder).map_err(ServiceError::file(folder))?;
            // A coordinator that was killed as it made the mark leaves a part of it.
            let ours = |name: &str| name == "runs" || name.starts_with(UNFINISHED);
            let mut names =
                all.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
            if let Some(text) = names.find(|name| !ours(name)) {
                return Err(ServiceError::Foreign { folder: folder.to_owned(), text });
            }
            put(&mark, TITLE.as_bytes()).map_err(ServiceError::file(&mark))?;
            Ok(false)
        }
        Err(error) => Err(ServiceError::file(&mark)(error)),
    }
}

/// Takes a state folder for this coordinator alone.
fn locked(folder: &Path) -> Result<File, ServiceError> {
    let path = folder.join("lock");
    let mut open = state::options();
    let lock = regular::open_with(open.write(true).create(true).truncate(true), &path);
    let lock = lock.map_err(ServiceError::file(&path))?;
    let begun = Instant::now();
    while lock.try_lock().is_err() {
        if begun.elapsed() > DYING {
            return Err(ServiceError::Taken { folder: folder.to_owned() });
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(lock)
}

/// A number that is kept in a file; none where there is no such file.
fn read_number(path: &Path, mend: &'static str) -> Result<Option<u64>, ServiceError> {
    match regular::read(path) {
        Ok(bytes) => match state::read_number(&bytes) {
            Ok(number) => Ok(Some(number)),
            Err(why) => Err(damaged(path, why, mend)),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(ServiceError::file(path)(error)),
    }
}

fn damaged(path: &Path, why: &str, mend: &'static str) -> ServiceError {
    ServiceError::Damaged { path: path.to_owned(), why: why.to_owned(), mend }
}

fn remove(folder: &Path) {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            tracing::warn!("{}: {error}", folder.display());
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests;
