//! The state of the service: the board, its journal, who asks, which runs go on.

use super::attempt::Ended;
use super::audit_log;
use super::board::{Board, BoardEvent};
use super::clients::Clients;
use super::config::ServiceConfig;
use super::error::ServiceError;
use super::journal::Journal;
use super::metrics::Metrics;
use super::quota::{self, Quota};
use super::remains::ends_here;
use super::run_status::RunStatus;
use super::store::Store;
use super::web::WebPage;
use cullet_pool::Pool;
use cullet_proto::service::JobCounts;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Instant;

/// A run that goes on.
pub(super) struct Going {
    pub(super) stop: Arc<AtomicBool>,
    /// Why it was stopped, where nobody wished it: a code and words.
    pub(super) over: Option<(u8, String)>,
    pub(super) thread: JoinHandle<Ended>,
}

/// Where runs are kept, and how much of the disk they may hold.
pub(super) struct Storage {
    /// Where runs record.
    pub(super) out: PathBuf,
    pub(super) store: Store,
    pub(super) quota: Quota,
}

/// The runs that are remembered, as far as this life knows more of them than the board.
pub(super) struct RunTable {
    pub(super) statuses: BTreeMap<u64, Arc<RunStatus>>,
    pub(super) going: BTreeMap<u64, Going>,
    /// Runs that ended in this life.
    pub(super) ended: u32,
    /// Memory that was held when a run was last stopped for it \[bytes\].
    pub(super) heaviest: u64,
    /// Whether it was logged that runs wait for room on the disk.
    pub(super) short: bool,
}

/// Runs that are to leave nothing behind.
pub(super) struct Pruning {
    /// Runs whose files did not go, and when that was tried.
    pub(super) stuck: BTreeMap<u64, Instant>,
    /// Up to which number it is on the disk beside the journal that they were given.
    pub(super) given: u64,
}

/// When what is next.
pub(super) struct Times {
    /// When the service started.
    pub(super) since: Instant,
    /// No run begins before then.
    pub(super) begin_at: Instant,
    /// When what is old was last looked for.
    pub(super) swept: Instant,
}

pub(super) struct Service<'a> {
    pub(super) pool: &'a Arc<Pool>,
    pub(super) config: &'a ServiceConfig,
    pub(super) storage: Storage,
    pub(super) journal: Journal,
    pub(super) board: Board,
    pub(super) clients: Clients,
    pub(super) runs: RunTable,
    pub(super) pruning: Pruning,
    pub(super) metrics: Option<Metrics>,
    pub(super) page: Option<WebPage>,
    pub(super) times: Times,
    pub(super) leaving: bool,
    pub(super) report: &'a mut dyn FnMut(&str),
}

impl Service<'_> {
    /// Keeps what happened, then lets it happen.
    pub(super) fn record(&mut self, events: &[BoardEvent]) -> Result<(), ServiceError> {
        self.journal.append(events)?;
        events.iter().for_each(|event| self.apply(event));
        self.journal.tidy(&self.board);
        Ok(())
    }

    /// What happened happened, even if it cannot be kept.
    pub(super) fn admit(&mut self, event: BoardEvent) {
        if let Err(error) = self.journal.append(std::slice::from_ref(&event)) {
            tracing::error!("not kept until there is room, or done again: {error}");
            self.journal.owe(&event);
        }
        self.apply(&event);
        self.journal.tidy(&self.board);
    }

    /// What the journal has happens. A test stops the coordinator at a line of the log: kept, and
    /// not answered yet.
    fn apply(&mut self, event: &BoardEvent) {
        audit_log::log(event);
        if let BoardEvent::Cancelled { run, .. } | BoardEvent::Paused { run } = event {
            self.pool.release(*run);
        }
        if let BoardEvent::Cancelled { run, end, .. } = event
            && !end.files.is_empty()
        {
            self.storage.quota.changed(*run);
            self.status(*run).log(&format!("cancelled: {}", ends_here(&end.files)));
        }
        if let Err(no) = self.board.apply(event) {
            tracing::error!("an event does not fit: {no}");
        }
    }

    pub(super) fn status(&mut self, run: u64) -> Arc<RunStatus> {
        let path = self.storage.store.run(run).join("log");
        let status =
            self.runs.statuses.entry(run).or_insert_with(|| Arc::new(RunStatus::open(&path)));
        Arc::clone(status)
    }

    /// Fracture jobs of the attempt at hand, or of the last one.
    pub(super) fn jobs(&self, run: u64) -> JobCounts {
        self.runs.statuses.get(&run).map(|status| status.jobs()).unwrap_or_default()
    }

    /// Whether the disk has room for so many bytes more.
    pub(super) fn room(&self, more: u64) -> Result<(), ServiceError> {
        let kept = (self.config.reserve, self.journal.length());
        quota::disks(more, kept, [self.storage.store.folder(), &self.storage.out])
    }

    /// Makes the runs at hand do what somebody wishes of them.
    pub(super) fn stop_run(&self, run: u64) {
        if let Some(going) = self.runs.going.get(&run) {
            going.stop.store(true, Ordering::Relaxed);
        }
    }
}
