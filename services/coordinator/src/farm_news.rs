//! The farm as its page has it.

use super::board::RunEntry;
use super::service::Service;
use cullet_web::{FarmNews, RunNews};

impl Service<'_> {
    /// All that there is to watch.
    pub(super) fn farm(&self) -> FarmNews {
        let (about, stats) = (self.about(), self.pool.stats());
        let runs = self.board.entries().map(|entry| self.news(entry)).collect();
        FarmNews {
            name: self.pool.name().to_string(),
            version: about.version,
            now_ms: about.now_ms,
            up_ms: about.up_ms,
            runs_at_once: about.runs_at_once,
            free_bytes: about.free_bytes,
            jobs_waiting: stats.jobs.waiting,
            jobs_running: stats.jobs.running,
            runs,
            workers: self.pool.workers(),
        }
    }

    fn news(&self, entry: &RunEntry) -> RunNews {
        let status = self.runs.statuses.get(&entry.run);
        let line = status.and_then(|status| status.last_line()).unwrap_or_default();
        let folder = entry.folder.as_ref().map(|name| self.storage.out.join(name));
        RunNews { info: self.info(entry), folder, line }
    }
}
