//! What is left of runs that had begun and do not go on: what they had recorded is kept.

use super::attempt::{CUT_OFF, products};
use super::board::RunEntry;
use super::local::{TIMELINE, leave};
use super::run_status::RunStatus;
use super::store::Store;
use super::timeline::RunHistory;
use cullet_proto::service::FileInfo;
use std::path::Path;

/// What a run has left that had begun and does not go on. `out`: where runs record.
pub(super) fn left(
    entry: &RunEntry,
    (store, out): (&Store, &Path),
    live: &RunStatus,
) -> Vec<FileInfo> {
    let Some(folder) = entry.folder.as_ref().map(|name| out.join(name)) else {
        return Vec::new();
    };
    if !folder.is_dir() {
        live.log(&format!("warning: {} is gone, and what it had recorded", folder.display()));
        return Vec::new();
    }
    if !folder.join(TIMELINE[0]).is_file() {
        let timeline = RunHistory::left(&store.run(entry.run));
        leave(&folder, (&entry.order.name, &timeline), live, &mut |line| live.log(&line));
    }
    products(&folder).unwrap_or_else(|text| {
        live.log(&format!("warning: what it had recorded cannot be fetched: {text}"));
        Vec::new()
    })
}

/// What a run's log says of a recording that ends before the scene does.
pub(super) fn ends_here(files: &[FileInfo]) -> &'static str {
    match files.iter().any(|file| file.name == CUT_OFF) {
        true => "the recording was cut off; `cullet recover` makes it readable",
        false => "the recording ends where the run was paused",
    }
}
