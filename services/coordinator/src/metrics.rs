//! Metrics in Prometheus' text format at `/metrics`, and health at `/healthz` and `/readyz`.

use super::board::Board;
use super::error::ServiceError;
use cullet_pool::{PoolStats, Refusals};
use cullet_proto::service::State;
use cullet_web::TextServer;
use std::fmt::Write;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A service that has not published for this long hangs, or its disk does.
const HEALTHY: Duration = Duration::from_secs(10);

/// What was published last, and when.
type Last = Mutex<(String, Instant)>;

/// What is answered over HTTP; it ends when dropped.
pub(super) struct Metrics {
    last: Arc<Last>,
    _server: TextServer,
}

impl Metrics {
    pub(super) fn serve(address: SocketAddr) -> Result<Self, ServiceError> {
        let last: Arc<Last> = Arc::new(Mutex::new((String::new(), Instant::now())));
        let shared = Arc::clone(&last);
        let answers = move |path: &str| answer(path, &shared);
        let server = TextServer::start("cullet-metrics", address, Arc::new(answers));
        let failed =
            |error: std::io::Error| ServiceError::Metrics { address, text: error.to_string() };
        Ok(Self { last, _server: server.map_err(failed)? })
    }

    pub(super) fn publish(&self, text: String) {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = (text, Instant::now());
    }
}

fn answer(path: &str, last: &Last) -> (u16, String) {
    let last = last.lock().unwrap_or_else(PoisonError::into_inner);
    let (text, at) = &*last;
    match path {
        "/metrics" => (200, text.clone()),
        "/healthz" | "/readyz" if at.elapsed() < HEALTHY => (200, "ok\n".to_owned()),
        "/healthz" | "/readyz" => (503, "the coordinator hangs\n".to_owned()),
        _ => (404, "there are /metrics, /healthz and /readyz\n".to_owned()),
    }
}

/// What there is to measure.
pub(super) fn text(
    board: &Board,
    (stats, clients): (&PoolStats, Refusals),
    free: Option<u64>,
    since: Instant,
) -> String {
    let mut out = String::new();
    let head = |out: &mut String, name: &str, kind: &str, help: &str| {
        let _ = writeln!(out, "# HELP cullet_{name} {help}\n# TYPE cullet_{name} {kind}");
    };
    head(&mut out, "runs", "gauge", "Runs by state.");
    let states = [
        State::Queued,
        State::Running,
        State::Paused,
        State::Done,
        State::Failed,
        State::Stalled,
        State::Cancelled,
    ];
    for state in states {
        let (word, count) = (state.word(), board.count(state));
        let _ = writeln!(out, "cullet_runs{{state=\"{word}\"}} {count}");
    }
    let rows = [
        ("jobs_opened_total", "counter", "Fracture jobs wanted.", stats.jobs.opened),
        ("jobs_settled_total", "counter", "Fracture jobs that ended.", stats.jobs.settled),
        ("jobs_refused_total", "counter", "Of these, refused by the solvers.", stats.jobs.refused),
        ("jobs_failed_total", "counter", "Of these, failed in the solver.", stats.jobs.failed),
        ("jobs_abandoned_total", "counter", "Of these, given up.", stats.jobs.abandoned),
        ("jobs_resent_total", "counter", "Attempts beyond a job's first.", stats.jobs.resent),
        ("jobs_adopted_total", "counter", "Attempts that outlived a coordinator.", stats.adopted),
        ("jobs_cached_total", "counter", "Openings answered from the cache.", stats.cached),
        ("jobs_hedged_total", "counter", "Second copies of slow jobs.", stats.hedged),
        ("jobs_quarantined", "gauge", "Jobs in quarantine.", stats.quarantined),
        ("jobs_queued_total", "counter", "Openings that had to wait for room.", stats.queued),
        ("jobs_stranded", "gauge", "Jobs that no worker here can solve.", stats.unschedulable),
        ("jobs_waiting", "gauge", "Jobs that wait for a worker.", stats.jobs.waiting),
        ("jobs_running", "gauge", "Jobs at workers.", stats.jobs.running),
        ("workers", "gauge", "Workers whose link is up.", stats.workers),
        ("workers_twins", "gauge", "Workers under a name that another has.", stats.duplicate_names),
        ("workers_respawned_total", "counter", "Own workers started again.", stats.respawned),
        ("links_lost_total", "counter", "Workers that left, or whose link did.", stats.lost),
        ("links_back_total", "counter", "Links of workers that came back.", stats.back),
        ("alarms_total", "counter", "Results that contradicted an earlier one.", stats.alarms),
        ("results_fenced_total", "counter", "Late results of another build.", stats.fenced),
        ("mesh_bytes_total", "counter", "Bytes of meshes sent to workers.", stats.mesh_bytes),
        ("pieces_damaged_total", "counter", "Pieces that came damaged.", stats.damaged),
    ];
    for (name, kind, help, value) in rows {
        head(&mut out, name, kind, help);
        let _ = writeln!(out, "cullet_{name} {value}");
    }
    head(&mut out, "messages_refused_total", "counter", "Messages refused on receipt.");
    for (of, refusals) in [("worker", stats.refusals), ("client", clients)] {
        for (reason, value) in refusals.named() {
            let label = format!("{{of=\"{of}\",reason=\"{reason}\"}}");
            let _ = writeln!(out, "cullet_messages_refused_total{label} {value}");
        }
    }
    if let Some(free) = free {
        head(&mut out, "disk_free_bytes", "gauge", "Room on the disk of the state folder.");
        let _ = writeln!(out, "cullet_disk_free_bytes {free}");
    }
    head(&mut out, "up_seconds", "gauge", "How long the coordinator has been there.");
    let _ = writeln!(out, "cullet_up_seconds {:.1}", since.elapsed().as_secs_f64());
    out
}
