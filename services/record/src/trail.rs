//! What decided a run, message by message, so that another run can be kept to it: a run that
//! resumes from a step takes the same way up to there.

use super::digest::decides;
use super::found::Found;
use super::grains::{GrainRows, LongForm};
use super::read::{load, walk};
use super::summary::decode;
use super::{
    BODIES, BODY, CRACKS, DEBRIS, GEOMETRY, JOBS, JOINTS, RecordError, SHAPE, SHEET_SURFACE,
    SHEETS, WINDOWS,
};
use cullet_proto::recording::{Grains, Recorded};
use std::path::{Path, PathBuf};

/// Nanoseconds of a second.
const NANOSECONDS: f64 = 1e9;

/// One message that decided a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mark {
    /// Simulated time \[ns\].
    time: u64,
    /// Digest of its topic and bytes.
    digest: [u8; 32],
}

impl Mark {
    fn of(topic: &str, time: u64, payload: &[u8]) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(topic.as_bytes()).update(&[0]).update(payload);
        Self { time, digest: *hasher.finalize().as_bytes() }
    }
}

/// All messages that decided a run, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct RunTrail {
    path: PathBuf,
    marks: Vec<Mark>,
    /// Time step \[s\].
    step: f64,
}

impl RunTrail {
    /// Reads it from a recording, whole or cut off.
    ///
    /// # Errors
    /// No recording of a run, or one of which a part is damaged.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let (path, bytes) = load(path)?;
        let (mut rows, mut step) = (GrainRows::default(), None);
        let mut marks = Vec::new();
        let walk = walk(&path, &bytes, &mut |found| {
            match found {
                Found::Metadata(metadata) if metadata.name == "run" => {
                    rows = GrainRows::of(&metadata.metadata);
                    step = metadata.metadata.get("step").and_then(|step| step.parse().ok());
                }
                Found::Message(header, data, Some(topic)) if decides(&topic) => {
                    let data = match &*topic {
                        DEBRIS => exact(&mut rows, header.log_time, data)?,
                        _ => data,
                    };
                    marks.push(Mark::of(&topic, header.log_time, &data));
                }
                _ => {}
            }
            Ok(())
        })?;
        let step = step.filter(|step: &f64| *step > 0.0);
        match step.filter(|_| walk.holes.is_empty()) {
            Some(step) => Ok(Self { path, marks, step }),
            None if walk.holes.is_empty() => Err(RecordError::Foreign { path }),
            None => Err(RecordError::Patchy { path, missing: walk.holes.to_string() }),
        }
    }

    /// The recording that it was read from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Time step of the run \[s\].
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The last step of which something was recorded.
    #[must_use]
    pub fn last_step(&self) -> u64 {
        self.marks.iter().map(|mark| self.step_at(mark.time)).max().unwrap_or(0)
    }

    fn step_at(&self, time: u64) -> u64 {
        (time as f64 / NANOSECONDS / self.step).round() as u64
    }
}

/// The bytes of a message of grains that the digest covers.
fn exact(rows: &mut GrainRows, time: u64, data: Vec<u8>) -> Result<Vec<u8>, RecordError> {
    let told: Grains = decode(DEBRIS, time, &data)?;
    let Some(LongForm { all, moved }) = rows.long(&told) else {
        rows.take(&told);
        return Ok(data);
    };
    rows.take(&moved);
    Ok(all.to_bytes())
}

/// A run that is to be as another one up to a step.
#[derive(Clone, Debug)]
pub(super) struct Following {
    trail: RunTrail,
    /// The first step that may differ.
    until: u64,
    /// Messages that were the same.
    same: usize,
    /// Whether that step was reached.
    reached: bool,
}

impl Following {
    pub(super) fn new(trail: RunTrail, until: u64) -> Self {
        Self { trail, until, same: 0, reached: false }
    }

    /// Takes in a message of the new run.
    ///
    /// # Errors
    /// [`RecordError::Differs`].
    pub(super) fn message(
        &mut self,
        topic: &str,
        time: u64,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        if self.reached || !decides(topic) {
            return Ok(());
        }
        let (step, due) = (self.trail.step_at(time), self.trail.marks.get(self.same));
        let same = match step < self.until {
            true => due == Some(&Mark::of(topic, time, payload)),
            false => {
                self.reached = true;
                due.is_none_or(|due| self.trail.step_at(due.time) >= self.until)
            }
        };
        self.same += 1;
        if same {
            return Ok(());
        }
        // What is missing in one of the two runs is of the earlier step.
        let step = due.map_or(step, |due| step.min(self.trail.step_at(due.time)));
        let (path, until, what) = (self.trail.path.clone(), self.until, word(topic));
        Err(RecordError::Differs { path, step, until, what })
    }
}

/// What messages of a topic are about.
fn word(topic: &str) -> &'static str {
    match topic {
        GEOMETRY | SHAPE => "the shape of a body",
        BODY => "a body",
        BODIES => "where the bodies are",
        DEBRIS => "where debris is",
        CRACKS => "a crack",
        JOINTS => "a joint",
        JOBS => "what came of a job",
        SHEET_SURFACE | SHEETS | WINDOWS => "a body that moves as it deforms",
        _ => "what happens",
    }
}

#[cfg(test)]
mod tests;
