//! A window, from the wire to what came of it.

use crate::families::CONTINUA;
use crate::solve::JobControl;
use cullet_model::{ContinuumEntry, PreparedBody, Refusal, WindowInProgress, WindowProgress};
use cullet_proto::{Verdict, WindowJob};
use std::sync::{Arc, Mutex, PoisonError};

/// Memory of the bodies that a process keeps prepared \[bytes\]: the next window is most likely of
/// one of them. The one used last is kept however large it is.
const MAX_PREPARED: u64 = 1 << 30;

static PREPARED: Mutex<PreparedBodies> = Mutex::new(PreparedBodies { kept: Vec::new() });

/// Prepared bodies by the digests of their setups, each with its size \[bytes\]; the one used last
/// is last.
struct PreparedBodies {
    kept: Vec<([u8; 32], PreparedBody, u64)>,
}

impl PreparedBodies {
    fn get(&mut self, name: &[u8; 32]) -> Option<PreparedBody> {
        let at = self.kept.iter().position(|(known, ..)| known == name)?;
        let found = self.kept.remove(at);
        let body = found.1.clone();
        self.kept.push(found);
        Some(body)
    }

    /// Keeps a body, and of the others as many as fit beside it, the least recently used ones not.
    fn put(&mut self, name: [u8; 32], body: PreparedBody, bytes: u64, bound: u64) {
        self.kept.retain(|(known, ..)| *known != name);
        let mut held: u64 = self.kept.iter().map(|(.., bytes)| bytes).sum();
        let mut gone = 0;
        for (.., own) in &self.kept {
            if held.saturating_add(bytes) <= bound {
                break;
            }
            held -= own;
            gone += 1;
        }
        self.kept.drain(..gone);
        self.kept.push((name, body, bytes));
    }
}

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
    let kept = lock().get(&name);
    if let Some(body) = kept {
        return Ok(body);
    }
    let body = (entry.prepare)(&job.setup)?;
    lock().put(name, Arc::clone(&body), (entry.bytes)(&body), MAX_PREPARED);
    Ok(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_model::continuum::PREPARED_GUESS;
    use cullet_model::{
        Continuum, ContinuumSetup, Failure, Window, WindowOutcome, continuum_entry,
    };
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

    /// A family that says how large its bodies are: as large as their seeds.
    struct SizedFamily;

    impl Continuum for SizedFamily {
        type Prepared = u64;
        const NAME: &'static str = "sized";

        fn prepare(setup: &ContinuumSetup) -> Result<u64, Refusal> {
            Ok(setup.seed)
        }

        fn open(_: Arc<u64>, _: Option<&[u8]>, _: Window) -> Result<Self, Refusal> {
            Ok(Self)
        }

        fn advance(&mut self) -> WindowProgress {
            WindowProgress::Running(0.0)
        }

        fn bytes(prepared: &u64) -> u64 {
            *prepared
        }
    }

    #[test]
    fn prepared_bodies_are_kept_by_their_bytes_and_the_least_recently_used_goes_first() {
        let body = |bytes: u64| -> PreparedBody { Arc::new(bytes) };
        let (sized, untold) = (continuum_entry::<SizedFamily>(), continuum_entry::<Counter>());
        assert_eq!(((sized.bytes)(&body(70)), (untold.bytes)(&body(70))), (70, PREPARED_GUESS));
        let mut kept = PreparedBodies { kept: Vec::new() };
        let put = |kept: &mut PreparedBodies, name: u8, bytes: u64| {
            kept.put([name; 32], body(bytes), (sized.bytes)(&body(bytes)), 100);
        };
        let names = |kept: &PreparedBodies| kept.kept.iter().map(|k| k.0[0]).collect::<Vec<_>>();
        for (name, bytes) in [(1, 40), (2, 30), (3, 30)] {
            put(&mut kept, name, bytes);
        }
        assert_eq!(names(&kept), [1, 2, 3], "they fill the bound");
        assert!(kept.get(&[1; 32]).is_some() && kept.get(&[9; 32]).is_none());
        put(&mut kept, 4, 40);
        assert_eq!(names(&kept), [1, 4], "30 bytes are not enough for 40");
        put(&mut kept, 1, 60);
        assert_eq!(names(&kept), [4, 1], "the same body counts once");
        put(&mut kept, 5, 101);
        assert_eq!(names(&kept), [5], "one over the bound is kept alone");
        put(&mut kept, 6, 1);
        assert_eq!(names(&kept), [6]);
    }

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
