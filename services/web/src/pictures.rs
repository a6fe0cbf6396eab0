//! Pictures as they come: while somebody watches, the present state of one run after another is
//! drawn from its recording as far as it is written. Drawing takes a bounded share of one core.

use crate::feed::Feed;
use crate::figures;
use crate::view::{RunView, SHEET};
use cullet_proto::service::State;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

/// Between looks.
const LOOK: Duration = Duration::from_millis(100);
/// Least time between the end of one picture and the begin of the next.
const LEAST: Duration = Duration::from_secs(2);
/// The same as a multiple of the processor's time that the last one took: drawing takes a twentieth
/// of a core at most.
const REST: u32 = 19;
/// Before a run is tried again that could not be drawn.
const AGAIN: Duration = Duration::from_secs(10);
/// A recording of more bytes is not drawn while it grows: drawing reads all of it.
const MAX_RECORDING: u64 = 512 << 20;
/// Most bytes of a picture.
const MAX_PICTURE: u64 = 4 << 20;
/// Summaries read between two looks.
const SUMMARIES: usize = 32;
/// What a recording is called until it is complete.
const PARTIAL: &str = "run.mcap.partial";

/// Draws recordings. It is called from threads that may wait.
pub trait Illustrator: Debug + Send + Sync {
    /// Draws the present state of the run that records into `folder`, as PNG into `file`, and
    /// hands back how much of a processor's time that took. Gives up once `stop` is set.
    ///
    /// # Errors
    /// In words: there is nothing to see yet, or it cannot be drawn.
    fn still(&self, folder: &Path, file: &Path, stop: &AtomicBool) -> Result<Duration, String>;

    /// Writes the report of the run in `folder` as a page into `file`. Gives up once `stop` is set.
    ///
    /// # Errors
    /// In words: the recording cannot be read, or the page not be written.
    fn report(&self, folder: &Path, file: &Path, stop: &AtomicBool) -> Result<(), String>;
}

/// Threads that read summaries and draw; they end when dropped.
#[derive(Debug)]
pub(crate) struct PictureThreads {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl PictureThreads {
    pub(crate) fn start(feed: Feed, illustrator: Arc<dyn Illustrator>) -> std::io::Result<Self> {
        let folder = tempfile::tempdir()?;
        let mut all = Self { stop: Arc::default(), threads: Vec::new() };
        let told = feed.clone();
        all.spawn("cullet-figures", move |_| read_summaries(&told))?;
        let mut studio = Studio::new(feed, illustrator);
        all.spawn("cullet-pictures", move |stop| studio.look(folder.path(), stop))?;
        Ok(all)
    }

    /// Does that again and again.
    fn spawn(
        &mut self,
        name: &str,
        mut act: impl FnMut(&AtomicBool) + Send + 'static,
    ) -> std::io::Result<()> {
        let stop = Arc::clone(&self.stop);
        let work = move || {
            while !stop.load(Ordering::Relaxed) {
                act(&stop);
                sleep(LOOK);
            }
        };
        self.threads.push(std::thread::Builder::new().name(name.into()).spawn(work)?);
        Ok(())
    }
}

impl Drop for PictureThreads {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _panicked = thread.join();
        }
    }
}

/// Reads what runs came to that are over and of which that is not known.
fn read_summaries(feed: &Feed) {
    let view = feed.now();
    let over = |run: &&Arc<RunView>| run.info.state.is_over() && run.figures.is_none();
    // The newest are seen first.
    for run in view.runs.values().rev().filter(over).take(SUMMARIES) {
        let told = run.folder.as_deref().map(figures::read).unwrap_or_default();
        feed.tell_figures(run, told);
    }
}

/// What is drawn, and when.
struct Studio {
    feed: Feed,
    illustrator: Arc<dyn Illustrator>,
    /// No picture is begun before then.
    next: Instant,
    /// Of each run that goes on: how long its recording was when it was drawn, when that was, and
    /// until when it rests.
    drawn: BTreeMap<u64, (u64, Instant)>,
}

impl Studio {
    fn new(feed: Feed, illustrator: Arc<dyn Illustrator>) -> Self {
        Self { feed, illustrator, next: Instant::now(), drawn: BTreeMap::new() }
    }

    fn look(&mut self, folder: &Path, stop: &AtomicBool) {
        let view = self.feed.now();
        if self.feed.watchers() == 0 || Instant::now() < self.next {
            return;
        }
        let goes_on = |run: &&Arc<RunView>| run.info.state == State::Running;
        self.drawn.retain(|run, _| view.runs.get(run).is_some_and(|run| goes_on(&run)));
        let mut due: Vec<(Instant, u64, &Arc<RunView>)> = Vec::new();
        for run in view.runs.values().filter(goes_on) {
            let Some(length) = run.folder.as_deref().and_then(recorded) else { continue };
            let (was, after) = self.drawn.get(&run.info.run).copied().unwrap_or((0, self.next));
            if length != was && length <= MAX_RECORDING && Instant::now() >= after {
                due.push((after, length, run));
            }
        }
        let Some((_, length, run)) = due.into_iter().min_by_key(|(after, ..)| *after) else {
            return;
        };
        let began = Instant::now();
        let (after, took) = match self.draw(run, &folder.join(SHEET), stop) {
            Ok((png, took)) => {
                self.feed.tell_still(run, png);
                (Instant::now(), took)
            }
            Err(error) => {
                tracing::debug!(run = run.info.run, "no picture: {error}");
                (Instant::now() + AGAIN, began.elapsed())
            }
        };
        self.drawn.insert(run.info.run, (length, after));
        self.next = Instant::now() + LEAST.max(REST * took);
    }

    fn draw(
        &self,
        run: &RunView,
        file: &Path,
        stop: &AtomicBool,
    ) -> Result<(Vec<u8>, Duration), String> {
        let folder = run.folder.as_deref().ok_or("it has no folder")?;
        let took = self.illustrator.still(folder, file, stop)?;
        let length = fs::metadata(file).map_err(|error| error.to_string())?.len();
        if length > MAX_PICTURE {
            return Err(format!("the picture has {length} bytes; at most {MAX_PICTURE} are shown"));
        }
        let png = fs::read(file).map_err(|error| error.to_string())?;
        fs::remove_file(file).map_err(|error| error.to_string())?;
        Ok((png, took))
    }
}

/// Bytes of the recording in a folder that is not complete.
fn recorded(folder: &Path) -> Option<u64> {
    fs::metadata(folder.join(PARTIAL)).ok().map(|known| known.len())
}
