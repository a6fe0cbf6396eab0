//! The workers of the simulated farm.

use super::super::check::{Wrong, result_of, twin_of};
use super::{Body, CONTROL, Farm, HEAL, Note};
use crate::*;

impl Farm {
    pub(super) fn born(&mut self, place: usize) -> Result<(), Wrong> {
        let worker = Worker(self.rng.next());
        let name = self.plan.name(worker, place);
        self.check.hired(worker, self.plan.workers[place], name);
        self.places.insert(worker, place);
        let sick = self.bad(self.plan.chaos.sick) && self.bodies.len() < 3;
        let sick = sick || self.plan.bad.contains(&place);
        let mut machine = WorkerMachine::default();
        machine.mutant = self.mutant;
        let body = Body { machine, frozen: 0, cut: 0, asks: 0, sick, waking: Millis::MAX };
        self.bodies.insert(worker, body);
        self.hear(worker, WorkerInput::Begin, None)
    }

    /// A worker hears something, unless it is stopped: then later.
    pub(super) fn hear(
        &mut self,
        worker: Worker,
        heard: WorkerInput,
        note: Option<Note>,
    ) -> Result<(), Wrong> {
        let now = self.now;
        let Some(body) = self.bodies.get_mut(&worker) else {
            return Ok(());
        };
        if body.frozen > now {
            let after = body.frozen - now;
            if let Some(note) = note {
                self.post(after, note);
            }
            return Ok(());
        }
        let before = body.machine.at();
        let acts = body.machine.step(now, heard);
        self.check.worker(now, worker, heard, before, &acts)?;
        for act in acts {
            self.does(worker, act)?;
        }
        self.schedule(worker);
        Ok(())
    }

    fn schedule(&mut self, worker: Worker) {
        let now = self.now;
        let Some(body) = self.bodies.get_mut(&worker) else {
            return;
        };
        if let Some(at) = body.machine.wake().map(|at| at.max(now + 1))
            && at < body.waking
        {
            body.waking = at;
            self.post(at - now, Note::Wake(worker));
        }
    }

    pub(super) fn wake(&mut self, worker: Worker) -> Result<(), Wrong> {
        let chaos = self.plan.chaos;
        if self.bad(chaos.crash) {
            self.crash(worker);
            return Ok(());
        }
        if self.bad(chaos.suspect) {
            self.post(1, Note::Link(Event::Suspect(worker)));
        }
        let (pause, cut) = (self.bad(chaos.pause), self.bad(chaos.cut));
        let length = self.rng.below(5_000);
        let now = self.now;
        let Some(body) = self.bodies.get_mut(&worker) else {
            return Ok(());
        };
        body.waking = Millis::MAX;
        if pause {
            body.frozen = body.frozen.max(now + length);
        }
        if cut {
            body.cut = body.cut.max(now + length);
        }
        if body.frozen > now {
            body.waking = body.frozen;
            let after = body.frozen - now;
            self.post(after, Note::Wake(worker));
            return Ok(());
        }
        self.hear(worker, WorkerInput::Tick, None)
    }

    pub(super) fn crash(&mut self, worker: Worker) {
        if self.bodies.remove(&worker).is_none() {
            return;
        }
        self.check.crashed(worker);
        if !self.rng.chance(self.plan.chaos.silent) {
            let after = 1 + self.rng.below(self.plan.chaos.delay + 1);
            let sure = self.rng.chance(50);
            let event = if sure { Event::Down(worker) } else { Event::Suspect(worker) };
            self.post(after, Note::Link(event));
        }
        let after = 100 + self.rng.below(1_000);
        self.post(after, Note::Born(self.places[&worker]));
    }

    fn does(&mut self, worker: Worker, act: WorkerOutput) -> Result<(), Wrong> {
        match act {
            WorkerOutput::Ask(question) => self.ask(worker, question),
            WorkerOutput::Fetch(work) => {
                let epoch = work.epoch;
                let cut = self.bodies.get(&worker).is_some_and(|body| body.cut > self.now);
                let there = self.machine.as_ref().is_some_and(|m| m.wants(work.job));
                let trouble = Trouble::Dropped;
                let heard = if there && !cut {
                    WorkerInput::Fetched { epoch }
                } else {
                    WorkerInput::Trouble { epoch, trouble }
                };
                let after = 1 + self.rng.below(100);
                self.post(after, Note::Own(worker, heard));
            }
            WorkerOutput::Solve(work) => self.solve(worker, work),
            WorkerOutput::Kill(_) => {}
            WorkerOutput::Leave => {
                self.bodies.remove(&worker);
                let after = 100 + self.rng.below(1_000);
                self.post(after, Note::Born(self.places[&worker]));
            }
        }
        Ok(())
    }

    fn ask(&mut self, worker: Worker, question: Question) {
        let Some(body) = self.bodies.get_mut(&worker) else {
            return;
        };
        if let Question::Renew { .. } = question {
            return self.send(worker, Note::Asked(worker, question));
        }
        body.asks += 1;
        let asks = body.asks;
        let poll = matches!(question, Question::Poll { .. });
        let patience = if poll { self.timing.park + 2 * CONTROL } else { CONTROL };
        let late = if self.now < HEAL { self.plan.chaos.delay } else { 0 };
        self.send(worker, Note::Asked(worker, question));
        self.post(patience + late, Note::Timeout(worker, question, asks));
    }

    fn solve(&mut self, worker: Worker, work: Work) {
        let Work { job, epoch, .. } = work;
        let after = 20 + self.rng.below(self.plan.length);
        let sick = self.bodies.get(&worker).is_some_and(|body| body.sick);
        if self.plan.poison.contains(&job) {
            // The supervisor lives, but for one that is not told apart from its job.
            if self.rng.chance(30) {
                return self.crash(worker);
            }
            let trouble = Trouble::Crashed;
            self.post(after, Note::Own(worker, WorkerInput::Trouble { epoch, trouble }));
        } else if self.plan.wedge.contains(&job) {
            // Nothing ever comes of it.
        } else if sick {
            let trouble = Trouble::Crashed;
            self.post(after, Note::Own(worker, WorkerInput::Trouble { epoch, trouble }));
        } else {
            let mut digest = result_of(job, self.plan.build(worker));
            if self.bad(self.plan.chaos.flaky) {
                digest = twin_of(digest);
            }
            self.post(after, Note::Own(worker, WorkerInput::Solved { epoch, digest }));
        }
    }
}
