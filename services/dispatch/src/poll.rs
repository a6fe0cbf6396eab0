//! Questions for work: answered once each, parked, granted, hedged, dismissed.

use crate::ask::Ask;
use crate::blame::find_doubt;
use crate::effect::Effect;
use crate::event::{Epoch, Job, Millis, Run, Worker};
use crate::grants::hold;
use crate::job_record::Phase;
use crate::leases::{Lease, Stage};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::parked_polls::{Asker, ParkedPolls, Ticket};
use crate::state::PoolState;
use crate::worker_table::{WorkerState, WorkerTable};
use crate::workers::drain;

/// Attempts looked at for one that takes long.
const MAX_SLOW: usize = 8;

pub(crate) fn answer_poll(
    pool: &mut PoolState,
    now: Millis,
    worker: Worker,
    seq: u64,
    (free, park): (bool, bool),
    out: &mut Vec<Effect>,
) {
    let Some(state) = pool.worker_table.get_mut(&worker) else {
        return;
    };
    #[cfg(test)]
    if pool.mutant == Some(Mutant::PollMintsTwice) {
        state.granted = None;
        state.last_seq = seq.saturating_sub(1);
    }
    if seq < state.last_seq {
        out.push(Effect::Idle { worker, seq });
        return;
    }
    if seq == state.last_seq {
        return repeat(pool, now, worker, seq, out);
    }
    (state.last_seq, state.granted) = (seq, None);
    if let Some(ticket) = state.parked.take() {
        pool.parked.take(ticket);
    }
    pool.worker_table.back(now, worker, pool.timing.patience());
    if let Some(cause) = find_doubt(pool, now, worker) {
        drain(pool, worker, cause, out);
    }
    let Some(state) = pool.worker_table.get_mut(&worker) else {
        return;
    };
    if state.drained {
        out.push(Effect::Dismiss { worker, seq });
        return;
    }
    if !free {
        out.push(Effect::Idle { worker, seq });
        return;
    }
    let until = now + pool.timing.park;
    state.parked = Some(pool.parked.add(state.skills, Asker { worker, seq, until }));
    grant(pool, now, out);
    let Some(state) = pool.worker_table.get_mut(&worker).filter(|state| state.parked.is_some())
    else {
        return;
    };
    if park {
        out.push(Effect::Park { worker, seq });
    } else {
        if let Some(ticket) = state.parked.take() {
            pool.parked.take(ticket);
        }
        out.push(Effect::Idle { worker, seq });
    }
}

/// Answers a poll that was asked before as it was answered then.
pub(crate) fn repeat(
    pool: &mut PoolState,
    now: Millis,
    worker: Worker,
    seq: u64,
    out: &mut Vec<Effect>,
) {
    let Some(state) = pool.worker_table.get(&worker) else {
        return;
    };
    let held = state.granted.and_then(|(job, epoch)| {
        let leases = &pool.jobs.get(&job)?.leases;
        let lease = leases.iter().find(|lease| lease.epoch == epoch)?;
        Some((job, lease.run, epoch, lease.hard.saturating_sub(now)))
    });
    out.push(if let Some((job, run, epoch, hard)) = held {
        let lease = pool.timing.lease;
        Effect::Grant { worker, seq, job, run, epoch, lease, hard }
    } else if state.parked.is_some() {
        Effect::Park { worker, seq }
    } else if state.drained {
        Effect::Dismiss { worker, seq }
    } else {
        Effect::Idle { worker, seq }
    });
}

/// Gives the jobs whose turn it is to the workers that have waited longest, or made what a job
/// starts from.
pub(crate) fn grant(pool: &mut PoolState, now: Millis, out: &mut Vec<Effect>) {
    let age = pool.timing.age;
    #[cfg(test)]
    let age = if pool.is(Mutant::NoAgeing) { Millis::MAX } else { age };
    while !pool.parked.is_empty() {
        let (parked, worker_table, avoids_killers) =
            (&pool.parked, &pool.worker_table, pool.avoids_killers());
        #[cfg(test)]
        let will = pool.mutant == Some(Mutant::AnybodyWill);
        #[cfg(not(test))]
        let will = false;
        let can = |ask: &Ask| {
            let fit = || {
                let anybody = ask.killers.is_empty() && !worker_table.has_doubts();
                anybody || asker(parked, worker_table, ask, avoids_killers).is_some()
            };
            will || parked.can(ask.need) && fit()
        };
        let Some((run, job)) = pool.shares.pick(now, age, can) else {
            return;
        };
        let Some(ticket) = asker_for(pool, job) else {
            return;
        };
        lend(pool, now, ticket, run, job, out);
    }
}

/// Whom this job goes to, of those that wait: who found the result that it starts from, if that one
/// waits and may have it.
pub(crate) fn asker_for(pool: &PoolState, job: Job) -> Option<Ticket> {
    #[cfg(test)]
    if pool.is(Mutant::AnybodyWill) {
        return pool.parked.overdue(Millis::MAX);
    }
    let record = pool.jobs.get(&job)?;
    let maker = record.maker.and_then(|maker| maker_asking(&pool.worker_table, maker, &record.ask));
    #[cfg(test)]
    let maker = maker.filter(|_| !pool.is(Mutant::MakerPassedOver));
    #[cfg(test)]
    if pool.is(Mutant::MakerAwaited) && record.maker.is_some() {
        return maker;
    }
    maker.or_else(|| asker(&pool.parked, &pool.worker_table, &record.ask, pool.avoids_killers()))
}

