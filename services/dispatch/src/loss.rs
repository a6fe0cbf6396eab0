//! Attempts that fail, leases that run out, workers that leave.

use crate::effect::{Effect, Loss, Reason, Receipt};
use crate::ending::abandon;
use crate::event::{Epoch, Job, Millis, Trouble, Worker};
use crate::grants::drop_lease;
use crate::job_record::{JobRecord, Phase};
use crate::leases::{Lease, Stage};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;
use crate::takeover::give_up;
use crate::workers::{close_worker, held_by};

/// One that has a job wants to hear when nobody wants it any more: perhaps that is so already.
/// Of a grant of an earlier life nothing is known: that is for a renewal to say.
pub(crate) fn watch_cancel(
    pool: &PoolState,
    (worker, job, epoch): (Worker, Job, Epoch),
    out: &mut Vec<Effect>,
) {
    let over = match pool.jobs.get(&job) {
        None => pool.past.get(&job).is_some(),
        Some(record) => match record.phase {
            Phase::Over(_) => true,
            Phase::Held => record.leases.iter().all(|lease| lease.epoch != epoch),
            Phase::Waiting(_) | Phase::Ready => false,
        },
    };
    if over {
        out.push(Effect::Cancel { worker, job, epoch });
    }
}

pub(crate) fn fail_attempt(
    pool: &mut PoolState,
    now: Millis,
    (worker, job, epoch): (Worker, Job, Epoch),
    trouble: Trouble,
    out: &mut Vec<Effect>,
) {
    let own = |lease: &Lease| (lease.worker, lease.epoch) == (worker, epoch);
    let held = |r: &JobRecord| r.leases.iter().any(own);
    if pool.jobs.get(&job).is_some_and(held) {
        match trouble {
            Trouble::Crashed => lose_lease(pool, now, job, epoch, Loss::Crashed, out),
            Trouble::Dropped => lose_lease(pool, now, job, epoch, Loss::Dropped, out),
            Trouble::Invalid => abandon(pool, now, job, Reason::Invalid, out),
        }
    } else {
        give_up(pool, now, (worker, job, epoch));
    }
    out.push(Effect::Taken { worker, receipt: Receipt::Noted });
}

pub(crate) fn lose_worker(
    pool: &mut PoolState,
    now: Millis,
    worker: Worker,
    loss: Loss,
    out: &mut Vec<Effect>,
) {
    close_worker(pool, worker);
    pool.inherited.forget_worker(worker);
    for (job, epoch) in held_by(pool, worker) {
        lose_lease(pool, now, job, epoch, loss, out);
    }
}

/// A job whose time has come: its pause is over, or a lease of it.
pub(crate) fn expire_leases(pool: &mut PoolState, now: Millis, job: Job, out: &mut Vec<Effect>) {
    if let Some(Phase::Waiting(_)) = pool.jobs.get(&job).map(|record| record.phase) {
        return pool.set_phase(now, job, Phase::Ready);
    }
    pool.jobs.note_slow(now, job, pool.timing.lease);
    pool.jobs.set_timer(job, pool.timing.lease);
    #[cfg(test)]
    if pool.is(Mutant::NoExpiry) {
        // The lease stays as it is, and nobody looks any more.
        return pool.jobs.get_mut(&job).into_iter().for_each(|record| record.timer = None);
    }
    let Some(record) = pool.jobs.get(&job) else {
        return;
    };
    let lost = |lease: &Lease| match (lease.hard <= now, lease.expires <= now, lease.suspect) {
        (true, _, _) => Some(Loss::TooLong),
        (false, true, true) => Some(Loss::Down),
        (false, true, false) => Some(Loss::Silent),
        (false, false, _) => None,
    };
    let ended: Vec<_> =
        record.leases.iter().filter_map(|l| lost(l).map(|loss| (l.epoch, loss))).collect();
    for (epoch, loss) in ended {
        lose_lease(pool, now, job, epoch, loss, out);
    }
}

/// A lease is over without a result.
pub(crate) fn lose_lease(
    pool: &mut PoolState,
    now: Millis,
    job: Job,
    epoch: Epoch,
    loss: Loss,
    out: &mut Vec<Effect>,
) {
    let timing = pool.timing;
    let Some(record) = pool.jobs.get_mut(&job) else {
        return;
    };
    let Some(lease) = record.leases.take(|lease| lease.epoch == epoch) else {
        return;
    };
    let worker = lease.worker;
    let name = pool.worker_table.name(worker);
    let charged = match loss {
        Loss::Crashed => true,
        // Nobody says what it died of: of the job only if a solver had the job.
        Loss::Down | Loss::TooLong => lease.stage == Stage::Begun,
        Loss::Dropped | Loss::Silent => false,
    };
    #[cfg(test)]
    let charged = pool.mutant.map_or(charged, |mutant| mutant.charges(charged, loss));
    if let Some(name) = name.filter(|_| charged) {
        record.crashes += 1;
        record.ask.died(name);
        if record.ask.killers == [name] {
            pool.worker_table.died_alone(now, name, job);
        }
    }
    if loss == Loss::Silent {
        record.lapsed = Some(Box::new(lease));
    }
    #[cfg(test)]
    if pool.mutant == Some(Mutant::NoLimit) {
        (record.crashes, record.attempts) = (0, 1);
    }
    let (crashes, attempts) = (record.crashes, record.attempts);
    let killers = record.ask.killers.len();
    let alone = record.leases.is_empty();
    record.leases.iter_mut().for_each(|other| other.slow = false);
    pool.jobs.note_slow(now, job, pool.timing.lease);
    drop_lease(pool, now, job, &lease, false);
    let idle =
        pool.worker_table.get(&worker).is_some_and(|p| p.held.is_empty() && p.parked.is_none());
    if matches!(loss, Loss::Silent | Loss::Down) && idle {
        // Nobody may have noticed its end: one that is not heard of does not count as there.
        close_worker(pool, worker);
    }
    out.push(Effect::Lost { job, worker, epoch, loss, charged });
    let died = Reason::Crashes { deaths: crashes, workers: killers as u32 };
    // Where there is nobody else, no second one can clear it.
    let others = || pool.jobs.get(&job).is_some_and(|r| pool.worker_table.others(&r.ask));
    if crashes >= timing.max_crashes && (killers >= timing.min_killers as usize || !others()) {
        abandon(pool, now, job, died, out);
    } else if !alone {
        pool.jobs.set_timer(job, pool.timing.lease);
    } else if attempts >= timing.max_attempts {
        let enough = crashes >= timing.max_crashes;
        let reason = if enough { died } else { Reason::Attempts };
        abandon(pool, now, job, reason, out);
    } else {
        let doublings = attempts.saturating_sub(1).min(16);
        let pause = (timing.backoff << doublings).min(timing.lease);
        pool.set_phase(now, job, Phase::Waiting(now + pause));
    }
}
