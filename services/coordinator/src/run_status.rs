//! What a run says while it goes on: lines, kept in a file too, how far it is, and its jobs.

use super::timeline::JobTimes;
use cullet_files::{regular, state};
use cullet_pool::Reproduction;
use cullet_proto::JobId;
use cullet_proto::service::{JobCounts, MAX_LINES, Position};
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Lines kept of a run in memory; the newest stay. The file has all of them.
const MAX_KEPT: usize = 4_096;
/// Longest line \[bytes\].
const MAX_LINE: usize = 400;
/// Most bytes of the file: what is said beyond it is not written there.
const MAX_FILE: u64 = 8 << 20;

/// What is shown for a line that is not as it was written.
const DAMAGED: &str = "(here was a line, which is torn or damaged)";

/// What one run says; its thread writes, whoever answers questions reads.
#[derive(Debug, Default)]
pub(super) struct RunStatus {
    inner: Mutex<Inner>,
}

#[derive(Debug, Default)]
struct Inner {
    lines: VecDeque<String>,
    dropped: u64,
    position: Option<Position>,
    jobs: JobCounts,
    timeline: Vec<JobTimes>,
    given_up: Option<JobId>,
    reproduction: Option<Reproduction>,
    /// Where lines are kept; opened for each of them, as there may be thousands of runs.
    path: Option<PathBuf>,
    written: u64,
}

impl RunStatus {
    /// With what the file says already.
    pub(super) fn open(path: &Path) -> Self {
        let mut inner = Inner::default();
        if let Ok(file) = regular::open(path) {
            inner.written = file.metadata().map_or(0, |known| known.len());
            let (mut sealed, mut bad) = (false, 0);
            for bytes in BufReader::new(file).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&bytes);
                inner.push(match state::read_line(&line) {
                    Ok((text, true)) => {
                        sealed = true;
                        text.to_owned()
                    }
                    // Those of before there were checksums come first.
                    Ok((text, false)) if !sealed => text.to_owned(),
                    _ => {
                        bad += 1;
                        DAMAGED.to_owned()
                    }
                });
            }
            if bad > 0 {
                tracing::warn!("{}: {bad} lines are torn or damaged", path.display());
            }
        }
        inner.path = Some(path.to_owned());
        Self { inner: Mutex::new(inner) }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says a line.
    pub(super) fn log(&self, line: &str) {
        let plain = line.replace(['\n', '\r'], " ");
        let line = plain[..plain.floor_char_boundary(MAX_LINE)].to_owned();
        let mut inner = self.inner();
        let kept = state::line(&line);
        inner.written += kept.len() as u64;
        let room = inner.written <= MAX_FILE;
        if let Some(path) = inner.path.as_ref().filter(|_| room)
            && let Err(error) = append(path, &kept)
        {
            tracing::warn!("{}: a line of a run is not in it: {error}", path.display());
        }
        inner.push(line);
    }

    pub(super) fn at(&self, position: Option<Position>) {
        self.inner().position = position;
    }

    pub(super) fn position(&self) -> Option<Position> {
        self.inner().position
    }

    /// An attempt begins: nothing is known of its jobs.
    pub(super) fn begin(&self) {
        let mut inner = self.inner();
        inner.jobs = JobCounts::default();
        inner.timeline.clear();
        inner.reproduction = None;
    }

    pub(super) fn opened(&self) {
        self.inner().jobs.opened += 1;
    }

    pub(super) fn settled(&self, job: JobTimes) {
        let mut inner = self.inner();
        inner.jobs.settled += 1;
        inner.jobs.kept += u64::from(job.kept);
        inner.jobs.resent += u64::from(job.attempts.saturating_sub(1));
        inner.timeline.push(job);
    }

    /// The run is over, and this job had not settled.
    pub(super) fn unsettled(&self, job: JobTimes) {
        self.inner().timeline.push(job);
    }

    /// The pool gave a job up.
    pub(super) fn give_up(&self, job: JobId, reproduction: Option<Reproduction>) {
        let mut inner = self.inner();
        (inner.given_up, inner.reproduction) = (Some(job), reproduction);
    }

    /// What reproduces that job, once.
    pub(super) fn reproduction(&self) -> Option<Reproduction> {
        self.inner().reproduction.take()
    }

    /// The job that the pool gave up, if it did.
    pub(super) fn given_up(&self) -> Option<JobId> {
        self.inner().given_up
    }

    pub(super) fn jobs(&self) -> JobCounts {
        self.inner().jobs
    }

    /// What was said last.
    pub(super) fn last_line(&self) -> Option<String> {
        self.inner().lines.back().cloned()
    }

    pub(super) fn timeline(&self) -> Vec<JobTimes> {
        self.inner().timeline.clone()
    }

    /// Lines from that one on, at most so many as an answer holds; what to ask for next; whether
    /// there is nothing after them.
    pub(super) fn lines(&self, from: u64) -> (Vec<String>, u64, bool) {
        let inner = self.inner();
        let skip = from.saturating_sub(inner.dropped) as usize;
        let lines: Vec<_> = inner.lines.iter().skip(skip).take(MAX_LINES).cloned().collect();
        let next = from.max(inner.dropped) + lines.len() as u64;
        (lines, next, next >= inner.dropped + inner.lines.len() as u64)
    }
}

