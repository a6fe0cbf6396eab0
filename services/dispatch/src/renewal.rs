//! Leases renewed by their workers.

use crate::effect::{Effect, StopReason};
use crate::event::{Epoch, Job};
use crate::grants::hold;
use crate::inherited::LeaseRenewal;
use crate::job_record::Phase;
use crate::leases::{Lease, Stage};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;
use crate::takeover::{renew_inherited, resume};

pub(crate) fn renew(pool: &mut PoolState, job: Job, renewal: LeaseRenewal, out: &mut Vec<Effect>) {
    let (worker, lease) = (renewal.worker, pool.timing.lease);
    match prolong(pool, job, renewal, out) {
        Ok(()) => {
            out.push(Effect::Renewed { worker, job, lease });
            if renewal.begun {
                advance_stage(pool, job, renewal.epoch, Stage::Begun);
            }
        }
        Err(reason) => out.push(Effect::Stop { worker, job, reason }),
    }
}

/// An attempt is that far; what comes late takes nothing back.
pub(crate) fn advance_stage(pool: &mut PoolState, job: Job, epoch: Epoch, stage: Stage) {
    if let Some(lease) = pool.jobs.get_mut(&job).and_then(|record| record.leases.find(epoch)) {
        lease.stage = lease.stage.max(stage);
    }
}

pub(crate) fn prolong(
    pool: &mut PoolState,
    job: Job,
    renewal: LeaseRenewal,
    out: &mut Vec<Effect>,
) -> Result<(), StopReason> {
    let (now, epoch) = (renewal.at, renewal.epoch);
    let expires = now + pool.timing.lease;
    let Some(record) = pool.jobs.get_mut(&job) else {
        if renew_inherited(pool, job, renewal) {
            return Ok(());
        }
        let known = pool.past.get(&job).is_some();
        return Err(if known { StopReason::Over } else { StopReason::Unknown });
    };
    if let Phase::Over(_) = record.phase {
        #[cfg(test)]
        if pool.mutant == Some(Mutant::DeafToStop) {
            return Ok(());
        }
        return Err(StopReason::Over);
    }
    if let Some(held) = record.leases.find_own(renewal.worker, epoch) {
        (held.expires, held.suspect) = (expires, false);
        pool.jobs.set_timer(job, pool.timing.lease);
        return Ok(());
    }
    let back = record
        .lapsed
        .as_deref()
        .copied()
        .filter(|last| (last.worker, last.epoch) == (renewal.worker, epoch))
        .filter(|_| record.phase != Phase::Held);
    let Some(back) = back else {
        let gone_on = resume(pool, now, job, renewal, out);
        return if gone_on { Ok(()) } else { Err(StopReason::Superseded) };
    };
    record.lapsed = None;
    pool.worker_table.back(now, back.worker, pool.timing.patience());
    let charged = pool.shares.charge(now, back.run, false);
    hold(pool, now, job, Lease { expires, suspect: false, slow: false, charged, ..back });
    Ok(())
}
