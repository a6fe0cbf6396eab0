//! What a watcher is sent: the whole state first, then what changed. A reader that is slow is sent
//! the difference to what it had last, however much was published in between.

use crate::feed::Feed;
use crate::view::{ClockView, FarmView, RunView, WorkerView};
use axum::response::sse::{Event, Sse};
use futures_util::stream::{Stream, unfold};
use serde::Serialize;
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

/// What changed.
#[derive(Debug, Serialize)]
struct FarmChange<'a> {
    #[serde(flatten)]
    clock: &'a ClockView,
    leaving: bool,
    /// Runs that are new or different.
    runs: Vec<&'a RunView>,
    /// Runs that are not there any more.
    gone: Vec<u64>,
    /// All workers, if anything of them is different.
    #[serde(skip_serializing_if = "Option::is_none")]
    workers: Option<&'a [WorkerView]>,
}

impl<'a> FarmChange<'a> {
    fn between(before: &FarmView, now: &'a FarmView) -> Self {
        let new = |(run, view): &(&u64, &Arc<RunView>)| {
            before.runs.get(run).is_none_or(|old| !Arc::ptr_eq(old, view))
        };
        let runs = now.runs.iter().filter(new).map(|(_, view)| &**view).collect();
        let gone = before.runs.keys().filter(|run| !now.runs.contains_key(run)).copied().collect();
        let same = Arc::ptr_eq(&before.workers, &now.workers);
        let workers = (!same).then_some(now.workers.as_slice());
        Self { clock: &now.clock, leaving: now.leaving, runs, gone, workers }
    }
}

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
    /// What it was sent last.
    last: Option<Arc<FarmView>>,
    told: Instant,
    ends: Instant,
    _watching: Watching,
}

/// The events of a feed; `watching` is set until they end.
pub(crate) fn events(
    feed: &Feed,
    watching: Arc<AtomicBool>,
) -> Sse<impl Stream<Item = Result<Event, Infallible>> + use<>> {
    watching.store(true, Ordering::Relaxed);
    let now = Instant::now();
    let watcher = Watcher {
        slot: feed.watch(),
        last: None,
        told: now,
        ends: now + LIFE,
        _watching: Watching(watching),
    };
    Sse::new(unfold(watcher, |mut watcher| async move {
        let event = watcher.next().await?;
        Some((Ok(event), watcher))
    }))
}

impl Watcher {
    async fn next(&mut self) -> Option<Event> {
        let Some(last) = self.last.clone() else {
            let now = Arc::clone(&self.slot.borrow_and_update());
            let event = event("farm", &*now);
            (self.last, self.told) = (Some(now), Instant::now());
            return Some(event);
        };
        if last.leaving {
            return None;
        }
        loop {
            let tick = tokio::select! {
                changed = self.slot.changed() => { changed.ok()?; false }
                () = sleep_until(self.told + TICK) => true,
                () = sleep_until(self.ends) => return None,
            };
            let now = Arc::clone(&self.slot.borrow_and_update());
            let change = FarmChange::between(&last, &now);
            let calm = change.runs.is_empty() && change.gone.is_empty() && !now.leaving;
            let (a, b) = (&now.clock, &last.clock);
            let jobs = (a.jobs_waiting, a.jobs_running) == (b.jobs_waiting, b.jobs_running);
            if !tick && calm && jobs && change.workers.is_none() {
                continue;
            }
            let event = event("change", &change);
            (self.last, self.told) = (Some(now), Instant::now());
            return Some(event);
        }
    }
}

fn event(name: &str, data: &impl Serialize) -> Event {
    // JSON has no line breaks, which would end the data.
    let text = serde_json::to_string(data);
    Event::default().event(name).data(text.unwrap_or_else(|_| "null".to_owned()))
}
