//! Workers under which jobs die: which of them get no more.

use crate::effect::{Cause, Effect};
use crate::event::{Job, Millis, Worker};
use crate::job_record::Phase;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;
use crate::workers::drain;

/// A job that is done here had died elsewhere: there, it was not the job's fault. Who has done
/// one is not under suspicion.
pub(crate) fn blame(pool: &mut PoolState, worker: Worker, job: Job, out: &mut Vec<Effect>) {
    if let Some(state) = pool.worker_table.get_mut(&worker) {
        state.alone.clear();
    }
    let killers = pool.jobs.get(&job).map(|r| r.ask.killers.clone()).unwrap_or_default();
    for killer in killers.into_iter().filter(|killer| *killer != worker) {
        let Some(state) = pool.worker_table.get_mut(&killer) else {
            continue;
        };
        state.blame += 1;
        if state.blame >= pool.timing.max_blame && pool.worker_table.spares(killer) {
            drain(pool, killer, Cause::Blamed, out);
        }
    }
}

/// Why a worker is to get no more, if it is. Never the last that can do what it can.
///
/// Different jobs died under it, it has finished none since, and nobody else has been free to
/// try them for as long as a lease lasts. So long, as a run may be full of jobs that kill
/// whoever has them: where others are free those die under them too, and count no more.
pub(crate) fn find_doubt(pool: &mut PoolState, now: Millis, worker: Worker) -> Option<Cause> {
    let (most, lease) = (pool.timing.max_blame, pool.timing.lease);
    let state = pool.worker_table.get_mut(&worker).filter(|state| !state.drained)?;
    let blamed = state.blame >= most;
    if !blamed && state.alone.is_empty() {
        return None;
    }
    let jobs = &pool.jobs;
    let open = |job: &Job| jobs.get(job).filter(|r| !matches!(r.phase, Phase::Over(_)));
    #[cfg(test)]
    let stays = pool.mutant == Some(Mutant::BlameStays);
    #[cfg(not(test))]
    let stays = false;
    state.alone.retain(|(job, _)| stays || open(job).is_some_and(|r| r.ask.killers == [worker]));
    let untried = |(job, died): &&(Job, Millis)| {
        stays || died + lease <= now && open(job).is_some_and(|r| r.phase != Phase::Held)
    };
    let alone = state.alone.iter().filter(untried).count() >= most as usize;
    #[cfg(test)]
    let alone = alone && pool.mutant != Some(Mutant::NeverDrained);
    if !(blamed || alone) || !pool.worker_table.spares(worker) {
        return None;
    }
    Some(if blamed { Cause::Blamed } else { Cause::Alone })
}
