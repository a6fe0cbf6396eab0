//! The bench's pool: worker processes of its own on this machine, and no second tries.
//!
//! A specimen that crashes or hangs is a finding. It is not tried again, and no result is kept for
//! a repeat, whose costs would then be another run's.

use super::limits::Limits;
use super::{SweepPoint, whole};
use crate::specimen::Subject;
use crate::specimen::whole::Whole;
use cullet_pool::{
    CacheConfig, JobEnding as Settled, LinkError, Pool, PoolConfig, Settlement, Share, SpawnConfig,
    Timing,
};
use cullet_proto::specimen::{Ending, SpecimenResult};
use cullet_proto::{JobId, Verdict};
use std::path::Path;
use std::time::Duration;

/// How often a result is waited for before it is waited for again.
const LOOK: Duration = Duration::from_secs(1);
/// Longest that a run may take at all.
const LONGEST: Duration = Duration::from_secs(1_000_000_000);

/// Runs every point in a process of its own; `done` gets each result, in the order of the
/// points, with the recording of a scene, which is gone afterwards.
///
/// # Errors
/// The pool does not start.
pub fn run_all(
    points: &[SweepPoint],
    limits: &Limits,
    done: &mut dyn FnMut(usize, SpecimenResult, Option<&Path>),
) -> Result<(), LinkError> {
    let is_body = |point: &SweepPoint| point.specimen.job().is_some();
    let mut first = 0;
    for group in points.chunk_by(|a, b| is_body(a) == is_body(b)) {
        let wholes: Vec<_> = group.iter().filter_map(scene_of).collect();
        if wholes.is_empty() {
            bodies(group, limits, &mut |index, result| done(first + index, result, None))?;
        } else {
            whole::run_all(&wholes, limits, &mut |index, result, recording| {
                done(first + index, result, recording);
            });
        }
        first += group.len();
    }
    Ok(())
}

/// A scene, and why it cannot be run, if so.
fn scene_of(point: &SweepPoint) -> Option<(&Whole, Option<&str>)> {
    match &point.specimen.subject {
        Subject::Whole(whole) => Some((whole, point.specimen.flaw.as_deref())),
        Subject::Body(_) => None,
    }
}

/// Has bodies solved by worker processes.
fn bodies(
    points: &[SweepPoint],
    limits: &Limits,
    done: &mut dyn FnMut(usize, SpecimenResult),
) -> Result<(), LinkError> {
    let workers = limits.workers.clamp(1, points.len().max(1));
    let timing = Timing {
        hard: limits.time.min(LONGEST).as_millis() as u64,
        max_crashes: 1,
        min_killers: 1,
        hedge_factor: u64::from(u32::MAX),
        ..Timing::production()
    };
    let mut spawn = SpawnConfig::new(limits.exe.clone(), workers, 1);
    spawn.args.extend(limits.words.iter().cloned());
    let pool = Pool::start(PoolConfig {
        spawn: Some(spawn),
        timing,
        cache: CacheConfig { memory: 0, disk: None },
        ..PoolConfig::default()
    })?;
    let run = pool.run(Share::default());
    let open = |point: &SweepPoint| {
        if let Some(flaw) = &point.specimen.flaw {
            return Err(Ending::Geometry(flaw.clone()));
        }
        let Some(job) = point.specimen.job() else {
            return Err(Ending::Crashed("it is no body".to_owned()));
        };
        job.encode().map_err(|error| Ending::Refused(error.to_string()))?;
        Ok(run.open_specimen(job))
    };
    let jobs: Vec<Result<JobId, Ending>> = points.iter().map(open).collect();
    for (index, job) in jobs.into_iter().enumerate() {
        let result = match job {
            Err(ending) => SpecimenResult::ended(ending),
            Ok(_) => loop {
                if let Some((_, settlement)) = run.settled(LOOK) {
                    break result_of(settlement, limits);
                }
            },
        };
        done(index, result);
    }
    pool.shutdown();
    Ok(())
}

/// What is made of the end of a run's job.
pub(super) fn result_of(settlement: Settlement, limits: &Limits) -> SpecimenResult {
    let text = match settlement.ending {
        Settled::Verdict(Verdict::Measured(result)) => return *result,
        Settled::Verdict(other) => format!("it was answered with {other:.40?}"),
        Settled::Abandoned(text) => text,
        Settled::Cancelled => "it was cancelled".to_owned(),
    };
    let last = settlement.tries.last();
    let took = last.map(|last| last.ended.unwrap_or(settlement.wall).saturating_sub(last.granted));
    let mut result = SpecimenResult::ended(if settlement.overdue {
        Ending::Timeout(limits.late())
    } else {
        Ending::Crashed(text)
    });
    // A process that was ended tells no costs: it has cost the time that it had.
    result.price.wall = took.unwrap_or_default().as_secs_f64();
    result.price.cpu = result.price.wall;
    result
}
