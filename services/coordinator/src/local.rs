//! A run without a queue, on a pool of its own, and what every run leaves beside its recording.

use super::replaying_pool::ReplayingPool;
use super::results::RunResults;
use super::run_status::RunStatus;
use super::timeline::{self, Timeline};
use cullet_files::output::write_file;
use cullet_pool::{Build, RunHandle};
use cullet_run::{News, Outcome, RunError, RunOptions, run};
use cullet_scene::Scene;
use std::path::Path;

/// Who solved what and when: a picture and a trace.
pub(super) const TIMELINE: [&str; 2] = ["timeline.svg", "timeline.trace.json"];
/// What reproduces a job that was given up: its encoding, and how its attempts ended.
pub(super) const REPRODUCTION: [&str; 2] = ["job.bin", "attempts.txt"];

/// Runs a scene to its end. Beside what [`run`] writes there is a timeline, also of a run that
/// could not go on, what reproduces a job that the pool gave up, and the results that
/// `options.again` keeps. `build`: what the workers of the pool are.
///
/// # Errors
/// As [`run`].
pub fn run_here(
    scene: &Scene,
    pool: &RunHandle,
    options: &RunOptions<'_>,
    build: Build,
    news: &mut dyn FnMut(&News),
) -> Result<Outcome, RunError> {
    let _span = tracing::info_span!("run", run = pool.number()).entered();
    tracing::info!(scene = scene.name, "run started");
    let live = RunStatus::default();
    let results = RunResults::open(options.out, &options.again, build)?;
    results.warning().into_iter().for_each(|line| news(&News::Results(line)));
    let replaying = ReplayingPool::new(pool, Some(&results), &live);
    let outcome = run(scene, &replaying, options, news);
    replaying.close();
    let refused = outcome.as_ref().is_err_and(RunError::is_refusal);
    if refused {
        results.discard();
    } else {
        results.lines(&live.jobs()).into_iter().for_each(|line| news(&News::Results(line)));
    }
    // A run that came to nothing leaves nothing.
    if outcome.is_ok() || live.jobs().opened > 0 && !refused {
        let timeline = Timeline::of(live.timeline());
        let mut warn = |line| news(&News::Line(line));
        leave(options.out, (&scene.name, &timeline), &live, &mut warn);
    }
    let (jobs, error) = (live.jobs(), outcome.as_ref().err().map(ToString::to_string));
    tracing::info!(opened = jobs.opened, settled = jobs.settled, error, "run ended");
    outcome
}

/// Writes the timeline of a run and what reproduces a job of it that was given up.
pub(super) fn leave(
    folder: &Path,
    (name, timeline): (&str, &Timeline),
    live: &RunStatus,
    warn: &mut dyn FnMut(String),
) {
    let (svg, trace) = (timeline::svg(name, timeline), timeline::trace(name, timeline));
    let timeline = TIMELINE.into_iter().zip([svg, trace].map(String::into_bytes));
    let reproduction = live.reproduction().map(|it| [it.job, it.attempts.into_bytes()]);
    let reproduction = reproduction.into_iter().flat_map(|both| REPRODUCTION.into_iter().zip(both));
    for (file, bytes) in timeline.into_iter().chain(reproduction) {
        if let Err(error) = write_file(&folder.join(file), &bytes) {
            warn(format!("warning: {file}: {error}"));
        }
    }
}
