//! How runs end that wait and do not go on.

use super::board::{BoardEvent, RunEnd};
use super::remains::left;
use super::service::Service;
use cullet_files::clock::unix_ms;
use cullet_proto::service::codes;

impl Service<'_> {
    /// How a run ends that is cancelled while it waits: with what it has recorded, or, where it has
    /// not begun, with these words.
    pub(super) fn cut_short(&mut self, run: u64, unbegun: &str) -> RunEnd {
        let (code, jobs, live) = (Some(codes::CANCELLED), self.jobs(run), self.status(run));
        let end = RunEnd { code, jobs, ..RunEnd::default() };
        let Ok(entry) = self.board.get(run) else { return end };
        match entry.folder {
            _ if !entry.waits() => end,
            None => RunEnd { text: unbegun.to_owned(), ..end },
            Some(_) => RunEnd {
                files: left(entry, (&self.storage.store, &self.storage.out), &live),
                ..end
            },
        }
    }

    /// Tells the runs that wait that they will not be run.
    pub(super) fn dismiss(&mut self) {
        let waiting = self.board.entries().filter(|entry| entry.waits());
        let waiting: Vec<u64> = waiting.map(|entry| entry.run).collect();
        for run in waiting {
            let end = self.cut_short(run, "the coordinator left before the run began");
            if !end.text.is_empty() {
                self.status(run).log(&format!("error: {}", end.text));
            }
            self.admit(BoardEvent::Cancelled { run, end, at: unix_ms() });
        }
    }
}
