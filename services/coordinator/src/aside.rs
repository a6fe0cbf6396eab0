//! How runs end that do not go on: what they had recorded is kept.

use super::attempt::{CUT_OFF, products};
use super::board::{End, Entry, Event};
use super::here::{TIMELINE, leave};
use super::live::RunStatus;
use super::timeline::RunHistory;
use super::{Service, Store};
use cullet_files::clock::unix_ms;
use cullet_proto::service::{FileInfo, codes};
use std::path::Path;

impl Service<'_> {
    /// How a run ends that is cancelled while it waits: with what it has recorded, or, where it has
    /// not begun, with these words.
    pub(super) fn cut_short(&mut self, run: u64, unbegun: &str) -> End {
        let (code, jobs, live) = (Some(codes::CANCELLED), self.jobs(run), self.live(run));
        let end = End { code, jobs, ..End::default() };
        let Ok(entry) = self.board.get(run) else { return end };
        match entry.folder {
            _ if !entry.waits() => end,
            None => End { text: unbegun.to_owned(), ..end },
            Some(_) => End { files: left(entry, (&self.store, &self.out), &live), ..end },
        }
    }

    /// Tells the runs that wait that they will not be run.
    pub(super) fn dismiss(&mut self) {
        let waiting = self.board.entries().filter(|entry| entry.waits());
        let waiting: Vec<u64> = waiting.map(|entry| entry.run).collect();
        for run in waiting {
            let end = self.cut_short(run, "the coordinator left before the run began");
            if !end.text.is_empty() {
                self.live(run).say(&format!("error: {}", end.text));
            }
            self.admit(Event::Cancelled { run, end, at: unix_ms() });
        }
    }
}

/// What a run has left that had begun and does not go on. `out`: where runs record.
pub(super) fn left(
    entry: &Entry,
    (store, out): (&Store, &Path),
    live: &RunStatus,
) -> Vec<FileInfo> {
    let Some(folder) = entry.folder.as_ref().map(|name| out.join(name)) else {
        return Vec::new();
    };
    if !folder.is_dir() {
        live.say(&format!("warning: {} is gone, and what it had recorded", folder.display()));
        return Vec::new();
    }
    if !folder.join(TIMELINE[0]).is_file() {
        let told = RunHistory::told(&store.run(entry.run));
        leave(&folder, (&entry.order.name, &told), live, &mut |line| live.say(&line));
    }
    products(&folder).unwrap_or_else(|text| {
        live.say(&format!("warning: what it had recorded cannot be fetched: {text}"));
        Vec::new()
    })
}

/// What a run's log says of a recording that ends before the scene does.
pub(super) fn ends_here(files: &[FileInfo]) -> &'static str {
    match files.iter().any(|file| file.name == CUT_OFF) {
        true => "the recording was cut off; `cullet recover` makes it readable",
        false => "the recording ends where the run was laid aside",
    }
}
