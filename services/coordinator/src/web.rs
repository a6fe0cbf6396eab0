//! The page of the farm, and where it is fed.

use super::error::ServiceError;
use cullet_web::{FarmNews, Feed, WebConfig, Website};
use std::net::SocketAddr;

/// The page; it ends when dropped.
pub(super) struct WebPage {
    feed: Feed,
    site: Website,
}

impl WebPage {
    /// Serves the page; who comes first finds what there is.
    pub(super) fn open(config: WebConfig, now: FarmNews) -> Result<Self, ServiceError> {
        let feed = Feed::default();
        feed.publish(now);
        let site = Website::serve(config, feed.clone())?;
        Ok(Self { feed, site })
    }

    /// Where it is, as it is bound.
    pub(super) fn address(&self) -> Option<SocketAddr> {
        self.site.address()
    }

    /// Puts down for watchers what there is, if it is time for it.
    pub(super) fn publish(&self, now: impl FnOnce() -> FarmNews) {
        if self.feed.is_due() {
            self.feed.publish(now());
        }
    }
}