fn append(path: &Path, line: &str) -> std::io::Result<()> {
    let mut file = regular::open_with(state::options().append(true).create(true), path)?;
    file.write_all(line.as_bytes())
}

impl Inner {
    fn push(&mut self, line: String) {
        self.lines.push_back(line);
        while self.lines.len() > MAX_KEPT {
            self.lines.pop_front();
            self.dropped += 1;
        }
    }
}

/// A clock that starts with an attempt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock(Instant);

impl Clock {
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    pub(super) fn now(self) -> f64 {
        self.at(Instant::now())
    }

    /// The same at another time, 0 before the start.
    pub(super) fn at(self, time: Instant) -> f64 {
        time.saturating_duration_since(self.0).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::{DAMAGED, MAX_KEPT, MAX_LINES, RunStatus};
    use cullet_files::state;

    #[test]
    fn lines_come_once_and_in_order_also_after_a_restart() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        let live = RunStatus::open(&path);
        let said: Vec<String> = (0..MAX_LINES + 5).map(|k| format!("line {k}")).collect();
        said.iter().for_each(|line| live.log(line));
        for live in [live, RunStatus::open(&path)] {
            let (mut seen, mut from) = (Vec::new(), 0);
            loop {
                let (lines, next, end) = live.lines(from);
                seen.extend(lines);
                from = next;
                if end {
                    break;
                }
            }
            assert_eq!(seen, said);
            assert_eq!(live.lines(from), (Vec::new(), from, true));
        }
    }

    /// A coordinator remembers thousands of runs, and may have fewer files open.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_run_that_is_remembered_holds_no_file_open() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        let live = RunStatus::open(&path);
        live.log("a line");
        let open = std::fs::read_dir("/proc/self/fd").expect("files").flatten();
        let of_it = open.filter_map(|file| std::fs::read_link(file.path()).ok());
        assert_eq!(of_it.filter(|target| *target == path).count(), 0);
        assert_eq!(std::fs::read_to_string(&path).expect("a log"), state::line("a line"));
    }

    #[test]
    fn a_line_in_which_a_bit_turned_is_not_shown_as_it_was_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        // Of before there were checksums.
        std::fs::write(&path, "an old line\n").expect("a log");
        let live = RunStatus::open(&path);
        ["one", "two"].iter().for_each(|line| live.log(line));
        let sound = std::fs::read(&path).expect("a log");
        assert_eq!(RunStatus::open(&path).lines(0).0, ["an old line", "one", "two"]);
        let second = sound.len() - state::line("two").len();
        for at in 8 * second..8 * (sound.len() - 1) {
            let mut bytes = sound.clone();
            bytes[at / 8] ^= 1 << (at % 8);
            std::fs::write(&path, &bytes).expect("a log");
            let lines = RunStatus::open(&path).lines(0).0;
            assert_eq!(lines[..2], ["an old line", "one"], "bit {at}");
            assert!(lines[2..].iter().all(|line| line == DAMAGED), "bit {at}: {lines:?}");
        }
    }

    #[test]
    fn the_newest_lines_stay_in_memory_and_one_line_is_one_line() {
        let live = RunStatus::default();
        (0..MAX_KEPT + 10).for_each(|k| live.log(&format!("{k}\nsecond")));
        let (lines, next, end) = live.lines(0);
        assert_eq!((lines[0].as_str(), next, end), ("10 second", 10 + MAX_LINES as u64, false));
    }
}
