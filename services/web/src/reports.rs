//! Reports of runs that are over: made when first asked for, one at a time in a thread of their
//! own, and kept for a while. Who waits for one waits for no other answer's thread.

use crate::pictures::Illustrator;
use crate::view::{RECORDING, RunView};
use std::collections::VecDeque;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tempfile::TempDir;
use tokio::sync::oneshot;

/// Reports kept, and most bytes of them: the oldest make room for the next.
const KEPT: usize = 16;
const KEPT_BYTES: u64 = 512 << 20;
/// A recording of more bytes has no report here: it would be a page of hundreds of megabytes, made
/// in as much memory.
const MAX_RECORDING: u64 = 1 << 30;
/// Those who may wait for reports; further ones are told so.
const WAITING: usize = 32;
/// Most bytes of a page.
const MAX_PAGE: u64 = 256 << 20;

/// Which report: of a run and an attempt that ended then.
type ReportKey = (u64, u32, Option<u64>);

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoReport {
    #[error("run {run} is {state}: there is a report of a run that has ended with a recording")]
    Unfinished { run: u64, state: &'static str },
    #[error(
        "the recording of run {run} has {length} bytes, and reports are made here up to \
         {MAX_RECORDING}: fetch it, and use `cullet report`"
    )]
    Large { run: u64, length: u64 },
    #[error("the report of run {run} has {length} bytes, and {MAX_PAGE} are sent at most")]
    LargePage { run: u64, length: u64 },
    #[error("run {run} has no report: {text}")]
    Failed { run: u64, text: String },
    #[error(
        "{WAITING} wait for a report already, which is as many as may: ask for that of run {run} \
         later"
    )]
    Busy { run: u64 },
}

/// A report that was made.
#[derive(Debug)]
struct ReportPage {
    of: ReportKey,
    /// Where it is; `None`: it was too large to be kept.
    path: Option<PathBuf>,
    /// Bytes that it has, or had.
    length: u64,
}

impl ReportPage {
    fn kept_bytes(&self) -> u64 {
        if self.path.is_some() { self.length } else { 0 }
    }
}

/// Those that are known, the oldest first.
#[derive(Debug, Default)]
struct ReportPages {
    pages: VecDeque<ReportPage>,
    /// How many were made: each has a file of its own.
    count: u64,
}

impl ReportPages {
    /// Deletes the oldest until there is room for one of `length` bytes.
    fn make_room(&mut self, length: u64) {
        let kept = |pages: &VecDeque<ReportPage>| pages.iter().map(ReportPage::kept_bytes).sum();
        while self.pages.len() >= KEPT || length.saturating_add(kept(&self.pages)) > KEPT_BYTES {
            let Some(oldest) = self.pages.pop_front() else { return };
            if let Some(path) = oldest.path {
                let _gone_already = fs::remove_file(path);
            }
        }
    }
}

/// Reports that were made.
#[derive(Debug)]
pub(crate) struct Reports {
    illustrator: Arc<dyn Illustrator>,
    folder: TempDir,
    made: Mutex<ReportPages>,
    /// Held while one is made.
    making: Mutex<()>,
    stop: AtomicBool,
}

impl Reports {
    pub(crate) fn new(illustrator: Arc<dyn Illustrator>) -> io::Result<Self> {
        let (folder, made) = (tempfile::tempdir()?, Mutex::default());
        let (making, stop) = (Mutex::default(), AtomicBool::new(false));
        Ok(Self { illustrator, folder, made, making, stop })
    }

    /// Nothing is made any more.
    pub(crate) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    fn made(&self) -> MutexGuard<'_, ReportPages> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The page of a run that was made, or of which that was tried.
    fn known(&self, view: &RunView) -> Option<Result<File, NoReport>> {
        let run = view.info.run;
        let made = self.made();
        let page = made.pages.iter().find(|page| page.of == key_of(view))?;
        let failed = |error: io::Error| NoReport::Failed { run, text: error.to_string() };
        Some(match &page.path {
            Some(path) => File::open(path).map_err(failed),
            None => Err(NoReport::LargePage { run, length: page.length }),
        })
    }

