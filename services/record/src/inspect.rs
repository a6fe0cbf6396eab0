//! What a recording says: the summary again, and a line an event.

use super::{RecordError, Recording, Summary, event};
use cullet_proto::recording::{EventKind, RunEvent};
use std::collections::BTreeMap;
use std::path::Path;

/// A recording in a few words.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Made from the messages, not from a stored copy.
    pub summary: Summary,
    /// A line an event.
    pub events: Vec<String>,
    /// False if the run was cut off: the summary then speaks of what was saved.
    pub complete: bool,
    /// True if something in the file is not as it was written.
    pub damaged: bool,
}

/// Reads a recording, whole or cut off.
///
/// # Errors
/// As [`Recording::open`].
pub fn inspect(path: &Path) -> Result<Inspection, RecordError> {
    let recording = Recording::open(path)?;
    let names: BTreeMap<u64, &str> =
        recording.bodies.iter().map(|body| (body.id, body.name.as_str())).collect();
    let name = |id: u64| names.get(&id).map_or_else(|| format!("body {id}"), ToString::to_string);
    // Of each fracture, how many of its fragments were sampled.
    let sampled: BTreeMap<u64, usize> =
        recording.sampled.iter().map(|of| (of.body, of.fragments.len())).collect();
    let line = |e: &RunEvent| {
        let told = event::line(e, &name);
        let broken = e.body.filter(|_| e.kind() == EventKind::Fractured);
        match broken.and_then(|body| sampled.get(&body)) {
            Some(drawn) => format!("{told}; {} solved, {drawn} sampled", e.fragments.len() - drawn),
            None => told,
        }
    };
    let summary = recording.summary();
    let shares = summary.shares.as_ref().filter(|_| summary.fractures > 0);
    let last = shares.map(|shares| format!("at the end: {shares}"));
    Ok(Inspection {
        events: recording.events.iter().map(line).chain(last).collect(),
        summary,
        complete: recording.complete,
        damaged: recording.damaged,
    })
}
