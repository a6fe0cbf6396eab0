//! What a job asks of a worker.

use crate::event::{Skills, Worker};

/// What a job asks of a worker: to be able, and not to be one under whom it died.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Ask {
    pub(crate) need: Skills,
    /// In order.
    pub(crate) killers: Vec<Worker>,
}

impl Ask {
    /// Of a job that has not died.
    pub(crate) fn of(need: Skills) -> Self {
        Self { need, killers: Vec::new() }
    }

    /// It died under this worker.
    pub(crate) fn died(&mut self, worker: Worker) {
        if let Err(at) = self.killers.binary_search(&worker) {
            self.killers.insert(at, worker);
        }
    }
}
