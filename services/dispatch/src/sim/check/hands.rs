//! What must hold of each worker.

use super::{Checker, Oracle, Wrong, wrong};
use crate::*;

impl Checker {
    /// A worker's side: what it heard, and does.
    pub(in super::super) fn worker(
        &mut self,
        now: Millis,
        worker: Worker,
        heard: WorkerInput,
        before: Option<Work>,
        acts: &[WorkerOutput],
    ) -> Result<(), Wrong> {
        let killed = acts.iter().any(|act| matches!(act, WorkerOutput::Kill(_)));
        if let Some((epoch, since)) = self.solving.get(&worker).copied() {
            let slack = self.timing.renew + 1;
            match heard {
                WorkerInput::Stop { epoch: e } if e == epoch && !killed => {
                    return wrong(Oracle::Stop, "goes on though told to stop");
                }
                WorkerInput::Tick if !killed && now > since + self.timing.hard + slack => {
                    return wrong(Oracle::Watchdog, "solves for ever");
                }
                _ => {}
            }
        }
        if let WorkerInput::Receipt { epoch, .. } | WorkerInput::Trouble { epoch, .. } = heard
            && self.results.get(&worker) == Some(&epoch)
        {
            self.results.remove(&worker);
        }
        for act in acts {
            match act {
                WorkerOutput::Solve(work) => {
                    let Work { job, epoch, .. } = *work;
                    let said = WorkerOutput::Ask(Question::Renew { job, epoch, begun: true });
                    if acts.iter().take_while(|other| *other != act).all(|other| *other != said) {
                        return wrong(Oracle::Poison, "a solver has a job, and nobody is told");
                    }
                    let hard = before.map_or(work.hard, |work| work.hard);
                    let left = self.timing.hard.saturating_sub(hard);
                    self.began.insert(work.epoch);
                    self.solving.insert(worker, (work.epoch, now.saturating_sub(left)));
                }
                WorkerOutput::Kill(_) | WorkerOutput::Leave => {
                    self.solving.remove(&worker);
                }
                WorkerOutput::Ask(Question::Commit { epoch, .. }) => {
                    self.solving.remove(&worker);
                    self.results.insert(worker, *epoch);
                }
                WorkerOutput::Ask(Question::Fail { .. }) => {
                    self.solving.remove(&worker);
                }
                WorkerOutput::Ask(Question::Poll { .. }) if self.results.contains_key(&worker) => {
                    return wrong(Oracle::Result, "a result is thrown away");
                }
                WorkerOutput::Ask(_) | WorkerOutput::Fetch(_) => {}
            }
        }
        Ok(())
    }
}
