//! What the attempts at a run write down of its timeline, so that a later one, also in another life
//! of the coordinator, tells of all of them.
//!
//! A line as a job is wanted, as a worker is given it or loses it, and as it settles, in a file
//! beside the run's bundle; no part of what the run is or records. A line that is torn is left out;
//! jobs beyond [`MOST`] bytes are not written, and that alone is reported.

use super::{Attempts, JobAttempt, JobFate, JobTimes, Timeline};
use crate::reach::seen;
use cullet_files::{regular, state};
use cullet_proto::verdict;
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Name of the file in a run's part of the state folder.
const NAME: &str = "timeline";
/// Most bytes that jobs of all attempts take.
const MOST: u64 = 8 << 20;
/// Bytes beyond them for where attempts begin and end.
const EDGES: u64 = 64 << 10;

/// A line of the file that a timeline is kept in.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TimelineLine {
    /// An attempt begins at that time; when the one before was last seen to go on
    /// \[ms since 1970\].
    Began { attempt: u32, at: u64, seen: Option<u64> },
    /// It wants a job; times are since it began \[s\].
    Opened { job: String, at: f64 },
    /// Somebody was given the job, or has lost it.
    Attempted(JobAttempt),
    /// A job of it settled.
    Settled(JobTimes),
    /// It ends, in order.
    Ended { at: f64 },
    /// There was no room for a job.
    Full,
}

/// The file of one run, as one attempt has it.
#[derive(Debug)]
pub(crate) struct RunHistory {
    path: PathBuf,
    attempt: u32,
    began: u64,
    /// Where lines go, and how long it is; nowhere, where the disk does not take them.
    file: RefCell<Option<(File, u64)>>,
    /// Whether a job of this attempt found no room.
    full: Cell<bool>,
}

impl RunHistory {
    /// An attempt begins at `now`. `seen`: when the coordinator was last seen to work on an attempt
    /// before \[ms since 1970\].
    pub(crate) fn begin(folder: &Path, attempt: u32, now: u64, seen: Option<u64>) -> Self {
        let path = folder.join(NAME);
        let file = regular::open_with(state::options().append(true).create(true), &path);
        let file = file.and_then(|file| Ok((file.metadata()?.len(), file)));
        let file = file.map(|(length, file)| (file, length));
        let file = file.inspect_err(|error| tracing::warn!("{}: {error}", path.display())).ok();
        let past =
            Self { path, attempt, began: now, file: RefCell::new(file), full: Cell::default() };
        past.put(&TimelineLine::Began { attempt, at: now, seen }, MOST + EDGES);
        past
    }

    /// A job is wanted that was not kept.
    pub(crate) fn opened(&self, job: &str, at: f64) {
        self.put_job(&TimelineLine::Opened { job: job.to_owned(), at: short(at) });
    }

    /// Somebody was given it, or has lost it.
    pub(crate) fn attempted(&self, one: &JobAttempt) {
        let mut one = one.clone();
        one.at = short(one.at);
        one.lost = one.lost.as_deref().map(verdict::cut);
        self.put_job(&TimelineLine::Attempted(one));
    }

    /// It settled.
    pub(crate) fn settled(&self, job: &JobTimes) {
        let mut job = job.clone();
        (job.opened, job.settled) = (short(job.opened), short(job.settled));
        for one in &mut job.tries {
            (one.from, one.to) = (short(one.from), short(one.to));
            one.lost = verdict::cut(&one.lost);
        }
        self.put_job(&TimelineLine::Settled(job));
    }

    /// The attempt ends, in order.
    pub(crate) fn ended(&self, at: f64) {
        self.put(&TimelineLine::Ended { at: short(at) }, MOST + EDGES);
    }

    /// The timeline of the run with these jobs of this attempt.
    pub(crate) fn timeline(&self, jobs: Vec<JobTimes>) -> Timeline {
        let mut all = earlier(&read(&self.path), self.attempt, None);
        all.add((self.attempt, self.began), jobs, 0.0, false);
        all
    }

    /// The timeline of a run that does not go on, from its part of the state folder.
    pub(crate) fn left(folder: &Path) -> Timeline {
        earlier(&read(&folder.join(NAME)), u32::MAX, seen(folder))
    }

