//! A file that is there only while one process writes it, which holds a lock on it: what is left
//! of one that was killed is known by that.

use super::regular;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::Duration;

/// How often a file is made anew that another process takes for left behind.
const TRIES: u32 = 16;
/// How long nobody has written a file that is left behind, where a file system has no locks
/// \[s\].
const IDLE: u64 = 3600;

/// Makes a file, and locks it where the file system has locks.
///
/// # Errors
/// It is there, and being written ([`ErrorKind::AlreadyExists`]); the file system says no.
pub fn create(path: &Path) -> io::Result<File> {
    create_with(path, &mut File::lock)
}

fn create_with(path: &Path, lock: &mut dyn FnMut(&File) -> io::Result<()>) -> io::Result<File> {
    for _ in 0..TRIES {
        let file = File::create_new(path)?;
        match lock(&file) {
            Err(error) if !has_no_locks(&error) => return Err(error),
            _ => {}
        }
        // Until it was locked, another process could take it for left behind and delete it.
        if is_at(&file, path) {
            return Ok(file);
        }
    }
    Err(io::Error::new(ErrorKind::ResourceBusy, "others delete it as soon as it is there"))
}

/// Deletes a file that was made so if it was left behind; what may not be deleted stays.
pub fn clear(path: &Path) {
    clear_with(path, &mut File::try_lock);
}

fn clear_with(path: &Path, lock: &mut dyn FnMut(&File) -> Result<(), TryLockError>) {
    let Ok(file) = regular::open(path) else { return };
    let is_left = match lock(&file) {
        Ok(()) => true,
        Err(TryLockError::Error(error)) => has_no_locks(&error) && is_idle(&file),
        Err(TryLockError::WouldBlock) => false,
    };
    if is_left && is_at(&file, path) {
        // It is still locked: nobody takes its name in between.
        let _it_stays = fs::remove_file(path);
    }
}

/// Locks a folder for as long as what is returned is kept, so that two processes do not write and
/// delete the same files of it. Where a file system has no locks on folders, there is none.
///
/// # Errors
/// Another holds it ([`ErrorKind::ResourceBusy`]).
pub fn hold_folder(path: &Path) -> io::Result<Option<File>> {
    let Ok(folder) = File::open(path) else { return Ok(None) };
    match folder.try_lock() {
        Ok(()) => Ok(Some(folder)),
        Err(TryLockError::Error(_)) => Ok(None),
        Err(TryLockError::WouldBlock) => {
            Err(io::Error::new(ErrorKind::ResourceBusy, "another run is being written into it"))
        }
    }
}

/// Whether an error says that a file system has no locks at all.
fn has_no_locks(error: &io::Error) -> bool {
    #[cfg(unix)]
    if error.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error()) {
        return true;
    }
    error.kind() == ErrorKind::Unsupported
}

fn is_idle(file: &File) -> bool {
    let written = file.metadata().and_then(|about| about.modified());
    let since = written.ok().and_then(|written| written.elapsed().ok());
    since.is_some_and(|since| since > Duration::from_secs(IDLE))
}

/// Whether a file still has its name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |about: fs::Metadata| (about.dev(), about.ino());
    let (own, named) = (file.metadata().map(number), fs::symlink_metadata(path).map(number));
    own.is_ok_and(|own| named.is_ok_and(|named| own == named))
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::{IDLE, clear_with, create, create_with, hold_folder};
    use std::fs::{self, File, TryLockError};
    use std::io::ErrorKind;
    use std::time::{Duration, SystemTime};

    #[test]
    fn a_folder_is_held_by_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let held = hold_folder(folder.path()).expect("free");
        assert!(held.is_some(), "no locks on folders here");
        let second = hold_folder(folder.path()).map(|_| ()).map_err(|error| error.kind());
        assert_eq!(second, Err(ErrorKind::ResourceBusy));
        drop(held);
        assert!(hold_folder(folder.path()).is_ok());
    }

    #[test]
    fn a_file_that_is_deleted_before_it_is_locked_is_made_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("it");
        let mut times = 0;
        let file = create_with(&path, &mut |file| {
            times += 1;
            if times == 1 {
                fs::remove_file(&path)?;
            }
            file.lock()
        });
        assert!(file.is_ok() && path.exists() && times == 2);
        assert!(File::open(&path).expect("opens").try_lock().is_err(), "it is locked");
        let again = create(&path).expect_err("it is being written");
        assert_eq!(again.kind(), ErrorKind::AlreadyExists);
        drop(file);
        fs::remove_file(&path).expect("it is there");
        let never = create_with(&path, &mut |_| fs::remove_file(&path));
        assert_eq!(never.expect_err("it never stays").kind(), ErrorKind::ResourceBusy);
    }

    #[test]
    fn a_name_that_another_file_has_by_now_is_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("it");
        fs::write(&path, "left").expect("writes");
        clear_with(&path, &mut |file| {
            fs::write(folder.path().join("new"), "at work").expect("writes");
            fs::rename(folder.path().join("new"), &path).expect("it takes the name");
            file.try_lock()
        });
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "at work");
    }

    #[test]
    fn without_locks_a_file_is_made_and_one_that_nobody_writes_any_more_is_deleted() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("it");
        let file = create_with(&path, &mut |_| Err(ErrorKind::Unsupported.into()));
        let file = file.expect("there are no locks");
        let mut none = |_: &File| Err(TryLockError::Error(ErrorKind::Unsupported.into()));
        clear_with(&path, &mut none);
        assert!(path.exists(), "somebody may write it");
        let before = SystemTime::now() - Duration::from_secs(IDLE + 60);
        file.set_modified(before).expect("a time");
        clear_with(&path, &mut none);
        assert!(!path.exists(), "it was left behind");
        let refused = create_with(&path, &mut |_| Err(ErrorKind::PermissionDenied.into()));
        assert_eq!(refused.expect_err("refused").kind(), ErrorKind::PermissionDenied);
    }
}
