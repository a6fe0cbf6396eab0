//! A window, from the wire to what came of it.

use crate::families::CONTINUA;
use crate::solve::JobControl;
use cullet_model::{ContinuumEntry, PreparedBody, Refusal, WindowInProgress, WindowProgress};
use cullet_proto::{Verdict, WindowJob};
use std::sync::{Mutex, PoisonError};

/// Bodies that a process keeps prepared: the next window is most likely of one of them.
const KEPT: usize = 8;

/// A prepared body, by the digest of its setup; the one used last is last.
static PREPARED: Mutex<Vec<([u8; 32], PreparedBody)>> = Mutex::new(Vec::new());

/// Solves a window with the family that it names. `None`: it was cancelled.
pub(crate) fn solve(job: &WindowJob, watch: &JobControl) -> Option<Verdict> {
    solve_with(job, watch, CONTINUA)
}

fn solve_with(job: &WindowJob, watch: &JobControl, table: &[ContinuumEntry]) -> Option<Verdict> {
    let solver = job.family.clone();
    let Some(entry) = table.iter().find(|entry| entry.name == solver) else {
        let text = format!("no family is named {solver:?} here");
        return Some(Verdict::Refused { solver, text });
    };
    let mut run = match begun(job, entry) {
        Ok(run) => run,
        Err(refusal) => return Some(Verdict::Refused { solver, text: refusal.to_string() }),
    };
    while !watch.cancelled() {
        match run.advance() {
            WindowProgress::Running(share) => watch.progress(share),
            WindowProgress::Done(outcome) => return Some(Verdict::Moved(outcome)),
            WindowProgress::Failed(failure) => {
                return Some(Verdict::Failed { solver, text: failure.to_string() });
            }
        }
    }
    None
}

fn begun(job: &WindowJob, entry: &ContinuumEntry) -> Result<Box<dyn WindowInProgress>, Refusal> {
    let prepared = prepared(job, entry)?;
    let state = job.state.as_ref().map(|state| state.as_slice());
    (entry.open)(&prepared, state, job.window.clone())
}

fn prepared(job: &WindowJob, entry: &ContinuumEntry) -> Result<PreparedBody, Refusal> {
    let lock = || PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
    // A setup that has no digest was not decoded from one.
    let Ok(name) = job.setup_digest() else { return (entry.prepare)(&job.setup) };
    let mut kept = lock();
    if let Some(at) = kept.iter().position(|(known, _)| *known == name) {
        let found = kept.remove(at);
        kept.push(found.clone());
        return Ok(found.1);
    }
    drop(kept);
    let body = (entry.prepare)(&job.setup)?;
    let mut kept = lock();
    if kept.len() >= KEPT {
        kept.remove(0);
    }
    kept.push((name, body.clone()));
    Ok(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_model::{
        Continuum, ContinuumSetup, Failure, Window, WindowOutcome, continuum_entry,
    };
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    static PREPARATIONS: AtomicU32 = AtomicU32::new(0);

    /// Counts steps; fails where its state says so.
    struct Counter {
        count: u8,
        left: u32,
    }

    impl Continuum for Counter {
        type Prepared = u64;
        const NAME: &'static str = "counter";

        fn prepare(setup: &ContinuumSetup) -> Result<u64, Refusal> {
            PREPARATIONS.fetch_add(1, Ordering::Relaxed);
            match setup.seed {
                0 => Err(Refusal::Unfit { solver: "counter", lack: "no seed".to_owned() }),
                seed => Ok(seed),
            }
        }

        fn open(_: Arc<u64>, state: Option<&[u8]>, window: Window) -> Result<Self, Refusal> {
            let count = state.map_or(0, |state| state[0]);
            Ok(Self { count, left: window.steps })
        }

        fn advance(&mut self) -> WindowProgress {
            if self.count == 99 {
                return WindowProgress::Failed(Failure::OutOfSteps { steps: 99 });
            }
            if self.left == 0 {
                let outcome = WindowOutcome { state: vec![self.count], ..WindowOutcome::default() };
                return WindowProgress::Done(Box::new(outcome));
            }
            (self.count, self.left) = (self.count + 1, self.left - 1);
            WindowProgress::Running(0.5)
        }
    }

    const TABLE: &[ContinuumEntry] = &[continuum_entry::<Counter>()];

    #[test]
    fn a_chain_of_windows_goes_from_state_to_state_and_prepares_its_body_once() {
        let watch = JobControl::default();
        let ask = |job: &WindowJob| solve_with(job, &watch, TABLE);
        let mut job = WindowJob::smallest("counter", 7);
        for count in [4, 8, 12] {
            let Some(Verdict::Moved(outcome)) = ask(&job) else { panic!("no outcome") };
            assert_eq!(outcome.state, [count]);
            job.state = Some(Arc::new(outcome.state));
        }
        assert_eq!(PREPARATIONS.load(Ordering::Relaxed), 1);
        job.state = Some(Arc::new(vec![99]));
        let failed = ask(&job);
        assert!(matches!(failed, Some(Verdict::Failed { .. })), "{failed:?}");
        let refused = ask(&WindowJob::smallest("counter", 0));
        assert!(
            matches!(&refused, Some(Verdict::Refused { text, .. }) if text.contains("no seed")),
            "{refused:?}"
        );
        let stranger = ask(&WindowJob::smallest("stranger", 7));
        assert!(matches!(stranger, Some(Verdict::Refused { .. })), "{stranger:?}");
        watch.cancel();
        assert_eq!(ask(&job), None);
    }
}