    /// Nothing comes after this run.
    pub(crate) fn forget(folder: &Path) {
        match fs::remove_file(folder.join(NAME)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                tracing::warn!("{}: {error}", folder.display());
            }
            _ => {}
        }
    }

    fn put_job(&self, line: &TimelineLine) {
        if !self.put(line, MOST) && !self.full.replace(true) {
            self.put(&TimelineLine::Full, MOST + EDGES);
        }
    }

    /// Writes a line where the file is shorter than that; whether it was.
    fn put(&self, line: &TimelineLine, most: u64) -> bool {
        let mut place = self.file.borrow_mut();
        let Some((file, length)) = place.as_mut() else { return true };
        if *length >= most {
            return false;
        }
        // On a line of its own whatever was torn before it.
        let text = state::line(&serde_json::to_string(line).unwrap_or_default());
        let text = format!("\n{}", text.trim_end());
        match file.write_all(text.as_bytes()) {
            Ok(()) => *length += text.len() as u64,
            Err(error) => tracing::debug!("{}: {error}", self.path.display()),
        }
        true
    }
}

/// A time to a tenth of a millisecond: what a line holds.
fn short(time: f64) -> f64 {
    (time * 1e4).round() / 1e4
}

/// When a job was wanted that has not settled, and who was given it.
type OpenJob = (VecDeque<f64>, Attempts);

/// An attempt at a run while its lines are read.
#[derive(Default)]
struct AttemptDraft {
    attempt: u32,
    at: u64,
    jobs: Vec<JobTimes>,
    /// Wanted and not settled.
    open: BTreeMap<String, OpenJob>,
    last: f64,
    ended: Option<f64>,
}

impl AttemptDraft {
    fn take(&mut self, line: &TimelineLine) {
        match line {
            TimelineLine::Opened { job, at } => {
                self.last = self.last.max(*at);
                self.open.entry(job.clone()).or_default().0.push_back(*at);
            }
            TimelineLine::Attempted(one) => {
                self.last = self.last.max(one.at);
                if let Some((_, attempts)) = self.open.get_mut(&one.job) {
                    attempts.take(one);
                }
            }
            TimelineLine::Settled(job) => {
                self.last = self.last.max(job.settled);
                if let Some((openings, _)) = self.open.get_mut(&job.job) {
                    openings.pop_front();
                    if openings.is_empty() {
                        self.open.remove(&job.job);
                    }
                }
                self.jobs.push(job.clone());
            }
            TimelineLine::Ended { at } => self.ended = Some(*at),
            TimelineLine::Began { .. } | TimelineLine::Full => {}
        }
    }

    /// No more comes of it. `seen`: when it was last seen to go on \[ms since 1970\].
    fn close(mut self, seen: Option<u64>, all: &mut Timeline) {
        let seen = seen.map_or(0.0, |seen| seen.saturating_sub(self.at) as f64 / 1e3);
        let settled = self.ended.unwrap_or(seen).max(self.last);
        let ending = if self.ended.is_some() { JobFate::Unsettled } else { JobFate::CutOff };
        let left = |(job, (openings, attempts)): (String, OpenJob)| {
            let tell = move |opened| {
                let tries = attempts.stretches(opened, settled);
                JobTimes::left(job.clone(), (opened, settled), tries, ending)
            };
            openings.into_iter().map(tell)
        };
        let mut left: Vec<JobTimes> = self.open.into_iter().flat_map(left).collect();
        left.sort_by(|one, other| one.opened.total_cmp(&other.opened));
        self.jobs.extend(left);
        let cut_off = self.ended.is_none();
        all.add((self.attempt, self.at), self.jobs, settled, cut_off);
    }
}

/// A line that is whole; one of before there were checksums has none.
fn parse(line: &str) -> Option<TimelineLine> {
    let whole = state::read_line(line).ok()?.0;
    serde_json::from_str(whole).ok()
}

