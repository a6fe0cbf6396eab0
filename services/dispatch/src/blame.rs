//! Workers under which jobs die: which of them get no more, and which only what nobody else can do.

use crate::effect::{Cause, Effect};
use crate::event::{Job, Millis, Worker, WorkerName};
use crate::job_record::Phase;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;
use crate::workers::drain;

/// A job that is done under this name had died elsewhere: there, it was not the job's fault. Who
/// has done one is not under suspicion.
pub(crate) fn blame(
    pool: &mut PoolState,
    now: Millis,
    name: WorkerName,
    job: Job,
    out: &mut Vec<Effect>,
) {
    if let Some(record) = pool.worker_table.record_mut(name) {
        record.alone.clear();
    }
    let killers = pool.jobs.get(&job).map(|r| r.ask.killers.clone()).unwrap_or_default();
    for killer in killers.into_iter().filter(|killer| *killer != name) {
        let Some(record) = pool.worker_table.record_mut(killer) else {
            continue;
        };
        record.blame += 1;
        record.blamed_at = now;
        if record.blame < pool.timing.max_blame {
            continue;
        }
        // One that is gone is looked at when it asks again.
        let there = record.there.clone();
        #[cfg(test)]
        let killer = if pool.is(Mutant::DoubtUnheeded) { WorkerName(u64::MAX) } else { killer };
        let new = pool.worker_table.doubt(killer);
        for worker in there {
            if new {
                out.push(Effect::Doubted { worker });
            }
            if pool.worker_table.spares(worker) {
                drain(pool, worker, Cause::Blamed, out);
            }
        }
    }
}

/// Why a worker is to get no more, if it is. Never the last that can do what it can: of a doubted
/// name, that one gets what nobody else can do.
///
/// Different jobs died under it, it has finished none since, and nobody else has been free to
/// try them for as long as a lease lasts. So long, as a run may be full of jobs that kill
/// whoever has them: where others are free those die under them too, and count no more.
pub(crate) fn find_doubt(pool: &mut PoolState, now: Millis, worker: Worker) -> Option<Cause> {
    let (most, lease) = (pool.timing.max_blame, pool.timing.lease);
    let name = pool.worker_table.get(&worker).filter(|state| !state.drained)?.name;
    let record = pool.worker_table.record_mut(name)?;
    let blamed = record.blame >= most;
    if !blamed && record.alone.is_empty() {
        return None;
    }
    let jobs = &pool.jobs;
    let open = |job: &Job| jobs.get(job).filter(|r| !matches!(r.phase, Phase::Over(_)));
    #[cfg(test)]
    let stays = pool.mutant == Some(Mutant::BlameStays);
    #[cfg(not(test))]
    let stays = false;
    record.alone.retain(|(job, _)| stays || open(job).is_some_and(|r| r.ask.killers == [name]));
    let untried = |(job, died): &&(Job, Millis)| {
        stays || died + lease <= now && open(job).is_some_and(|r| r.phase != Phase::Held)
    };
    let alone = record.alone.iter().filter(untried).count() >= most as usize;
    #[cfg(test)]
    let alone = alone && pool.mutant != Some(Mutant::NeverDrained);
    if !(blamed || alone) || !pool.worker_table.spares(worker) {
        return None;
    }
    Some(if blamed { Cause::Blamed } else { Cause::Alone })
}
