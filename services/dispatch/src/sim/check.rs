//! What must hold, whatever the schedule: an account of its own, kept from what the machines hear
//! and say.

mod chains;
mod deaths;
mod ends;
mod grants;
mod hands;
mod lives;
mod told;

use super::plan::Plan;
use crate::*;
use std::collections::{BTreeMap, BTreeSet};

/// Which law is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Oracle {
    /// Each run's openings settle once, in order.
    Order,
    /// What settles is the job's own result; nobody's wish or trouble becomes a verdict of others.
    Truth,
    /// One result of a job counts.
    Once,
    /// A poll has one answer.
    Poll,
    /// No grant's number comes again.
    Epoch,
    /// A job that kills is stopped.
    Poison,
    /// What nobody began is not charged with a death.
    Innocent,
    /// A lease ends for a reason that there is.
    Healthy,
    /// What was acknowledged is not computed again.
    Kept,
    /// A paused run gets nothing.
    Pause,
    /// At most one duplicate, and late.
    Hedge,
    /// No run with work waits for ever.
    Starved,
    /// Queues are as long as they may be.
    Bound,
    /// Nobody goes on with what nobody wants.
    Stop,
    /// A worker ends a solve that takes too long.
    Watchdog,
    /// A worker keeps its result until there is a receipt.
    Result,
    /// Who has a job that nobody wants any more is told at once, and nobody else is.
    Told,
    /// A result that differs from the one that counts, and is of the same build, raises an alarm;
    /// nothing else does.
    Alarm,
    /// A late result of another build does not count, and one of the same does.
    Fence,
    /// A job goes to who can do it.
    Skill,
    /// A job goes nowhere it died while somebody else lives, and is not ended by one alone.
    Spared,
    /// Who only kills gets no more; who does not, or is the last, stays.
    Drained,
    /// Who only kills gets nothing that another can do, whatever it says that it can do beside.
    Doubted,
    /// What was at work when the coordinator ended is not begun anew.
    Anew,
    /// No job of a chain is opened before the one whose result it starts from is done.
    Chain,
    /// A job goes to the worker that found what it starts from, if that one waits.
    Maker,
    /// No job waits while a worker that can do it does.
    Idle,
    /// Everything is done in the end.
    Live,
}

/// What is wrong with a schedule.
#[derive(Clone, Debug)]
pub(super) struct Wrong {
    pub(super) oracle: Oracle,
    pub(super) text: String,
}

/// Whether a result counts.
fn accepts(effects: &[Effect]) -> bool {
    let accepted = |e: &Effect| matches!(e, Effect::Taken { receipt: Receipt::Accepted, .. });
    effects.iter().any(accepted)
}

fn wrong(oracle: Oracle, text: impl Into<String>) -> Result<(), Wrong> {
    Err(Wrong { oracle, text: text.into() })
}

/// The result of a job, which whoever computes it with this build finds; half of the jobs have the
/// same of every build.
pub(super) fn result_of(job: Job, build: Build) -> Digest {
    let touch = if job.0[2].is_multiple_of(2) { 0 } else { build.0[0] };
    Digest(job.0.map(|b| b ^ 0x5a ^ touch))
}

/// What a solve finds that is not as it should be.
pub(super) fn twin_of(mut digest: Digest) -> Digest {
    digest.0[31] ^= 1;
    digest
}

#[derive(Clone, Copy)]
struct Held {
    worker: Worker,
    granted: Millis,
    heard: Millis,
    suspect: Option<Millis>,
    now: bool,
    /// The machine has heard that a solver has it, and that there is a result.
    begun: bool,
    offered: bool,
}

/// What is known of a job in this life of the coordinator.
#[derive(Default)]
struct Known {
    wants: BTreeMap<usize, u32>,
    grants: u32,
    crashes: u32,
    killers: BTreeSet<WorkerName>,
    over: bool,
    stalled: bool,
    holders: BTreeSet<Epoch>,
    /// Who was granted it last.
    last: Option<Worker>,
    /// Who found what it starts from.
    maker: Option<Worker>,
}

#[derive(Default)]
struct Course {
    jobs: Vec<Job>,
    opened: usize,
    settled: usize,
    /// What settled in any life.
    truth: BTreeMap<usize, Digest>,
    cancelled: bool,
    paused: bool,
    /// A job of it was given up, in this life: a chain ends there.
    ended: bool,
    /// It has had fresh work and no grant since then, and so many went to others when it was due.
    waiting: Option<Millis>,
    overdue: usize,
}

