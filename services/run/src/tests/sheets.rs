//! Windows of sheets: what the world does with what they give.

use super::super::{JobPool, PoolLoad, RunOptions, WantedJob, run};
use super::settlement;
use cullet_geometry::shapes::{Detail, cuboid};
use cullet_geometry::{Pose, Solid, Vec3};
use cullet_model::{
    Handed, MovingSurface, Proxy, ProxyMotion, SettledPiece, SurfaceFrame, SweptExtent, Window,
    WindowOutcome,
};
use cullet_pool::Settlement;
use cullet_proto::recording::SheetWindow;
use cullet_proto::{JobId, Verdict, WindowJob};
use cullet_record::{PoseRow, Recording};
use cullet_scene::load;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Steps of a window in one of the world.
const PARTS: u32 = 64;
/// Stiffness of the net over a body's mass \[1/s²\].
const STIFF: f64 = 4000.0;

/// A pool whose sheets are a spring below z = 0.5 m.
struct Net {
    /// Over a body's mass \[1/s²\].
    stiff: f64,
    /// A part that has come to rest after eight steps, where parts are to become rigid bodies.
    plate: Option<SettledPiece>,
    waiting: RefCell<VecDeque<(JobId, WindowOutcome)>>,
    asked: RefCell<Vec<AskedWindow>>,
}

/// A window that was asked for.
struct AskedWindow {
    id: JobId,
    /// What it follows.
    after: Option<JobId>,
    window: Window,
    /// Where it has each body at its end.
    ends: Vec<Pose>,
}

impl Net {
    fn of(stiff: f64) -> Self {
        Self { stiff, plate: None, waiting: RefCell::default(), asked: RefCell::default() }
    }
}

