//! One attempt at a run: from its bundle to its files.

use super::board::{AttemptEnd, Reached, RunEnd, RunEntry};
use super::local::{REPRODUCTION, TIMELINE, leave};
use super::reach::{ReachWriter, seen};
use super::replaying_pool::{ReplayingPool, ReportingPool};
use super::run_status::RunStatus;
use super::store::Kept;
use super::timeline::RunHistory;
use cullet_files::clock::unix_ms;
use cullet_files::output::UNFINISHED;
use cullet_files::regular;
use cullet_pool::bundle;
use cullet_proto::service::{FileInfo, Position, codes, hex_of};
use cullet_run::{News, Outcome, RunError, RunOptions, run};
use cullet_scene::{Scene, load_bundle_until};
use std::fs;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What a run leaves to be fetched; one that was cut off has its recording as far as it was
/// written.
const PRODUCTS: [&str; 9] = [
    "run.mcap",
    CUT_OFF,
    "summary.json",
    "preview.png",
    "preview.gif",
    TIMELINE[0],
    TIMELINE[1],
    REPRODUCTION[0],
    REPRODUCTION[1],
];
/// A recording that was cut off, which `recover` makes a readable file of.
pub(super) const CUT_OFF: &str = "run.mcap.partial";
/// Between two lines of a run's position.
const NEWS_PERIOD: Duration = Duration::from_secs(2);

/// An attempt at a run, with all that it needs.
pub(super) struct RunAttempt {
    pub(super) entry: RunEntry,
    pub(super) bundle: Vec<u8>,
    pub(super) folder: PathBuf,
    pub(super) kept: Kept,
    /// Its part of the state folder.
    pub(super) state: PathBuf,
    /// Where it says how far it is; nowhere, where nobody comes back to it.
    pub(super) reach: Option<ReachWriter>,
    pub(super) live: Arc<RunStatus>,
    pub(super) stop: Arc<AtomicBool>,
}

/// How an attempt ended, and when.
#[derive(Debug)]
pub(super) struct Ended {
    pub(super) how: AttemptEnd,
    pub(super) end: RunEnd,
    pub(super) at: u64,
}

impl Ended {
    pub(super) fn failed(code: u8, text: String) -> Self {
        let end = RunEnd { code: Some(code), text, ..RunEnd::default() };
        Self { how: AttemptEnd::Failed, end, at: unix_ms() }
    }

    /// It was asked to stop, and left this.
    pub(super) fn stopped(files: Vec<FileInfo>) -> Self {
        let end = RunEnd { files, ..RunEnd::default() };
        Self { how: AttemptEnd::Stopped, end, at: unix_ms() }
    }
}

/// Where a run stands before its world is built. That can take seconds and most of its memory, and
/// who looks for the largest run has to find it by then.
fn start_of(scene: &Scene) -> Position {
    let (end, bodies) = (scene.world.duration, scene.bodies.len() as u64);
    Position { end, bodies, steps: scene.steps(), ..Position::default() }
}

impl RunAttempt {
    /// Runs the scene to its end, to trouble, or until it is asked to stop.
    pub(super) fn run(mut self, pool: &dyn ReportingPool) -> Ended {
        let _span = tracing::info_span!("run", run = self.entry.run).entered();
        let scene = match self.scene() {
            Ok(scene) => scene,
            Err(_) if self.stop.load(Ordering::Relaxed) => return self.stopped_early(),
            Err(text) => return self.ended(Ended::failed(codes::UNFIT, text)),
        };
        if let Err(error) = empty(&self.folder) {
            let text = format!("{}: {error}", self.folder.display());
            return self.ended(Ended::failed(codes::UNKEPT, text));
        }
        let seen = seen(&self.state);
        let past = RunHistory::begin(&self.state, self.entry.attempt, unix_ms(), seen);
        let replaying = ReplayingPool::new(pool, Some(&self.kept), &self.live).noting(&past);
        let (mut told, mut last) = (Instant::now(), String::new());
        let mut reach = self.reach.take();
        let options = RunOptions::new(&self.folder, &self.stop);
        self.live.at(Some(start_of(&scene)));
        let outcome = run(&scene, &replaying, &options, &mut |news| match news {
            News::Line(line) | News::Results(line) => self.live.log(line),
            News::At(p) => {
                self.live.at(Some(*p));
                let (time, settled) = ((p.time * 1e6) as u64, self.live.jobs().settled);
                if let Some(reach) = &mut reach {
                    reach.note(Reached { time, settled });
                }
                if told.elapsed() >= NEWS_PERIOD {
                    told = Instant::now();
                    let text = format!("{:.3} of {:.3} s, {} bodies", p.time, p.end, p.bodies);
                    let text = text + &solving(p);
                    // One that stands still is said once: why is a line of its own.
                    if text != last {
                        self.live.log(&text);
                        last = text;
                    }
                }
            }
        });
        self.live.at(None);
        replaying.close();
        let ended = match outcome {
            Ok(outcome) => self.over(&outcome, &past),
            Err(error) => {
                let (how, code) = kind(&error);
                let mut ended = Ended::failed(code, error.to_string());
                self.leave(&past);
                ended.end.files = products(&self.folder).unwrap_or_default();
                Ended { how, ..ended }
            }
        };
        self.ended(ended)
    }

