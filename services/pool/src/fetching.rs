//! A fetch that goes on in a folder: while it does, and where it was broken off, a file there says
//! what of, so that the same one may go on there, and no other.

use super::error::LinkError;
use cullet_files::output::UNFINISHED;
use cullet_files::regular;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Most bytes of the file that are looked at.
const MOST: u64 = 1 << 20;

/// A fetch that goes on.
#[derive(Debug)]
pub struct Fetching {
    path: PathBuf,
    /// Locked while it goes on.
    _file: File,
}

impl Fetching {
    /// Begins one, or goes on with the same. `what`: what is fetched.
    ///
    /// # Errors
    /// [`LinkError::Occupied`] where another was broken off or goes on; a disk that does not take
    /// it.
    pub fn begin(folder: &Path, what: &str) -> Result<Self, LinkError> {
        let path = place(folder);
        let failed = |source| LinkError::File { path: path.clone(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let mut open = OpenOptions::new();
        let open = open.read(true).write(true).create(true).truncate(false);
        let open = regular::open_with(open, &path);
        let mut file = open.map_err(failed)?;
        let occupied = |why| Err(LinkError::Occupied { folder: folder.to_owned(), why });
        if file.try_lock().is_err() {
            return occupied("another fetch goes on there");
        }
        let mut there = Vec::new();
        (&file).take(MOST).read_to_end(&mut there).map_err(failed)?;
        // One that was killed as it began has said a part of it, or nothing.
        if !what.as_bytes().starts_with(&there) {
            return occupied("the fetch of another run was broken off there");
        }
        file.rewind().and_then(|()| file.write_all(what.as_bytes())).map_err(failed)?;
        file.sync_all().map_err(failed)?;
        Ok(Self { path: place(folder), _file: file })
    }

    /// All is there.
    ///
    /// # Errors
    /// The disk does not let the file go.
    pub fn done(self) -> Result<(), LinkError> {
        let gone = std::fs::remove_file(&self.path);
        gone.map_err(|source| LinkError::File { path: self.path.clone(), source })
    }

    /// Takes back what one has left in a folder that has nothing else: nothing came of it.
    pub fn take_back(folder: &Path) {
        let all = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let all: Vec<PathBuf> = all.map(|file| file.path()).collect();
        let own = place(folder).to_string_lossy().into_owned();
        if all.iter().all(|path| path.to_string_lossy().starts_with(&own)) {
            all.iter().for_each(|path| drop(std::fs::remove_file(path)));
        }
    }

    /// Whether one was broken off there, or goes on.
    #[must_use]
    pub fn is_in(folder: &Path) -> bool {
        place(folder).is_file()
    }
}

fn place(folder: &Path) -> PathBuf {
    folder.join(format!("{UNFINISHED}fetch"))
}

/// Where a file is until it is whole.
pub(super) fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{UNFINISHED}fetch-{name}"))
}

#[cfg(test)]
mod tests {
    use super::{Fetching, LinkError, place};
    use std::fs;

    #[test]
    fn a_fetch_that_was_broken_off_goes_on_and_no_other_does() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, what) = (folder.path(), "run 7: run.mcap 0123");
        let first = Fetching::begin(path, what).expect("it begins");
        let occupied = |what| match Fetching::begin(path, what) {
            Err(LinkError::Occupied { why, .. }) => why,
            other => panic!("{other:?}"),
        };
        assert!(occupied(what).contains("goes on"));
        drop(first);
        assert!(Fetching::is_in(path));
        assert!(occupied("run 8: run.mcap 4567").contains("broken off"));
        // Killed at any byte of what it says.
        for cut in 0..=what.len() {
            fs::write(place(path), &what[..cut]).expect("a file");
            drop(Fetching::begin(path, what).expect("it goes on"));
            assert_eq!(fs::read_to_string(place(path)).expect("a file"), what);
        }
        Fetching::begin(path, what).expect("it goes on").done().expect("it is over");
        assert!(!Fetching::is_in(path));
    }
}
