//! What a client asks about runs and wants done with them, and a submission's own name.

use super::LinkError;
use super::client::{Client, Terms};
use cullet_geometry::math::scramble;
use cullet_proto::keys::UserVerb;
use cullet_proto::service::{
    About, Noted, Nothing, RunInfo, Runs, Which, WorkerInfo, Workers, WorkersAfter,
};
use std::time::{SystemTime, UNIX_EPOCH};

impl Terms {
    /// The default terms with a ticket that no other submission has: from the process and the
    /// moment.
    #[must_use]
    pub fn unique() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let nanoseconds = since.map_or(0, |since| since.as_nanos() as u64);
        let mixed = scramble(nanoseconds ^ (u64::from(std::process::id()) << 32));
        Self { ticket: format!("{mixed:016x}"), ..Self::default() }
    }
}

impl Client {
    /// What the coordinator is and has.
    ///
    /// # Errors
    /// A refusal or silence.
    pub fn about(&self) -> Result<About, LinkError> {
        self.question(UserVerb::About, &Nothing {})
    }

    /// Every run that the coordinator remembers, by number.
    ///
    /// # Errors
    /// A refusal or silence.
    pub fn runs(&self) -> Result<Vec<RunInfo>, LinkError> {
        self.question(UserVerb::Runs, &Nothing {}).map(|Runs { runs }| runs)
    }

    /// Every worker that the coordinator knows, by name, a question for each page.
    ///
    /// # Errors
    /// A refusal or silence.
    pub fn workers(&self) -> Result<Vec<WorkerInfo>, LinkError> {
        let (mut all, mut asked) = (Vec::new(), WorkersAfter::default());
        loop {
            let Workers { workers, next } = self.question(UserVerb::Workers, &asked)?;
            all.extend(workers);
            // Whatever it says, each page lies behind the one before.
            if next <= asked.after {
                return Ok(all);
            }
            asked.after = next;
        }
    }

    /// Ends a run; its recording so far is kept. A run that is under way stops at its next step:
    /// the answer may still say `Running`.
    ///
    /// # Errors
    /// A refusal, silence, or a run that the coordinator does not know.
    pub fn cancel(&self, run: u64) -> Result<RunInfo, LinkError> {
        self.question(UserVerb::Cancel, &Which { run })
    }

    /// Pauses a run, which begins anew when it is resumed and takes the verdicts that were kept.
    ///
    /// # Errors
    /// As [`Client::cancel`].
    pub fn pause(&self, run: u64) -> Result<RunInfo, LinkError> {
        self.question(UserVerb::Pause, &Which { run })
    }

    /// Puts a paused run back into the queue.
    ///
    /// # Errors
    /// As [`Client::cancel`].
    pub fn resume(&self, run: u64) -> Result<RunInfo, LinkError> {
        self.question(UserVerb::Resume, &Which { run })
    }

    /// Puts a run that failed, stalled or was cancelled back into the queue.
    ///
    /// # Errors
    /// As [`Client::cancel`].
    pub fn retry(&self, run: u64) -> Result<RunInfo, LinkError> {
        self.question(UserVerb::Retry, &Which { run })
    }

    /// Deletes a run that is over, with its recording, from the coordinator's disk.
    ///
    /// # Errors
    /// As [`Client::cancel`]; a run that is not over.
    pub fn delete(&self, run: u64) -> Result<(), LinkError> {
        self.question(UserVerb::Delete, &Which { run }).map(|Noted { .. }| ())
    }
}
