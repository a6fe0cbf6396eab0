//! The state machine: events in, effects out. What each event does is in a file of its own.

use crate::counts::Counts;
use crate::effect::{Bound, Cause, Effect, Loss, Reason, Receipt, Verdict};
use crate::ending::{abandon, commit};
use crate::event::{Build, Claimant, Epoch, Event, Job, Millis, Run, Skills};
use crate::inherited::LeaseRenewal;
use crate::leases::Stage;
use crate::loss::{expire_leases, fail_attempt, lose_worker, watch_cancel};
#[cfg(test)]
use crate::mutant::Mutant;
use crate::opening::{apply_prior, open, prefer_maker};
use crate::poll::{answer_poll, grant, hedge};
use crate::renewal::{advance_stage, renew};
use crate::settle::{cancel_run, settle_run};
use crate::state::PoolState;
use crate::takeover::{
    adopt, claimants, complete_unclaimed, earlier, is_inherited, is_inherited_by, learn_past,
    release_claims,
};
use crate::timing::Timing;
use crate::workers::{close_worker, drain, register, suspect, unheard};
use std::collections::BTreeSet;

/// The pool.
#[derive(Debug)]
pub struct Dispatch {
    pub(crate) state: PoolState,
}

impl Dispatch {
    /// An empty pool. `incarnation` grows with each life of one coordinator, and whoever keeps it
    /// has it on disk before the first grant: then no grant number of an earlier life comes again.
    #[must_use]
    pub fn new(timing: Timing, incarnation: u32) -> Self {
        Self { state: PoolState::new(timing, incarnation) }
    }

