//! Runs as they are recorded, for Foxglove and Lichtblick (`cullet run --foxglove`).

use crate::exit::{CommandError, Exit};
use crate::logs;
use cullet_record::MessageTap;
use cullet_web::{StreamChannel, ViewerServer};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

/// How long viewers may take for the end of the last run.
const LAST: Duration = Duration::from_secs(5);

/// A server of runs one after another.
pub(crate) struct LiveViewers {
    server: Arc<ViewerServer>,
    tap: Arc<dyn MessageTap>,
}

#[derive(Debug)]
struct ViewerTap(Arc<ViewerServer>);

impl MessageTap for ViewerTap {
    fn channel(&self, topic: &str, schema_name: &str, schema: &[u8]) {
        self.0.channel(&StreamChannel { topic, schema_name, schema });
    }

    fn message(&self, topic: &str, log_time: u64, payload: &[u8]) {
        self.0.message(topic, log_time, payload);
    }
}

impl LiveViewers {
    /// Serves, if it is wished.
    pub(crate) fn open(
        wished: Option<SocketAddr>,
        quiet: bool,
    ) -> Result<Option<Self>, CommandError> {
        let Some(address) = wished else { return Ok(None) };
        let server = ViewerServer::start(address).map_err(|error| {
            CommandError::new(Exit::Broken, format!("--foxglove={address}: {error}"))
        })?;
        if !quiet {
            let address = server.address();
            logs::say(format!("Foxglove and Lichtblick can open ws://{address}"));
        }
        let server = Arc::new(server);
        let tap = Arc::new(ViewerTap(Arc::clone(&server)));
        Ok(Some(Self { server, tap }))
    }

    /// A run begins; what is to get its messages.
    pub(crate) fn begin(&self, name: &str) -> &Arc<dyn MessageTap> {
        self.server.begin(name);
        &self.tap
    }

    /// All is over: stays until viewers have the end, and says what they have not.
    pub(crate) fn end(&self) {
        self.server.drain(LAST);
        let left_out = self.server.left_out();
        if left_out > 0 {
            logs::warn(format!("viewers were too slow for {left_out} messages, and miss them"));
        }
    }
}
