//! The simulated farm: clock, network, journal, workers, coordinator.

mod bodies;
mod disk;
mod openings;

use super::check::{Checker, Oracle, Wrong};
use super::plan::{Plan, Rng};
use crate::mutant::Mutant;
use crate::*;
use disk::{Disk, Found};
use std::collections::{BTreeMap, BTreeSet};

/// Faults end here \[ms\].
pub(super) const HEAL: Millis = 12_000;
/// Everything is settled by then \[ms\].
const END: Millis = 3_600_000;
/// How often the coordinator looks at its clock \[ms\].
const TICK: Millis = 100;
/// A question that is answered at once is given up after this \[ms\].
const CONTROL: Millis = 500;

#[derive(Clone, Copy, Debug)]
enum Note {
    /// A question of a worker reaches the coordinator.
    Asked(Worker, Question),
    /// An answer reaches a worker.
    Told(Worker, WorkerInput),
    /// A worker's transport gives a question up.
    Timeout(Worker, Question, u64),
    /// Something in a worker's own process.
    Own(Worker, WorkerInput),
    Wake(Worker),
    /// One more worker, in that place.
    Born(usize),
    Link(Event),
    Open(usize),
    Cancel(usize),
    Pause(usize, bool),
    Drain(usize),
    Tick,
    Restart,
    /// A planted bug: the disk hears of a result at last, if the coordinator still lives.
    Kept(Job, Found, u32),
}

struct Body {
    machine: WorkerMachine,
    frozen: Millis,
    cut: Millis,
    asks: u64,
    /// Jobs die here.
    sick: bool,
    waking: Millis,
}

pub(super) struct Farm {
    plan: Plan,
    rng: Rng,
    now: Millis,
    notes: BTreeMap<(Millis, u64), Note>,
    posted: u64,
    timing: Timing,
    machine: Option<Dispatch>,
    disk: Disk,
    paused: BTreeSet<usize>,
    /// Jobs of each chain that were done in this life of the coordinator.
    done: Vec<usize>,
    bodies: BTreeMap<Worker, Body>,
    /// The place of each worker that ever was.
    places: BTreeMap<Worker, usize>,
    pub(super) check: Checker,
    mutant: Option<Mutant>,
    pub(super) events: u64,
}

impl Farm {
    pub(super) fn new(plan: &Plan, mutant: Option<Mutant>) -> Self {
        let timing = Timing { max_open: plan.max_open, hard: 6_000, ..Timing::test() };
        let opened = vec![0; plan.runs.len()];
        let mut farm = Self {
            rng: Rng(plan.seed ^ 0x1234_5678_9abc),
            now: 0,
            notes: BTreeMap::new(),
            posted: 0,
            timing,
            machine: None,
            disk: Disk { opened, ..Disk::default() },
            paused: BTreeSet::new(),
            done: vec![0; plan.runs.len()],
            bodies: BTreeMap::new(),
            places: BTreeMap::new(),
            check: Checker::new(plan, timing),
            mutant,
            events: 0,
            plan: plan.clone(),
        };
        for place in 0..plan.workers.len() {
            farm.post(0, Note::Born(place));
        }
        for (index, run) in plan.runs.iter().enumerate() {
            if let Some(at) = run.cancel {
                farm.post(at, Note::Cancel(index));
            }
            if let Some((from, to)) = run.pause {
                farm.post(from, Note::Pause(index, true));
                farm.post(to, Note::Pause(index, false));
            }
        }
        for (at, place) in &plan.drains {
            farm.post(*at, Note::Drain(*place));
        }
        farm.post(0, Note::Tick);
        farm
    }

    fn is(&self, mutant: Mutant) -> bool {
        self.mutant == Some(mutant)
    }

    fn bad(&mut self, percent: u64) -> bool {
        self.now < HEAL && percent > 0 && self.rng.chance(percent)
    }

    fn post(&mut self, after: Millis, note: Note) {
        self.posted += 1;
        self.notes.insert((self.now + after, self.posted), note);
    }

