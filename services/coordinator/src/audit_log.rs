//! The life of runs as log lines: one for each event that the journal has. Those of their jobs are
//! written where jobs are opened, granted and settled.

use super::board::{End, Event, Wish};

/// Logs what happened to a run.
pub(super) fn log(event: &Event) {
    match event {
        Event::Submitted { run, order } => {
            let (ticket, user, scene, sweep) =
                (&order.ticket, &order.user, &order.name, &order.sweep);
            let priority = order.priority;
            tracing::info!(run, ticket, user, scene, sweep, priority, "run handed in");
        }
        Event::Started { run, folder, .. } => tracing::info!(run, folder, "run started"),
        Event::Ended { run, how, end, .. } => ended(*run, &format!("{how:?}"), end),
        Event::Cancelled { run, end, .. } => ended(*run, "Cancelled", end),
        Event::Wished { run, wish: Wish::Cancel } => tracing::info!(run, "run is to be cancelled"),
        Event::Wished { run, wish: Wish::Pause } => tracing::info!(run, "run is to be laid aside"),
        Event::Paused { run } => tracing::info!(run, "run laid aside"),
        Event::Queued { run } => tracing::info!(run, "run queued again"),
        Event::Died { run, reached } => {
            let (time_us, settled) = (reached.time, reached.settled);
            tracing::warn!(run, time_us, settled, "the coordinator died while the run went on");
        }
        Event::Forgotten { run } => tracing::info!(run, "run forgotten"),
        Event::Removed { .. }
        | Event::Numbered { .. }
        | Event::Returned { .. }
        | Event::Kept { .. } => {}
    }
}

fn ended(run: u64, how: &str, end: &End) {
    let (code, text, jobs) = (end.code, &end.text, &end.jobs);
    let (opened, settled, kept, resent) = (jobs.opened, jobs.settled, jobs.kept, jobs.resent);
    tracing::info!(run, how, code, text, opened, settled, kept, resent, "run ended");
}
