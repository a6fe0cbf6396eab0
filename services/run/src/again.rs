//! A run that takes up an earlier one.

use super::RunError;
use cullet_record::{RecordError, Recorder, RunTrail};
use cullet_scene::Scene;
use std::path::{Path, PathBuf};

/// The folder with the results of a run, in the folder of the run.
pub const RESULTS: &str = "results";

/// The earlier run that a run takes up, and what it keeps for later ones. By default: none, and
/// nothing. The digest of a run does not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunAgain<'a> {
    /// An earlier run, its folder or its recording: results of jobs that it kept are taken for
    /// jobs that are the same.
    pub from: Option<&'a Path>,
    /// First step that may differ from the earlier run: all that is recorded before it must be the
    /// same, or the run is refused with [`RecordError::Differs`].
    pub from_step: Option<u64>,
    /// Most bytes of results that are kept in the folder `results` beside the recording \[bytes\].
    pub keep: u64,
}

impl RunAgain<'_> {
    /// The recording of the earlier run.
    #[must_use]
    pub fn recording(&self) -> Option<PathBuf> {
        self.from.map(|from| if from.is_dir() { from.join("run.mcap") } else { from.to_owned() })
    }

    /// The folder with the results of the earlier run, for a run into the folder `out`. It need not
    /// be there: the earlier run may have kept none.
    ///
    /// # Errors
    /// [`RunError::From`]: there is no earlier run, or it is the one in that folder.
    pub fn results(&self, out: &Path) -> Result<Option<PathBuf>, RunError> {
        let Some(from) = self.from else { return Ok(None) };
        let fault = |why: &str| RunError::From { path: from.to_owned(), why: why.to_owned() };
        if !from.exists() {
            return Err(fault("there is no such run"));
        }
        let folder = if from.is_dir() { Some(from) } else { from.parent() };
        let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        if !OF_RUN.iter().any(|name| folder.join(name).exists()) {
            return Err(match folder.join("1/run.mcap").exists() {
                true => fault("that is a sweep; name one of its runs"),
                false => fault("no run was recorded in this folder"),
            });
        }
        let own = out.canonicalize().ok();
        let of_run = |place: &Path| OF_RUN.iter().any(|name| place.ends_with(name));
        let is_own = |place: &Path| {
            own.as_deref() == Some(place) || of_run(place) && place.parent() == own.as_deref()
        };
        if own.is_some() && places(from, folder).iter().any(|place| is_own(place)) {
            return Err(fault("a run cannot take up itself; name another folder for it"));
        }
        Ok(Some(folder.join(RESULTS)))
    }

    /// Whether the earlier run can be taken up by runs of these scenes, before anything of them is
    /// made or deleted. `out`: the folder of the run, if it has a name yet.
    ///
    /// # Errors
    /// [`RunError::From`], [`RunError::FromStep`], [`RunError::Trail`].
    pub fn check(&self, out: Option<&Path>, scenes: &[Scene]) -> Result<(), RunError> {
        self.results(out.unwrap_or(Path::new("")))?;
        let Some((until, trail)) = self.read_trail()? else { return Ok(()) };
        scenes.iter().try_for_each(|scene| fits(&trail, until, scene))
    }

    /// The same for a folder of many runs, in which the earlier one may not be.
    ///
    /// # Errors
    /// As [`RunAgain::check`].
    pub fn check_sweep(&self, out: Option<&Path>, scenes: &[Scene]) -> Result<(), RunError> {
        self.check(out, scenes)?;
        let own = out.and_then(|out| out.canonicalize().ok());
        let (Some(from), Some(own)) = (self.from, own) else { return Ok(()) };
        let folder = if from.is_dir() { from } else { from.parent().unwrap_or(from) };
        if places(from, folder).iter().any(|place| place.starts_with(&own)) {
            let why = "it is in the folder of this sweep; name another folder for the sweep";
            return Err(RunError::From { path: from.to_owned(), why: why.to_owned() });
        }
        Ok(())
    }

    fn read_trail(&self) -> Result<Option<(u64, RunTrail)>, RunError> {
        let Some(until) = self.from_step else { return Ok(None) };
        let Some(path) = self.recording() else {
            let why = "no earlier run is given to resume from".to_owned();
            return Err(RunError::FromStep { until, why });
        };
        Ok(Some((until, RunTrail::read(&path).map_err(RunError::Trail)?)))
    }

    /// The way that the earlier run took, where this one is to take it too.
    pub(super) fn trail(&self, scene: &Scene) -> Result<Option<(RunTrail, u64)>, RunError> {
        let Some((until, trail)) = self.read_trail()? else { return Ok(None) };
        fits(&trail, until, scene)?;
        Ok(Some((trail, until)))
    }
}

/// What says that a run is or was in a folder.
const OF_RUN: [&str; 3] = ["run.mcap", "run.mcap.partial", RESULTS];

/// Where a run really is, and its files, whatever links lead there.
fn places(from: &Path, folder: &Path) -> Vec<PathBuf> {
    let files = OF_RUN.iter().map(|name| folder.join(name));
    let all = [from.to_owned(), folder.to_owned()].into_iter().chain(files);
    all.filter_map(|place| place.canonicalize().ok()).collect()
}

/// Whether a run of a scene can take a way up to a step.
fn fits(trail: &RunTrail, until: u64, scene: &Scene) -> Result<(), RunError> {
    let from_step = |why: String| Err(RunError::FromStep { until, why });
    let (name, last) = (trail.path().display(), trail.last_step());
    if until > last {
        return from_step(format!("{name} is recorded up to step {last}"));
    }
    if until > scene.steps() {
        return from_step(format!("this run has {} steps", scene.steps()));
    }
    if trail.step() != scene.world.step {
        let (theirs, own) = (trail.step(), scene.world.step);
        return from_step(format!("steps are {theirs} s long in {name} and {own} s in this run"));
    }
    Ok(())
}

/// Begins the recording of a run, which is to be as an earlier one up to a step.
pub(super) fn begin(
    recorder: Result<Recorder, RecordError>,
    trail: Option<(RunTrail, u64)>,
) -> Result<Recorder, RunError> {
    let mut recorder = recorder?;
    if let Some((trail, until)) = trail {
        recorder.follow(trail, until);
    }
    Ok(recorder)
}
