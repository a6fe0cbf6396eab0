//! Jobs that were being solved when an earlier life of the coordinator ended.

use crate::effect::{Effect, Receipt, Verdict};
use crate::event::{Claimant, Epoch, Event, Job, Millis, Worker};
use crate::grants::{give_back, hold};
use crate::inherited::LeaseRenewal;
use crate::job_record::{JobRecord, Phase};
use crate::leases::{Lease, Stage};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;
use crate::worker_table::WorkerState;
use crate::workers::register;
use std::collections::BTreeSet;

/// Whether this job was at work when the coordinator ended, and no run has it open.
pub(crate) fn is_inherited(pool: &PoolState, job: Job) -> bool {
    pool.inherited.contains(job)
}

/// The runs that will want what was at work when the coordinator ended, each once.
pub(crate) fn claimants(pool: &PoolState) -> BTreeSet<Claimant> {
    pool.inherited.claimants()
}

/// Whether a result of this job by this grant is one of an inherited job.
pub(crate) fn is_inherited_by(pool: &PoolState, job: Job, epoch: Epoch) -> bool {
    #[cfg(test)]
    if pool.is(Mutant::InheritedUnknown) {
        return false;
    }
    is_inherited(pool, job) && earlier(pool, epoch)
}

/// Whether a grant is of an earlier life.
pub(crate) fn earlier(pool: &PoolState, epoch: Epoch) -> bool {
    epoch.0 >> 32 < pool.next_epoch >> 32
}

/// What an earlier life has left, or that a job of it is pardoned.
pub(crate) fn learn_past(pool: &mut PoolState, now: Millis, event: Event) {
    match event {
        #[cfg(test)]
        Event::Bar(_) if pool.is(Mutant::DrainForgotten) => {}
        Event::Bar(worker) => pool.worker_table.bar(worker),
        Event::Inherit(job, claimant) if pool.jobs.get(&job).is_none() => {
            pool.inherited.inherit(job, claimant, now + pool.timing.lease);
        }
        #[cfg(test)]
        Event::Isolate(_) if pool.is(Mutant::QuarantineForgotten) => {}
        Event::Isolate(job) => drop(pool.quarantine.put(job, 1)),
        Event::Pardon(job) => pool.quarantine.remove(job),
        _ => {}
    }
}

/// A run of an earlier life is over. Who is at what only it wanted is told so, now if it has
/// been heard, with its next renewal if not.
pub(crate) fn release_claims(pool: &mut PoolState, claimant: Claimant, out: &mut Vec<Effect>) {
    #[cfg(test)]
    if pool.is(Mutant::InheritedKept) {
        return;
    }
    for (job, renewal) in pool.inherited.release(claimant) {
        if let Some(LeaseRenewal { worker, epoch, .. }) = renewal {
            out.push(Effect::Cancel { worker, job, epoch });
        }
        pool.past.remember(job, Verdict::Cancelled);
    }
}

/// The last run that had a job open wants it no more. Where a claimant may yet, and its worker
/// has it from an earlier life or is still waited for, it is inherited again. Whether it is.
pub(crate) fn inherit_again(pool: &mut PoolState, now: Millis, job: Job) -> bool {
    #[cfg(test)]
    if pool.is(Mutant::ClaimantPassedOver) {
        return false;
    }
    let Some(record) = pool.jobs.get(&job).filter(|_| pool.inherited.is_claimed(job)) else {
        return false;
    };
    let lease = match record.phase {
        Phase::Waiting(_) | Phase::Ready if record.attempts == 0 => {
            let until = if let Phase::Waiting(until) = record.phase { until } else { now };
            pool.inherited.put(job, until, None);
            return true;
        }
        Phase::Held => record.leases.only().copied(),
        Phase::Waiting(_) | Phase::Ready | Phase::Over(_) => None,
    };
    let Some(lease) = lease.filter(|lease| earlier(pool, lease.epoch)) else {
        return false;
    };
    let Lease { worker, epoch, expires, stage, .. } = lease;
    let at = expires.saturating_sub(pool.timing.lease);
    let renewal = pool.worker_table.get(&worker).map(|state| {
        let begun = stage >= Stage::Begun;
        let (build, skills, name) = (state.build, state.skills, state.name);
        LeaseRenewal { worker, build, skills, name, epoch, begun, at }
    });
    give_back(pool, now, job, &lease);
    pool.inherited.put(job, expires, renewal);
    true
}

