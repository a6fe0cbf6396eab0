//! The digest of a run.

use super::{
    BODIES, BODY, CRACKS, DEBRIS, EVENTS, GEOMETRY, JOBS, JOINTS, SHAPE, SHEET_SURFACE, SHEETS,
    WINDOWS,
};

/// The topics of all that decided a run.
const DECIDING: [&str; 12] = [
    GEOMETRY,
    BODY,
    SHAPE,
    BODIES,
    DEBRIS,
    CRACKS,
    JOINTS,
    EVENTS,
    JOBS,
    SHEET_SURFACE,
    SHEETS,
    WINDOWS,
];

/// BLAKE3 over everything that decided a run, in recorded order: geometry, bodies, poses, joints,
/// events and job reports, and of sheets their surfaces, frames and windows. Wall times and worker
/// names are on other topics and never reach it.
#[derive(Clone, Debug, Default)]
pub struct RunDigest {
    hasher: blake3::Hasher,
}

/// Whether messages of a topic belong to the digest.
pub(super) fn decides(topic: &str) -> bool {
    DECIDING.contains(&topic)
}

impl RunDigest {
    /// Takes in one message if its topic decides; others are passed over.
    pub fn update(&mut self, topic: &str, payload: &[u8]) {
        if !decides(topic) {
            return;
        }
        self.hasher.update(&(topic.len() as u64).to_le_bytes());
        self.hasher.update(topic.as_bytes());
        self.hasher.update(&(payload.len() as u64).to_le_bytes());
        self.hasher.update(payload);
    }

    /// The digest so far, in hexadecimal.
    #[must_use]
    pub fn hex(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}
