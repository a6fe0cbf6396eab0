//! Hits that the scene gives settings of their own.

use super::super::{JobPool, Outcome, PoolLoad, RunOptions, WantedJob, run};
use cullet_pool::{JobEnding, Settlement};
use cullet_proto::recording::EventKind;
use cullet_proto::{FractureJob, JobId, Verdict};
use cullet_record::Recording;
use cullet_scene::Scene;
use std::cell::RefCell;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A pool that refuses every job, and keeps what it was asked.
#[derive(Default)]
struct Refuser {
    waiting: RefCell<Vec<JobId>>,
    asked: RefCell<Vec<FractureJob>>,
}

impl JobPool for Refuser {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let WantedJob::Fracture(job) = job else { panic!("a fracture") };
        let id = JobId::of(&job.encode().expect("a job"));
        self.waiting.borrow_mut().push(id);
        self.asked.borrow_mut().push(job.clone());
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let id = self.waiting.borrow_mut().pop()?;
        let verdict = Verdict::Refused { solver: "stub".into(), text: "never".into() };
        let (ending, worker) = (JobEnding::Verdict(verdict), String::new());
        let (wall, tries) = (Duration::ZERO, Vec::new());
        let (cached, overdue, reproduction) = (false, false, None);
        let settlement =
            Settlement { ending, attempts: 1, worker, wall, cached, overdue, tries, reproduction };
        Some((id, settlement))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

/// A cube that bounces on a floor: each of its hits is asked for, and leaves it whole.
const BOUNCING: &str = r#"
[world]
duration = 2.0
impulse_threshold = 0.01
[[material]]
name = "lively"
preset = "plaster"
restitution = 0.9
[[body]]
name = "floor"
shape = { kind = "box", size = [4, 4, 0.2] }
position = [0, 0, -0.1]
material = "granite"
fixed = true
[[body]]
name = "cube"
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
position = [0, 0, 0.3]
velocity = [0, 0, -4]
material = "lively"
"#;

/// What is asked of the pool and when \[s\], what came of the run, and what it said.
struct Bounced {
    jobs: Vec<FractureJob>,
    times: Vec<f64>,
    outcome: Outcome,
    lines: Vec<String>,
}

/// Runs the scene with more text behind it and values set.
fn bounced(more: &str, set: &[&str]) -> Bounced {
    let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    let text = format!("{BOUNCING}{more}");
    let scene = Scene::parse("bouncing", &text, &set).unwrap_or_else(|why| panic!("{why}"));
    let (out, stop) = (tempfile::tempdir().expect("a folder"), AtomicBool::new(false));
    let (pool, mut lines) = (Refuser::default(), Vec::new());
    let options = RunOptions::new(out.path(), &stop);
    let outcome = run(&scene, &pool, &options, &mut |news| {
        if let super::super::News::Line(line) = news {
            lines.push(line.clone());
        }
    });
    let outcome = outcome.unwrap_or_else(|why| panic!("{why}"));
    let recording = Recording::open(&outcome.recording).expect("reads");
    let opened = recording.events.iter().filter(|event| event.kind() == EventKind::JobOpened);
    let times: Vec<f64> = opened.map(|event| event.time).collect();
    let jobs = pool.asked.take();
    assert_eq!(times.len(), jobs.len());
    Bounced { jobs, times, outcome, lines }
}

#[test]
fn one_hit_gets_its_settings_and_the_others_keep_theirs() {
    let Bounced { jobs: plain, outcome: before, .. } = bounced("", &[]);
    assert!(plain.len() >= 3, "{} hits", plain.len());
    assert_eq!(before.summary.directed, None);
    let set = ["hit.cube.seed=77", "hit.cube.particles=9000", "hit.cube.solver=geometric"];
    let Bounced { jobs, outcome: after, lines, .. } = bounced("", &set);
    assert_eq!(jobs.len(), plain.len(), "no hit breaks it: the same way");
    let first = (&jobs[0], &plain[0]);
    assert_ne!(first.0.problem.seed, first.1.problem.seed);
    assert_eq!(first.0.problem.settings.max_particles, 9000);
    assert_eq!((first.0.solver.as_str(), first.1.solver.as_str()), ("geometric", "brittle"));
    // Another body of the same seed has other flaws, and so has another seed of the same body.
    let seed = |job: &FractureJob| match &job.problem.law {
        cullet_model::Law::Brittle { strength, .. } => strength.seed,
        other => panic!("{other:?}"),
    };
    assert_ne!(seed(first.0), seed(first.1));
    assert_eq!(jobs[1..], plain[1..], "byte for byte");
    assert_eq!(after.summary.directed.as_ref().map(|directed| directed.hits), Some(1));
    assert_ne!(after.summary.digest, before.summary.digest);
    let told = "1 hit solved with settings of its own";
    assert!(lines.iter().any(|line| line.contains(told)), "{lines:?}");
}

#[test]
fn a_hit_is_the_first_from_its_time_on_and_one_that_never_comes_is_told_of() {
    let Bounced { jobs: plain, times, .. } = bounced("", &[]);
    let changed = |jobs: &[FractureJob]| -> Vec<usize> {
        (0..plain.len()).filter(|&k| jobs[k] != plain[k]).collect()
    };
    let hits = |run: &Bounced| run.outcome.summary.directed.as_ref().map(|it| it.hits);
    // A time as `cullet inspect` shows it.
    let second = format!("{:.4}", times[1]);
    let run = bounced("", &["hit.cube.seed=5", &format!("hit.cube.at={second}")]);
    assert_eq!((changed(&run.jobs), hits(&run)), (vec![1], Some(1)), "{times:?}");
    let entry =
        |at: &str, seed: u32| format!("[[hit]]\nbody = \"cube\"\nat = {at}\nseed = {seed}\n");
    let run = bounced(&(entry("0", 5) + &entry(&second, 6)), &[]);
    assert_eq!((changed(&run.jobs), hits(&run)), (vec![0, 1], Some(2)));
    // Two that wait for one hit: the later is meant, and the other is about no later hit.
    let early = format!("{:.4}", 0.5 * (times[0] + times[1]));
    let run = bounced(&(entry(&early, 5) + &entry(&second, 6)), &[]);
    assert_eq!((changed(&run.jobs), hits(&run)), (vec![1], Some(1)), "{times:?}");
    let told = "warning: hit[0] had no effect: hit[1] is about the same hit of `cube`";
    assert!(run.lines.iter().any(|line| line.starts_with(told)), "{:?}", run.lines);
    // This pool refuses all.
    let told = "warning: hit[1] had no effect: no solve of that hit of `cube` came to an end";
    assert!(run.lines.iter().any(|line| line == told), "{:?}", run.lines);
    let run = bounced("", &["hit.cube.seed=5", "hit.cube.at=100"]);
    assert_eq!((changed(&run.jobs), hits(&run)), (Vec::new(), None));
    let told = "warning: hit[0] had no effect: no hit of `cube` from 100 s on was solved";
    assert!(run.lines.iter().any(|line| line == told), "{:?}", run.lines);
}