pub(super) struct Checker {
    timing: Timing,
    calm: bool,
    plan: Plan,
    skills: BTreeMap<Worker, Skills>,
    names: BTreeMap<Worker, WorkerName>,
    /// Jobs in quarantine, in this life and all before.
    isolated: BTreeSet<Job>,
    runs: Vec<Course>,
    deaths: deaths::Deaths,
    /// Who was drained in this life or by hand, and who by hand, in any life.
    drained: BTreeSet<Worker>,
    by_hand: BTreeSet<Worker>,
    lives: lives::Lives,
    chains: chains::Chains,
    jobs: BTreeMap<Job, Known>,
    held: BTreeMap<Epoch, Held>,
    epochs: BTreeMap<Epoch, (Worker, u64, Job)>,
    by_seq: BTreeMap<(Worker, u64), (Job, Epoch)>,
    accepted: BTreeSet<Job>,
    acknowledged: BTreeSet<Job>,
    /// What the disk has, of any life, and what found it.
    kept: BTreeMap<Job, (Digest, Build)>,
    /// Grants whose holders are to be told that nobody wants their job, and that were.
    due: BTreeSet<Epoch>,
    told: BTreeSet<Epoch>,
    full: bool,
    /// Grants whose job a solver has had.
    began: BTreeSet<Epoch>,
    solving: BTreeMap<Worker, (Epoch, Millis)>,
    results: BTreeMap<Worker, Epoch>,
}

impl Checker {
    pub(super) fn new(plan: &Plan, timing: Timing) -> Self {
        let course = |run: &super::plan::Script| Course {
            jobs: run.jobs.iter().map(|(_, job)| *job).collect(),
            ..Course::default()
        };
        Self {
            timing,
            calm: plan.is_calm(),
            runs: plan.runs.iter().map(course).collect(),
            plan: plan.clone(),
            skills: BTreeMap::new(),
            names: BTreeMap::new(),
            isolated: BTreeSet::new(),
            deaths: deaths::Deaths::default(),
            drained: BTreeSet::new(),
            by_hand: BTreeSet::new(),
            lives: lives::Lives::default(),
            chains: chains::Chains::default(),
            jobs: BTreeMap::new(),
            held: BTreeMap::new(),
            epochs: BTreeMap::new(),
            by_seq: BTreeMap::new(),
            accepted: BTreeSet::new(),
            acknowledged: BTreeSet::new(),
            kept: BTreeMap::new(),
            due: BTreeSet::new(),
            told: BTreeSet::new(),
            full: false,
            began: BTreeSet::new(),
            solving: BTreeMap::new(),
            results: BTreeMap::new(),
        }
    }

    /// The coordinator begins a life.
    pub(super) fn life(&mut self) {
        self.jobs.clear();
        self.held.clear();
        self.by_seq.clear();
        self.accepted.clear();
        self.due.clear();
        self.told.clear();
        self.drained.clone_from(&self.by_hand);
        self.deaths = deaths::Deaths::default();
        self.chains = chains::Chains::default();
        self.forget_lives();
        for run in &mut self.runs {
            (run.opened, run.settled, run.waiting) = (0, 0, None);
            (run.paused, run.ended) = (false, false);
        }
    }

    pub(super) fn opened(&self, run: usize) -> usize {
        self.runs[run].opened
    }

    pub(super) fn full(&mut self, run: usize, bound: u64) -> bool {
        self.full = (self.runs[run].opened - self.runs[run].settled) as u64 >= bound;
        self.full
    }

    pub(super) fn open(&mut self, now: Millis, run: usize, job: Job) -> Result<(), Wrong> {
        let maker = self.look_for_maker(run)?;
        self.runs[run].opened += 1;
        self.opened_now(job);
        let known = self.jobs.entry(job).or_default();
        *known.wants.entry(run).or_default() += 1;
        known.maker = known.maker.or(maker);
        self.look_for_waiting(now);
        Ok(())
    }

    pub(super) fn known(&mut self, job: Job) {
        self.over(job, None);
    }

    pub(super) fn keeps(&mut self, job: Job, found: (Digest, Build)) {
        self.kept.insert(job, found);
    }

    pub(super) fn cancelled(&mut self, run: usize) {
        self.runs[run].cancelled = true;
    }

