//! Specimens of the whole: each scene is run by a process of its own, as `cullet run` runs it, and
//! its numbers are read off the recording.

mod books;
mod read;
mod state;
#[cfg(test)]
mod tests;

use super::crew::in_order;
use super::limits::Limits;
use super::process::{ProcessEnd, Ran, SceneCommand, run as run_process};
use crate::specimen::whole::Whole;
use cullet_proto::specimen::{Ending, SpecimenResult};
use cullet_record::Recording;
use std::path::Path;
use tempfile::TempDir;

/// A run and the folder of its recording.
type RecordedRun = (SpecimenResult, Option<TempDir>);

/// Runs scenes, several at once, but those that have a flaw; `done` gets each result, with its
/// recording where there is one, in their order.
pub(super) fn run_all(
    wholes: &[(&Whole, Option<&str>)],
    limits: &Limits,
    done: &mut dyn FnMut(usize, SpecimenResult, Option<&Path>),
) {
    let work = |index: usize| match wholes[index] {
        (_, Some(flaw)) => (SpecimenResult::ended(Ending::Geometry(flaw.into())), None),
        (whole, None) => run(whole, limits),
    };
    in_order(wholes.len(), limits.workers, &work, &mut |index, (result, folder): RecordedRun| {
        let recording = folder.as_ref().map(|folder| folder.path().join(RECORDING));
        done(index, result, recording.as_deref());
    });
}

/// Where a run's folder is in the temporary one.
const OUT: &str = "run";
/// And its recording.
const RECORDING: &str = "run/run.mcap";

fn run(whole: &Whole, limits: &Limits) -> RecordedRun {
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(why) => {
            return (SpecimenResult::ended(Ending::Crashed(format!("no folder: {why}"))), None);
        }
    };
    let ran = run_process(SceneCommand {
        exe: &limits.exe,
        scene: &whole.file,
        overrides: &whole.overrides,
        out: &folder.path().join(OUT),
        limit: limits.time,
    });
    let ending = ending(&ran, limits);
    let ended = SpecimenResult::ended(ending);
    let mut result = SpecimenResult { price: ran.price, ..ended };
    result.outcome.step = whole.step;
    if result.outcome.ending != Ending::Ok {
        return (result, None);
    }
    match Recording::open(&folder.path().join(RECORDING)) {
        Ok(recording) => {
            read::fill(&mut result.outcome, whole, &recording);
            (result, Some(folder))
        }
        Err(why) => {
            result.outcome.ending = Ending::Crashed(why.to_string());
            (result, None)
        }
    }
}

/// What a process that ended so says of its run.
fn ending(ran: &Ran, limits: &Limits) -> Ending {
    let said = ran.said.clone();
    match ran.end {
        ProcessEnd::Complete => Ending::Ok,
        ProcessEnd::Refused => Ending::Refused(said),
        ProcessEnd::Late => Ending::Timeout(limits.late()),
        ProcessEnd::NotFinite => Ending::NotFinite(said),
        ProcessEnd::Broken => Ending::Crashed(said),
    }
}