    /// Over the network, from or to a worker: lost, copied, late.
    fn send(&mut self, worker: Worker, note: Note) {
        if self.bodies.get(&worker).is_some_and(|body| body.cut > self.now) {
            return;
        }
        let copies = 1 + u64::from(self.bad(self.plan.chaos.twice));
        for _ in 0..copies {
            if !self.bad(self.plan.chaos.drop) {
                let late = if self.now < HEAL { self.plan.chaos.delay } else { 0 };
                let after = 1 + self.rng.below(3) + self.rng.below(late + 1);
                self.post(after, note);
            }
        }
    }

    /// Until everything is done, or something is wrong.
    pub(super) fn run(&mut self) -> Result<(), Wrong> {
        self.restart()?;
        while let Some((key, note)) = self.notes.pop_first() {
            self.now = key.0;
            self.events += 1;
            if self.now > END {
                return Err(self.check.unfinished());
            }
            self.take(note)?;
            if self.now > HEAL && self.machine.is_some() && self.check.finished() {
                return self.check.farewell();
            }
        }
        Err(self.check.unfinished())
    }

    fn take(&mut self, note: Note) -> Result<(), Wrong> {
        match note {
            Note::Asked(worker, question) => self.asked(worker, question),
            Note::Told(worker, heard) | Note::Own(worker, heard) => {
                self.hear(worker, heard, Some(note))
            }
            Note::Timeout(worker, question, asks) => {
                if self.bodies.get(&worker).is_some_and(|body| body.asks == asks) {
                    return self.hear(worker, WorkerInput::Silence(question), Some(note));
                }
                Ok(())
            }
            Note::Wake(worker) => self.wake(worker),
            Note::Born(place) => self.born(place),
            Note::Link(event) => self.step(event),
            Note::Open(run) => self.open(run),
            Note::Cancel(run) => {
                self.disk.cancelled.insert(run);
                self.check.cancelled(run);
                self.step(Event::Cancel(number(run)))?;
                self.step(Event::Release(claimant(run)))
            }
            Note::Pause(run, paused) => self.pause(run, paused),
            Note::Drain(place) => self.drain(place),
            Note::Tick => {
                self.post(TICK, Note::Tick);
                self.step(Event::Tick)
            }
            Note::Restart => self.restart(),
            Note::Kept(job, found, life) => {
                if self.machine.is_some() && self.disk.incarnation == life {
                    self.keep(job, found);
                }
                Ok(())
            }
        }
    }

    fn pause(&mut self, run: usize, paused: bool) -> Result<(), Wrong> {
        let run_number = number(run);
        let event = if paused { Event::Pause(run_number) } else { Event::Resume(run_number) };
        if paused {
            self.paused.insert(run);
        } else {
            self.paused.remove(&run);
        }
        if self.machine.is_some() {
            self.check.paused(self.now, run, paused);
        }
        self.step(event)
    }

    /// The coordinator begins a life, with what its disk holds.
    fn restart(&mut self) -> Result<(), Wrong> {
        if !self.is(Mutant::IncarnationForgotten) {
            self.disk.incarnation += 1;
        }
        let mut machine = Dispatch::new(self.timing, self.disk.incarnation);
        machine.state.mutant = self.mutant;
        self.machine = Some(machine);
        self.check.life();
        self.done.fill(0);
        for worker in self.disk.drained.clone() {
            self.step(Event::Bar(worker))?;
        }
        for (job, run) in self.disk.at_work(&mut self.rng) {
            self.check.inherits(self.now, job, run);
            self.step(Event::Inherit(job, claimant(run)))?;
        }
        for job in self.disk.quarantine.clone() {
            self.step(Event::Isolate(job))?;
        }
        for run in 0..self.plan.runs.len() {
            let share = self.plan.runs[run].share;
            self.step(Event::Begin { run: number(run), share })?;
            if self.paused.contains(&run) {
                self.pause(run, true)?;
            }
            // It is done again from its beginning, which may take a while.
            if self.disk.incarnation > 1 && self.rng.chance(50) {
                let after = self.rng.below(3_000);
                self.post(after, Note::Open(run));
            } else {
                self.open(run)?;
            }
        }
        Ok(())
    }

