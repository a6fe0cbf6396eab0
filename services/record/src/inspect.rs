//! What a recording says: the summary again, and a line an event.

use super::{Jobs, RecordError, Recording, Summary, event};
use cullet_proto::recording::{EventKind, RunEvent, Sampled};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A recording in a few words.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Made from the messages, not from a stored copy.
    pub summary: Summary,
    /// Of a recording with holes a line that says so; a line an event; then one of results that
    /// were there already, one of the shares that were solved, one of what was directed, and one a
    /// sheet.
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
    let sampled: BTreeMap<u64, &Sampled> =
        recording.sampled.iter().map(|of| (of.body, of)).collect();
    let taken: BTreeSet<&[u8]> =
        recording.pool.iter().filter(|of| of.cached).map(|of| &of.job[..]).collect();
    let line = |e: &RunEvent| {
        let mut told = event::line(e, &name);
        if e.kind() == EventKind::JobSettled && taken.contains(&e.job[..]) {
            told += "; taken from an earlier solve";
        }
        let broken = e.body.filter(|_| e.kind() == EventKind::Fractured);
        match broken.and_then(|body| sampled.get(&body)) {
            Some(of) => format!("{told}; {}", parts(e.fragments.len(), of)),
            None => told,
        }
    };
    let summary = recording.summary();
    let shares = summary.shares.as_ref().filter(|_| summary.fractures > 0);
    let last = shares.map(|shares| format!("at the end: {shares}"));
    let directed = summary.directed.as_ref().map(ToString::to_string);
    let again = again(&summary.jobs);
    let sheets = recording.sheet_census().lines();
    let missing = summary.missing.as_ref();
    let missing =
        missing.map(|of| format!("the recording has holes, and this is what is left of it: {of}"));
    Ok(Inspection {
        events: missing
            .into_iter()
            .chain(recording.events.iter().map(line))
            .chain(again)
            .chain(last)
            .chain(directed)
            .chain(sheets)
            .collect(),
        summary,
        complete: recording.complete,
        damaged: recording.damaged,
    })
}

/// How many results were there already, if any were.
fn again(jobs: &Jobs) -> Option<String> {
    let Jobs { taken, solved, .. } = *jobs;
    let all = taken + solved;
    let told = || format!("of {all} jobs, {taken} taken from earlier solves, {solved} solved anew");
    (taken > 0).then(told)
}

/// How much of a fracture was solved, sampled and directed.
fn parts(fragments: usize, of: &Sampled) -> String {
    let drawn = of.fragments.len();
    let asked = of.directed.len();
    let solved = fragments.saturating_sub(drawn + asked);
    let mut counts = format!("{solved} solved, {drawn} sampled");
    if asked > 0 {
        counts.push_str(&format!(", {asked} directed"));
    }
    let volume = of.solved_volume + of.sampled_volume + of.directed_volume;
    if volume <= 0.0 {
        // A recording of before says no more.
        return counts;
    }
    let area = of.solved_crack_area + of.sampled_crack_area + of.directed_crack_area;
    let percent = |part: f64, all: f64| if all > 0.0 { 100.0 * part / all } else { 0.0 };
    let sampled = format!(
        "{counts}: {:.0} % of the volume, {:.0} % of the crack area",
        percent(of.sampled_volume, volume),
        percent(of.sampled_crack_area, area)
    );
    if asked == 0 {
        return sampled;
    }
    let (volume, area) =
        (percent(of.directed_volume, volume), percent(of.directed_crack_area, area));
    format!("{sampled} sampled; {volume:.0} % and {area:.0} % directed")
}

#[cfg(test)]
mod tests {
    use super::{Sampled, parts};

    #[test]
    fn a_fracture_says_what_share_was_sampled() {
        let old = Sampled { fragments: vec![4], ..Sampled::default() };
        assert_eq!(parts(3, &old), "2 solved, 1 sampled");
        let (solved_volume, sampled_volume) = (3e-4, 1e-4);
        let now = Sampled { solved_volume, sampled_volume, solved_crack_area: 0.1, ..old };
        let line = "2 solved, 1 sampled: 25 % of the volume, 0 % of the crack area";
        assert_eq!(parts(3, &now), line);
        let asked = Sampled { directed: vec![5, 6], directed_volume: 6e-4, ..now };
        let line = "0 solved, 1 sampled, 2 directed: 10 % of the volume, 0 % of the crack area \
                    sampled; 60 % and 0 % directed";
        assert_eq!(parts(3, &asked), line);
    }
}
