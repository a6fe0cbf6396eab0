//! A job, from the problem to the verdict.

use crate::families::by_name;
use cullet_fragment::directed::direct;
use cullet_model::{
    ContinuumEntry, Failure, PointPrecision, Progress, Refusal, SolveInProgress, SolveOutcome,
    SolverEntry,
};
use cullet_proto::pool::Family;
use cullet_proto::{FractureJob, Verdict};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};

/// A way to solve: a verdict, or `None` if it was cancelled.
pub type SolveFn = Arc<dyn Fn(&FractureJob, &JobControl) -> Option<Verdict> + Send + Sync>;

/// What a running job shares with its worker: whether it is cancelled, and how far it is.
#[derive(Clone, Debug, Default)]
pub struct JobControl {
    cancelled: Arc<AtomicBool>,
    permille: Arc<AtomicU16>,
}

impl JobControl {
    /// Whether the result is not wanted any more.
    #[must_use]
    pub fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Says that the result is not wanted any more.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Says how far the job is, a share in `[0, 1]`.
    pub fn progress(&self, share: f64) {
        self.permille.store((share.clamp(0.0, 1.0) * 1000.0) as u16, Ordering::Relaxed);
    }

    /// How far the job is \[1/1000\].
    #[must_use]
    pub fn permille(&self) -> u16 {
        self.permille.load(Ordering::Relaxed)
    }
}

/// The families of the table, each with the precisions that it has.
#[must_use]
pub fn families() -> Vec<Family> {
    let has = |entry: &SolverEntry, precision| entry.precisions.contains(&precision);
    let family = |entry: &SolverEntry| Family {
        name: entry.name.into(),
        single: has(entry, PointPrecision::Single),
        double: has(entry, PointPrecision::Double),
    };
    // Windows are worked out in double precision.
    let moving =
        |entry: &ContinuumEntry| Family { name: entry.name.into(), single: false, double: true };
    let solvers = crate::families::FAMILIES.iter().map(family);
    solvers.chain(crate::families::CONTINUA.iter().map(moving)).collect()
}

enum Solved {
    Done(SolveOutcome),
    Refused(String),
    Failed(Failure),
    Cancelled,
}

/// Solves with the family that the job names; if that refuses, cannot cut what it solved, or does
/// not hold for what the body becomes, with its fallback. The report says which ran and why another
/// did not.
#[must_use]
pub fn by_table(job: &FractureJob, watch: &JobControl) -> Option<Verdict> {
    directed(job, with_lookup(job, watch, by_name)?, watch)
}

/// What broke, as the scene wants it to come apart, if it says so.
fn directed(job: &FractureJob, verdict: Verdict, watch: &JobControl) -> Option<Verdict> {
    match (verdict, &job.direction) {
        (Verdict::Solved(SolveOutcome::Broken(found)), Some(direction)) => {
            let cancelled = || watch.cancelled();
            let made = direct(*found, &job.problem, direction, &cancelled)?;
            Some(Verdict::Solved(made.into()))
        }
        (verdict, _) => Some(verdict),
    }
}

fn with_lookup(
    job: &FractureJob,
    watch: &JobControl,
    lookup: impl Fn(&str) -> Option<&'static SolverEntry>,
) -> Option<Verdict> {
    let named = job.solver.clone();
    let other = job.fallback.as_ref().filter(|other| **other != named);
    let refusal = match slices(job, &named, watch, &lookup) {
        Solved::Refused(text) => text,
        // What was solved could not be cut into fragments that may be shown.
        Solved::Failed(failure @ (Failure::Cut(_) | Failure::Beyond { .. })) if other.is_some() => {
            failure.to_string()
        }
        Solved::Done(outcome) => return Some(Verdict::Solved(outcome)),
        Solved::Failed(failure) => return Some(failed(named, &failure.to_string())),
        Solved::Cancelled => return None,
    };
    let Some(other) = other else {
        return Some(Verdict::Refused { solver: named, text: refusal });
    };
    match slices(job, other, watch, &lookup) {
        Solved::Refused(text) => {
            let text = format!("{refusal}; {other}: {text}");
            Some(Verdict::Refused { solver: named, text })
        }
        Solved::Done(mut outcome) => {
            outcome.report_mut().refusal = Some(refusal);
            Some(Verdict::Solved(outcome))
        }
        Solved::Failed(failure) => Some(failed(other.clone(), &failure.to_string())),
        Solved::Cancelled => None,
    }
}

fn failed(solver: String, text: &str) -> Verdict {
    Verdict::Failed { solver, text: text.to_owned() }
}

