//! The state machine: what it knows, and how jobs open and end.

use crate::ask::Ask;
use crate::counts::Counts;
use crate::effect::{Bound, Cause, Effect, Loss, Reason, Receipt, Verdict};
use crate::event::{Build, Epoch, Event, Job, Millis, Prior, Run, Skills, Worker};
use crate::inherited::{InheritedJobs, LeaseRenewal};
use crate::job_record::{JobRecord, Phase, Want};
use crate::jobs::Jobs;
use crate::leases::{Leases, Stage};
use crate::lru_index::LruIndex;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::parked_polls::ParkedPolls;
use crate::past::PastVerdicts;
use crate::share::Shares;
use crate::timing::Timing;
use crate::worker_table::WorkerTable;

/// Jobs kept in quarantine; beyond it the oldest are let out.
const MAX_QUARANTINE: u64 = 1_024;

/// The pool.
#[derive(Debug)]
pub struct Dispatch {
    pub(crate) timing: Timing,
    pub(crate) jobs: Jobs,
    pub(crate) shares: Shares,
    pub(crate) parked: ParkedPolls,
    pub(crate) worker_table: WorkerTable,
    pub(crate) past: PastVerdicts,
    pub(crate) quarantine: LruIndex,
    pub(crate) inherited: InheritedJobs,
    pub(crate) next_epoch: u64,
    pub(crate) counts: Counts,
    /// Runs whose first opening may be over.
    dirty: Vec<Run>,
    #[cfg(test)]
    pub(crate) mutant: Option<Mutant>,
}

impl Dispatch {
    /// An empty pool. `incarnation` grows with each life of one coordinator, and whoever keeps it
    /// has it on disk before the first grant: then no grant number of an earlier life comes again.
    #[must_use]
    pub fn new(timing: Timing, incarnation: u32) -> Self {
        Self {
            timing,
            jobs: Jobs::default(),
            shares: Shares::default(),
            parked: ParkedPolls::default(),
            worker_table: WorkerTable::default(),
            past: PastVerdicts::default(),
            quarantine: LruIndex::new(MAX_QUARANTINE),
            inherited: InheritedJobs::default(),
            next_epoch: u64::from(incarnation) << 32,
            counts: Counts::default(),
            dirty: Vec::new(),
            #[cfg(test)]
            mutant: None,
        }
    }

