//! What the pool knows, and how a job changes its phase.

use crate::counts::Counts;
use crate::effect::{Bound, Verdict};
use crate::event::{Build, Epoch, Job, Millis, Prior, Run, Skills, Worker};
use crate::inherited::InheritedJobs;
use crate::job_record::Phase;
use crate::jobs::Jobs;
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

/// The state of the pool between two events.
#[derive(Debug)]
pub(crate) struct PoolState {
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
    pub(crate) dirty: Vec<Run>,
    #[cfg(test)]
    pub(crate) mutant: Option<Mutant>,
}

impl PoolState {
    /// An empty pool. `incarnation` grows with each life of one coordinator, and whoever keeps it
    /// has it on disk before the first grant: then no grant number of an earlier life comes again.
    pub(crate) fn new(timing: Timing, incarnation: u32) -> Self {
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
    pub(crate) fn counts(&self) -> Counts {
        let unschedulable = self.unschedulable().map(|(_, jobs)| jobs).sum();
        Counts { quarantined: self.quarantine.held(), unschedulable, ..self.counts }
    }

    /// The same of one run; nothing if there is no such run.
    pub(crate) fn counts_of(&self, run: Run) -> Option<Counts> {
        self.shares.get(run).map(|account| account.counts)
    }

    /// What jobs wait for, and how many, that no worker here can give.
    pub(crate) fn unschedulable(&self) -> impl Iterator<Item = (Skills, u64)> {
        let ready = self.jobs.ready().iter().filter(|_| !self.worker_table.is_empty());
        ready.filter(|(need, _)| !self.worker_table.can(**need)).map(|(need, jobs)| (*need, *jobs))
    }

    /// Whether this job is open and its verdict still out.
    pub(crate) fn wants(&self, job: Job) -> bool {
        self.jobs.get(&job).is_some_and(|r| !matches!(r.phase, Phase::Over(_)))
    }

    /// Whether anything is remembered of this job: it is open, or was not long ago.
    pub(crate) fn knows(&self, job: Job) -> bool {
        self.jobs.get(&job).is_some() || self.past.get(&job).is_some()
    }

    /// Who found the result of a job, if a worker did and it was not long ago.
    pub(crate) fn maker_of(&self, job: Job) -> Option<Worker> {
        let maker = |verdict| match verdict {
            Verdict::Done { worker, .. } => worker,
            Verdict::Abandoned(_) | Verdict::Cancelled => None,
        };
        let open = self.jobs.get(&job).and_then(|record| match record.phase {
            Phase::Over(verdict) => maker(verdict),
            Phase::Waiting(_) | Phase::Ready | Phase::Held => None,
        });
        open.or_else(|| self.past.get(&job).and_then(maker))
    }

    /// Whether a run may open one more, or which bound is reached.
    ///
    /// # Errors
    /// The bound.
    pub(crate) fn room(&self, run: Run) -> Result<(), Bound> {
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

    #[cfg(test)]
    pub(crate) fn is(&self, mutant: Mutant) -> bool {
        self.mutant == Some(mutant)
    }

    pub(crate) fn build_of(&self, worker: Worker) -> Option<Build> {
        self.worker_table.get(&worker).map(|state| state.build)
    }

    pub(crate) fn is_foreign(&self, job: Job, epoch: Epoch, build: Build) -> bool {
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

    /// The verdict that was kept, if one was.
    pub(crate) fn kept(&self, prior: Prior) -> Option<Verdict> {
        let Prior::Result { digest, outcome, build } = prior else {
            return None;
        };
        #[cfg(test)]
        let build = build.filter(|_| !self.is(Mutant::KeptOfNobody));
        Some(Verdict::Done { digest, outcome, worker: None, build })
    }

    /// Whether a job is held back from those under whom it died.
    pub(crate) fn avoids_killers(&self) -> bool {
        #[cfg(test)]
        return !self.is(Mutant::KillerAgain);
        #[cfg(not(test))]
        true
    }
}
