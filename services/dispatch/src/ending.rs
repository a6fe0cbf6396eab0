//! How a job ends: by a result, by giving it up, once.

use crate::blame::blame;
use crate::effect::{Effect, Reason, Receipt, Verdict};
use crate::event::{Job, Millis, WorkerName};
use crate::grants::release;
use crate::job_record::Phase;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::state::PoolState;

/// `foreign`: late, and of another build than the one that has or had the job.
pub(crate) fn commit(
    pool: &mut PoolState,
    now: Millis,
    (name, job): (WorkerName, Job),
    (done, foreign): (Verdict, bool),
    kept: Option<Verdict>,
    out: &mut Vec<Effect>,
) -> Receipt {
    let over = match pool.jobs.get(&job).map(|r| r.phase) {
        Some(Phase::Over(verdict)) => Some(verdict),
        Some(Phase::Waiting(_) | Phase::Ready | Phase::Held) => None,
        None => match pool.past.get(&job).or(kept) {
            Some(verdict) => Some(verdict),
            None => return Receipt::Unknown,
        },
    };
    #[cfg(test)]
    let over = over.filter(|_| !pool.is(Mutant::NoDedupe));
    let Some(over) = over else {
        if foreign {
            pool.counts.fenced += 1;
            return Receipt::Fenced;
        }
        blame(pool, now, name, job, out);
        end_job(pool, now, job, done, out);
        return Receipt::Accepted;
    };
    let (Verdict::Done { digest: kept, build: by, .. }, Verdict::Done { digest, build, .. }) =
        (over, done)
    else {
        return Receipt::TooLate;
    };
    if kept == digest {
        Receipt::Duplicate
    } else if by != build {
        pool.counts.fenced += 1;
        Receipt::Fenced
    } else {
        pool.counts.alarms += 1;
        out.push(Effect::Alarm { job, kept, other: digest });
        Receipt::Conflict
    }
}

/// Gives a job up: its runs hear of it, and only they.
pub(crate) fn abandon(
    pool: &mut PoolState,
    now: Millis,
    job: Job,
    reason: Reason,
    out: &mut Vec<Effect>,
) {
    let Some(record) = pool.jobs.get(&job) else {
        return;
    };
    if let Phase::Over(_) = record.phase {
        return;
    }
    let (attempts, crashes) = (record.attempts, record.crashes);
    if let Reason::Crashes { .. } = reason
        && !pool.quarantine.touch(job)
    {
        pool.quarantine.put(job, 1);
        out.push(Effect::Quarantine { job, crashes });
    }
    out.push(Effect::Stall { job, reason, attempts });
    end_job(pool, now, job, Verdict::Abandoned(reason), out);
}

/// The first end counts; terminal is final.
pub(crate) fn end_job(
    pool: &mut PoolState,
    now: Millis,
    job: Job,
    verdict: Verdict,
    out: &mut Vec<Effect>,
) {
    let Some(record) = pool.jobs.get(&job) else {
        return;
    };
    if let Phase::Over(_) = record.phase {
        return;
    }
    pool.inherited.drop_claims(job);
    release(pool, now, job, verdict, out);
    pool.set_phase(now, job, Phase::Over(verdict));
}
