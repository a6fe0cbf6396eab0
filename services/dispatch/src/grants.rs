//! Leases as they come and go: held, dropped, given back, released.

use crate::effect::{Effect, Verdict};
use crate::event::{Job, Millis};
use crate::job_record::Phase;
use crate::leases::Lease;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;

/// A job comes under a lease.
pub(crate) fn hold(pool: &mut PoolState, now: Millis, job: Job, lease: Lease) {
    let Some(record) = pool.jobs.get_mut(&job) else {
        return;
    };
    record.leases.push(lease);
    let alone = record.leases.only().is_some();
    #[cfg(test)]
    let alone = alone || pool.mutant == Some(Mutant::HedgedAgain);
    let hedged: Vec<_> =
        record.leases.iter().filter(|held| held.slow && !alone).map(|held| held.granted).collect();
    for granted in hedged {
        pool.jobs.forget_slow(granted, job);
    }
    if let Some(state) = pool.worker_table.get_mut(&lease.worker) {
        state.held.push((job, lease.epoch));
    }
    pool.set_phase(now, job, Phase::Held);
}

/// A lease is over, however: it is charged what it took.
pub(crate) fn drop_lease(pool: &mut PoolState, now: Millis, job: Job, lease: &Lease, whole: bool) {
    let took = now.saturating_sub(lease.granted);
    pool.shares.took(lease.run, lease.charged, took, whole);
    if lease.slow {
        pool.jobs.forget_slow(lease.granted, job);
    }
    if let Some(state) = pool.worker_table.get_mut(&lease.worker) {
        state.held.retain(|held| *held != (job, lease.epoch));
        state.heard = now;
    }
}

/// A lease of a job is nobody's any more, and who has it goes on.
pub(crate) fn give_back(pool: &mut PoolState, now: Millis, job: Job, lease: &Lease) {
    if let Some(record) = pool.jobs.get_mut(&job) {
        record.leases.take(|held| held.epoch == lease.epoch);
    }
    drop_lease(pool, now, job, lease, false);
}

/// All leases of a job are over, with this verdict; who has one is told, but who found it.
pub(crate) fn release(
    pool: &mut PoolState,
    now: Millis,
    job: Job,
    verdict: Verdict,
    out: &mut Vec<Effect>,
) {
    let Some(record) = pool.jobs.get_mut(&job) else {
        return;
    };
    let by = match verdict {
        Verdict::Done { worker, .. } => worker,
        Verdict::Abandoned(_) | Verdict::Cancelled => None,
    };
    for lease in std::mem::take(&mut record.leases) {
        let Lease { worker, epoch, .. } = lease;
        drop_lease(pool, now, job, &lease, by == Some(worker));
        #[cfg(test)]
        if pool.is(Mutant::CancelUnsaid) {
            continue;
        }
        if by != Some(worker) {
            out.push(Effect::Cancel { worker, job, epoch });
        }
    }
}
