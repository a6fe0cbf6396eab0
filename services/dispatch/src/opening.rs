//! Openings: a run wants a job.

use crate::ask::Ask;
use crate::effect::{Effect, Reason};
use crate::ending::{abandon, end_job};
use crate::event::{Job, Millis, Prior, Run, Skills};
use crate::job_record::{JobRecord, Phase, Want};
use crate::leases::Leases;
use crate::state::PoolState;
use crate::takeover::awaited;

pub(crate) fn open(
    pool: &mut PoolState,
    now: Millis,
    run: Run,
    (job, need): (Job, Skills),
    out: &mut Vec<Effect>,
) {
    let Some(account) = pool.shares.get_mut(run) else {
        return;
    };
    let opening = account.counts.opened;
    account.counts.opened += 1;
    account.openings.push_back(job);
    pool.counts.opened += 1;
    let want = Want { run, opening, count: 1 };
    let Some(record) = pool.jobs.get_mut(&job) else {
        return admit(pool, now, (job, need), want, out);
    };
    match record.wants.iter_mut().find(|want| want.run == run) {
        Some(want) => want.count += 1,
        None => {
            record.wants.push(want);
            pool.count_want(job, 1);
            if let Some(record) = pool.jobs.get(&job)
                && record.phase == Phase::Ready
            {
                pool.shares.ready(now, run, &record.ask, (opening, job));
            }
        }
    }
    pool.dirty.push(run);
}

/// The job starts from the result of another: whoever found that has it already. Of a job that is
/// open, the first known maker stays.
pub(crate) fn prefer_maker(pool: &mut PoolState, job: Job, after: Option<Job>) {
    let maker = after.and_then(|after| pool.maker_of(after));
    if let Some(record) = pool.jobs.get_mut(&job) {
        record.maker = record.maker.or(maker);
    }
}

/// Acts on what is known of a job before anybody is asked.
pub(crate) fn apply_prior(
    pool: &mut PoolState,
    now: Millis,
    job: Job,
    prior: Prior,
    out: &mut Vec<Effect>,
) {
    match pool.kept(prior) {
        Some(done) => end_job(pool, now, job, done, out),
        None if prior == Prior::Unfit => abandon(pool, now, job, Reason::Invalid, out),
        None => {}
    }
}

pub(crate) fn admit(
    pool: &mut PoolState,
    now: Millis,
    (job, need): (Job, Skills),
    want: Want,
    out: &mut Vec<Effect>,
) {
    let record = JobRecord {
        wants: vec![want],
        ask: Ask::of(need),
        phase: Phase::Waiting(now),
        leases: Leases::default(),
        lapsed: None,
        maker: None,
        last: None,
        attempts: 0,
        crashes: 0,
        timer: None,
    };
    pool.jobs.insert(job, record);
    pool.counts.waiting += 1;
    pool.count_want(job, 1);
    pool.set_phase(now, job, awaited(pool, now, job));
    if pool.quarantine.touch(job) {
        abandon(pool, now, job, Reason::Crashes { deaths: 0, workers: 0 }, out);
    }
}
