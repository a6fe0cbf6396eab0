//! News of attempts at jobs that have not settled.

use cullet_proto::JobId;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// News of attempts that are kept until somebody asks; what is beyond it is reported as a job
/// settles.
const MAX_NEWS: usize = 4_096;

/// News of an attempt at a job that has not settled.
#[derive(Clone, Debug)]
pub struct Attempted {
    /// The job concerned.
    pub job: JobId,
    /// By which grant.
    pub grant: u64,
    /// Whose attempt.
    pub worker: String,
    /// The moment of it.
    pub at: Instant,
    /// How the attempt was lost; `None`: the worker was given the job.
    pub lost: Option<String>,
}

/// Where such news is put and found.
#[derive(Clone, Debug, Default)]
pub(super) struct AttemptNews(Arc<Mutex<Vec<Attempted>>>);

impl AttemptNews {
    pub(super) fn put(&self, news: impl IntoIterator<Item = Attempted>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let room = MAX_NEWS - all.len();
        all.extend(news.into_iter().take(room));
    }

    pub(super) fn take(&self) -> Vec<Attempted> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
