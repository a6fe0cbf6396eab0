//! Windows of sheets: what the world does with what they give.

use super::super::{JobPool, PoolLoad, RunOptions, WantedJob, run};
use super::settlement;
use cullet_geometry::Vec3;
use cullet_model::{Handed, MovingSurface, ProxyMotion, SurfaceFrame, SweptExtent, WindowOutcome};
use cullet_pool::Settlement;
use cullet_proto::recording::SheetWindow;
use cullet_proto::{JobId, Verdict, WindowJob};
use cullet_record::{PoseRow, Recording};
use cullet_scene::load;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Steps of a window in one of the world.
const PARTS: u32 = 64;
/// Stiffness of the net over a body's mass \[1/s²\].
const STIFF: f64 = 4000.0;

/// A pool whose sheets are a spring below z = 0.5 m.
#[derive(Default)]
struct Net {
    waiting: RefCell<VecDeque<(JobId, WindowOutcome)>>,
}

fn solved(job: &WindowJob) -> WindowOutcome {
    let (window, gravity) = (&job.window, job.setup.gravity);
    let dt = job.setup.world_step / f64::from(PARTS);
    let handed = window.proxies.iter().map(|proxy| {
        let (mut at, mut velocity) = (proxy.pose, proxy.velocity);
        let (mut impulses, mut poses) = (Vec::new(), Vec::new());
        for step in 0..window.steps {
            let mut given = Vec3::zeros();
            let from = at.translation.vector;
            for part in 1..=PARTS {
                let mass = match &proxy.motion {
                    ProxyMotion::Free { mass, .. } => *mass,
                    ProxyMotion::Steady | ProxyMotion::Led(_) => 1.0,
                };
                let depth = (0.5 - at.translation.z).max(0.0);
                let impulse = Vec3::z() * (STIFF * depth * mass * dt);
                given += impulse;
                match &proxy.motion {
                    ProxyMotion::Free { mass, .. } => {
                        velocity += gravity * dt + impulse / *mass;
                        at.translation.vector += velocity * dt;
                    }
                    ProxyMotion::Steady => at.translation.vector += velocity * dt,
                    ProxyMotion::Led(poses) => {
                        let to = poses[step as usize].translation.vector;
                        let share = f64::from(part) / f64::from(PARTS);
                        at.translation.vector = from + (to - from) * share;
                    }
                }
            }
            if let ProxyMotion::Led(poses) = &proxy.motion {
                at = poses[step as usize];
            }
            impulses.push([given, Vec3::zeros()]);
            poses.push(at);
        }
        Handed { body: proxy.body, impulses, poses }
    });
    let before = job.state.as_ref().map_or(0, |state| state[0]);
    let reference = vec![[-0.5, -0.5], [0.5, -0.5], [0.0, 0.5]];
    let frame = |step| SurfaceFrame {
        step,
        surface: 0,
        origin: Vec3::new(0.0, 0.0, 0.5),
        offsets: reference.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
        quantity: Vec::new(),
    };
    let first = window.first_step;
    let steps = (first + 1).min(first)..=first + u64::from(window.steps);
    let shown = |step: &u64| {
        (*step > first || first == 0) && step.is_multiple_of(u64::from(window.frame_every))
    };
    WindowOutcome {
        state: vec![before.wrapping_add(1)],
        extent: SweptExtent { low: [-0.5; 3], high: [0.5; 3], speed: 1.0, spacing: 0.02 },
        handed: handed.collect(),
        frames: steps.filter(shown).map(frame).collect(),
        surfaces: vec![MovingSurface { triangles: vec![[0, 1, 2]], reference, thickness: 1e-3 }],
        ..WindowOutcome::default()
    }
}

