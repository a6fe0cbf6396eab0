//! A recorder that is to record what another run did, up to a step.

use super::trail::{Following, RunTrail};
use super::{RecordError, Recorder};

impl Recorder {
    /// From now on, what is recorded of steps before `until` must be what another run has there.
    /// The first message that is not is refused with [`RecordError::Differs`].
    pub fn follow(&mut self, trail: RunTrail, until: u64) {
        self.following = Some(Following::new(trail, until));
    }

    /// What follows need not be as in another run: this one ends early.
    pub fn unfollow(&mut self) {
        self.following = None;
    }

    /// Deletes what was recorded so far: the run is refused.
    pub fn discard(self) {
        // What is left of it is a file that nobody asked for, and no more.
        let _it_stays = std::fs::remove_file(&self.partial);
    }

    /// Takes a message into the summary, once it is what a run that this one follows has there.
    pub(super) fn count(
        &mut self,
        topic: &str,
        time: u64,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        if let Some(following) = &mut self.following {
            following.message(topic, time, payload)?;
        }
        self.tally.message(topic, time, payload)
    }
}
