//! The farm as its page has it: what is published, and when.

use super::board::RunEntry;
use super::error::ServiceError;
use super::service::Service;
use cullet_web::{FarmNews, Feed, RunNews, Website};

/// The page, and where it is fed.
pub(super) struct WebPage {
    feed: Feed,
    _site: Website,
}

impl Service<'_> {
    /// Serves the page, if it is wished; who comes first finds what there is.
    pub(super) fn open_page(&mut self) -> Result<(), ServiceError> {
        let Some(web) = &self.config.web else { return Ok(()) };
        let feed = Feed::default();
        feed.publish(self.farm());
        let site = Website::serve(web.clone(), feed.clone())?;
        self.page = Some(WebPage { feed, _site: site });
        Ok(())
    }

    /// Puts down for watchers what there is, if it is time for it.
    pub(super) fn publish(&self) {
        if let Some(page) = self.page.as_ref().filter(|page| page.feed.is_due()) {
            page.feed.publish(self.farm());
        }
    }

    fn farm(&self) -> FarmNews {
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
