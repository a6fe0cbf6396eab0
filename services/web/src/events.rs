//! What a watcher is sent: the state first, then what changed, in pages of a bounded number of
//! bytes. A reader that is slow is sent the difference to what it had last, however much was
//! published in between, and no page is made before it has taken the one before.

use crate::feed::Feed;
use crate::view::{ClockView, FarmView, RunView, WorkerViews, list};
use axum::body::{Body, Bytes};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderValue, Response};
use futures_util::stream::{Stream, unfold};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

/// Longest silence: a watcher that hears nothing for much longer has lost the connection.
const TICK: Duration = Duration::from_secs(5);
/// Longest life of a stream; the browser then connects again.
const LIFE: Duration = Duration::from_secs(3_600);
/// Bytes of the runs of one event, beyond which the next one begins.
pub(crate) const PAGE: usize = 256 << 10;

/// Set as long as it lives: its connection is that of a watcher, not of a stranger.
struct Watching(Arc<AtomicBool>);

impl Drop for Watching {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// One who watches.
struct Watcher {
    slot: watch::Receiver<Arc<FarmView>>,
    /// The clock, and whether the farm is about to end, as it was sent them last.
    last: Option<(ClockView, bool)>,
    /// The workers as it was sent them.
    workers: Arc<WorkerViews>,
    /// The runs as it was sent them.
    runs: BTreeMap<u64, Arc<RunView>>,
    /// Whether runs are left that it was not sent for want of room.
    behind: bool,
    told: Instant,
    ends: Instant,
    _watching: Watching,
}

/// The events of a feed; `watching` is set until they end.
pub(crate) fn events(feed: &Feed, watching: Arc<AtomicBool>) -> Response<Body> {
    let mut response = Response::new(Body::from_stream(stream(feed, watching)));
    let kind = HeaderValue::from_static("text/event-stream");
    response.headers_mut().insert(CONTENT_TYPE, kind);
    response
}

fn stream(
    feed: &Feed,
    watching: Arc<AtomicBool>,
) -> impl Stream<Item = Result<Bytes, Infallible>> + use<> {
    watching.store(true, Ordering::Relaxed);
    let now = Instant::now();
    let watcher = Watcher {
        slot: feed.watch(),
        last: None,
        workers: Arc::default(),
        runs: BTreeMap::new(),
        behind: true,
        told: now,
        ends: now + LIFE,
        _watching: Watching(watching),
    };
    unfold(watcher, |mut watcher| async move {
        let event = watcher.next().await?;
        Some((Ok(event), watcher))
    })
}

/// What changed.
struct FarmChange {
    /// Runs that are new or different, as many as have room.
    runs: Vec<Arc<RunView>>,
    /// Runs that are not there any more.
    gone: Vec<u64>,
    /// Whether more runs are new or different.
    more: bool,
    /// All workers as JSON, if anything of them is different.
    workers: Option<Bytes>,
}

impl Watcher {
    async fn next(&mut self) -> Option<Bytes> {
        if self.last.as_ref().is_some_and(|(_, leaving)| *leaving) {
            return None;
        }
        loop {
            let tick = !self.behind
                && tokio::select! {
                    changed = self.slot.changed() => { changed.ok()?; false }
                    () = sleep_until(self.told + TICK) => true,
                    () = sleep_until(self.ends) => return None,
                };
            let now = Arc::clone(&self.slot.borrow_and_update());
            let change = self.change(&now);
            let jobs = |clock: &ClockView| (clock.jobs_waiting, clock.jobs_running);
            let last = self.last.as_ref();
            let same = last.is_some_and(|(clock, _)| jobs(clock) == jobs(&now.clock));
            let calm = change.runs.is_empty() && change.gone.is_empty() && !now.leaving;
            self.behind = change.more;
            if !tick && calm && same && change.workers.is_none() {
                continue;
            }
            let name = if last.is_none() { "farm" } else { "change" };
            let event = event(name, &now, &change);
            self.told = Instant::now();
            self.last = Some((now.clock.clone(), now.leaving));
            self.workers = Arc::clone(&now.workers);
            change.gone.iter().for_each(|run| drop(self.runs.remove(run)));
            self.runs.extend(change.runs.into_iter().map(|run| (run.info.run, run)));
            return Some(event);
        }
    }

    /// Runs that are not over come first, then the newest.
    fn change(&self, now: &FarmView) -> FarmChange {
        let new = |run: &&Arc<RunView>| {
            self.runs.get(&run.info.run).is_none_or(|old| !Arc::ptr_eq(old, run))
        };
        let over = |run: &&Arc<RunView>| run.info.state.is_over();
        let going = now.runs.values().rev().filter(|run| !over(run));
        let all = going.chain(now.runs.values().rev().filter(over));
        let (mut runs, mut bytes, mut more) = (Vec::new(), 0, false);
        for run in all.filter(new) {
            bytes += run.json.len();
            if bytes > PAGE && !runs.is_empty() {
                more = true;
                break;
            }
            runs.push(Arc::clone(run));
        }
        runs.sort_by_key(|run| run.info.run);
        let gone = self.runs.keys().filter(|run| !now.runs.contains_key(run)).copied().collect();
        let same = self.last.is_some() && Arc::ptr_eq(&self.workers, &now.workers);
        let workers = (!same).then(|| now.workers.json.clone());
        FarmChange { runs, gone, more, workers }
    }
}

/// An event as it is sent. JSON has no line breaks, which would end it.
fn event(name: &str, now: &FarmView, change: &FarmChange) -> Bytes {
    let clock = serde_json::to_string(&now.clock).unwrap_or_else(|_| "{}".to_owned());
    // More fields follow.
    let clock = clock.trim_end_matches('}');
    let (leaving, gone) = (now.leaving, &change.gone);
    let mut text = format!("event: {name}\ndata: {clock},\"leaving\":{leaving},").into_bytes();
    text.extend_from_slice(b"\"runs\":");
    text.extend_from_slice(&list(change.runs.iter().map(|run| &run.json)));
    // As the brackets of a list are written.
    text.extend_from_slice(format!(",\"gone\":{gone:?}").as_bytes());
    if let Some(workers) = &change.workers {
        text.extend_from_slice(b",\"workers\":");
        text.extend_from_slice(workers);
    }
    text.extend_from_slice(b"}\n\n");
    text.into()
}