    /// The page of a run, as a file. It waits while another is made.
    fn page(&self, view: &RunView) -> Result<File, NoReport> {
        let run = view.info.run;
        let Some(folder) = view.folder.as_ref().filter(|_| view.report) else {
            return Err(NoReport::Unfinished { run, state: view.info.state.word() });
        };
        let _alone = self.making.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = self.known(view) {
            return known;
        }
        let page = self.make(folder, key_of(view))?;
        self.made().pages.push_back(page);
        let lost = || NoReport::Failed { run, text: "it made room for another".to_owned() };
        self.known(view).unwrap_or_else(|| Err(lost()))
    }

    /// Makes a page, and room for it. One that is too large is not kept.
    fn make(&self, folder: &Path, of: ReportKey) -> Result<ReportPage, NoReport> {
        let (run, ..) = of;
        let length = fs::metadata(folder.join(RECORDING)).map_or(0, |known| known.len());
        if length > MAX_RECORDING {
            return Err(NoReport::Large { run, length });
        }
        let count = {
            let mut made = self.made();
            made.count += 1;
            made.count
        };
        let path = self.folder.path().join(format!("{count}.html"));
        let done = self.illustrator.report(folder, &path, &self.stop);
        let done = done.and_then(|()| fs::metadata(&path).map_err(|error| error.to_string()));
        let length = match done {
            Ok(known) => known.len(),
            Err(text) => {
                let _never_there = fs::remove_file(&path);
                return Err(NoReport::Failed { run, text });
            }
        };
        if length > MAX_PAGE {
            fs::remove_file(&path)
                .map_err(|error| NoReport::Failed { run, text: error.to_string() })?;
            self.made().make_room(0);
            return Ok(ReportPage { of, path: None, length });
        }
        self.made().make_room(length);
        Ok(ReportPage { of, path: Some(path), length })
    }
}

fn key_of(view: &RunView) -> ReportKey {
    (view.info.run, view.info.attempt, view.info.ended_ms)
}

/// Somebody who waits for a report.
type ReportWish = (Arc<RunView>, oneshot::Sender<Result<File, NoReport>>);

/// Where reports are asked for. Clones are the same queue; its thread ends with the last of them.
#[derive(Clone, Debug)]
pub(crate) struct ReportQueue {
    reports: Arc<Reports>,
    asks: SyncSender<ReportWish>,
}

impl ReportQueue {
    pub(crate) fn start(reports: Arc<Reports>) -> io::Result<Self> {
        let (asks, asked) = sync_channel::<ReportWish>(WAITING);
        let maker = Arc::clone(&reports);
        let work = move || {
            // For one that has left nothing is made.
            for (view, answer) in asked.iter().filter(|(_, answer)| !answer.is_closed()) {
                let _has_left = answer.send(maker.page(&view));
            }
        };
        std::thread::Builder::new().name("cullet-reports".into()).spawn(work)?;
        Ok(Self { reports, asks })
    }

