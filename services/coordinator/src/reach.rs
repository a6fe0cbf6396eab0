//! How far each run is, on disk: so the next life of the coordinator knows where a run was that the
//! coordinator died in.

use super::board::Reached;
use cullet_files::clock::unix_ms;
use cullet_files::{regular, state};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the file beside a run's bundle that says how far it is.
const NAME: &str = "reached";
/// Between two writings, where no job settled.
const PERIOD: Duration = Duration::from_millis(200);

/// Writes how far an attempt at a run has come, for the coordinator's next start.
#[derive(Debug)]
pub(super) struct ReachWriter {
    path: PathBuf,
    file: Option<File>,
    told: Option<(Reached, Instant)>,
}

impl ReachWriter {
    pub(super) fn new(folder: &Path) -> Self {
        Self { path: folder.join(NAME), file: None, told: None }
    }

    /// Notes it, not more often than need be. Where the disk takes no more, it stays unknown.
    pub(super) fn note(&mut self, reached: Reached) {
        let soon = |(last, at): &(Reached, Instant)| {
            last.settled == reached.settled && at.elapsed() < PERIOD
        };
        if self.told.as_ref().is_some_and(soon) {
            return;
        }
        self.told = Some((reached, Instant::now()));
        if let Err(error) = self.write(reached) {
            tracing::debug!("{}: {error}", self.path.display());
        }
    }

    /// One write of one length in its place, so that a death leaves the last or the one before.
    fn write(&mut self, reached: Reached) -> io::Result<()> {
        if self.file.is_none() {
            let mut open = state::options();
            let options = open.write(true).create(true).truncate(false);
            self.file = Some(regular::open_with(options, &self.path)?);
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        file.seek(SeekFrom::Start(0))?;
        let Reached { time, settled } = reached;
        let text = format!("{time:020} {settled:020} {:013}", unix_ms());
        file.write_all(state::line(&text).as_bytes())
    }
}

/// The numbers in a run's folder that say how far it came; none where that is unknown.
fn numbers(folder: &Path) -> Vec<u64> {
    let (path, mut text) = (folder.join(NAME), Vec::new());
    let read = regular::open(&path).and_then(|file| file.take(128).read_to_end(&mut text));
    if let Err(error) = read {
        if error.kind() != io::ErrorKind::NotFound {
            tracing::warn!("{}: {error}", path.display());
        }
        return Vec::new();
    }
    let line = String::from_utf8_lossy(&text);
    let numbers = state::read_line(line.strip_suffix('\n').unwrap_or(&line))
        .and_then(|(line, sealed)| whole(line, sealed).ok_or("it is no line of numbers"));
    let bad = |why: &&str| tracing::warn!("{} is damaged: {why}", path.display());
    numbers.inspect_err(bad).unwrap_or_default()
}

/// The numbers of a line; those of one that is older than checksums may be fewer.
fn whole(line: &str, sealed: bool) -> Option<Vec<u64>> {
    let numbers: Option<Vec<u64>> = line.split(' ').map(|word| word.parse().ok()).collect();
    // A bit that turned in the mark makes one more of a checksum without letters.
    numbers.filter(|numbers| numbers.len() == 3 || !sealed && numbers.len() < 3)
}

/// When that was last noted \[ms since 1970\].
pub(super) fn seen(folder: &Path) -> Option<u64> {
    numbers(folder).get(2).copied()
}

/// How far a run came; nothing where that is unknown.
pub(super) fn reached(folder: &Path) -> Reached {
    match numbers(folder)[..] {
        [time, settled, ..] => Reached { time, settled },
        _ => Reached::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::{ReachWriter, Reached, reached, seen};
    use cullet_files::clock::unix_ms;
    use cullet_files::state;
    use std::path::Path;

    #[test]
    fn how_far_it_is_is_read_again_also_when_that_is_less() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!((reached(folder.path()), seen(folder.path())), (Reached::default(), None));
        let begun = unix_ms();
        for (time, settled) in [(u64::MAX, 3), (5, 0), (7, 1)] {
            let mut reach = ReachWriter::new(folder.path());
            reach.note(Reached { time, settled });
            assert_eq!(reached(folder.path()), Reached { time, settled });
            // A job that settled is noted at once, whatever the clock says.
            reach.note(Reached { time, settled: settled + 1 });
            assert_eq!(reached(folder.path()).settled, settled + 1);
            assert!(seen(folder.path()).is_some_and(|at| at >= begun));
        }
        // As it was written before it had a time.
        std::fs::write(folder.path().join(super::NAME), "12 3").expect("an older one");
        let at = (reached(folder.path()), seen(folder.path()));
        assert_eq!(at, (Reached { time: 12, settled: 3 }, None));
        std::fs::write(folder.path().join(super::NAME), "12").expect("torn");
        assert_eq!(reached(folder.path()), Reached::default());
    }

    #[test]
    fn how_far_it_is_is_not_known_where_a_bit_turned() {
        let folder = tempfile::tempdir().expect("a folder");
        let told = Reached { time: 5, settled: 3 };
        ReachWriter::new(folder.path()).note(told);
        let path = folder.path().join(super::NAME);
        let sound = std::fs::read(&path).expect("a file");
        assert_eq!(reached(folder.path()), told);
        // And one whose checksum could pass for a number.
        let plain = |ms: &u64| {
            let line = state::line(&format!("5 3 {ms}"));
            line.trim_end().bytes().rev().take(8).all(|digit| digit.is_ascii_digit())
        };
        let plain = (unix_ms()..).find(plain).map(|ms| state::line(&format!("5 3 {ms}")));
        for sound in [sound, plain.expect("some").into_bytes()] {
            turned(&path, &sound, told);
        }
    }

    fn turned(path: &Path, sound: &[u8], told: Reached) {
        let folder = path.parent().expect("a folder");
        for at in 0..8 * sound.len() {
            let mut bytes = sound.to_vec();
            bytes[at / 8] ^= 1 << (at % 8);
            std::fs::write(path, &bytes).expect("a file");
            let read = reached(folder);
            let end = at / 8 + 1 == sound.len();
            assert!(read == Reached::default() || end && read == told, "bit {at}: {read:?}");
        }
    }
}
