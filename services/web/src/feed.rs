//! Where a farm's owner puts what there is, and watchers take it from. There is one slot: what is
//! put there takes the place of what was, whoever has read it or not.

use crate::view::{
    ClockView, FarmNews, FarmView, Png, RunExtras, RunFigures, RunNews, RunView, WorkerView,
    WorkerViews,
};
use cullet_proto::service::WorkerInfo;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Between two publications while somebody watches, and while nobody does.
const WATCHED: Duration = Duration::from_millis(400);
const ALONE: Duration = Duration::from_secs(3);

/// The present state of a farm. Clones are the same feed.
#[derive(Clone, Debug)]
pub struct Feed {
    inner: Arc<FeedSlot>,
}

#[derive(Debug)]
struct FeedSlot {
    slot: watch::Sender<Arc<FarmView>>,
    extras: Mutex<BTreeMap<u64, RunExtras>>,
    published: Mutex<Option<Instant>>,
    stills: AtomicU64,
}

impl Default for Feed {
    fn default() -> Self {
        let inner = FeedSlot {
            slot: watch::Sender::new(Arc::new(FarmView::default())),
            extras: Mutex::default(),
            published: Mutex::default(),
            stills: AtomicU64::new(0),
        };
        Self { inner: Arc::new(inner) }
    }
}

impl Feed {
    /// Whether it is time to publish: soon after the last time if somebody watches.
    #[must_use]
    pub fn is_due(&self) -> bool {
        let period = if self.watchers() > 0 { WATCHED } else { ALONE };
        let last = self.inner.published.lock().unwrap_or_else(PoisonError::into_inner);
        last.is_none_or(|at| at.elapsed() >= period)
    }

    /// Those who have the page open.
    #[must_use]
    pub fn watchers(&self) -> usize {
        self.inner.slot.receiver_count()
    }

    /// Puts down what there is now. It waits for nobody.
    pub fn publish(&self, news: FarmNews) {
        let before = self.now();
        let mut extras = self.extras();
        let known: BTreeSet<u64> = news.runs.iter().map(|run| run.info.run).collect();
        extras.retain(|run, _| known.contains(run));
        let view = |run: RunNews| {
            let number = run.info.run;
            let new = RunView::new(run, extras.get(&number));
            let same = before.runs.get(&number).filter(|old| ***old == new);
            (number, same.cloned().unwrap_or_else(|| Arc::new(new)))
        };
        let runs = news.runs.into_iter().map(view).collect();
        drop(extras);
        let workers = WorkerViews::new(workers(news.workers, &before.workers.all, news.now_ms));
        let same = *before.workers == workers;
        let workers = if same { Arc::clone(&before.workers) } else { Arc::new(workers) };
        let clock = ClockView {
            name: news.name,
            version: news.version,
            now_ms: news.now_ms,
            up_ms: news.up_ms,
            runs_at_once: news.runs_at_once,
            free_bytes: news.free_bytes,
            jobs_waiting: news.jobs_waiting,
            jobs_running: news.jobs_running,
        };
        let view = FarmView { clock, leaving: before.leaving, runs, workers };
        self.inner.slot.send_replace(Arc::new(view));
        let mut last = self.inner.published.lock().unwrap_or_else(PoisonError::into_inner);
        *last = Some(Instant::now());
    }

    /// Says that nothing more comes.
    pub fn leave(&self) {
        let last = self.now();
        self.inner.slot.send_replace(Arc::new(FarmView { leaving: true, ..(*last).clone() }));
    }

    /// What was published last.
    pub(crate) fn now(&self) -> Arc<FarmView> {
        Arc::clone(&self.inner.slot.borrow())
    }

    /// To be woken by what is published.
    pub(crate) fn watch(&self) -> watch::Receiver<Arc<FarmView>> {
        self.inner.slot.subscribe()
    }

    /// A run as it is now, and the newest picture of it while it goes on.
    pub(crate) fn run(&self, run: u64) -> Option<(Arc<RunView>, Option<Png>)> {
        let view = Arc::clone(self.now().runs.get(&run)?);
        let extras = self.extras();
        let still = extras.get(&run).and_then(|extras| extras.still.clone());
        Some((view, still.map(|(_, bytes)| bytes)))
    }

    /// What a run came to; watchers hear of it with the next publication.
    pub(crate) fn tell_figures(&self, view: &RunView, figures: RunFigures) {
        self.extras_of(view, |extras| extras.figures = Some(figures));
    }

    /// A picture of a run that goes on.
    pub(crate) fn tell_still(&self, view: &RunView, png: Vec<u8>) {
        let number = self.inner.stills.fetch_add(1, Ordering::Relaxed) + 1;
        self.extras_of(view, |extras| extras.still = Some((number, Arc::new(png))));
    }

    fn extras_of(&self, view: &RunView, change: impl FnOnce(&mut RunExtras)) {
        let of = (view.info.attempt, view.info.ended_ms);
        let mut all = self.extras();
        let extras = all.entry(view.info.run).or_default();
        if extras.of != of {
            *extras = RunExtras { of, ..RunExtras::default() };
        }
        change(extras);
    }

    fn extras(&self) -> MutexGuard<'_, BTreeMap<u64, RunExtras>> {
        self.inner.extras.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Workers with the time at which those that are gone were last seen.
fn workers(now: Vec<WorkerInfo>, before: &[WorkerView], now_ms: u64) -> Vec<WorkerView> {
    let before: BTreeMap<&str, Option<u64>> =
        before.iter().map(|old| (&old.info.session[..], old.gone_ms)).collect();
    let gone = |info: &WorkerInfo| {
        let old = before.get(&info.session[..]).copied().flatten();
        (!info.up).then_some(old.unwrap_or(now_ms))
    };
    now.into_iter().map(|info| WorkerView { gone_ms: gone(&info), info }).collect()
}
