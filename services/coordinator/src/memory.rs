//! How much memory the coordinator may hold, and which run goes when it holds more.
//!
//! Runs are threads of one process, whose memory nobody can tell apart: what is measured is that of
//! all, and what is stopped is the run with the most bodies. A process does not give back all that
//! a run leaves, so a further one is stopped only where more is held than when the last one was.
//! What grows too fast to be seen here ends the process; what then becomes of its runs is in
//! [`super::recovery`].

use super::service::{Going, Service};
use cullet_files::process_memory::of_process;
use cullet_proto::service::codes;
use std::sync::atomic::Ordering;

/// What is held may grow by this share before a further run is stopped \[1\].
const GROWTH: f64 = 0.05;

impl Service<'_> {
    /// A run is gone: if it was stopped, what is held now is what it left.
    pub(super) fn left_by(&mut self, going: &Going) {
        if going.over.is_some() && self.config.memory.is_some() {
            self.runs.heaviest = self.runs.heaviest.max(resident().unwrap_or(0));
        }
    }

    /// Stops the largest run if more is held than may be.
    pub(super) fn stop_largest(&mut self) {
        let (Some(most), Some(held)) = (self.config.memory, resident()) else { return };
        if held <= most {
            self.runs.heaviest = 0;
            return;
        }
        // What one that was stopped takes until it is gone is no other's doing.
        if self.runs.going.values().any(|going| going.over.is_some()) {
            self.runs.heaviest = self.runs.heaviest.max(held);
            return;
        }
        if held as f64 <= self.runs.heaviest as f64 * (1.0 + GROWTH) {
            return;
        }
        let bodies = |run: &u64| {
            let position = self.runs.statuses.get(run).and_then(|live| live.position());
            position.map_or(0, |position| position.bodies)
        };
        // The oldest of several that are alike.
        let largest = self.runs.going.keys().rev().max_by_key(|run| bodies(run)).copied();
        let Some(run) = largest else { return };
        let text = format!(
            "stopped: the coordinator came to hold {} MB of memory, and may hold {} \
             (--world-memory); this run had the most bodies of those at hand, {}",
            held / 1_000_000,
            most / 1_000_000,
            bodies(&run)
        );
        self.runs.heaviest = held;
        tracing::warn!(run, held, most, "{text}");
        if let Some(going) = self.runs.going.get_mut(&run) {
            going.over = Some((codes::FAILED, text));
            going.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// Memory that this process holds \[bytes\], where the system tells.
fn resident() -> Option<u64> {
    of_process("self", "VmRSS:")
}