    pub(super) fn paused(&mut self, now: Millis, run: usize, paused: bool) {
        self.runs[run].paused = paused;
        self.look_for_waiting(now);
    }

    /// The runs that want a job now.
    pub(super) fn wanting(&self, job: Job) -> Vec<usize> {
        let known = self.jobs.get(&job);
        known.map(|known| known.wants.keys().copied().collect()).unwrap_or_default()
    }

    pub(super) fn acknowledged(&mut self, job: Job) {
        self.acknowledged.insert(job);
    }

    pub(super) fn isolated(&mut self, job: Job) {
        self.isolated.insert(job);
    }

    /// There is one more worker.
    pub(super) fn hired(&mut self, worker: Worker, skills: Skills, name: WorkerName) {
        self.skills.insert(worker, skills);
        self.names.insert(worker, name);
    }

    /// What a worker is called.
    fn name(&self, worker: Worker) -> WorkerName {
        self.names.get(&worker).copied().unwrap_or(WorkerName(worker.0))
    }

    pub(super) fn crashed(&mut self, worker: Worker) {
        self.solving.remove(&worker);
        self.results.remove(&worker);
    }

    pub(super) fn finished(&self) -> bool {
        self.runs.iter().zip(&self.plan.runs).all(|(run, script)| {
            let ended = run.cancelled || script.chain && run.ended;
            run.settled == run.opened && (ended || run.opened == run.jobs.len())
        })
    }

    pub(super) fn unfinished(&self) -> Wrong {
        let open: Vec<_> = self.runs.iter().map(|r| (r.settled, r.opened, r.jobs.len())).collect();
        let text = format!("settled, opened, all of each run: {open:?}");
        Wrong { oracle: Oracle::Live, text }
    }

    pub(super) fn farewell(&self) -> Result<(), Wrong> {
        if self.runs.iter().any(|run| run.cancelled) {
            return Ok(());
        }
        let stalled = self.jobs.values().any(|job| job.stalled);
        if self.calm && stalled {
            return wrong(Oracle::Truth, "a job was given up in a calm farm");
        }
        Ok(())
    }

    /// Which runs have fresh work from now on, or none any more.
    fn look_for_waiting(&mut self, now: Millis) {
        for (index, run) in self.runs.iter_mut().enumerate() {
            let fresh = |job: &Job| {
                let known = &self.jobs[job];
                let fresh = known.grants == 0 && !known.over && known.wants.contains_key(&index);
                fresh && !self.lives.waits(now, job)
            };
            let open = &run.jobs[run.settled..run.opened];
            let waits = !run.paused && open.iter().any(fresh);
            if !waits {
                (run.waiting, run.overdue) = (None, 0);
            } else if run.waiting.is_none() {
                run.waiting = Some(now);
            }
        }
    }

    /// An event and all that the machine says to it.
    pub(super) fn heard(
        &mut self,
        now: Millis,
        event: Event,
        effects: &[Effect],
    ) -> Result<(), Wrong> {
        self.all_told()?;
        match event {
            Event::Commit { name, job, build, digest, .. } => {
                self.alarmed((job, build, digest), effects)?;
                let known = self.jobs.get(&job).filter(|_| accepts(effects));
                let killers = known.map(|known| known.killers.iter().copied());
                killers.into_iter().for_each(|of| self.deaths.finished(now, name, of));
            }
            Event::Open { .. } => {
                let busy = effects.iter().any(|e| matches!(e, Effect::Busy { .. }));
                if busy != std::mem::take(&mut self.full) {
                    return wrong(Oracle::Bound, format!("taken: {}", !busy));
                }
            }
            Event::Offer { epoch, .. } => {
                if let Some(held) = self.held.get_mut(&epoch).filter(|held| held.now) {
                    held.offered = true;
                }
            }
            Event::Renew { worker, job, epoch, begun, .. } => {
                let wanted = self.jobs.get(&job).is_some_and(|k| !k.over && !k.wants.is_empty());
                let stop = effects.iter().any(|e| matches!(e, Effect::Stop { .. }));
                if !wanted && !stop && !self.is_inherited(job) {
                    return wrong(Oracle::Stop, "told to go on with what nobody wants");
                }
                self.inherited_renewal(now, (worker, job, epoch), begun, effects)?;
            }
            Event::Poll { worker, seq, .. } => {
                self.deaths.asks(now, worker, seq);
                self.questioned(worker, seq);
                self.asked(worker);
            }
            Event::Fail { worker, job, epoch, .. } => self.returned(now, (worker, job, epoch)),
            Event::Release(claimant) => self.released(claimant.0 as usize),
            Event::Down(worker) | Event::Bye(worker) => {
                self.deaths.doubt(worker, true);
                self.silenced(worker);
                self.unparked(worker);
            }
            Event::Suspect(worker) => {
                self.deaths.doubt(worker, false);
                self.unparked(worker);
                let held = self.held.values_mut().filter(|held| held.worker == worker && held.now);
                held.for_each(|held| held.suspect = Some(held.suspect.unwrap_or(now).min(now)));
            }
            Event::Begin { .. }
            | Event::Pause(_)
            | Event::Resume(_)
            | Event::WatchCancel { .. }
            | Event::Cancel(_)
            | Event::End(_)
            | Event::Drain(_)
            | Event::Bar(_)
            | Event::Inherit(..)
            | Event::Isolate(_)
            | Event::Pardon(_)
            | Event::Forsaken => {}
            Event::Tick => self.nothing_waits(now)?,
        }
        Ok(())
    }

