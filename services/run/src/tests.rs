mod contact;
mod dent;
mod directed;
mod hits;
mod resting;
mod sheets;
mod solids;

use super::{JobPool, PoolLoad, RunOptions, WantedJob, run};
use cullet_geometry::shapes::{Detail, cuboid};
use cullet_geometry::{Pose, Sheet, Solid, Vec3};
use cullet_model::{Fragment, Fragmentation, Report};
use cullet_pool::{JobEnding, Settlement};
use cullet_proto::recording::EventKind;
use cullet_proto::{JobId, Verdict};
use cullet_record::Recording;
use cullet_scene::load;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A pool that cuts a cube of 10 cm into halves, with a crack whose area is off by a fifth a
/// millimetre of the grid, and fails on grids below a bound \[m\].
struct Halver {
    fails_below: f64,
    waiting: RefCell<VecDeque<(JobId, f64)>>,
    /// The job, its spacing \[m\], and whether another family might have taken it.
    asked: RefCell<Vec<(JobId, f64, bool)>>,
}

impl JobPool for Halver {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let WantedJob::Fracture(job) = job else { panic!("no fracture") };
        let id = JobId::of(&job.encode().expect("a job"));
        let spacing = job.problem.settings.spacing.unwrap_or(0.0);
        self.waiting.borrow_mut().push_back((id, spacing));
        self.asked.borrow_mut().push((id, spacing, job.fallback.is_some()));
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let (id, spacing) = self.waiting.borrow_mut().pop_front()?;
        let verdict = if spacing < self.fails_below {
            Verdict::Failed { solver: "brittle".to_owned(), text: "it ran away".to_owned() }
        } else {
            halves(spacing).into()
        };
        Some((id, settlement(verdict)))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

/// A verdict as a pool of one brings it.
fn settlement(verdict: Verdict) -> Settlement {
    Settlement {
        ending: JobEnding::Verdict(verdict),
        attempts: 1,
        worker: "w".to_owned(),
        wall: Duration::ZERO,
        cached: false,
        overdue: false,
        tries: Vec::new(),
        reproduction: None,
    }
}

fn halves(spacing: f64) -> Fragmentation {
    let half = |x: f64| {
        let mesh = cuboid(Vec3::new(0.05, 0.1, 0.1), Detail::default()).expect("a box");
        let mesh = mesh.translated(Vec3::new(x, 0.0, 0.0));
        let hulls = vec![mesh.vertices.clone()];
        let (still, sheet) = (Vec3::zeros(), Sheet::default());
        Fragment { solid: Solid::outer(mesh), hulls, velocity: still, spin: still, sheet }
    };
    let crack_area = 0.01 * (1.0 + 200.0 * spacing);
    let report = Report { solver: "brittle".to_owned(), spacing, crack_area, ..Report::default() };
    Fragmentation { fragments: vec![half(-0.025), half(0.025)], report, ..Default::default() }
}

/// Spacings asked of the first hit \[m\], that of the solve whose halves are in the world, and all
/// that the events say.
fn dropped(fails_below: f64) -> (Vec<f64>, f64, String) {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/corpus/drop.toml");
    let sets = [
        "body.right.breakable=false",
        "fidelity.error=0.15",
        "fracture.max_particles=1000000",
        "world.duration=0.02",
    ];
    let scene = load(Path::new(scene), &sets.map(str::to_owned)).expect("a scene");
    let (waiting, asked) = (RefCell::default(), RefCell::default());
    let (pool, out) =
        (Halver { fails_below, waiting, asked }, tempfile::tempdir().expect("a folder"));
    let (stop, out) = (AtomicBool::new(false), out.path());
    let outcome = run(&scene, &pool, &RunOptions::new(out, &stop), &mut |_| {});
    let recording = Recording::open(&outcome.expect("a run").recording).expect("a recording");
    let broken = recording.events.iter().find(|event| event.kind() == EventKind::Fractured);
    let broken = broken.expect("the cube breaks");
    let asked = pool.asked.into_inner();
    let first: Vec<_> = asked.into_iter().take_while(|job| job.1 > 0.0).take(4).collect();
    assert!(first.iter().all(|job| !job.2), "there is always a solve to fall back on: {first:?}");
    let used = first.iter().find(|job| job.0.0[..] == broken.job[..]).expect("one of the four");
    // What its pieces are measured in is that solve's grid, whatever came after it.
    assert_eq!(recording.spacings().get(&broken.body.expect("a body")), Some(&used.1));
    // At rest the halves lie where they were cut from the cube.
    let (rest, cube) = (recording.rest_poses(), broken.body.expect("a body"));
    for (part, x) in broken.fragments.iter().zip([-0.025, 0.025]) {
        let within = rest[&cube].inv_mul(&rest[part]);
        let off = within.to_homogeneous() - Pose::translation(x, 0.0, 0.0).to_homogeneous();
        assert!(off.norm() < 1e-9, "{within}");
    }
    let told: Vec<&str> = recording.events.iter().map(|event| event.text.as_str()).collect();
    (first.iter().map(|job| job.1).collect(), used.1, told.join("\n"))
}

/// Points allow half of the plan's spacing, and the error asks for it.
#[test]
fn the_finest_solve_is_used_beyond_the_plan() {
    let (spacings, used, told) = dropped(0.0);
    let plan = 0.1 / 24.0;
    assert!((spacings[2] - plan).abs() < 1e-9, "{spacings:?}");
    assert_eq!(spacings[3], spacings[2] / 2.0);
    assert_eq!(used, spacings[3]);
    assert!(told.contains("over 0.15; finer than planned: 2.083e-3 m, "), "{told}");
    assert!(told.contains("none below 2.000e-3 m by the most points"), "{told}");
}

/// A finer solve that fails takes nothing away: the one before it is used, and that is reported.
#[test]
fn the_solve_before_one_that_fails_is_used() {
    let (spacings, used, told) = dropped(3e-3);
    assert_eq!(spacings.len(), 4);
    assert_eq!(used, spacings[2]);
    assert!(told.contains("brittle: it ran away; the solve before it is used"), "{told}");
}
