//! What becomes of runs that went on when the coordinator died, at its next start.

use super::audit_log;
use super::board::{AttemptEnd, Board, BoardEvent, CoordinatorDeaths, RunEnd, Wish};
use super::error::ServiceError;
use super::journal::Journal;
use super::reach::reached;
use super::remains::{ends_here, left};
use super::run_status::RunStatus;
use super::store::Store;
use cullet_files::clock::unix_ms;
use cullet_proto::service::codes;
use std::path::Path;

/// Journals that the coordinator is back: runs that went on wait again, and those that it died of
/// are ended as stalled. How many went on.
pub(super) fn returned(
    (store, out): (&Store, &Path),
    journal: &mut Journal,
    board: &mut Board,
    report: &mut dyn FnMut(&str),
) -> Result<usize, ServiceError> {
    let going: Vec<u64> = board.running().map(|entry| entry.run).collect();
    if going.is_empty() {
        return Ok(0);
    }
    let mut keep = |board: &mut Board, events: Vec<BoardEvent>| -> Result<(), ServiceError> {
        journal.append(&events)?;
        for event in &events {
            audit_log::log(event);
            // They fit: the runs go on.
            let _fits = board.apply(event);
        }
        Ok(())
    };
    let died = |run: &u64| BoardEvent::Died { run: *run, reached: reached(&store.run(*run)) };
    keep(board, going.iter().map(died).collect())?;
    let mut last = Vec::new();
    for run in &going {
        let Ok(entry) = board.get(*run) else { continue };
        let live = RunStatus::open(&store.run(*run).join("log"));
        live.log(&line(entry.deaths));
        if entry.wish == Some(Wish::Cancel) {
            let files = left(entry, (store, out), &live);
            live.log(&format!("cancelled: {}", ends_here(&files)));
            let end = RunEnd { code: Some(codes::CANCELLED), files, ..RunEnd::default() };
            last.push(BoardEvent::Ended {
                run: *run,
                how: AttemptEnd::Stopped,
                end,
                at: unix_ms(),
            });
        } else if board.deadly().contains(run) {
            let text = verdict(entry.deaths);
            live.log(&format!("error: {text}"));
            report(&format!("run {run}: {text}"));
            let files = left(entry, (store, out), &live);
            let end = RunEnd { code: Some(codes::STALLED), text, files, ..RunEnd::default() };
            last.push(BoardEvent::Ended {
                run: *run,
                how: AttemptEnd::Stalled,
                end,
                at: unix_ms(),
            });
        }
    }
    last.push(BoardEvent::Returned { at: unix_ms() });
    keep(board, last)?;
    Ok(going.len())
}

fn line(deaths: CoordinatorDeaths) -> String {
    let CoordinatorDeaths { all, reached, .. } = deaths;
    let at = reached.time as f64 * 1e-6;
    match (all, deaths.is_suspect()) {
        (_, false) => "the coordinator died while the run went on".to_owned(),
        (all, true) => format!(
            "the coordinator died while the run went on, {all} times and never later than at \
             {at:.3} s: it goes on alone"
        ),
    }
}

fn verdict(deaths: CoordinatorDeaths) -> String {
    let CoordinatorDeaths { all, alone, reached } = deaths;
    format!(
        "the coordinator died {all} times while the run went on, the last {alone} while it alone \
         went on, and it never came further than {:.3} s and {} jobs. It may need more memory than \
         there is here; `retry` begins it again",
        reached.time as f64 * 1e-6,
        reached.settled
    )
}
