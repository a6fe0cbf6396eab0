//! The workers that somebody has drained, on disk, so that they get none of the next life either: a
//! line a worker's life, written through before anybody gets an answer.

use cullet_dispatch::Worker;
use cullet_files::{regular, state};
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// Lives remembered; beyond it the oldest, which ended long ago, are forgotten.
const MAX_KEPT: usize = 4_096;

#[derive(Debug)]
pub(super) struct DrainedLives {
    path: PathBuf,
    lives: VecDeque<Worker>,
}

impl DrainedLives {
    /// Those of all lives before.
    pub(super) fn open(path: &Path) -> Self {
        let lives = read(path).unwrap_or_else(|error| {
            tracing::error!("{}: {error}: who was drained gets jobs again", path.display());
            // The next that is drained would take its place.
            cullet_files::set_aside::damaged(path);
            VecDeque::new()
        });
        Self { path: path.to_owned(), lives }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Worker> {
        self.lives.iter().copied()
    }

    /// One more, if it is.
    pub(super) fn keep(&mut self, worker: Worker) {
        if self.lives.contains(&worker) {
            return;
        }
        self.lives.push_back(worker);
        if self.lives.len() > MAX_KEPT {
            self.lives.pop_front();
        }
        if let Err(error) = self.write() {
            tracing::error!("{}: {error}: a next life does not know of it", self.path.display());
        }
    }

    /// Whole or not at all: written beside, written through, and renamed.
    fn write(&self) -> Result<()> {
        let text: String = self.lives.iter().map(|life| format!("{:016x}\n", life.0)).collect();
        state::put(&self.path, state::seal(&text).as_bytes())
    }
}

fn read(path: &Path) -> Result<VecDeque<Worker>> {
    let text = match regular::read_text(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(VecDeque::new()),
        text => text?,
    };
    let text = state::unseal(&text).map_err(Error::other)?;
    let life = |line: &str| u64::from_str_radix(line, 16).map(Worker).map_err(Error::other);
    text.lines().map(life).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn who_was_drained_is_known_to_the_next_life_up_to_a_bound() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("drained");
        let mut kept = DrainedLives::open(&path);
        assert_eq!(kept.iter().count(), 0);
        kept.keep(Worker(7));
        kept.keep(Worker(u64::MAX));
        kept.keep(Worker(7));
        let next = DrainedLives::open(&path);
        assert_eq!(next.iter().collect::<Vec<_>>(), [Worker(7), Worker(u64::MAX)]);
        // A bit that turned makes no other worker of it; the file is kept for whoever looks at it.
        let sound = fs::read(&path).expect("the file");
        for at in 0..8 * sound.len() {
            let mut bytes = sound.clone();
            bytes[at / 8] ^= 1 << (at % 8);
            fs::write(&path, bytes).expect("it is damaged");
            assert_eq!(DrainedLives::open(&path).iter().count(), 0, "bit {at}");
            assert!(!path.exists(), "bit {at}");
        }
        let aside = fs::read_dir(folder.path().join("set-aside")).expect("a folder").count();
        assert_eq!(aside, 8 * sound.len());
        // Of before there were checksums.
        let many: String = (0..MAX_KEPT).map(|k| format!("{k:016x}\n")).collect();
        fs::write(&path, many).expect("it is written");
        let mut next = DrainedLives::open(&path);
        next.keep(Worker(1 << 40));
        let next = DrainedLives::open(&path);
        assert_eq!((next.iter().next(), next.iter().count()), (Some(Worker(1)), MAX_KEPT));
    }
}