    fn scene(&self) -> Result<Scene, String> {
        let overrides = &self.entry.order.overrides;
        let bundle = bundle::decode(&self.bundle, overrides).map_err(|e| e.to_string())?;
        load_bundle_until(&bundle, Arc::clone(&self.stop)).map_err(|e| e.to_string())
    }

    /// Stopped before it began: an earlier attempt may have left a recording.
    fn stopped_early(&self) -> Ended {
        Ended::stopped(products(&self.folder).unwrap_or_default())
    }

    fn ended(&self, ended: Ended) -> Ended {
        if !ended.end.text.is_empty() {
            self.live.log(&format!("error: {}", ended.end.text));
        }
        ended
    }

    fn over(&self, outcome: &Outcome, past: &RunHistory) -> Ended {
        let drawn = cullet_picture::from_recording(&outcome.recording, &self.folder);
        if let Err(error) = &drawn {
            self.live.log(&format!("warning: the run has no picture: {error}"));
        }
        for text in &outcome.unmet {
            self.live.log(&format!("expected, and does not hold: {text}"));
        }
        self.leave(past);
        let files = match products(&self.folder) {
            Ok(files) => files,
            Err(text) => return Ended::failed(codes::UNKEPT, text),
        };
        let (how, code) = match (outcome.interrupted, outcome.unmet.is_empty(), drawn.is_ok()) {
            // Who asked it to stop knows what for, and gives it a code.
            (true, _, _) => (AttemptEnd::Stopped, None),
            (false, false, _) => (AttemptEnd::Done, Some(codes::UNMET)),
            (false, true, false) => (AttemptEnd::Done, Some(codes::UNPICTURED)),
            (false, true, true) => (AttemptEnd::Done, Some(codes::DONE)),
        };
        let end = RunEnd { code, files, ..RunEnd::default() };
        Ended { how, end, at: unix_ms() }
    }

    fn leave(&self, past: &RunHistory) {
        let told = (&*self.entry.order.name, &past.timeline(self.live.timeline()));
        leave(&self.folder, told, &self.live, &mut |line| self.live.log(&line));
    }
}

/// How far the solves are that a run waits for.
fn solving(p: &Position) -> String {
    match p.permille {
        0 => String::new(),
        permille => format!(", {} jobs to do (at work: {} %)", p.jobs, permille / 10),
    }
}

fn kind(error: &RunError) -> (AttemptEnd, u8) {
    match error {
        RunError::Abandoned { .. } => (AttemptEnd::Stalled, codes::STALLED),
        RunError::Record(_) | RunError::File { .. } => (AttemptEnd::Failed, codes::UNKEPT),
        RunError::World(_)
        | RunError::Lost(_)
        | RunError::From { .. }
        | RunError::Trail(_)
        | RunError::FromStep { .. }
        | RunError::OutOfOrder { .. }
        | RunError::Window { .. }
        | RunError::TooManyNear { .. }
        | RunError::Joint { .. } => (AttemptEnd::Failed, codes::FAILED),
    }
}

/// A folder with nothing of an earlier attempt in it.
fn empty(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for file in fs::read_dir(folder)? {
        let path = file?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let ours = PRODUCTS.iter().any(|product| {
            name.strip_prefix(product).is_some_and(|rest| rest.is_empty() || rest == ".partial")
        });
        if ours || name.starts_with(UNFINISHED) {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// Removes what a run recorded, and its folder if nothing of others is in it.
pub(super) fn discard(folder: &Path) -> io::Result<()> {
    if folder.is_dir() {
        empty(folder)?;
        let _others_are_in_it = fs::remove_dir(folder);
    }
    Ok(())
}

pub(super) fn products(folder: &Path) -> Result<Vec<FileInfo>, String> {
    let there = PRODUCTS.iter().filter(|name| folder.join(name).is_file());
    let row = |name: &&str| {
        let path = folder.join(name);
        let (length, digest) = sum(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(FileInfo { name: (*name).to_owned(), length, digest: hex_of(&digest) })
    };
    there.map(row).collect()
}

fn sum(path: &Path) -> io::Result<(u64, [u8; 32])> {
    let mut hasher = blake3::Hasher::new();
    let length = io::copy(&mut BufReader::new(regular::open(path)?), &mut hasher)?;
    Ok((length, *hasher.finalize().as_bytes()))
}