fn slices(
    job: &FractureJob,
    name: &str,
    watch: &JobControl,
    lookup: &impl Fn(&str) -> Option<&'static SolverEntry>,
) -> Solved {
    let Some(entry) = lookup(name) else {
        return Solved::Refused(format!("no solver is named {name:?} here"));
    };
    let begun: Result<Box<dyn SolveInProgress>, Refusal> = (entry.begin)(job.problem.clone());
    let mut run = match begun {
        Ok(run) => run,
        Err(refusal) => return Solved::Refused(refusal.to_string()),
    };
    while !watch.cancelled() {
        match run.advance() {
            Progress::Running(share) => watch.progress(share),
            Progress::Done(outcome) => return Solved::Done(outcome),
            Progress::Failed(failure) => return Solved::Failed(failure),
        }
    }
    Solved::Cancelled
}

/// Solves, and makes a verdict of a panic too: a job is pure, so it would panic anywhere.
pub(crate) fn guarded(solver: &str, solve: impl FnOnce() -> Option<Verdict>) -> Option<Verdict> {
    catch_unwind(AssertUnwindSafe(solve)).unwrap_or_else(|panic| {
        Some(failed(solver.to_owned(), &format!("the solver panicked: {}", words(&*panic))))
    })
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_model::{
        ArtDirection, Cost, FragmentOrigin, Fragmentation, Problem, Report, Solver,
    };

    struct Slow(u32);

    impl SolveInProgress for Slow {
        fn advance(&mut self) -> Progress {
            self.0 += 1;
            match self.0 {
                0..=3 => Progress::Running(f64::from(self.0) / 4.0),
                _ => {
                    let solver = "slow".to_owned();
                    let report = Report { solver, ..Report::default() };
                    Progress::Done(Fragmentation { report, ..Fragmentation::default() }.into())
                }
            }
        }
    }

    struct Picky;

    impl Solver for Picky {
        const NAME: &'static str = "picky";
        const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Double];
        fn accepts(_: &Problem) -> Result<Cost, Refusal> {
            Err(Refusal::TooThin { thickness: 1e-3, cells: 1.0, minimum: 3.0 })
        }
        fn begin(_: Problem) -> Result<Self, Refusal> {
            Ok(Self)
        }
        fn advance(&mut self) -> Progress {
            Progress::Failed(Failure::OutOfSteps { steps: 0 })
        }
    }

    fn refuse(problem: Problem) -> Result<Box<dyn SolveInProgress>, Refusal> {
        Picky::accepts(&problem)?;
        Ok(Box::new(Picky::begin(problem)?))
    }

    /// Solves, and has no cut.
    struct Uncut;

    impl SolveInProgress for Uncut {
        fn advance(&mut self) -> Progress {
            let why = "crack faces lie along the grid's planes 21.9 times as often as chance (F22)";
            Progress::Failed(Failure::Cut(why.to_owned()))
        }
    }

    /// Finds that it does not hold for what the body becomes.
    struct Shallow;

    impl SolveInProgress for Shallow {
        fn advance(&mut self) -> Progress {
            let what = "a plastic strain of 0.4; bonds hold up to 0.3".to_owned();
            Progress::Failed(Failure::Beyond { what, step: 7 })
        }
    }

    const TABLE: [SolverEntry; 5] = [
        SolverEntry {
            name: "shallow",
            precisions: &[PointPrecision::Double],
            begin: |_| Ok(Box::new(Shallow)),
        },
        SolverEntry {
            name: "slow",
            precisions: &[PointPrecision::Double],
            begin: |_| Ok(Box::new(Slow(0))),
        },
        SolverEntry { name: "picky", precisions: &[PointPrecision::Double], begin: refuse },
        SolverEntry {
            name: "sick",
            precisions: &[PointPrecision::Double],
            begin: |_| Ok(Box::new(Picky)),
        },
        SolverEntry {
            name: "uncut",
            precisions: &[PointPrecision::Double],
            begin: |_| Ok(Box::new(Uncut)),
        },
    ];
    static ENTRIES: [SolverEntry; 5] = TABLE;

    fn lookup(name: &str) -> Option<&'static SolverEntry> {
        ENTRIES.iter().find(|entry| entry.name == name)
    }

    fn job(solver: &str, fallback: Option<&str>) -> FractureJob {
        FractureJob { fallback: fallback.map(Into::into), ..FractureJob::smallest(solver, 0) }
    }

    #[test]
    fn a_refusal_falls_back_and_the_report_says_so() {
        let solved = with_lookup(&job("picky", Some("slow")), &JobControl::default(), lookup);
        let Some(Verdict::Solved(outcome)) = solved else { panic!("{solved:?}") };
        assert_eq!(outcome.report().solver, "slow");
        assert!(outcome.report().refusal.as_ref().is_some_and(|text| text.starts_with("too thin")));
    }

    /// F22: a body whose cut shows the grid is handed over, and the report says why; where there is
    /// no other family, it has failed.
    #[test]
    fn what_cannot_be_cut_is_handed_over() {
        let ask = |b: Option<&str>| with_lookup(&job("uncut", b), &JobControl::default(), lookup);
        let solved = ask(Some("slow"));
        let Some(Verdict::Solved(outcome)) = solved else { panic!("{solved:?}") };
        assert_eq!(outcome.report().solver, "slow");
        let why = outcome.report().refusal.clone().expect("why");
        assert!(why.starts_with("the cut failed: ") && why.contains("21.9 times"), "{why}");
        assert!(matches!(ask(None), Some(Verdict::Failed { .. })));
    }

    #[test]
    fn what_nobody_takes_is_refused_and_what_goes_wrong_is_failed() {
        let ask =
            |a: &str, b: Option<&str>| with_lookup(&job(a, b), &JobControl::default(), lookup);
        for (first, second) in [("picky", None), ("picky", Some("picky")), ("none", Some("nor"))] {
            let solved = ask(first, second);
            assert!(matches!(&solved, Some(Verdict::Refused { solver, .. }) if solver == first));
        }
        assert!(matches!(ask("sick", Some("slow")), Some(Verdict::Failed { .. })));
        assert!(
            matches!(ask("slow", None), Some(Verdict::Solved(o)) if o.report().refusal.is_none())
        );
    }

    /// What a body becomes may be another family's; without one it is a failure.
    #[test]
    fn what_a_method_does_not_hold_for_goes_to_the_fallback() {
        let ask = |fallback| {
            let watch = JobControl::default();
            with_lookup(&job("shallow", fallback), &watch, lookup).expect("not cancelled")
        };
        let words = "at step 7: a plastic strain of 0.4; bonds hold up to 0.3";
        let Verdict::Solved(outcome) = ask(Some("slow")) else { panic!("not solved") };
        let refusal = outcome.report().refusal.clone().expect("why");
        assert!(refusal.contains(words), "{refusal}");
        let Verdict::Failed { text, .. } = ask(None) else { panic!("no failure") };
        assert!(text.contains(words), "{text}");
    }

    #[test]
    fn cancel_is_seen_between_slices_and_progress_is_told() {
        let watch = JobControl::default();
        with_lookup(&job("slow", None), &watch, lookup);
        assert_eq!(watch.permille(), 750);
        watch.cancel();
        assert_eq!(with_lookup(&job("slow", None), &watch, lookup), None);
    }

    /// Whatever family found the fragments.
    #[test]
    fn what_broke_comes_apart_as_the_scene_wants() {
        let mut job = FractureJob::smallest("geometric", 3);
        job.problem.impacts[0].energy = 1e4;
        job.problem.impacts[0].closing_speed = 60.0;
        job.problem.settings.max_fragments = 9;
        let found = |job: &FractureJob| match by_table(job, &JobControl::default()) {
            Some(Verdict::Solved(outcome)) => outcome.fracture().expect("a fracture"),
            other => panic!("{other:?}"),
        };
        let plain = found(&job);
        assert!((2..=9).contains(&plain.fragments.len()), "{}", plain.fragments.len());
        let direction = ArtDirection { pieces: Some(30), ..ArtDirection::default() };
        job.direction = Some(direction);
        let made = found(&job);
        assert!((24..=36).contains(&made.fragments.len()), "{}", made.fragments.len());
        let directed = made.origins.iter().filter(|it| **it == FragmentOrigin::Directed).count();
        assert!(directed >= 21, "{directed} directed");
        assert_eq!(made.report.fracture_energy, plain.report.fracture_energy, "at no cost");
        let gone = JobControl::default();
        gone.cancel();
        assert_eq!(by_table(&job, &gone), None);
    }

    #[test]
    fn a_panic_is_a_verdict() {
        let solve: SolveFn = Arc::new(|_, _| panic!("index out of range"));
        let (job, watch) = (job("slow", None), JobControl::default());
        let verdict = guarded("slow", || solve(&job, &watch));
        let Some(Verdict::Failed { text, .. }) = verdict else { panic!("{verdict:?}") };
        assert_eq!(text, "the solver panicked: index out of range");
    }
}
