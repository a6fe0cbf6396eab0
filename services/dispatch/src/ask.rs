//! What a job asks of a worker.

use crate::event::{Skills, WorkerName};

/// What a job asks of a worker: to be able, and not to be one under whom it died.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Ask {
    pub(crate) need: Skills,
    /// In order.
    pub(crate) killers: Vec<WorkerName>,
}

impl Ask {
    /// Of a job that has not died.
    pub(crate) fn of(need: Skills) -> Self {
        Self { need, killers: Vec::new() }
    }

    /// It died under a worker of this name.
    pub(crate) fn died(&mut self, name: WorkerName) {
        if let Err(at) = self.killers.binary_search(&name) {
            self.killers.insert(at, name);
        }
    }
}