fn solved(job: &WindowJob, net: &Net) -> WindowOutcome {
    let stiff = net.stiff;
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
                let impulse = Vec3::z() * (stiff * depth * mass * dt);
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
    // The second byte remembers that the plate has become a rigid body.
    let listed = |plate: &SettledPiece| {
        window.retired.as_ref().is_some_and(|list| list.contains(&plate.number))
    };
    let gone = job.state.as_ref().is_some_and(|state| state[1] == 1)
        || net.plate.as_ref().is_some_and(listed);
    let offered = window.retired.is_some() && !gone && window.first_step >= 8;
    WindowOutcome {
        state: vec![before.wrapping_add(1), u8::from(gone)],
        settled: net.plate.iter().filter(|_| offered).cloned().collect(),
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
        let WantedJob::Window { job, after } = job else { panic!("no window") };
        let outcome = solved(job, self);
        let end = |handed: &Handed| *handed.poses.last().expect("a step");
        let (window, ends) = (job.window.clone(), outcome.handed.iter().map(end).collect());
        self.asked.borrow_mut().push(AskedWindow { id, after, window, ends });
        self.waiting.borrow_mut().push_back((id, outcome));
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
    scene_on(&Net::of(STIFF), more, sets)
}

/// The same on another net.
fn scene_on(net: &Net, more: &str, sets: &[&str]) -> (Recording, f64) {
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
    let options = RunOptions::new(out, &stop);
    let outcome = run(&scene, net, &options, &mut |_| {}).expect("a run");
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
    assert_eq!(recording.sheets()[0].frames.len(), 16);
}

/// A fixed box whose top is at z = 0.4 m.
const FLOOR: &str = "[[body]]\nname = \"floor\"\nmaterial = \"soda-lime-glass\"\nfixed = true\n\
                     position = [0.0, 0.0, 0.35]\n\
                     shape = { kind = \"box\", size = [1.0, 1.0, 0.1] }\n";

/// A floor that the window does not know of stops the ball: the window is solved again with the
/// ball led as the world had it, and what the ball was not given is told.
#[test]
fn f90m_a_gap_makes_a_window_be_solved_again() {
    let (recording, _) = scene(FLOOR, &["body.ball.velocity=[0.1, 0.0, -6.0]"]);
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

/// What hits squarely.
const BLOCK: &str = "body.ball.shape={ kind = \"box\", size = [0.1, 0.1, 0.1] }";

/// The window does not know the floor: a block that lies on it stands still there, and does not
/// fall through it by gravity.
#[test]
fn a_body_that_rests_on_something_rigid_is_steady_in_a_window() {
    let net = Net::of(1.0);
    let sets = [
        BLOCK,
        "world.gravity=[0.0, 0.0, -9.81]",
        "body.ball.position=[0.0, 0.0, 0.4502]",
        "body.ball.velocity=[0.0, 0.0, 0.0]",
    ];
    let (recording, step) = scene_on(&net, FLOOR, &sets);
    let end = row_at_the_end(&recording).pose.translation.z;
    assert!((end - 0.45).abs() < 1e-3, "{end}");
    let free = |proxy: &Proxy| !matches!(proxy.motion, ProxyMotion::Steady);
    let asked = net.asked.into_inner();
    // In the first it has not met the floor yet, and falls.
    let first = &asked[0];
    let time = f64::from(first.window.steps) * step;
    let most = 0.5 * 9.81 * time * time;
    assert!(most > 1e-3, "a window is long enough to show the fall: {most} m");
    assert!(first.window.proxies.iter().any(free));
    assert!(first.ends.iter().any(|end| (0.44..0.4495).contains(&end.translation.z)));
    let landed: Vec<_> = asked.iter().filter(|asked| asked.window.first_step >= 12).collect();
    assert!(landed.len() > 10);
    for asked in landed {
        let window = &asked.window;
        let on_the_floor = |proxy: &Proxy| proxy.pose.translation.z > 0.42;
        let ball = window.proxies.iter().position(on_the_floor).expect("the block is near");
        let (begun, ends) = (window.proxies[ball].pose.translation.z, &asked.ends[ball]);
        assert!(!free(&window.proxies[ball]), "step {}", window.first_step);
        assert!((ends.translation.z - begun).abs() < most / 10.0, "step {}", window.first_step);
    }
}

/// A hammer, of which the sheet is out of reach, drives a still block into the sheet within a
/// window that has the block untouched: what the sheet has for it there, a second solve says.
#[test]
fn a_body_that_something_rigid_pushed_into_a_sheet_makes_its_window_be_solved_again() {
    let hammer = "[[body]]\nname = \"hammer\"\nmaterial = \"soda-lime-glass\"\n\
                  breakable = false\nposition = [0.0, 0.0, 0.75]\nvelocity = [0.0, 0.0, -6.0]\n\
                  shape = { kind = \"box\", size = [0.1, 0.1, 0.1] }\n";
    let sets = [BLOCK, "body.ball.position=[0.0, 0.0, 0.54]", "body.ball.velocity=[0.0, 0.0, 0.0]"];
    let net = Net::of(STIFF);
    let (recording, _) = scene_on(&net, hammer, &sets);
    let windows = windows(&recording);
    let driven = windows.iter().find(|window| window.solved > 1).expect("one is solved again");
    assert_eq!(driven.gap, 0.0, "its first solve gave the block nothing: {driven:?}");
    assert_eq!(driven.solved, 2, "once led as the world had it, it does not stray");
    assert!(kept_back(driven) > 0.0, "{driven:?}");
    // Both solves of it follow the window before, and the next follows the second.
    let asked = net.asked.into_inner();
    let of = |first: u64| asked.iter().filter(move |asked| asked.window.first_step == first);
    let both: Vec<_> = of(driven.first_step).collect();
    let before = of(driven.first_step - u64::from(driven.steps)).next_back().map(|asked| asked.id);
    assert_eq!(both.iter().map(|asked| asked.after).collect::<Vec<_>>(), [before; 2]);
    let next = of(driven.first_step + u64::from(driven.steps)).next().expect("a next window");
    assert_eq!(next.after, Some(both[1].id));
    assert!(before.is_some() && asked[0].after.is_none());
}

/// A part of a sheet that has come to rest is a rigid body from the next window on, which is told
/// of it once; where the scene does not want that, nothing is offered and nothing told.
#[test]
fn a_piece_at_rest_becomes_a_rigid_body() {
    let mesh = cuboid(Vec3::new(0.1, 0.1, 0.01), Detail::default()).expect("a plate");
    let solid = Arc::new(Solid::outer(mesh));
    let plate = SettledPiece { number: 3, solid, place: Vec3::new(0.3, 0.3, 0.4052), mass: 0.25 };
    let net = || Net { plate: Some(plate.clone()), ..Net::of(0.0) };
    let sets = ["world.gravity=[0.0, 0.0, -9.81]", "body.ball.position=[0.0, 0.0, 5.0]"];
    let retiring = net();
    let (recording, _) = scene_on(&retiring, &format!("retire = true\n{FLOOR}"), &sets);
    let named = |recording: &Recording| {
        let found = recording.bodies.iter().filter(|body| body.name.contains("piece"));
        found.cloned().collect::<Vec<_>>()
    };
    let bodies = named(&recording);
    let [body] = &bodies[..] else { panic!("{bodies:?}") };
    assert_eq!((body.name.as_str(), body.object.as_str()), ("net-piece-3", "net"));
    assert_eq!((body.birth_step, body.parent), (12, None), "with the third window's end");
    assert!((body.mass / 0.25 - 1.0).abs() < 1e-9, "{}", body.mass);
    let rows = recording.poses.iter().flat_map(PoseRow::of).filter(|row| row.id == body.id);
    let rows: Vec<PoseRow> = rows.collect();
    let (first, last) = (rows.first().expect("a row"), rows.last().expect("a row"));
    assert!((first.pose.translation.vector - plate.place).norm() < 1e-4, "{}", first.pose);
    let on_floor = Vec3::new(0.3, 0.3, 0.405);
    assert!((last.pose.translation.vector - on_floor).norm() < 1e-3, "{}", last.pose);
    assert!(last.velocity.norm() < 0.01, "{}", last.velocity);
    let asked = retiring.asked.into_inner();
    let told: Vec<_> = asked.iter().map(|asked| asked.window.retired.clone()).collect();
    let due = |k: usize| Some(if k == 3 { vec![3] } else { vec![] });
    assert_eq!(told, (0..asked.len()).map(due).collect::<Vec<_>>());
    // It is one of the bodies that the sheet may meet now.
    let met = |k: usize| asked[k].window.proxies.iter().any(|proxy| proxy.body == body.id);
    assert!(!met(2) && met(3));
    let keeping = net();
    let (recording, _) = scene_on(&keeping, FLOOR, &sets);
    assert!(named(&recording).is_empty());
    assert!(keeping.asked.into_inner().iter().all(|asked| asked.window.retired.is_none()));
}
