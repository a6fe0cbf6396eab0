//! The ends of openings: in the order of their run, once.

use crate::effect::{Effect, Verdict};
#[cfg(test)]
use crate::ending::end_job;
use crate::event::{Job, Millis, Run};
use crate::grants::release;
use crate::job_record::{JobRecord, Phase};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;
use crate::takeover::inherit_again;

/// No run has the job open any more.
pub(crate) fn withdraw(pool: &mut PoolState, now: Millis, job: Job, out: &mut Vec<Effect>) {
    let inherited = inherit_again(pool, now, job);
    release(pool, now, job, Verdict::Cancelled, out);
    if let Some(record) = pool.jobs.remove(&job) {
        pool.counts.stands(record.phase, -1);
    }
    if !inherited {
        pool.inherited.drop_claims(job);
        pool.past.remember(job, Verdict::Cancelled);
    }
}

/// Settles the openings of a run that are over, up to the first that is not.
pub(crate) fn settle_run(pool: &mut PoolState, run: Run, out: &mut Vec<Effect>) {
    #[cfg(test)]
    settle_as_they_come(pool, run);
    while let Some(&job) = pool.shares.get(run).and_then(|account| account.openings.front()) {
        let Some(Phase::Over(verdict)) = pool.jobs.get(&job).map(|record| record.phase) else {
            return;
        };
        settle_first(pool, run, job, verdict, out);
    }
}

/// Every opening of the run settles now, in order: those that are over as they are.
pub(crate) fn cancel_run(pool: &mut PoolState, now: Millis, run: Run, out: &mut Vec<Effect>) {
    while let Some(&job) = pool.shares.get(run).and_then(|account| account.openings.front()) {
        let verdict = match pool.jobs.get(&job).map(|record| record.phase) {
            Some(Phase::Over(verdict)) => verdict,
            Some(Phase::Waiting(_) | Phase::Ready | Phase::Held) | None => Verdict::Cancelled,
        };
        settle_first(pool, run, job, verdict, out);
        #[cfg(test)]
        if pool.is(Mutant::CancelSpreads) {
            end_job(pool, now, job, Verdict::Cancelled, out);
        }
        if pool.jobs.get(&job).is_some_and(|record| record.wants.is_empty()) {
            withdraw(pool, now, job, out);
        }
    }
}

/// The run's first opening settles.
pub(crate) fn settle_first(
    pool: &mut PoolState,
    run: Run,
    job: Job,
    verdict: Verdict,
    out: &mut Vec<Effect>,
) {
    let Some(account) = pool.shares.get_mut(run) else {
        return;
    };
    account.openings.pop_front();
    let opening = account.counts.settled;
    account.counts.settle(verdict);
    pool.counts.settle(verdict);
    let attempts = pool.jobs.get(&job).map_or(0, |record| record.attempts);
    out.push(Effect::Settle { run, opening, job, verdict, attempts });
    stop_wanting(pool, run, job);
    let spent = |r: &JobRecord| r.wants.is_empty() && matches!(r.phase, Phase::Over(_));
    if pool.jobs.get(&job).is_some_and(spent) {
        pool.jobs.remove(&job);
        pool.past.remember(job, verdict);
    }
}

/// The run wants the job once less.
pub(crate) fn stop_wanting(pool: &mut PoolState, run: Run, job: Job) {
    let Some(record) = pool.jobs.get_mut(&job) else {
        return;
    };
    let Some(at) = record.wants.iter().position(|want| want.run == run) else {
        return;
    };
    record.wants[at].count -= 1;
    if record.wants[at].count > 0 {
        return;
    }
    let last = record.wants.len() - 1;
    record.wants.swap(at, last);
    let (phase, opening) = (record.phase, record.wants[last].opening);
    pool.count_want(job, -1);
    if let Some(record) = pool.jobs.get_mut(&job) {
        if phase == Phase::Ready {
            pool.shares.unready(run, &record.ask, opening);
        }
        record.wants.pop();
    }
}

#[cfg(test)]
pub(crate) fn settle_as_they_come(pool: &mut PoolState, run: Run) {
    if !pool.is(Mutant::SettleAsTheyCome) {
        return;
    }
    let jobs = &pool.jobs;
    let open = |job: &Job| !matches!(jobs.get(job).map(|r| r.phase), Some(Phase::Over(_)));
    if let Some(account) = pool.shares.get_mut(run) {
        account.openings.make_contiguous().sort_by_key(open);
    }
}