    /// The page of a run. One that was made is there at once.
    pub(crate) async fn page(&self, view: Arc<RunView>) -> Result<File, NoReport> {
        let run = view.info.run;
        if let Some(known) = self.reports.known(&view) {
            return known;
        }
        let (answer, answered) = oneshot::channel();
        self.asks.try_send((view, answer)).map_err(|_| NoReport::Busy { run })?;
        let ended = || NoReport::Failed { run, text: "the page ends".to_owned() };
        answered.await.unwrap_or_else(|_| Err(ended()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::RunNews;
    use cullet_proto::service::{FileInfo, RunInfo, State};
    use std::sync::atomic::AtomicU64;
    use std::time::Duration;

    /// Makes pages of as many bytes as it is told.
    #[derive(Debug, Default)]
    struct Filler {
        length: AtomicU64,
        made: AtomicU64,
    }

    impl Illustrator for Filler {
        fn still(&self, _: &Path, _: &Path, _: &AtomicBool) -> Result<Duration, String> {
            Err("nothing is drawn here".to_owned())
        }

        fn report(&self, _: &Path, file: &Path, _: &AtomicBool) -> Result<(), String> {
            self.made.fetch_add(1, Ordering::SeqCst);
            let file = File::create_new(file).map_err(|error| error.to_string())?;
            // Without blocks on the disk.
            file.set_len(self.length.load(Ordering::SeqCst)).map_err(|error| error.to_string())
        }
    }

    struct Desk {
        filler: Arc<Filler>,
        reports: Reports,
        folder: TempDir,
    }

    fn desk() -> Desk {
        let filler = Arc::new(Filler::default());
        let reports = Reports::new(Arc::clone(&filler) as _).expect("a folder");
        Desk { filler, reports, folder: tempfile::tempdir().expect("a folder") }
    }

    impl Desk {
        /// Asks for the report of a run that ended then.
        fn ask(&self, run: u64, ended_ms: u64, length: u64) -> Result<u64, NoReport> {
            self.filler.length.store(length, Ordering::SeqCst);
            let mut news: RunNews = crate::tests::run(run, State::Done, "pot");
            let RunInfo { files, ended_ms: ended, .. } = &mut news.info;
            *ended = Some(ended_ms);
            let (name, digest) = (RECORDING.to_owned(), String::new());
            *files = vec![FileInfo { name, length: 1, digest }];
            news.folder = Some(self.folder.path().to_owned());
            let page = self.reports.page(&RunView::new(news, None))?;
            Ok(page.metadata().expect("a file").len())
        }

        fn made(&self) -> u64 {
            self.filler.made.load(Ordering::SeqCst)
        }

        /// Files that are kept, and their bytes.
        fn kept(&self) -> (usize, u64) {
            let files = fs::read_dir(self.reports.folder.path()).expect("a folder");
            let lengths = files.map(|file| file.expect("a file").metadata().expect("it").len());
            let lengths: Vec<u64> = lengths.collect();
            (lengths.len(), lengths.iter().sum())
        }
    }

    #[test]
    fn a_page_that_is_too_large_is_made_once_and_not_kept() {
        let desk = desk();
        for _ in 0..2 {
            let no = desk.ask(1, 1, MAX_PAGE + 1).expect_err("it is refused");
            let large = matches!(no, NoReport::LargePage { run: 1, length } if length > MAX_PAGE);
            assert!(large, "{no}");
        }
        assert_eq!((desk.made(), desk.kept()), (1, (0, 0)));
        assert_eq!(desk.ask(1, 2, MAX_PAGE).expect("a page"), MAX_PAGE);
    }

    #[test]
    fn pages_are_kept_up_to_a_number_and_a_sum_of_bytes() {
        let desk = desk();
        for run in 1..=3 {
            desk.ask(run, 1, 200 << 20).expect("a page");
        }
        assert_eq!((desk.made(), desk.kept()), (3, (2, 400 << 20)));
        desk.ask(2, 1, 1).expect("it is there");
        assert_eq!(desk.made(), 3, "the newer ones are kept");
        desk.ask(1, 1, 1).expect("it is made again");
        assert_eq!((desk.made(), desk.kept()), (4, (3, (400 << 20) + 1)));
        for run in 10..10 + KEPT as u64 {
            desk.ask(run, 1, 1).expect("a page");
        }
        assert_eq!(desk.kept(), (KEPT, KEPT as u64));
    }

    #[test]
    fn two_ends_of_one_attempt_have_a_page_each() {
        let desk = desk();
        assert_eq!(desk.ask(1, 1, 10).expect("a page"), 10);
        assert_eq!(desk.ask(1, 2, 20).expect("a page"), 20);
        assert_eq!(desk.ask(1, 1, 0).expect("the first one's"), 10);
    }
}