impl JobPool for Net {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let id = JobId::of(&job.encode().expect("a job"));
        let WantedJob::Window(job) = job else { panic!("no window") };
        self.waiting.borrow_mut().push_back((id, solved(job)));
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let (id, outcome) = self.waiting.borrow_mut().pop_front()?;
        Some((id, settlement(Verdict::Moved(Box::new(outcome)))))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

/// A ball that falls on a net, and what else there is.
fn scene(more: &str, sets: &[&str]) -> (Recording, f64) {
    let text = format!(
        "description = \"a ball on a net\"\n\
         [world]\nduration = 0.25\ngravity = [0.0, 0.0, 0.0]\n\
         [[body]]\nname = \"ball\"\nmaterial = \"soda-lime-glass\"\nbreakable = false\n\
         position = [0.0, 0.0, 0.6]\nvelocity = [0.1, 0.0, -3.0]\n\
         shape = {{ kind = \"sphere\", radius = 0.05 }}\n\
         [[sheet]]\nname = \"net\"\nmaterial = \"soda-lime-glass\"\nthickness = 0.001\n\
         size = [1.0, 1.0]\nposition = [0.0, 0.0, 0.5]\n{more}"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("a file");
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let scene = load(Path::new(&file), &sets).expect("a scene");
    let (stop, out) = (AtomicBool::new(false), folder.path());
    let options = RunOptions { out, stop: &stop };
    let outcome = run(&scene, &Net::default(), &options, &mut |_| {}).expect("a run");
    let recording = Recording::open(&outcome.recording).expect("a recording");
    assert_eq!(recording.summary().digest, outcome.summary.digest);
    (recording, scene.world.step)
}

fn windows(recording: &Recording) -> Vec<&SheetWindow> {
    recording.windows.iter().collect()
}

/// Impulse of a window that bodies were not given \[N·s\].
fn kept_back(window: &SheetWindow) -> f64 {
    let told = window.figures.iter().find(|figure| figure.name.starts_with("impulse that"));
    told.expect("the figure").value
}

fn row_at_the_end(recording: &Recording) -> PoseRow {
    PoseRow::of(recording.poses.last().expect("poses")).next().expect("a row")
}

/// A body that meets nothing rigid is where its window has it, to rounding, and has the momentum
/// that it was given.
#[test]
fn a_ball_on_a_net_leaves_no_gap() {
    let (recording, step) = scene("", &[]);
    let windows = windows(&recording);
    assert_eq!(windows.len(), 15);
    assert!(windows.iter().all(|window| window.solved == 1 && window.gap < 1e-12), "{windows:?}");
    assert!(windows.iter().all(|window| kept_back(window) == 0.0), "{windows:?}");
    // The same spring, on its own: it is a chain of windows that changes nothing.
    let dt = step / f64::from(PARTS);
    let (mut z, mut velocity) = (0.6_f64, -3.0);
    for _ in 0..60 * PARTS {
        velocity += dt * STIFF * (0.5 - z).max(0.0);
        z += velocity * dt;
    }
    let end = row_at_the_end(&recording);
    assert!(velocity > 1.0, "{velocity}");
    assert!((end.velocity.z - velocity).abs() < 1e-9, "{} {velocity}", end.velocity.z);
    assert!((end.pose.translation.z - z).abs() < 1e-9, "{} {z}", end.pose.translation.z);
    assert_eq!(recording.sheets()[0].frames.len(), 8);
}

/// A floor that the window does not know of stops the ball: the window is solved again with the
/// ball led as the world had it, and what the ball was not given is told.
#[test]
fn a_gap_makes_a_window_be_solved_again() {
    let floor = "[[body]]\nname = \"floor\"\nmaterial = \"soda-lime-glass\"\nfixed = true\n\
                 position = [0.0, 0.0, 0.35]\n\
                 shape = { kind = \"box\", size = [1.0, 1.0, 0.1] }\n";
    let (recording, _) = scene(floor, &["body.ball.velocity=[0.1, 0.0, -6.0]"]);
    let windows = windows(&recording);
    let again: Vec<&&SheetWindow> = windows.iter().filter(|window| window.solved > 1).collect();
    assert!(!again.is_empty());
    for window in again {
        assert!(window.gap > 0.01, "{window:?}");
        assert_eq!(window.solved, 2, "once led as the world had it, it has no gap");
        assert!(kept_back(window) > 0.0, "{window:?}");
    }
}

/// One-way: the ball goes its way through the net, and that is told.
#[test]
fn what_one_way_keeps_back_is_told() {
    let (recording, _) = scene("coupling = \"one-way\"\n", &[]);
    let end = row_at_the_end(&recording);
    assert!(end.pose.translation.z < -0.1, "{}", end.pose);
    let windows = windows(&recording);
    assert!(windows.iter().all(|window| window.one_way && window.solved == 1));
    assert!(windows.iter().filter(|window| kept_back(window) > 0.0).count() > 5);
}
