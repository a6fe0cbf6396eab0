//! The state machine: what it knows, and how jobs open and end.

use crate::counts::Counts;
use crate::effect::{Bound, Effect, Loss, Reason, Receipt, Verdict};
use crate::event::{Digest, Epoch, Event, Job, Millis, Outcome, Prior, Run, Worker};
use crate::jobs::Jobs;
#[cfg(test)]
use crate::mutant::Mutant;
use crate::share::Shares;
use crate::timing::Timing;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Workers remembered after their end, so that a late copy of their polls mints no grant.
pub(crate) const MAX_GONE: usize = 4_096;
/// Jobs kept in quarantine; beyond it the oldest are let out.
const MAX_QUARANTINE: usize = 1_024;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Lease {
    pub(crate) worker: Worker,
    pub(crate) epoch: Epoch,
    pub(crate) granted: Millis,
    pub(crate) expires: Millis,
    pub(crate) hard: Millis,
    pub(crate) suspect: bool,
    /// To whom and how much it is charged.
    pub(crate) run: Run,
    pub(crate) charged: Millis,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Not before then.
    Waiting(Millis),
    /// In the lines of its runs.
    Ready,
    /// Under one lease, or two.
    Held,
    Over(Verdict),
}

/// What a run wants of a job.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Want {
    pub(crate) run: Run,
    /// The run's first opening of it.
    pub(crate) opening: u64,
    /// Unsettled openings.
    pub(crate) count: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct Record {
    pub(crate) wants: Vec<Want>,
    pub(crate) phase: Phase,
    pub(crate) leases: Vec<Lease>,
    /// The grant that ran silent last, which a late renewal may take up again.
    pub(crate) lapsed: Option<Lease>,
    pub(crate) attempts: u32,
    pub(crate) crashes: u32,
    /// Under whom it died.
    pub(crate) killers: Vec<Worker>,
    /// When it is looked at next, as in [`Dispatch::timers`].
    pub(crate) timer: Option<Millis>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Peer {
    pub(crate) last_seq: u64,
    /// What the last poll was answered with, for its repeats.
    pub(crate) granted: Option<(Job, Epoch)>,
    /// Its place among the parked.
    pub(crate) parked: Option<u64>,
    pub(crate) held: Vec<(Job, Epoch)>,
    /// Jobs that died here and that others finished.
    pub(crate) blame: u32,
    pub(crate) gone: bool,
    pub(crate) drained: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Parked {
    pub(crate) worker: Worker,
    pub(crate) seq: u64,
    pub(crate) until: Millis,
}

/// The pool.
#[derive(Debug)]
pub struct Dispatch {
    pub(crate) timing: Timing,
    pub(crate) jobs: Jobs,
    pub(crate) shares: Shares,
    /// When to look at which job: its pause is over, or a lease of it.
    pub(crate) timers: BTreeSet<(Millis, Job)>,
    /// Attempts without a duplicate, oldest first.
    pub(crate) single: BTreeSet<(Millis, Job)>,
    /// In the order in which they came.
    pub(crate) parked: BTreeMap<u64, Parked>,
    pub(crate) tickets: u64,
    pub(crate) peers: BTreeMap<Worker, Peer>,
    pub(crate) live: usize,
    pub(crate) gone: VecDeque<Worker>,
    pub(crate) past: BTreeMap<Job, Verdict>,
    pub(crate) past_order: VecDeque<Job>,
    quarantine: VecDeque<Job>,
    pub(crate) unsettled: u64,
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
            timers: BTreeSet::new(),
            single: BTreeSet::new(),
            parked: BTreeMap::new(),
            tickets: 0,
            peers: BTreeMap::new(),
            live: 0,
            gone: VecDeque::new(),
            past: BTreeMap::new(),
            past_order: VecDeque::new(),
            quarantine: VecDeque::new(),
            unsettled: 0,
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
        Counts { quarantined: self.quarantine.len() as u64, ..self.counts }
    }

    /// The same of one run; nothing if there is no such run.
    #[must_use]
    pub fn counts_of(&self, run: Run) -> Option<Counts> {
        self.shares.get(run).map(|account| account.counts)
    }

    /// Whether this job is open and its verdict still out.
    #[must_use]
    pub fn wants(&self, job: Job) -> bool {
        self.jobs.get(&job).is_some_and(|r| !matches!(r.phase, Phase::Over(_)))
    }

    /// Takes in one event at `now` \[ms\] and says what to do about it.
    pub fn step(&mut self, now: Millis, event: Event) -> Vec<Effect> {
        let mut out = Vec::new();
        match event {
            Event::Begin { run, share } => self.shares.begin(now, run, share),
            Event::Open { run, job, prior } => {
                self.open(now, run, job, &mut out);
                self.weigh(now, job, prior, &mut out);
            }
            #[cfg(test)]
            Event::Pause(_) if self.is(Mutant::PauseIgnored) => {}
            Event::Pause(run) => self.shares.pause(now, run, true),
            Event::Resume(run) => self.shares.pause(now, run, false),
            Event::Poll { worker, seq, slots, park } => {
                self.poll(now, worker, seq, slots > 0, park, &mut out);
            }
            Event::Renew { worker, job, epoch } => self.renew(now, worker, job, epoch, &mut out),
            Event::Commit { worker, job, digest, outcome, epoch: _ } => {
                self.commit(now, (worker, job), digest, outcome, &mut out);
            }
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
            Event::Drain(worker) => self.drain(worker, &mut out),
            Event::Pardon(job) => self.quarantine.retain(|held| *held != job),
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

    fn open(&mut self, now: Millis, run: Run, job: Job, out: &mut Vec<Effect>) {
        let (most, full) = (self.timing.max_open, self.unsettled >= self.timing.max_pool);
        let Some(account) = self.shares.get_mut(run) else {
            out.push(Effect::Busy { run, job, bound: Bound::NoRun });
            return;
        };
        let here = account.openings.len() as u64 >= most;
        #[cfg(test)]
        let (here, full) =
            if self.mutant == Some(Mutant::NoBound) { (false, false) } else { (here, full) };
        if here || full {
            let bound = if here { Bound::Run } else { Bound::Pool };
            out.push(Effect::Busy { run, job, bound });
            return;
        }
        let opening = account.counts.opened;
        account.counts.opened += 1;
        account.openings.push_back(job);
        self.counts.opened += 1;
        self.unsettled += 1;
        let want = Want { run, opening, count: 1 };
        let Some(record) = self.jobs.get_mut(&job) else {
            return self.admit(now, job, want, out);
        };
        match record.wants.iter_mut().find(|want| want.run == run) {
            Some(want) => want.count += 1,
            None => {
                record.wants.push(want);
                self.tally(job, 1);
                if self.jobs.get(&job).is_some_and(|r| r.phase == Phase::Ready) {
                    self.shares.ready(now, run, opening, job);
                }
            }
        }
        self.dirty.push(run);
    }

    /// Acts on what is known of a job before anybody is asked.
    fn weigh(&mut self, now: Millis, job: Job, prior: Prior, out: &mut Vec<Effect>) {
        match prior {
            Prior::Nothing => {}
            Prior::Result { digest, outcome } => {
                self.end(now, job, Verdict::Done { digest, outcome, worker: None });
            }
            Prior::Unfit => self.abandon(now, job, Reason::Invalid, out),
        }
    }

    fn admit(&mut self, now: Millis, job: Job, want: Want, out: &mut Vec<Effect>) {
        let record = Record {
            wants: vec![want],
            phase: Phase::Waiting(now),
            leases: Vec::new(),
            lapsed: None,
            attempts: 0,
            crashes: 0,
            killers: Vec::new(),
            timer: None,
        };
        self.jobs.insert(job, record);
        self.counts.waiting += 1;
        self.tally(job, 1);
        self.turn(now, job, Phase::Ready);
        if self.quarantine.contains(&job) {
            self.abandon(now, job, Reason::Crashes, out);
        }
    }

    /// A job changes its phase: everything that follows from the phase alone is done here.
    pub(crate) fn turn(&mut self, now: Millis, job: Job, phase: Phase) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let old = std::mem::replace(&mut record.phase, phase);
        for want in &record.wants {
            match (old, phase) {
                (Phase::Ready, Phase::Ready) => {}
                (Phase::Ready, _) => self.shares.unready(want.run, want.opening, job),
                (_, Phase::Ready) => self.shares.ready(now, want.run, want.opening, job),
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
        self.set_timer(job);
    }

    /// Books a job that a run begins (`1`) or ceases (`-1`) to want.
    pub(crate) fn tally(&mut self, job: Job, sign: i64) {
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

    pub(crate) fn set_timer(&mut self, job: Job) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        let next = match record.phase {
            Phase::Waiting(until) => Some(until),
            Phase::Held => record.leases.iter().map(|lease| lease.expires.min(lease.hard)).min(),
            Phase::Ready | Phase::Over(_) => None,
        };
        if record.timer == next {
            return;
        }
        if let Some(old) = std::mem::replace(&mut record.timer, next) {
            self.timers.remove(&(old, job));
        }
        if let Some(next) = next {
            self.timers.insert((next, job));
        }
    }

    fn commit(
        &mut self,
        now: Millis,
        (worker, job): (Worker, Job),
        digest: Digest,
        outcome: Outcome,
        out: &mut Vec<Effect>,
    ) {
        let over = match self.jobs.get(&job).map(|r| r.phase) {
            Some(Phase::Over(verdict)) => Some(verdict),
            Some(Phase::Waiting(_) | Phase::Ready | Phase::Held) => None,
            None => match self.past.get(&job) {
                Some(verdict) => Some(*verdict),
                None => {
                    out.push(Effect::Taken { worker, receipt: Receipt::Unknown });
                    return;
                }
            },
        };
        #[cfg(test)]
        let over = over.filter(|_| !self.is(Mutant::NoDedupe));
        let receipt = match over {
            None => {
                self.blame(worker, job, out);
                self.end(now, job, Verdict::Done { digest, outcome, worker: Some(worker) });
                Receipt::Accepted
            }
            Some(Verdict::Done { digest: kept, .. }) if kept == digest => Receipt::Duplicate,
            Some(Verdict::Done { digest: kept, .. }) => {
                self.counts.alarms += 1;
                out.push(Effect::Alarm { job, kept, other: digest });
                Receipt::Conflict
            }
            Some(Verdict::Abandoned(_) | Verdict::Cancelled) => Receipt::TooLate,
        };
        out.push(Effect::Taken { worker, receipt });
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
        if reason == Reason::Crashes && !self.quarantine.contains(&job) {
            self.quarantine.push_back(job);
            if self.quarantine.len() > MAX_QUARANTINE {
                self.quarantine.pop_front();
            }
            out.push(Effect::Quarantine { job, crashes });
        }
        out.push(Effect::Stall { job, reason, attempts });
        self.end(now, job, Verdict::Abandoned(reason));
    }

    /// The first end counts; terminal is final.
    pub(crate) fn end(&mut self, now: Millis, job: Job, verdict: Verdict) {
        let Some(record) = self.jobs.get(&job) else {
            return;
        };
        if let Phase::Over(_) = record.phase {
            return;
        }
        self.release(now, job, verdict);
        self.turn(now, job, Phase::Over(verdict));
    }
}
