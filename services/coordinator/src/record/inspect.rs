//! What a recording says: the summary again, and a line an event.

use super::{RecordError, Recording, Summary, event};
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
    Ok(Inspection {
        summary: recording.summary(),
        events: recording.events.iter().map(|e| event::line(e, &name)).collect(),
        complete: recording.complete,
        damaged: recording.damaged,
    })
}