    /// Whoever is at that place gets no more, if there is anybody.
    fn drain(&mut self, place: usize) -> Result<(), Wrong> {
        let at = |worker: &&Worker| self.places.get(*worker) == Some(&place);
        match self.bodies.keys().find(at).copied() {
            Some(worker) => self.step(Event::Drain(worker)),
            None => Ok(()),
        }
    }

    fn fall(&mut self) {
        self.machine = None;
        let after = 100 + self.rng.below(3_000);
        self.post(after, Note::Restart);
    }

    /// One event for the coordinator; its outputs one by one, between any two of which it may die.
    fn step(&mut self, event: Event) -> Result<(), Wrong> {
        self.step_then(event, |_, _, _| ())
    }

    fn step_then(
        &mut self,
        event: Event,
        mut answer: impl FnMut(&mut Self, Effect, &mut bool),
    ) -> Result<(), Wrong> {
        let Some(machine) = self.machine.as_mut() else {
            return Ok(());
        };
        let effects = machine.step(self.now, event);
        self.check.heard(self.now, event, &effects)?;
        for effect in effects {
            if self.bad(self.plan.chaos.fall) && self.rng.chance(20) {
                self.fall();
                return Ok(());
            }
            self.check.watch(self.now, event, effect)?;
            if let Effect::Grant { job, .. } = effect {
                let runs = self.check.wanting(job);
                self.disk.granted.entry(job).or_default().extend(runs);
            }
            if let Effect::Drained { worker, cause: Cause::Asked } = effect {
                self.disk.drained.insert(worker);
            }
            let mut said = false;
            answer(self, effect, &mut said);
            if !said {
                self.act(effect);
            }
        }
        Ok(())
    }

    fn act(&mut self, effect: Effect) {
        let (worker, heard) = match effect {
            Effect::Quarantine { job, .. } => {
                self.disk.quarantine.insert(job);
                return self.check.isolated(job);
            }
            Effect::Grant { worker, seq, job, epoch, hard, .. } => {
                (worker, WorkerInput::Grant { seq, work: self.work(job, epoch, hard) })
            }
            Effect::Idle { worker, seq } => (worker, WorkerInput::Idle { seq }),
            Effect::Dismiss { worker, seq } => (worker, WorkerInput::Dismiss { seq }),
            Effect::Cancel { worker, epoch, .. } => (worker, WorkerInput::Stop { epoch }),
            Effect::Settle { run, verdict, .. } => return self.settled(run, verdict),
            _ => return,
        };
        self.send(worker, Note::Told(worker, heard));
    }

    fn work(&self, job: Job, epoch: Epoch, hard: Millis) -> Work {
        Work { job, epoch, renew: self.timing.renew, hard }
    }

    /// As the coordinator's shell does it.
    fn asked(&mut self, worker: Worker, question: Question) -> Result<(), Wrong> {
        if self.machine.is_none() {
            return Ok(());
        }
        match question {
            Question::Poll { seq } => self.step(self.poll(worker, seq, true)),
            Question::Renew { job, epoch, begun } => {
                let (build, skills, name) = self.about(worker);
                let event = Event::Renew { worker, job, epoch, begun, build, skills, name };
                self.step_then(event, |farm, effect, said| {
                    if let Effect::Stop { .. } = effect {
                        *said = true;
                        farm.send(worker, Note::Told(worker, WorkerInput::Stop { epoch }));
                    }
                })
            }
            Question::Commit { job, epoch, .. } if self.bad(self.plan.chaos.drop) => {
                // Pieces are missing; the worker sends them, and this again.
                self.step(Event::Offer { job, epoch })
            }
            Question::Commit { job, epoch, digest, next } => {
                self.commit((worker, job, epoch), digest, Outcome::Broken, next)
            }
            Question::Fail { job, epoch, trouble } => {
                self.step(Event::Fail { worker, job, epoch, trouble })?;
                self.noted(worker);
                Ok(())
            }
            Question::Bye => {
                self.step(Event::Bye(worker))?;
                self.noted(worker);
                Ok(())
            }
        }
    }

