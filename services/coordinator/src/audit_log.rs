//! The life of runs as log lines: one for each event that the journal has. Those of their jobs are
//! written where jobs are opened, granted and settled.

use super::board::{BoardEvent, RunEnd, Wish};

/// Logs what happened to a run.
pub(super) fn log(event: &BoardEvent) {
    match event {
        BoardEvent::Submitted { run, order } => {
            let (ticket, user, scene, sweep) =
                (&order.ticket, &order.user, &order.name, &order.sweep);
            let priority = order.priority;
            tracing::info!(run, ticket, user, scene, sweep, priority, "run handed in");
        }
        BoardEvent::Started { run, folder, .. } => tracing::info!(run, folder, "run started"),
        BoardEvent::Ended { run, how, end, .. } => ended(*run, &format!("{how:?}"), end),
        BoardEvent::Cancelled { run, end, .. } => ended(*run, "Cancelled", end),
        BoardEvent::Wished { run, wish: Wish::Cancel } => {
            tracing::info!(run, "run is to be cancelled");
        }
        BoardEvent::Wished { run, wish: Wish::Pause } => {
            tracing::info!(run, "run is to be paused");
        }
        BoardEvent::Paused { run } => tracing::info!(run, "run paused"),
        BoardEvent::Queued { run } => tracing::info!(run, "run queued again"),
        BoardEvent::Died { run, reached } => {
            let (time_us, settled) = (reached.time, reached.settled);
            tracing::warn!(run, time_us, settled, "the coordinator died while the run went on");
        }
        BoardEvent::Forgotten { run } => tracing::info!(run, "run forgotten"),
        BoardEvent::Removed { .. }
        | BoardEvent::Numbered { .. }
        | BoardEvent::Returned { .. }
        | BoardEvent::Kept { .. } => {}
    }
}

fn ended(run: u64, how: &str, end: &RunEnd) {
    let (code, text, jobs) = (end.code, &end.text, &end.jobs);
    let (opened, settled, kept, resent) = (jobs.opened, jobs.settled, jobs.kept, jobs.resent);
    tracing::info!(run, how, code, text, opened, settled, kept, resent, "run ended");
}
