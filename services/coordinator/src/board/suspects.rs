//! Which runs may begin beside others, and which the coordinator died of.

use super::{Board, RunEntry, Wish};

impl Board {
    /// The runs to end as stalled before any goes on: the coordinator died of them.
    pub(crate) fn deadly(&self) -> Vec<u64> {
        let deadly =
            |entry: &&RunEntry| entry.deaths.is_proof() && entry.wish != Some(Wish::Cancel);
        self.running().filter(deadly).map(|entry| entry.run).collect()
    }

    /// Whether a run may begin beside those that go on: a suspect is alone.
    pub(super) fn may_begin(&self, entry: &RunEntry) -> bool {
        let mut running = self.running();
        match entry.deaths.is_suspect() {
            true => running.next().is_none(),
            false => !running.any(|other| other.deaths.is_suspect()),
        }
    }
}