    /// One output, as it takes effect.
    pub(super) fn watch(&mut self, now: Millis, event: Event, effect: Effect) -> Result<(), Wrong> {
        match effect {
            Effect::Grant { worker, seq, job, epoch, .. } => {
                self.grant(now, (worker, seq), (job, epoch))?;
                self.answered(worker, seq);
            }
            Effect::Cancel { epoch, .. } => self.tell(epoch),
            Effect::Taken { worker, receipt: Receipt::Accepted } => {
                let Event::Commit { job, epoch, build, .. } = event else {
                    return wrong(Oracle::Once, "accepted what?");
                };
                if self.foreign(job, epoch, build) {
                    return wrong(Oracle::Fence, "a late result of another build counts");
                }
                if !self.accepted.insert(job) {
                    return wrong(Oracle::Once, "one job accepted twice");
                }
                self.mourned(job);
                self.found(job, worker);
                self.over(job, Some(worker));
            }
            Effect::Taken { receipt: Receipt::Unknown, .. } => self.unknown(event)?,
            Effect::Adopted { worker, job, epoch, .. } => {
                self.adopted(now, (worker, job, epoch))?;
            }
            Effect::Taken { receipt: Receipt::Fenced, .. } => {
                let Event::Commit { job, epoch, build, .. } = event else {
                    return wrong(Oracle::Fence, "fenced what?");
                };
                let open = self.jobs.get(&job).is_some_and(|k| !k.over && !k.wants.is_empty());
                if !self.plan.mixed || (open && !self.foreign(job, epoch, build)) {
                    return wrong(Oracle::Fence, "fenced without a reason");
                }
            }
            Effect::Renewed { worker, job, .. } => self.renewed(now, event, worker, job)?,
            Effect::Lost { job, worker, epoch, loss, charged } => {
                self.lost(now, event, (job, worker, epoch), (loss, charged))?;
            }
            Effect::Settle { run, opening, job, verdict, .. } => {
                self.settle((run, opening), job, verdict)?;
            }
            Effect::Alarm { kept, other, .. } if kept == other => {
                return wrong(Oracle::Truth, "alarm over equal results");
            }
            Effect::Stall { job, reason, attempts } => self.stall(now, (job, reason, attempts))?,
            Effect::Doubted { worker } => {
                if !self.doubtful(self.name(worker)) {
                    return wrong(Oracle::Doubted, "told of a name under which too few died");
                }
            }
            Effect::Drained { worker, cause } => {
                self.unparked(worker);
                self.sent_away(event, worker, cause)?;
            }
            Effect::Idle { worker, seq } => self.answered(worker, seq),
            Effect::Park { .. }
            | Effect::Dismiss { .. }
            | Effect::Stop { .. }
            | Effect::Alarm { .. }
            | Effect::Busy { .. }
            | Effect::Quarantine { .. }
            | Effect::Taken { .. } => {}
        }
        self.look_for_waiting(now);
        Ok(())
    }

    /// Whether a result of this grant and build is late, and another build has come after it.
    fn foreign(&self, job: Job, epoch: Epoch, build: Build) -> bool {
        self.jobs.get(&job).is_some_and(|known| {
            let last = known.last.map(|worker| self.plan.build(worker));
            !known.holders.contains(&epoch) && last.is_some_and(|last| last != build)
        })
    }
}
