//! The state machine.

use crate::counts::Counts;
use crate::effect::{Effect, Loss, Reason, Receipt, Verdict};
use crate::event::{Digest, Epoch, Event, Job, Millis, Outcome, Worker};
use crate::timing::Timing;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Settled jobs whose results are remembered, to tell a duplicate from a stranger. Beyond it the
/// oldest are forgotten, and a result that comes that late is answered "unknown".
const MAX_PAST: usize = 65_536;
/// Workers remembered after their end, so that a late copy of their polls mints no grant.
pub(crate) const MAX_GONE: usize = 4_096;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Lease {
    pub(crate) worker: Worker,
    pub(crate) epoch: Epoch,
    pub(crate) expires: Millis,
    pub(crate) hard: Millis,
    pub(crate) suspect: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Phase {
    /// Waits; `last` is the grant that ran silent, which a late renewal may take up again.
    Queued {
        not_before: Millis,
        last: Option<Lease>,
    },
    Leased(Lease),
    Over(Verdict),
}

#[derive(Clone, Debug)]
pub(crate) struct Record {
    /// Its first unsettled opening: the queue is in this order.
    pub(crate) opening: u64,
    /// Unsettled openings.
    pub(crate) wanted: u32,
    pub(crate) phase: Phase,
    pub(crate) attempts: u32,
    pub(crate) crashes: u32,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer {
    pub(crate) last_seq: u64,
    /// What the last poll was answered with, for its repeats.
    pub(crate) granted: Option<(Job, Epoch)>,
    pub(crate) gone: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Parked {
    pub(crate) worker: Worker,
    pub(crate) seq: u64,
    pub(crate) until: Millis,
}

/// Bugs planted on purpose: the simulation must find each of them.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mutant {
    /// Results settle as they come.
    SettleAsTheyCome,
    /// A repeated poll gets a second job.
    PollMintsTwice,
    /// Leases never run out.
    NoExpiry,
    /// A second result settles again.
    NoDedupe,
    /// The end of a worker takes everybody's leases.
    DownTakesAll,
    /// Crashes are not counted.
    NoLimit,
}

/// The pool.
#[derive(Debug)]
pub struct Dispatch {
    pub(crate) timing: Timing,
    pub(crate) jobs: BTreeMap<Job, Record>,
    openings: VecDeque<(u64, Job)>,
    pub(crate) queue: BTreeSet<(u64, Job)>,
    pub(crate) parked: VecDeque<Parked>,
    pub(crate) peers: BTreeMap<Worker, Peer>,
    pub(crate) gone: VecDeque<Worker>,
    pub(crate) past: BTreeMap<Job, Verdict>,
    past_order: VecDeque<Job>,
    next_epoch: u64,
    counts: Counts,
    #[cfg(test)]
    pub(crate) mutant: Option<Mutant>,
}

impl Dispatch {
    /// An empty pool. `incarnation` differs between lives of one coordinator, so that no grant
    /// number of an earlier life comes again.
    #[must_use]
    pub fn new(timing: Timing, incarnation: u32) -> Self {
        Self {
            timing,
            jobs: BTreeMap::new(),
            openings: VecDeque::new(),
            queue: BTreeSet::new(),
            parked: VecDeque::new(),
            peers: BTreeMap::new(),
            gone: VecDeque::new(),
            past: BTreeMap::new(),
            past_order: VecDeque::new(),
            next_epoch: u64::from(incarnation) << 32,
            counts: Counts::default(),
            #[cfg(test)]
            mutant: None,
        }
    }

    /// How many of each there are now.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let running = |r: &&Record| matches!(r.phase, Phase::Leased(_));
        Counts {
            waiting: self.queue.len() as u64,
            running: self.jobs.values().filter(running).count() as u64,
            ..self.counts
        }
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
            Event::Open(job) => self.open(now, job),
            Event::Poll { worker, seq, slots, park } => {
                self.poll(now, worker, seq, slots > 0, park, &mut out);
            }
            Event::Renew { worker, job, epoch } => self.renew(now, worker, job, epoch, &mut out),
            Event::Commit { worker, job, digest, outcome, epoch: _ } => {
                self.commit(worker, job, digest, outcome, &mut out);
            }
            Event::Fail { worker, job, epoch, trouble } => {
                self.fail(now, worker, job, epoch, trouble, &mut out);
            }
            Event::Suspect(worker) => self.suspect(now, worker),
            Event::Down(worker) => self.leave(now, worker, Loss::Down, &mut out),
            Event::Bye(worker) => {
                self.leave(now, worker, Loss::Dropped, &mut out);
                out.push(Effect::Taken { worker, receipt: Receipt::Noted });
            }
            Event::Cancel(job) => self.end(job, Verdict::Cancelled),
            Event::CancelAll => {
                for job in self.jobs.keys().copied().collect::<Vec<_>>() {
                    self.end(job, Verdict::Cancelled);
                }
            }
            Event::Forsaken => {
                for job in self.jobs.keys().copied().collect::<Vec<_>>() {
                    self.abandon(job, Reason::Forsaken, &mut out);
                }
            }
            Event::Reject(job) => self.abandon(job, Reason::Invalid, &mut out),
            Event::Tick => self.tick(now, &mut out),
        }
        self.grant(now, &mut out);
        self.settle(&mut out);
        out
    }

    fn open(&mut self, now: Millis, job: Job) {
        let opening = self.counts.opened;
        self.counts.opened += 1;
        self.openings.push_back((opening, job));
        if let Some(record) = self.jobs.get_mut(&job) {
            record.wanted += 1;
            return;
        }
        let phase = Phase::Queued { not_before: now, last: None };
        let record = Record { opening, wanted: 1, phase, attempts: 0, crashes: 0 };
        self.jobs.insert(job, record);
        self.queue.insert((opening, job));
    }

    fn poll(
        &mut self,
        now: Millis,
        worker: Worker,
        seq: u64,
        free: bool,
        park: bool,
        out: &mut Vec<Effect>,
    ) {
        let fresh = Peer { last_seq: 0, granted: None, gone: false };
        let peer = self.peers.entry(worker).or_insert(fresh);
        #[cfg(test)]
        if self.mutant == Some(Mutant::PollMintsTwice) {
            peer.granted = None;
            peer.last_seq = seq.saturating_sub(1);
        }
        if seq < peer.last_seq {
            out.push(Effect::Idle { worker, seq });
            return;
        }
        if seq == peer.last_seq {
            let granted = peer.granted;
            self.repeat(now, worker, seq, granted, out);
            return;
        }
        *peer = Peer { last_seq: seq, granted: None, gone: false };
        self.parked.retain(|p| p.worker != worker);
        if !free {
            out.push(Effect::Idle { worker, seq });
            return;
        }
        self.parked.push_back(Parked { worker, seq, until: now + self.timing.park });
        self.grant(now, out);
        if self.parked.iter().all(|p| p.worker != worker) {
            return;
        }
        if park {
            out.push(Effect::Park { worker, seq });
        } else {
            self.parked.retain(|p| p.worker != worker);
            out.push(Effect::Idle { worker, seq });
        }
    }

    /// Answers a poll that was asked before as it was answered then.
    fn repeat(
        &mut self,
        now: Millis,
        worker: Worker,
        seq: u64,
        granted: Option<(Job, Epoch)>,
        out: &mut Vec<Effect>,
    ) {
        let held = granted.and_then(|(job, epoch)| {
            let lease = self.lease_mut(job).filter(|l| l.epoch == epoch)?;
            Some((job, epoch, lease.hard.saturating_sub(now)))
        });
        if let Some((job, epoch, hard)) = held {
            let lease = self.timing.lease;
            out.push(Effect::Grant { worker, seq, job, epoch, lease, hard });
        } else if self.parked.iter().any(|p| p.worker == worker) {
            out.push(Effect::Park { worker, seq });
        } else {
            out.push(Effect::Idle { worker, seq });
        }
    }

    fn commit(
        &mut self,
        worker: Worker,
        job: Job,
        digest: Digest,
        outcome: Outcome,
        out: &mut Vec<Effect>,
    ) {
        let over = match self.jobs.get(&job).map(|r| r.phase) {
            Some(Phase::Over(verdict)) => Some(verdict),
            Some(Phase::Queued { .. } | Phase::Leased(_)) => None,
            None => match self.past.get(&job) {
                Some(verdict) => Some(*verdict),
                None => {
                    out.push(Effect::Taken { worker, receipt: Receipt::Unknown });
                    return;
                }
            },
        };
        #[cfg(test)]
        let over = over.filter(|_| self.mutant != Some(Mutant::NoDedupe));
        let receipt = match over {
            None => {
                self.end(job, Verdict::Done { digest, outcome, worker });
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

    pub(crate) fn abandon(&mut self, job: Job, reason: Reason, out: &mut Vec<Effect>) {
        let Some(record) = self.jobs.get(&job) else {
            return;
        };
        if let Phase::Over(_) = record.phase {
            return;
        }
        out.push(Effect::Stall { job, reason, attempts: record.attempts });
        self.end(job, Verdict::Abandoned(reason));
    }

    /// The first end counts; terminal is final.
    fn end(&mut self, job: Job, verdict: Verdict) {
        let Some(record) = self.jobs.get_mut(&job) else {
            return;
        };
        match record.phase {
            Phase::Over(_) => {}
            Phase::Queued { .. } => {
                self.queue.remove(&(record.opening, job));
                record.phase = Phase::Over(verdict);
            }
            Phase::Leased(_) => record.phase = Phase::Over(verdict),
        }
    }

    /// Gives the oldest jobs that are due to the workers that have waited longest.
    fn grant(&mut self, now: Millis, out: &mut Vec<Effect>) {
        while let Some(asker) = self.parked.front().copied() {
            let due = |(_, job): &&(u64, Job)| match self.jobs.get(job).map(|r| r.phase) {
                Some(Phase::Queued { not_before, .. }) => not_before <= now,
                Some(Phase::Leased(_) | Phase::Over(_)) | None => false,
            };
            let Some(&(opening, job)) = self.queue.iter().find(due) else {
                return;
            };
            self.parked.pop_front();
            self.queue.remove(&(opening, job));
            self.next_epoch += 1;
            let (worker, seq, epoch) = (asker.worker, asker.seq, Epoch(self.next_epoch));
            let (lease, hard) = (self.timing.lease, self.timing.hard);
            if let Some(record) = self.jobs.get_mut(&job) {
                record.attempts += 1;
                self.counts.resent += u64::from(record.attempts > 1);
                let (expires, hard) = (now + lease, now + hard);
                let held = Lease { worker, epoch, expires, hard, suspect: false };
                record.phase = Phase::Leased(held);
            }
            if let Some(peer) = self.peers.get_mut(&worker) {
                peer.granted = Some((job, epoch));
            }
            out.push(Effect::Grant { worker, seq, job, epoch, lease, hard });
        }
    }

    /// Settles the openings at the front whose jobs are over.
    fn settle(&mut self, out: &mut Vec<Effect>) {
        #[cfg(test)]
        if self.mutant == Some(Mutant::SettleAsTheyCome) {
            let jobs = &self.jobs;
            let open = |job: &Job| !matches!(jobs.get(job).map(|r| r.phase), Some(Phase::Over(_)));
            self.openings.make_contiguous().sort_by_key(|(_, job)| open(job));
        }
        while let Some(&(opening, job)) = self.openings.front() {
            let Some(record) = self.jobs.get_mut(&job) else {
                return;
            };
            let Phase::Over(verdict) = record.phase else {
                return;
            };
            self.openings.pop_front();
            record.wanted -= 1;
            let (attempts, spent) = (record.attempts, record.wanted == 0);
            self.count(verdict);
            out.push(Effect::Settle { opening, job, verdict, attempts });
            if spent {
                self.jobs.remove(&job);
                self.remember(job, verdict);
            }
        }
    }

    fn count(&mut self, verdict: Verdict) {
        self.counts.settled += 1;
        match verdict {
            Verdict::Done { outcome: Outcome::Refused, .. } => self.counts.refused += 1,
            Verdict::Done { outcome: Outcome::Failed, .. } => self.counts.failed += 1,
            Verdict::Abandoned(_) => self.counts.abandoned += 1,
            Verdict::Done { outcome: Outcome::Broken, .. } | Verdict::Cancelled => {}
        }
    }

    fn remember(&mut self, job: Job, verdict: Verdict) {
        if self.past.insert(job, verdict).is_none() {
            self.past_order.push_back(job);
        }
        while self.past_order.len() > MAX_PAST {
            if let Some(oldest) = self.past_order.pop_front() {
                self.past.remove(&oldest);
            }
        }
    }
}