    /// How many of each there are now.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.state.counts()
    }

    /// The same of one run; nothing if there is no such run.
    #[must_use]
    pub fn counts_of(&self, run: Run) -> Option<Counts> {
        self.state.counts_of(run)
    }

    /// What jobs wait for, and how many, that no worker here can give.
    pub fn unschedulable(&self) -> impl Iterator<Item = (Skills, u64)> {
        self.state.unschedulable()
    }

    /// Whether this job is open and its verdict still out.
    #[must_use]
    pub fn wants(&self, job: Job) -> bool {
        self.state.wants(job)
    }

    /// Whether a result by this grant and build would count: the job is open, and the grant stands
    /// or nobody else's build has followed; or no run has opened it yet, and it was at work when
    /// the coordinator ended.
    #[must_use]
    pub fn takes(&self, job: Job, epoch: Epoch, build: Build) -> bool {
        let pool = &self.state;
        is_inherited_by(pool, job, epoch) || pool.wants(job) && !pool.is_foreign(job, epoch, build)
    }

    /// Whether anything is remembered of this job: it is open, or was not long ago.
    #[must_use]
    pub fn knows(&self, job: Job) -> bool {
        self.state.knows(job)
    }

    /// Whether a run may open one more, or which bound is reached.
    ///
    /// # Errors
    /// The bound.
    pub fn room(&self, run: Run) -> Result<(), Bound> {
        self.state.room(run)
    }

    /// Whether this job was at work when the coordinator ended, and no run has it open.
    #[must_use]
    pub fn is_inherited(&self, job: Job) -> bool {
        is_inherited(&self.state, job)
    }

    /// The runs that will want what was at work when the coordinator ended, each once.
    #[must_use]
    pub fn claimants(&self) -> BTreeSet<Claimant> {
        claimants(&self.state)
    }

    /// Whether a grant is of an earlier life.
    #[must_use]
    pub fn earlier(&self, epoch: Epoch) -> bool {
        earlier(&self.state, epoch)
    }

    /// Takes in one event at `now` \[ms\] and says what to do about it.
    pub fn step(&mut self, now: Millis, event: Event) -> Vec<Effect> {
        let pool = &mut self.state;
        let mut out = Vec::new();
        match event {
            Event::Begin { run, share } => pool.shares.begin(now, run, share),
            Event::Open { run, job, need, after, prior } => match pool.room(run) {
                Ok(()) => {
                    open(pool, now, run, (job, need), &mut out);
                    prefer_maker(pool, job, after);
                    apply_prior(pool, now, job, prior, &mut out);
                    adopt(pool, now, job, &mut out);
                }
                Err(bound) => out.push(Effect::Busy { run, job, bound }),
            },
            #[cfg(test)]
            Event::Pause(_) if pool.is(Mutant::PauseIgnored) => {}
            Event::Pause(run) => pool.shares.pause(now, run, true),
            Event::Resume(run) => pool.shares.pause(now, run, false),
            Event::Poll { worker, seq, slots, park, build, skills, name } => {
                register(pool, now, worker, (build, skills, name), &mut out);
                answer_poll(pool, now, worker, seq, (slots > 0, park), &mut out);
            }
            Event::Renew { worker, job, epoch, begun, build, skills, name } => {
                let renewal = LeaseRenewal { worker, build, skills, name, epoch, begun, at: now };
                renew(pool, job, renewal, &mut out);
            }
            Event::WatchCancel { worker, job, epoch } => {
                watch_cancel(pool, (worker, job, epoch), &mut out);
            }
            Event::Offer { job, epoch } => advance_stage(pool, job, epoch, Stage::Offered),
            Event::Commit { .. } => take_result(pool, now, event, &mut out),
            Event::Fail { worker, job, epoch, trouble } => {
                fail_attempt(pool, now, (worker, job, epoch), trouble, &mut out);
            }
            Event::Suspect(worker) => suspect(pool, now, worker),
            Event::Down(worker) => lose_worker(pool, now, worker, Loss::Down, &mut out),
            Event::Bye(worker) => {
                lose_worker(pool, now, worker, Loss::Dropped, &mut out);
                out.push(Effect::Taken { worker, receipt: Receipt::Noted });
            }
            Event::Cancel(run) => cancel_run(pool, now, run, &mut out),
            Event::End(run) => {
                cancel_run(pool, now, run, &mut out);
                pool.shares.end(run);
            }
            Event::Drain(worker) => drain(pool, worker, Cause::Asked, &mut out),
            Event::Bar(_) | Event::Inherit(..) | Event::Isolate(_) | Event::Pardon(_) => {
                learn_past(pool, now, event);
            }
            Event::Release(claimant) => release_claims(pool, claimant, &mut out),
            Event::Forsaken => {
                for job in pool.jobs.names() {
                    abandon(pool, now, job, Reason::Forsaken, &mut out);
                }
            }
            Event::Tick => tick(pool, now, &mut out),
        }
        grant(pool, now, &mut out);
        while let Some(run) = pool.dirty.pop() {
            settle_run(pool, run, &mut out);
        }
        out
    }
}

/// A worker hands in a result ([`Event::Commit`]).
fn take_result(pool: &mut PoolState, now: Millis, event: Event, out: &mut Vec<Effect>) {
    let Event::Commit { worker, name, job, epoch, build, digest, outcome, prior } = event else {
        return;
    };
    let foreign = pool.is_foreign(job, epoch, build);
    let done = Verdict::Done { digest, outcome, worker: Some(worker), build: Some(build) };
    let kept = pool.kept(prior);
    let receipt = if kept.is_none() && is_inherited_by(pool, job, epoch) {
        complete_unclaimed(pool, job, done)
    } else {
        commit(pool, now, (name, job), (done, foreign), kept, out)
    };
    out.push(Effect::Taken { worker, receipt });
}

fn tick(pool: &mut PoolState, now: Millis, out: &mut Vec<Effect>) {
    for job in pool.jobs.due(now) {
        expire_leases(pool, now, job, out);
    }
    while let Some(asker) = pool.parked.overdue(now).and_then(|t| pool.parked.take(t)) {
        if let Some(state) = pool.worker_table.get_mut(&asker.worker) {
            state.parked = None;
        }
        out.push(Effect::Idle { worker: asker.worker, seq: asker.seq });
    }
    for worker in unheard(pool, now) {
        close_worker(pool, worker);
    }
    hedge(pool, now, out);
}