/// The question of the worker that found what a job starts from, if it waits and the worker may
/// have the job.
fn maker_asking(worker_table: &WorkerTable, maker: Worker, ask: &Ask) -> Option<Ticket> {
    let sound = |state: &&WorkerState| !state.drained && !worker_table.doubts(state.name);
    let state = worker_table.get(&maker).filter(sound)?;
    state.parked.filter(|_| state.skills.meet(ask.need) && !ask.killers.contains(&state.name))
}

/// Answers a parked worker's poll with a job.
pub(crate) fn lend(
    pool: &mut PoolState,
    now: Millis,
    ticket: Ticket,
    run: Run,
    job: Job,
    out: &mut Vec<Effect>,
) {
    let Some(Asker { worker, seq, .. }) = pool.parked.take(ticket) else {
        return;
    };
    pool.next_epoch += 1;
    let epoch = Epoch(pool.next_epoch);
    if let Some(state) = pool.worker_table.get_mut(&worker) {
        state.parked = None;
        state.granted = Some((job, epoch));
    }
    let resent = pool.jobs.get_mut(&job).is_some_and(|record| {
        record.attempts += 1;
        record.last = Some(worker);
        record.attempts > 1
    });
    let fresh = pool.jobs.get(&job).is_some_and(|record| record.leases.is_empty());
    let charged = pool.shares.charge(now, run, fresh);
    pool.counts.resent += u64::from(resent);
    if let Some(account) = pool.shares.get_mut(run) {
        account.counts.resent += u64::from(resent);
    }
    let (expires, hard) = (now + pool.timing.lease, now + pool.timing.hard);
    let (granted, suspect, stage, slow) = (now, false, Stage::Granted, false);
    let lease = Lease { worker, epoch, granted, expires, hard, suspect, stage, slow, run, charged };
    hold(pool, now, job, lease);
    let (lease, hard) = (pool.timing.lease, pool.timing.hard);
    out.push(Effect::Grant { worker, seq, job, run, epoch, lease, hard });
}

/// Gives a second worker a job that takes much longer than its run's jobs do, while workers
/// have nothing else to do. The first result counts.
pub(crate) fn hedge(pool: &mut PoolState, now: Millis, out: &mut Vec<Effect>) {
    grant(pool, now, out);
    if pool.parked.is_empty() {
        return;
    }
    for (granted, job) in pool.jobs.slowest(MAX_SLOW) {
        let Some(record) = pool.jobs.get(&job).filter(|r| r.phase == Phase::Held) else {
            continue;
        };
        let Some(lease) = record.leases.first().copied() else {
            continue;
        };
        let spent = record.attempts >= pool.timing.max_attempts || record.crashes > 0;
        let usual = pool.shares.median(lease.run);
        let long = usual.is_some_and(|usual| {
            now - granted > (usual * pool.timing.hedge_factor).max(pool.timing.lease)
        });
        // Another build may find other bits: then which came first would show.
        let build = pool.build_of(lease.worker);
        // One name is one machine, and one that is slow or lies is so in all of its processes.
        let name = pool.worker_table.name(lease.worker);
        #[cfg(test)]
        let name = name.filter(|_| !pool.is(Mutant::HedgedAtHome));
        let other = |worker| {
            worker != lease.worker
                && pool.worker_table.name(worker) != name
                && pool.build_of(worker) == build
                && !doubted(&pool.worker_table, worker)
        };
        let Some(ticket) = pool.parked.first(record.ask.need, other) else {
            continue;
        };
        if long && !spent {
            pool.counts.hedged += 1;
            lend(pool, now, ticket, lease.run, job, out);
        }
    }
}

fn died_under(ask: &Ask, worker_table: &WorkerTable, worker: Worker) -> bool {
    worker_table.name(worker).is_some_and(|name| ask.killers.contains(&name))
}

fn doubted(worker_table: &WorkerTable, worker: Worker) -> bool {
    worker_table.name(worker).is_some_and(|name| worker_table.doubts(name))
}

/// The worker that has waited longest, of those under whom the job has not died and whose name is
/// not doubted. One of a doubted name gets it only if there is nobody else, not even a busy one:
/// else the job waits for that one. One under whom it has died gets it only after those.
fn asker(
    parked: &ParkedPolls,
    worker_table: &WorkerTable,
    ask: &Ask,
    avoids_killers: bool,
) -> Option<Ticket> {
    if ask.killers.is_empty() && !worker_table.has_doubts() {
        return parked.first(ask.need, |_| true);
    }
    let clean = |worker: &Worker| !died_under(ask, worker_table, *worker);
    let sound = |worker: &Worker| clean(worker) && !doubted(worker_table, *worker);
    let found = parked.first(ask.need, |worker| sound(&worker));
    if found.is_some() || avoids_killers && worker_table.sound_others(ask) {
        return found;
    }
    let found = parked.first(ask.need, |worker| clean(&worker));
    if found.is_some() || avoids_killers && worker_table.others(ask) {
        return found;
    }
    parked.first(ask.need, |_| true)
}
