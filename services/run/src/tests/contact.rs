//! Which object of the scene a rigid body is, for a sheet that takes something up from one.

use super::super::{JobPool, PoolLoad, RunOptions, WantedJob, run};
use super::{halves, settlement};
use cullet_model::{Handed, Proxy, SweptExtent, Window, WindowOutcome};
use cullet_pool::Settlement;
use cullet_proto::{JobId, Verdict};
use cullet_record::Recording;
use cullet_scene::load;
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A pool that cuts cubes into halves, and whose sheets touch nothing and reach everything.
#[derive(Default)]
struct Reaching {
    waiting: RefCell<VecDeque<(JobId, Verdict)>>,
    asked: RefCell<Vec<Window>>,
}

fn untouched(window: &Window) -> WindowOutcome {
    let still = |proxy: &Proxy| Handed {
        body: proxy.body,
        impulses: vec![Default::default(); window.steps as usize],
        poses: Vec::new(),
    };
    WindowOutcome {
        state: vec![1],
        extent: SweptExtent { low: [-1.0; 3], high: [1.0; 3], speed: 0.0, spacing: 0.02 },
        handed: window.proxies.iter().map(still).collect(),
        ..WindowOutcome::default()
    }
}

impl JobPool for Reaching {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let id = JobId::of(&job.encode().expect("a job"));
        let verdict = match job {
            WantedJob::Window { job, .. } => {
                self.asked.borrow_mut().push(job.window.clone());
                Verdict::Moved(Box::new(untouched(&job.window)))
            }
            _ => halves(0.01).into(),
        };
        self.waiting.borrow_mut().push_back((id, verdict));
        id
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let (id, verdict) = self.waiting.borrow_mut().pop_front()?;
        Some((id, settlement(verdict)))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

/// The object that windows name of each body, by the body's own object in the recording.
fn objects(source: &str) -> BTreeMap<String, Vec<Option<u32>>> {
    let cubes = include_str!("../../../../tests/corpus/drop.toml");
    let text = format!(
        "{cubes}\n[[sheet]]\nname = \"cloth\"\nmaterial = \"pmma\"\nthickness = 0.001\n\
         size = [1.0, 1.0]\nposition = [0.0, 0.0, 0.5]\n\
         diffusion = {{ source = [{{ {source}, film = 1e-4, towards = 1 }}] }}\n"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("a file");
    let scene = load(Path::new(&file), &["world.duration=0.05".to_owned()]).expect("a scene");
    let (pool, stop, out) = (Reaching::default(), AtomicBool::new(false), folder.path());
    let outcome = run(&scene, &pool, &RunOptions::new(out, &stop), &mut |_| {});
    let recording = Recording::open(&outcome.expect("a run").recording).expect("a recording");
    assert!(recording.bodies.len() > scene.bodies.len(), "the cubes break");
    let mut found: BTreeMap<String, Vec<Option<u32>>> = BTreeMap::new();
    for proxy in pool.asked.into_inner().iter().flat_map(|window| &window.proxies) {
        let body = recording.bodies.iter().find(|body| body.id == proxy.body);
        let object = body.expect("a recorded body").object.clone();
        found.entry(object).or_default().push(proxy.object);
    }
    found
}

/// Bodies and their fragments have the number of their object in the scene; a sheet that asks for
/// none is told none, so that its jobs are what they were.
#[test]
fn windows_say_of_which_object_a_body_is() {
    let found = objects("body = \"left\"");
    assert_eq!(found.len(), 3);
    for (object, number) in [("floor", 0), ("left", 1), ("right", 2)] {
        assert!(found[object].iter().all(|told| *told == Some(number)), "{object}: {found:?}");
    }
    // There are windows with both halves of a cube.
    assert!(found["left"].len() > found["floor"].len(), "{found:?}");
    let found = objects("patch = { centre = [0, 0], radius = 0.1 }");
    assert!(found.values().flatten().all(Option::is_none), "{found:?}");
}
