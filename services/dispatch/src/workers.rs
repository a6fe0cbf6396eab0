//! Workers as they come, go silent and are drained.

use crate::effect::{Cause, Effect};
use crate::event::{Build, Epoch, Job, Millis, Skills, Worker, WorkerName};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::parked_polls::Asker;
use crate::state::PoolState;

/// A worker is there; one that an earlier life has drained stays so.
pub(crate) fn register(
    pool: &mut PoolState,
    now: Millis,
    worker: Worker,
    (build, skills, name): (Build, Skills, WorkerName),
    out: &mut Vec<Effect>,
) {
    #[cfg(test)]
    let name = if pool.is(Mutant::BlameBySession) { WorkerName(worker.0) } else { name };
    if pool.worker_table.arrive(now, worker, (build, skills, name)) {
        out.push(Effect::Drained { worker, cause: Cause::Before });
    }
}

/// No further job for this worker. Who asks for it is answered where it was drained before, too:
/// of what the pool finds by itself the next life knows nothing.
pub(crate) fn drain(pool: &mut PoolState, worker: Worker, cause: Cause, out: &mut Vec<Effect>) {
    let known = cause == Cause::Asked && pool.worker_table.get(&worker).is_some();
    if !pool.worker_table.drain(worker) && !known {
        return;
    }
    let ticket = pool.worker_table.get_mut(&worker).and_then(|state| state.parked.take());
    out.push(Effect::Drained { worker, cause });
    if let Some(Asker { worker, seq, .. }) = ticket.and_then(|t| pool.parked.take(t)) {
        out.push(Effect::Dismiss { worker, seq });
    }
}

/// It is gone.
pub(crate) fn close_worker(pool: &mut PoolState, worker: Worker) {
    unpark(pool, worker);
    pool.worker_table.part(worker);
}

/// Its question is not answered any more.
pub(crate) fn unpark(pool: &mut PoolState, worker: Worker) {
    let ticket = pool.worker_table.get_mut(&worker).and_then(|state| state.parked.take());
    ticket.and_then(|ticket| pool.parked.take(ticket));
}

/// Those whose end nobody has noticed, and who would be waited for in vain.
pub(crate) fn unheard(pool: &mut PoolState, now: Millis) -> Vec<Worker> {
    #[cfg(test)]
    if pool.is(Mutant::GhostAwaited) {
        return Vec::new();
    }
    pool.worker_table.unheard(now, pool.timing.patience())
}

pub(crate) fn held_by(pool: &PoolState, worker: Worker) -> Vec<(Job, Epoch)> {
    #[cfg(test)]
    if pool.is(Mutant::DownTakesAll) {
        let all =
            pool.worker_table.names().into_iter().filter_map(|name| pool.worker_table.get(&name));
        return all.flat_map(|state| state.held.iter().copied()).collect();
    }
    pool.worker_table.get(&worker).map(|state| state.held.clone()).unwrap_or_default()
}

pub(crate) fn suspect(pool: &mut PoolState, now: Millis, worker: Worker) {
    let until = now + pool.timing.suspect;
    let held = held_by(pool, worker);
    if held.is_empty() {
        close_worker(pool, worker);
    } else {
        unpark(pool, worker);
    }
    for (job, epoch) in held {
        let record = pool.jobs.get_mut(&job);
        if let Some(lease) = record.and_then(|record| record.leases.find(epoch)) {
            lease.expires = lease.expires.min(until);
            lease.suspect = true;
        }
        pool.jobs.set_timer(job, pool.timing.lease);
    }
}