/// What the file has, as far as it can be read.
fn read(path: &Path) -> String {
    let mut text = Vec::new();
    let read = regular::open(path).and_then(|f| f.take(MOST + 2 * EDGES).read_to_end(&mut text));
    if let Err(error) = read {
        tracing::warn!("{}: {error}", path.display());
    }
    let text = String::from_utf8_lossy(&text).into_owned();
    let bad = text.lines().filter(|line| !line.is_empty() && parse(line).is_none()).count();
    if bad > 0 {
        tracing::warn!("{}: {bad} lines are torn or damaged, and left out", path.display());
    }
    text
}

/// What was written by the attempts before that one. `seen`: when the last was last seen to go on,
/// where no further one says so \[ms since 1970\].
fn earlier(text: &str, attempt: u32, seen: Option<u64>) -> Timeline {
    let mut all = Timeline::default();
    let mut draft: Option<AttemptDraft> = None;
    for line in text.lines().filter_map(parse) {
        match line {
            TimelineLine::Began { attempt: which, at, seen } => {
                if let Some(draft) = draft.take() {
                    draft.close(seen, &mut all);
                }
                if which >= attempt {
                    break;
                }
                draft = Some(AttemptDraft { attempt: which, at, ..AttemptDraft::default() });
            }
            TimelineLine::Full => all.untold = true,
            line => draft.iter_mut().for_each(|draft| draft.take(&line)),
        }
    }
    if let Some(draft) = draft {
        draft.close(seen, &mut all);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{JobFate, JobTimes, MOST, NAME, RunHistory, Timeline};
    use crate::timeline::{Span, Stretch, svg, trace};
    use std::fs;
    use std::path::Path;

    fn job(name: &str, worker: &str, opened: f64, settled: f64) -> JobTimes {
        let tries =
            vec![Stretch { worker: worker.into(), from: opened, to: settled, lost: "".into() }];
        let (job, worker) = (name.to_owned(), worker.to_owned());
        let ending = JobFate::Solved;
        JobTimes { job, worker, opened, settled, attempts: 1, kept: false, tries, ending }
    }

    /// The first attempt is cut off with a job settled and one wanted, the second ends in order
    /// with one wanted, the third goes on.
    fn three(folder: &Path) -> (RunHistory, Timeline) {
        let first = RunHistory::begin(folder, 1, 10_000, None);
        first.opened("aa", 0.5);
        first.settled(&job("aa", "w1", 0.5, 1.5));
        first.opened("bb", 2.0);
        drop(first);
        // It was seen 3 s after it had begun, and back after 60.
        let second = RunHistory::begin(folder, 2, 70_000, Some(13_000));
        second.opened("bb", 0.25);
        second.settled(&job("bb", "w2", 0.25, 1.0));
        second.opened("cc", 1.0);
        second.ended(2.0);
        let third = RunHistory::begin(folder, 3, 80_000, Some(71_000));
        let kept = JobTimes { kept: true, tries: Vec::new(), ..job("aa", "", 0.0, 0.0) };
        let all = third.timeline(vec![kept, job("cc", "w1", 0.5, 4.0)]);
        (third, all)
    }

    #[test]
    fn a_timeline_tells_of_every_attempt_in_times_of_the_first() {
        let folder = tempfile::tempdir().expect("a folder");
        let (_, all) = three(folder.path());
        let span = |attempt, from, to, cut_off| Span { attempt, from, to, cut_off };
        let spans =
            [span(1, 0.0, 3.0, true), span(2, 60.0, 62.0, false), span(3, 70.0, 74.0, false)];
        assert_eq!(all.spans, spans);
        let told: Vec<_> = all.jobs.iter().map(|j| (&j.job[..], j.ending, j.settled)).collect();
        let due = [
            ("aa", JobFate::Solved, 1.5),
            ("bb", JobFate::CutOff, 3.0),
            ("bb", JobFate::Solved, 61.0),
            ("cc", JobFate::Unsettled, 62.0),
            ("aa", JobFate::Solved, 70.0),
            ("cc", JobFate::Solved, 74.0),
        ];
        assert_eq!(told, due);
        assert_eq!(all.jobs[2].tries[0].from, 60.25);
    }

    #[test]
    fn what_lies_between_attempts_is_shown_and_takes_little_room() {
        let folder = tempfile::tempdir().expect("a folder");
        let (_, all) = three(folder.path());
        // 57 s away and 8 s aside, of 9 s that went on.
        assert_eq!([3.0, 60.0, 62.0, 70.0, 74.0].map(|at| (all.drawn(at) * 1e6).round() / 1e6), {
            [3.0, 3.9, 5.9, 6.8, 10.8]
        });
        let picture = svg("pot", &all);
        assert!(picture.contains("3 jobs in 74.00 s, 3 attempts"), "{picture}");
        assert!(picture.contains("<title>3.000–60.000 s: the coordinator was away"), "{picture}");
        assert!(picture.contains("<title>62.000–70.000 s: the run did not go on"), "{picture}");
        let said: serde_json::Value = serde_json::from_str(&trace("pot", &all)).expect("JSON");
        let events = said["traceEvents"].as_array().expect("events").iter();
        let away = events.filter(|event| event["cat"] == "away");
        let away: Vec<_> = away.map(|event| (&event["name"], &event["ts"])).collect();
        let due = [(&"coordinator away".into(), &3e6.into()), (&"paused".into(), &62e6.into())];
        assert_eq!(away, due);
        let alone = svg("pot", &Timeline::of(vec![job("aa", "w1", 0.0, 1.0)]));
        assert!(alone.contains("1 jobs in 1.00 s</text>"), "{alone}");
    }

    #[test]
    fn a_torn_line_is_left_out_and_a_clock_that_is_set_back_turns_nothing_round() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = RunHistory::begin(folder.path(), 1, 10_000, None);
        first.opened("aa", 0.5);
        first.settled(&job("aa", "w1", 0.5, 1.5));
        let path = folder.path().join(NAME);
        let text = fs::read_to_string(&path).expect("a file");
        fs::write(&path, &text[..text.len() - 19]).expect("it is torn");
        let all = RunHistory::begin(folder.path(), 2, 4_000, Some(3_000)).timeline(Vec::new());
        assert_eq!(all.jobs.len(), 1, "{all:?}");
        assert_eq!(all.jobs[0].ending, JobFate::CutOff, "its end is torn");
        assert_eq!(all.spans[1], Span { attempt: 2, from: 0.5, to: 0.5, cut_off: false });
    }

    #[test]
    fn a_line_in_which_a_bit_turned_is_left_out() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = RunHistory::begin(folder.path(), 1, 10_000, None);
        first.opened("aa", 0.5);
        let path = folder.path().join(NAME);
        let before = fs::read(&path).expect("a file");
        first.settled(&job("aa", "w1", 0.5, 1.5));
        let sound = fs::read(&path).expect("a file");
        for at in 8 * (before.len() + 1)..8 * sound.len() {
            let mut bytes = sound.clone();
            bytes[at / 8] ^= 1 << (at % 8);
            fs::write(&path, &bytes).expect("a file");
            let all = RunHistory::left(folder.path());
            let told: Vec<_> = all.jobs.iter().map(|job| (&job.job[..], job.ending)).collect();
            assert_eq!(told, [("aa", JobFate::CutOff)], "bit {at}");
        }
    }

    #[test]
    fn the_file_has_a_bound_and_what_is_beyond_it_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = RunHistory::begin(folder.path(), 1, 0, None);
        let mut long = job("aa", "w1", 0.0, 1.0);
        long.tries = vec![Stretch { lost: "x".repeat(2_000), ..long.tries[0].clone() }; 16];
        for _ in 0..MOST / 10_000 {
            first.settled(&long);
        }
        first.ended(2.0);
        let length = fs::metadata(folder.path().join(NAME)).expect("a file").len();
        assert!((MOST..MOST + (64 << 10)).contains(&length), "{length}");
        let second = RunHistory::begin(folder.path(), 2, 5_000, None);
        let all = second.timeline(Vec::new());
        assert!(all.untold && svg("pot", &all).contains("not all is told"));
        assert_eq!(all.spans[0], Span { attempt: 1, from: 0.0, to: 2.0, cut_off: false });
        RunHistory::forget(folder.path());
        assert!(!folder.path().join(NAME).exists());
    }
}
