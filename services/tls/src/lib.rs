//! The TLS link of Zenoh, in the place of `zenoh-link-tls` 1.10.2.
//!
//! Zenoh's own link reads and writes one TLS session from two threads without a lock. A record that
//! does not decrypt makes the reader queue an alert while the writer encrypts, and the process
//! aborts on corrupted memory (upstream issue 2557, open in the newest version). Here the two
//! directions share one lock, which each holds only while it is polled.
//!
//! It serves what Cullet uses: TLS 1.3 in which both ends show a certificate of one authority,
//! both from files. Anything else in the configuration is refused by name. The name and version of
//! the package are those of what it replaces (`[patch.crates-io]` in the workspace manifest).

mod config;
mod link;
mod manager;

use async_trait::async_trait;
pub use config::TlsConfigurator;
pub use manager::LinkManagerUnicastTls;
use std::str::FromStr;
use zenoh_link_commons::LocatorInspector;
use zenoh_protocol::core::{Locator, Metadata, Reliability};
use zenoh_result::ZResult;

/// How locators of these links begin.
pub const TLS_LOCATOR_PREFIX: &str = "tls";

/// What a locator says of its links.
#[derive(Clone, Copy, Debug, Default)]
pub struct TlsLocatorInspector;

#[async_trait]
impl LocatorInspector for TlsLocatorInspector {
    fn protocol(&self) -> &str {
        TLS_LOCATOR_PREFIX
    }

    async fn is_multicast(&self, _locator: &Locator) -> ZResult<bool> {
        Ok(false)
    }

    fn is_reliable(&self, locator: &Locator) -> ZResult<bool> {
        match locator.metadata().get(Metadata::RELIABILITY) {
            Some(named) => Ok(Reliability::from_str(named)? == Reliability::Reliable),
            None => Ok(true),
        }
    }
}
