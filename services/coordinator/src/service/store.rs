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
//! ```
//!
//! A file is whole or not there: it is written beside its place, written through, and renamed.

use super::ServiceError;
use crate::link::PoolConfig;
use crate::run::{UNFINISHED, write_file};
use cullet_proto::ids::digest;
use cullet_proto::{JobId, Verdict};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const MARK: &str = "cullet-state";
const TITLE: &str = "cullet state 1\n";
const NUMBERS: &str = "numbers";
/// A coordinator that was killed may take this long to be gone.
const DYING: Duration = Duration::from_secs(5);

/// The state folder of one coordinator.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    incarnation: Option<u32>,
    _lock: File,
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
        let fail = ServiceError::file(&folder);
        fs::create_dir_all(folder.join("runs")).map_err(&fail)?;
        let mark = folder.join(MARK);
        match fs::read_to_string(&mark) {
            Ok(text) if text == TITLE => {}
            Ok(text) => {
                let text = text.lines().next().unwrap_or_default().to_owned();
                return Err(ServiceError::Foreign { folder, text });
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let mut others = fs::read_dir(&folder).map_err(&fail)?.flatten();
                if let Some(other) = others.find(|entry| entry.file_name() != "runs") {
                    let text = other.file_name().to_string_lossy().into_owned();
                    return Err(ServiceError::Foreign { folder, text });
                }
                put(&mark, TITLE.as_bytes()).map_err(ServiceError::file(&mark))?;
            }
            Err(error) => return Err(ServiceError::file(&mark)(error)),
        }
        let path = folder.join("lock");
        let lock = File::create(&path).map_err(ServiceError::file(&path))?;
        let begun = Instant::now();
        while lock.try_lock().is_err() {
            if begun.elapsed() > DYING {
                return Err(ServiceError::Taken { folder });
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let mut store = Self { folder, incarnation: None, _lock: lock, own };
        if asked.is_some() {
            store.incarnation = Some(store.next_life()?);
        }
        Ok(store)
    }

    /// Counts the lives of this folder, before anything is done in this one.
    fn next_life(&self) -> Result<u32, ServiceError> {
        let path = self.folder.join("incarnation");
        let last = match fs::read_to_string(&path) {
            Ok(text) => text.trim().parse::<u32>().map_err(|_| ServiceError::Foreign {
                folder: self.folder.clone(),
                text: format!("incarnation {}", text.chars().take(40).collect::<String>()),
            })?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => 0,
            Err(error) => return Err(ServiceError::file(&path)(error)),
        };
        let next = last.wrapping_add(1);
        put(&path, format!("{next}\n").as_bytes()).map_err(ServiceError::file(&path))?;
        Ok(next)
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
    pub(super) fn given(&self, last: u64) -> u64 {
        let noted = fs::read_to_string(self.folder.join(NUMBERS)).ok();
        let noted = noted.and_then(|text| text.trim().parse().ok());
        let folders = fs::read_dir(self.folder.join("runs")).into_iter().flatten().flatten();
        let numbers = folders.filter_map(|folder| folder.file_name().to_str()?.parse().ok());
        numbers.chain(noted).fold(last, u64::max)
    }

    /// Notes up to which number runs have been.
    pub(super) fn give(&self, last: u64) -> Result<(), ServiceError> {
        let path = self.folder.join(NUMBERS);
        put(&path, format!("{last}\n").as_bytes()).map_err(ServiceError::file(&path))
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
        fs::create_dir(&folder).map_err(ServiceError::file(&folder))?;
        let path = folder.join("bundle");
        let put = put(&path, bytes).and_then(|()| sync(&self.folder.join("runs")));
        put.map_err(ServiceError::file(&path))
    }

    pub(super) fn bundle(&self, run: u64) -> Result<Vec<u8>, ServiceError> {
        let path = self.run(run).join("bundle");
        fs::read(&path).map_err(ServiceError::file(&path))
    }

    /// The verdicts of a run.
    pub(super) fn kept(&self, run: u64) -> Kept {
        Kept { folder: self.run(run).join("kept") }
    }

    /// Forgets all but these runs, and what a crash left unfinished.
    pub(super) fn sweep(&self, known: &dyn Fn(u64) -> bool) {
        let files = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        for file in files.filter(|f| f.file_name().to_string_lossy().starts_with(UNFINISHED)) {
            let _it_goes_next_time = fs::remove_file(file.path());
        }
        let runs = fs::read_dir(self.folder.join("runs")).into_iter().flatten().flatten();
        for folder in runs {
            let number = folder.file_name().to_str().and_then(|name| name.parse().ok());
            if number.is_some_and(|run| !known(run)) {
                remove(&folder.path());
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
        let bytes = fs::read(&path).ok()?;
        let (told, verdict) = bytes.split_at_checked(32)?;
        if told != digest(verdict) {
            tracing::warn!("{} is damaged: the job is done again", path.display());
            return None;
        }
        Verdict::decode(verdict).ok()
    }

    /// Keeps a verdict before anybody acts on it.
    pub(super) fn put(&self, job: JobId, verdict: &Verdict) -> io::Result<()> {
        let verdict = verdict.encode().map_err(|error| io::Error::other(error.to_string()))?;
        fs::create_dir_all(&self.folder)?;
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

/// Writes a file that is whole or not there, also after a crash of the machine.
pub(super) fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_file(path, bytes)?;
    path.parent().map_or(Ok(()), sync)
}

/// Writes a folder's names through.
fn sync(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
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
mod tests {
    use super::{Store, put};
    use crate::service::ServiceError;
    use cullet_geometry::Vec3;
    use cullet_proto::{BrokenBody, Grain, JobId, Verdict};

    #[test]
    fn a_folder_of_others_is_refused_and_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        put(&folder.path().join("thesis.tex"), b"x").expect("a file");
        let said = Store::open(Some(folder.path())).expect_err("it is somebody else's");
        assert!(said.to_string().contains("thesis.tex"), "{said}");
        let newer = tempfile::tempdir().expect("a folder");
        put(&newer.path().join(super::MARK), b"cullet state 9\n").expect("a file");
        let said = Store::open(Some(newer.path())).expect_err("it is newer");
        assert!(said.to_string().contains("cullet state 9"), "{said}");
    }

    #[test]
    fn one_coordinator_at_a_time() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = Store::open(Some(folder.path())).expect("it opens");
        let said = Store::open(Some(folder.path())).expect_err("it is taken");
        assert!(matches!(said, ServiceError::Taken { .. }), "{said}");
        drop(first);
        assert!(Store::open(Some(folder.path())).is_ok());
    }

    #[test]
    fn a_damaged_verdict_is_no_verdict() {
        let store = Store::open(None).expect("a folder of its own");
        let (kept, job) = (store.kept(1), JobId([7; 32]));
        assert_eq!(kept.get(job), None);
        let verdict = Verdict::Refused { solver: "brittle".into(), text: "thin".into() };
        kept.put(job, &verdict).expect("it is kept");
        assert_eq!(kept.get(job), Some(verdict));
        let path = store.run(1).join("kept").join(job.to_string());
        // One of numbers alone, in which a bit that turns makes another verdict as sound as it.
        let grain = |k: i32| Grain {
            position: Vec3::repeat(f64::from(k)),
            velocity: Vec3::zeros(),
            volume: 1.0,
            size: 0.5,
        };
        let debris = (0..20).map(grain).collect();
        let broken = Verdict::Broken(Box::new(BrokenBody { debris, ..BrokenBody::default() }));
        kept.put(job, &broken).expect("it is kept");
        let sound = std::fs::read(&path).expect("it is there");
        let mut passed = 0;
        for at in (0..sound.len()).step_by(7) {
            let mut bytes = sound.clone();
            bytes[at] ^= 1;
            passed += usize::from(bytes.get(32..).is_some_and(|b| Verdict::decode(b).is_ok()));
            std::fs::write(&path, bytes).expect("it is damaged");
            assert_eq!(kept.get(job), None, "byte {at}");
        }
        assert!(passed > 50, "only {passed} of them decode: the digest is not what is tested");
        kept.put(job, &broken).expect("it is kept again");
        assert_eq!(kept.get(job), Some(broken));
    }
}