/// What a job that is opened waits for first.
pub(crate) fn awaited(pool: &PoolState, now: Millis, job: Job) -> Phase {
    #[cfg(test)]
    if pool.is(Mutant::InheritedUnawaited) {
        return Phase::Ready;
    }
    pool.inherited.until(job).filter(|until| *until > now).map_or(Phase::Ready, Phase::Waiting)
}

/// A run has opened the job: who was heard to be at it goes on.
pub(crate) fn adopt(pool: &mut PoolState, now: Millis, job: Job, out: &mut Vec<Effect>) {
    let heard = pool.inherited.open(job);
    if let Some(renewal) = heard.filter(|heard| heard.at + pool.timing.lease > now) {
        resume(pool, now, job, renewal, out);
    }
}

/// Remembers a renewal of a job that no run has opened yet; whether it is an inherited one. Where
/// two are at it, or one only says so, the first that was heard stays the one that is waited for.
pub(crate) fn renew_inherited(pool: &mut PoolState, job: Job, renewal: LeaseRenewal) -> bool {
    let inherited = is_inherited_by(pool, job, renewal.epoch);
    if inherited {
        pool.inherited.renew(job, renewal, pool.timing.lease);
    }
    inherited
}

/// A result of a job that no run has opened yet counts for whoever opens it.
pub(crate) fn complete_unclaimed(pool: &mut PoolState, job: Job, done: Verdict) -> Receipt {
    pool.inherited.forget(job);
    pool.past.remember(job, done);
    Receipt::Accepted
}

/// Gives a job that nobody has been granted in this life back to who has it from an earlier
/// one; whether it does. After that a late copy of a renewal takes nothing up.
pub(crate) fn resume(
    pool: &mut PoolState,
    now: Millis,
    job: Job,
    renewal: LeaseRenewal,
    out: &mut Vec<Effect>,
) -> bool {
    #[cfg(test)]
    if pool.is(Mutant::InheritedSuperseded) {
        return false;
    }
    let LeaseRenewal { worker, build, skills, name, epoch, begun, at } = renewal;
    // Who asks for work, or has some, is not at this any more.
    let at_else = |state: &WorkerState| state.parked.is_some() || !state.held.is_empty();
    if !earlier(pool, epoch) || pool.worker_table.get(&worker).is_some_and(at_else) {
        return false;
    }
    let Some(record) = pool.jobs.get_mut(&job).filter(|_| pool.past.get(&job).is_none()) else {
        return false;
    };
    let waits = matches!(record.phase, Phase::Waiting(_) | Phase::Ready);
    let free = waits && record.attempts == 0 && skills.meet(record.ask.need);
    let Some(run) = record.wants.first().map(|want| want.run).filter(|_| free) else {
        return false;
    };
    record.attempts += 1;
    record.last = Some(worker);
    register(pool, now, worker, (build, skills, name), out);
    pool.worker_table.back(now, worker, pool.timing.patience());
    let charged = pool.shares.charge(now, run, false);
    let (expires, hard) = (at + pool.timing.lease, now + pool.timing.hard);
    let stage = if begun { Stage::Begun } else { Stage::Granted };
    let (granted, suspect, slow) = (now, false, false);
    let lease = Lease { worker, epoch, granted, expires, hard, suspect, stage, slow, run, charged };
    hold(pool, now, job, lease);
    pool.counts.adopted += 1;
    out.push(Effect::Adopted { worker, job, run, epoch });
    true
}

/// Who was at an inherited job gives it back, or leaves: nothing is left to wait for, unless
/// another is heard to be at it.
pub(crate) fn give_up(
    pool: &mut PoolState,
    now: Millis,
    (worker, job, epoch): (Worker, Job, Epoch),
) {
    let held = pool.jobs.get(&job).is_some_and(|record| !record.leases.is_empty());
    let elsewhere = held || pool.inherited.is_anothers((now, pool.timing.lease), job, worker);
    if !earlier(pool, epoch) || elsewhere {
        return;
    }
    pool.inherited.forget(job);
    let awaited = |r: &JobRecord| r.attempts == 0 && matches!(r.phase, Phase::Waiting(_));
    if pool.jobs.get(&job).is_some_and(awaited) {
        pool.set_phase(now, job, Phase::Ready);
    }
}