    /// How many of each there are now.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let unschedulable = self.unschedulable().map(|(_, jobs)| jobs).sum();
        Counts { quarantined: self.quarantine.held(), unschedulable, ..self.counts }
    }

    /// The same of one run; nothing if there is no such run.
    #[must_use]
    pub fn counts_of(&self, run: Run) -> Option<Counts> {
        self.shares.get(run).map(|account| account.counts)
    }

    /// What jobs wait for, and how many, that no worker here can give.
    pub fn unschedulable(&self) -> impl Iterator<Item = (Skills, u64)> {
        let ready = self.jobs.ready().iter().filter(|_| !self.worker_table.is_empty());
        ready.filter(|(need, _)| !self.worker_table.can(**need)).map(|(need, jobs)| (*need, *jobs))
    }

    /// Whether this job is open and its verdict still out.
    #[must_use]
    pub fn wants(&self, job: Job) -> bool {
        self.jobs.get(&job).is_some_and(|r| !matches!(r.phase, Phase::Over(_)))
    }

    /// Whether a result by this grant and build would count: the job is open, and the grant stands
    /// or nobody else's build has followed; or no run has opened it yet, and it was at work when
    /// the coordinator ended.
    #[must_use]
    pub fn takes(&self, job: Job, epoch: Epoch, build: Build) -> bool {
        self.is_inherited_by(job, epoch) || self.wants(job) && !self.foreign(job, epoch, build)
    }

    /// Whether anything is remembered of this job: it is open, or was not long ago.
    #[must_use]
    pub fn knows(&self, job: Job) -> bool {
        self.jobs.get(&job).is_some() || self.past.get(&job).is_some()
    }

    #[cfg(test)]
    pub(crate) fn is(&self, mutant: Mutant) -> bool {
        self.mutant == Some(mutant)
    }

    fn foreign(&self, job: Job, epoch: Epoch, build: Build) -> bool {
        #[cfg(test)]
        if self.is(Mutant::ForeignTaken) {
            return false;
        }
        let Some(record) = self.jobs.get(&job) else {
            return false;
        };
        let stands = record.leases.iter().any(|lease| lease.epoch == epoch);
        !stands && record.last.is_some_and(|last| self.build_of(last) != Some(build))
    }

    pub(crate) fn build_of(&self, worker: Worker) -> Option<Build> {
        self.worker_table.get(&worker).map(|state| state.build)
    }

    /// Whether a run may open one more, or which bound is reached.
    ///
    /// # Errors
    /// The bound.
    pub fn room(&self, run: Run) -> Result<(), Bound> {
        #[cfg(test)]
        if self.is(Mutant::NoBound) {
            return Ok(());
        }
        match self.shares.get(run) {
            None => Err(Bound::NoRun),
            Some(run) if run.openings.len() as u64 >= self.timing.max_open => Err(Bound::Run),
            Some(_) if self.counts.unsettled() >= self.timing.max_pool => Err(Bound::Pool),
            Some(_) => Ok(()),
        }
    }

    /// Takes in one event at `now` \[ms\] and says what to do about it.
    pub fn step(&mut self, now: Millis, event: Event) -> Vec<Effect> {
        let mut out = Vec::new();
        match event {
            Event::Begin { run, share } => self.shares.begin(now, run, share),
            Event::Open { run, job, need, prior } => match self.room(run) {
                Ok(()) => {
                    self.open(now, run, (job, need), &mut out);
                    self.apply_prior(now, job, prior, &mut out);
                    self.adopt(now, job, &mut out);
                }
                Err(bound) => out.push(Effect::Busy { run, job, bound }),
            },
            #[cfg(test)]
            Event::Pause(_) if self.is(Mutant::PauseIgnored) => {}
            Event::Pause(run) => self.shares.pause(now, run, true),
            Event::Resume(run) => self.shares.pause(now, run, false),
            Event::Poll { worker, seq, slots, park, build, skills } => {
                self.arrive(worker, build, skills, &mut out);
                self.poll(now, worker, seq, (slots > 0, park), &mut out);
            }
            Event::Renew { worker, job, epoch, begun, build, skills } => {
                let renewal = LeaseRenewal { worker, build, skills, epoch, begun, at: now };
                self.renew(job, renewal, &mut out);
            }
            Event::WatchCancel { worker, job, epoch } => {
                self.watch_cancel((worker, job, epoch), &mut out);
            }
            Event::Offer { job, epoch } => self.reach(job, epoch, Stage::Offered),
            Event::Commit { .. } => self.take_result(now, event, &mut out),
            Event::Fail { worker, job, epoch, trouble } => {
                self.fail(now, (worker, job, epoch), trouble, &mut out);
            }
            Event::Suspect(worker) => self.suspect(now, worker),
            Event::Down(worker) => self.leave(now, worker, Loss::Down, &mut out),
            Event::Bye(worker) => {
                self.leave(now, worker, Loss::Dropped, &mut out);
                out.push(Effect::Taken { worker, receipt: Receipt::Noted });
            }
            Event::Cancel(run) => self.cancel(now, run, &mut out),
            Event::End(run) => {
                self.cancel(now, run, &mut out);
                self.shares.end(run);
            }
            Event::Drain(worker) => self.drain(worker, Cause::Asked, &mut out),
            Event::Bar(_) | Event::Inherit(..) | Event::Isolate(_) | Event::Pardon(_) => {
                self.learn_past(now, event);
            }
            Event::Release(claimant) => self.release_claims(claimant, &mut out),
            Event::Forsaken => {
                for job in self.jobs.names() {
                    self.abandon(now, job, Reason::Forsaken, &mut out);
                }
            }
            Event::Tick => self.tick(now, &mut out),
        }
        self.grant(now, &mut out);
        while let Some(run) = self.dirty.pop() {
            self.settle(run, &mut out);
        }
        out
    }

    /// A worker hands in a result ([`Event::Commit`]).
    fn take_result(&mut self, now: Millis, event: Event, out: &mut Vec<Effect>) {
        let Event::Commit { worker, job, epoch, build, digest, outcome, prior } = event else {
            return;
        };
        let foreign = self.foreign(job, epoch, build);
        let done = Verdict::Done { digest, outcome, worker: Some(worker), build: Some(build) };
        let kept = self.kept(prior);
        let receipt = if kept.is_none() && self.is_inherited_by(job, epoch) {
            self.complete_unclaimed(job, done)
        } else {
            self.commit(now, (worker, job), (done, foreign), kept, out)
        };
        out.push(Effect::Taken { worker, receipt });
    }

    fn open(&mut self, now: Millis, run: Run, (job, need): (Job, Skills), out: &mut Vec<Effect>) {
        let Some(account) = self.shares.get_mut(run) else {
            return;
        };
        let opening = account.counts.opened;
        account.counts.opened += 1;
        account.openings.push_back(job);
        self.counts.opened += 1;
        let want = Want { run, opening, count: 1 };
        let Some(record) = self.jobs.get_mut(&job) else {
            return self.admit(now, (job, need), want, out);
        };
        match record.wants.iter_mut().find(|want| want.run == run) {
            Some(want) => want.count += 1,
            None => {
                record.wants.push(want);
                self.count_want(job, 1);
                if let Some(record) = self.jobs.get(&job)
                    && record.phase == Phase::Ready
                {
                    self.shares.ready(now, run, &record.ask, (opening, job));
                }
            }
        }
        self.dirty.push(run);
    }

    /// Acts on what is known of a job before anybody is asked.
    fn apply_prior(&mut self, now: Millis, job: Job, prior: Prior, out: &mut Vec<Effect>) {
        match self.kept(prior) {
            Some(done) => self.end(now, job, done, out),
            None if prior == Prior::Unfit => self.abandon(now, job, Reason::Invalid, out),
            None => {}
        }
    }

    /// The verdict that was kept, if one was.
    fn kept(&self, prior: Prior) -> Option<Verdict> {
        let Prior::Result { digest, outcome, build } = prior else {
            return None;
        };
        #[cfg(test)]
        let build = build.filter(|_| !self.is(Mutant::KeptOfNobody));
        Some(Verdict::Done { digest, outcome, worker: None, build })
    }

    fn admit(
        &mut self,
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
            last: None,
            attempts: 0,
            crashes: 0,
            timer: None,
        };
        self.jobs.insert(job, record);
        self.counts.waiting += 1;
        self.count_want(job, 1);
        self.set_phase(now, job, self.awaited(now, job));
        if self.quarantine.touch(job) {
            self.abandon(now, job, Reason::Crashes { deaths: 0, workers: 0 }, out);
        }
    }

    /// A job changes its phase: everything that follows from the phase alone is done here.
    pub(crate) fn set_phase(&mut self, now: Millis, job: Job, phase: Phase) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let old = std::mem::replace(&mut record.phase, phase);
        let ask = &record.ask;
        for want in &record.wants {
            match (old, phase) {
                (Phase::Ready, Phase::Ready) => {}
                (Phase::Ready, _) => self.shares.unready(want.run, ask, want.opening),
                (_, Phase::Ready) => self.shares.ready(now, want.run, ask, (want.opening, job)),
                (Phase::Waiting(_) | Phase::Held | Phase::Over(_), _) => {}
            }
            if let Some(account) = self.shares.get_mut(want.run) {
                account.counts.moved(old, phase);
            }
            if let Phase::Over(_) = phase {
                self.dirty.push(want.run);
            }
        }
        self.counts.moved(old, phase);
        let need = ask.need;
        let ready = |phase| i64::from(phase == Phase::Ready);
        self.jobs.count_ready(need, ready(phase) - ready(old));
        self.jobs.set_timer(job, self.timing.lease);
    }

    /// Books a job that a run begins (`1`) or ceases (`-1`) to want.
    pub(crate) fn count_want(&mut self, job: Job, sign: i64) {
        let Some(record) = self.jobs.get(&job) else {
            return;
        };
        let Some(want) = record.wants.last() else {
            return;
        };
        if let Some(account) = self.shares.get_mut(want.run) {
            account.counts.stands(record.phase, sign);
        }
    }

    /// `foreign`: late, and of another build than the one that has or had the job.
    fn commit(
        &mut self,
        now: Millis,
        (worker, job): (Worker, Job),
        (done, foreign): (Verdict, bool),
        kept: Option<Verdict>,
        out: &mut Vec<Effect>,
    ) -> Receipt {
        let over = match self.jobs.get(&job).map(|r| r.phase) {
            Some(Phase::Over(verdict)) => Some(verdict),
            Some(Phase::Waiting(_) | Phase::Ready | Phase::Held) => None,
            None => match self.past.get(&job).or(kept) {
                Some(verdict) => Some(verdict),
                None => return Receipt::Unknown,
            },
        };
        #[cfg(test)]
        let over = over.filter(|_| !self.is(Mutant::NoDedupe));
        let Some(over) = over else {
            if foreign {
                self.counts.fenced += 1;
                return Receipt::Fenced;
            }
            self.blame(worker, job, out);
            self.end(now, job, done, out);
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
            self.counts.fenced += 1;
            Receipt::Fenced
        } else {
            self.counts.alarms += 1;
            out.push(Effect::Alarm { job, kept, other: digest });
            Receipt::Conflict
        }
    }

    /// Gives a job up: its runs hear of it, and only they.
    pub(crate) fn abandon(&mut self, now: Millis, job: Job, reason: Reason, out: &mut Vec<Effect>) {
        let Some(record) = self.jobs.get(&job) else {
            return;
        };
        if let Phase::Over(_) = record.phase {
            return;
        }
        let (attempts, crashes) = (record.attempts, record.crashes);
        if let Reason::Crashes { .. } = reason
            && !self.quarantine.touch(job)
        {
            self.quarantine.put(job, 1);
            out.push(Effect::Quarantine { job, crashes });
        }
        out.push(Effect::Stall { job, reason, attempts });
        self.end(now, job, Verdict::Abandoned(reason), out);
    }

    /// The first end counts; terminal is final.
    pub(crate) fn end(&mut self, now: Millis, job: Job, verdict: Verdict, out: &mut Vec<Effect>) {
        let Some(record) = self.jobs.get(&job) else {
            return;
        };
        if let Phase::Over(_) = record.phase {
            return;
        }
        self.inherited.drop_claims(job);
        self.release(now, job, verdict, out);
        self.set_phase(now, job, Phase::Over(verdict));
    }
}
