//! The life of runs as log lines: one for each event that the journal has. Those of their jobs are
//! written where jobs are opened, granted and settled.

use super::board::{RunEnd, RunJournalEvent, Wish};

/// Logs what happened to a run.
pub(super) fn log(event: &RunJournalEvent) {
    match event {
        RunJournalEvent::Submitted { run, order } => {
            let (ticket, user, scene, sweep) =
                (&order.ticket, &order.user, &order.name, &order.sweep);
            let priority = order.priority;
            tracing::info!(run, ticket, user, scene, sweep, priority, "run handed in");
        }
        RunJournalEvent::Started { run, folder, .. } => tracing::info!(run, folder, "run started"),
        RunJournalEvent::Ended { run, how, end, .. } => ended(*run, &format!("{how:?}"), end),
        RunJournalEvent::Cancelled { run, end, .. } => ended(*run, "Cancelled", end),
        RunJournalEvent::Wished { run, wish: Wish::Cancel } => {
            tracing::info!(run, "run is to be cancelled")
        }
        RunJournalEvent::Wished { run, wish: Wish::Pause } => {
            tracing::info!(run, "run is to be laid aside")
        }
        RunJournalEvent::Paused { run } => tracing::info!(run, "run laid aside"),
        RunJournalEvent::Queued { run } => tracing::info!(run, "run queued again"),
        RunJournalEvent::Died { run, reached } => {
            let (time_us, settled) = (reached.time, reached.settled);
            tracing::warn!(run, time_us, settled, "the coordinator died while the run went on");
        }
        RunJournalEvent::Forgotten { run } => tracing::info!(run, "run forgotten"),
        RunJournalEvent::Removed { .. }
        | RunJournalEvent::Numbered { .. }
        | RunJournalEvent::Returned { .. }
        | RunJournalEvent::Kept { .. } => {}
    }
}

fn ended(run: u64, how: &str, end: &RunEnd) {
    let (code, text, jobs) = (end.code, &end.text, &end.jobs);
    let (opened, settled, kept, resent) = (jobs.opened, jobs.settled, jobs.kept, jobs.resent);
    tracing::info!(run, how, code, text, opened, settled, kept, resent, "run ended");
}