    fn poll(&self, worker: Worker, seq: u64, park: bool) -> Event {
        let (build, skills, name) = self.about(worker);
        Event::Poll { worker, seq, slots: 1, park, build, skills, name }
    }

    /// What a worker runs, what it can do, and what it is called.
    fn about(&self, worker: Worker) -> (Build, Skills, WorkerName) {
        let place = self.places[&worker];
        (self.plan.build(worker), self.plan.workers[place], self.plan.name(worker, place))
    }

    /// The disk keeps a result.
    fn keep(&mut self, job: Job, found: Found) {
        self.disk.results.insert(job, found);
        self.check.keeps(job, (found.0, found.2));
    }

    fn noted(&mut self, worker: Worker) {
        if self.machine.is_some() {
            self.send(worker, Note::Told(worker, WorkerInput::Noted));
        }
    }

    /// First the disk has the result, then the machine hears of it, then the worker.
    fn commit(
        &mut self,
        (worker, job, epoch): (Worker, Job, Epoch),
        digest: Digest,
        outcome: Outcome,
        next: u64,
    ) -> Result<(), Wrong> {
        let (build, _, name) = self.about(worker);
        let taken = self.machine.as_ref().is_some_and(|machine| machine.takes(job, epoch, build));
        if taken && !self.is(Mutant::AckedBeforeKept) {
            self.keep(job, (digest, outcome, build));
        }
        let mut accepted = false;
        let known = self.machine.as_ref().is_some_and(|machine| machine.knows(job));
        let prior = if known { Prior::Nothing } else { self.disk.prior(job) };
        let event = Event::Commit { worker, name, job, epoch, build, digest, outcome, prior };
        self.step_then(event, |_, effect, _| {
            accepted |= matches!(effect, Effect::Taken { receipt: Receipt::Accepted, .. });
        })?;
        let mut granted = None;
        self.step_then(self.poll(worker, next, false), |farm, effect, said| match effect {
            Effect::Grant { worker: to, seq, job, epoch, hard, .. }
                if to == worker && seq == next =>
            {
                (*said, granted) = (true, Some(farm.work(job, epoch, hard)));
            }
            Effect::Idle { worker: to, seq } if to == worker && seq == next => *said = true,
            _ => {}
        })?;
        if self.machine.is_some() {
            if accepted {
                self.check.acknowledged(job);
            }
            self.send(worker, Note::Told(worker, WorkerInput::Receipt { epoch, next: granted }));
        }
        if self.is(Mutant::AckedBeforeKept) && accepted {
            let found = (digest, outcome, build);
            self.post(500, Note::Kept(job, found, self.disk.incarnation));
        }
        Ok(())
    }
}

pub(super) fn number(run: usize) -> Run {
    Run(run as u64)
}

fn claimant(run: usize) -> Claimant {
    Claimant(run as u64)
}

/// Runs a schedule; what is wrong with it.
pub(super) fn try_plan(plan: &Plan, mutant: Option<Mutant>) -> Result<u64, Wrong> {
    let mut farm = Farm::new(plan, mutant);
    farm.run().map(|()| farm.events)
}

/// The mildest schedule that still fails at the same oracle, and how.
pub(super) fn shrink(plan: &Plan, mutant: Option<Mutant>, oracle: Oracle) -> (Plan, Option<Wrong>) {
    let (mut best, mut why) = (plan.clone(), None);
    'milder: loop {
        for less in best.milder() {
            match try_plan(&less, mutant) {
                Err(wrong) if wrong.oracle == oracle => {
                    (best, why) = (less, Some(wrong));
                    continue 'milder;
                }
                Ok(_) | Err(_) => {}
            }
        }
        return (best, why);
    }
}
