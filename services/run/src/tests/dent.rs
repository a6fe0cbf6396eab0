//! A family that deforms and does not break, from the solver over the wire into the world and the
//! recording, and back out of it.

use super::super::{JobPool, PoolLoad, RunOptions, WantedJob, run};
use super::settlement;
use cullet_geometry::{Solid, Vec3};
use cullet_model::{
    BodyShape, BrittleProblem, Cost, Deformation, PointPrecision, Problem, Progress, Refusal,
    Report, SolveInProgress, SolveOutcome, Solver, SolverEntry, entry,
};
use cullet_pool::Settlement;
use cullet_proto::recording::EventKind;
use cullet_proto::{FractureJob, JobId, Verdict};
use cullet_record::{Inspection, Recording, inspect};
use cullet_scene::load;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Presses a body flat by a tenth along the push, whatever it is made of.
struct Press(BrittleProblem);

impl Solver for Press {
    const NAME: &'static str = "press";
    const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Double];

    fn accepts(_: &Problem) -> Result<Cost, Refusal> {
        Ok(Cost { particles: 0.0, steps: 1.0, bytes: 0.0 })
    }

    fn begin(problem: Problem) -> Result<Self, Refusal> {
        Ok(Self(BrittleProblem::of(problem, Self::NAME)?))
    }

    fn advance(&mut self) -> Progress {
        let Self(problem) = self;
        let hit = problem.impacts[0];
        let mut mesh = problem.solid.mesh.clone();
        mesh.vertices.iter_mut().for_each(|p| *p -= hit.normal * (0.1 * p.dot(&hit.normal)));
        let hulls = vec![mesh.vertices.clone()];
        let mass = problem.material.density * problem.solid.mesh.signed_volume();
        let work = 0.1 * hit.energy;
        let report = Report { solver: Self::NAME.to_owned(), steps: 1, ..Report::default() };
        Progress::Done(SolveOutcome::Deformed(Box::new(Deformation {
            body: Solid::outer(mesh).into(),
            hulls,
            velocity: hit.normal * (hit.impulse / mass),
            spin: Vec3::zeros(),
            work,
            reactions: vec![0.0; problem.supports.len()],
            report: report.with("plastic_work", "J", work),
        })))
    }
}

/// A pool of one that knows no other family.
struct Pressing {
    waiting: RefCell<VecDeque<FractureJob>>,
    /// Mass of the body of each job, by its law and its mesh \[kg\].
    masses: RefCell<Vec<f64>>,
}

const PRESS: SolverEntry = entry::<Press>();

impl JobPool for Pressing {
    fn open(&self, job: WantedJob<'_>) -> JobId {
        let bytes = job.encode().expect("a job");
        self.waiting.borrow_mut().push_back(FractureJob::decode(&bytes).expect("the same job"));
        JobId::of(&bytes)
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        let job = self.waiting.borrow_mut().pop_front()?;
        let id = job.id().expect("a job");
        let BodyShape::Solid(solid) = &job.problem.body else { panic!("another body") };
        let mass = job.problem.law.density() * solid.mesh.signed_volume();
        self.masses.borrow_mut().push(mass);
        let mut solve: Box<dyn SolveInProgress> = (PRESS.begin)(job.problem).expect("a solve");
        let Progress::Done(outcome) = solve.advance() else { panic!("not done") };
        let bytes = Verdict::Solved(outcome).encode().expect("a verdict");
        Some((id, settlement(Verdict::decode(&bytes).expect("the same verdict"))))
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

/// The recording of two cubes that fall on the floor, what `inspect` says of it, and the masses of
/// the jobs.
fn dented() -> (Recording, Inspection, Vec<f64>) {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/corpus/drop.toml");
    let sets = ["body.right.breakable=false", "world.duration=0.3"].map(str::to_owned);
    let scene = load(Path::new(scene), &sets).expect("a scene");
    let pool = Pressing { waiting: RefCell::default(), masses: RefCell::default() };
    let (out, stop) = (tempfile::tempdir().expect("a folder"), AtomicBool::new(false));
    let options = RunOptions::new(out.path(), &stop);
    let outcome = run(&scene, &pool, &options, &mut |_| {}).expect("a run");
    let recording = Recording::open(&outcome.recording).expect("a recording");
    assert_eq!(recording.summary(), outcome.summary, "read back from the messages alone");
    let said = inspect(&outcome.recording).expect("a recording");
    (recording, said, pool.masses.into_inner())
}

#[test]
fn a_dent_goes_into_the_world_and_comes_out_of_the_recording() {
    let (recording, said, masses) = dented();
    let summary = &said.summary;
    assert!(summary.deformed >= 1 && summary.fractures == 0 && summary.fragments == 0, "{said:?}");
    assert!(summary.ledger.mass_rel_error < 1e-12 && summary.ledger.momentum_rel_error < 1e-9);
    assert!(summary.ledger.energy_gain_rel < 1e-9 && summary.open_fragments == 0);
    assert_eq!(recording.shapes.len() as u64, summary.deformed);
    assert!(said.events.iter().any(|line| line.contains(" is deformed: ")), "{:?}", said.events);
    // The mesh in the recording is that of the solver, moved to its centre of mass, bit for bit.
    let shape = &recording.shapes[0];
    let body = recording.bodies.iter().find(|body| body.id == shape.body).expect("a body");
    let solid = |hash: &[u8]| Solid::try_from(&recording.geometries[hash]).expect("a solid");
    let (old, new) = (solid(&body.geometry), solid(&shape.geometry));
    assert_eq!(recording.geometry_of(body.id, shape.step - 1), Some(&body.geometry[..]));
    assert_eq!(recording.geometry_of(body.id, shape.step), Some(&shape.geometry[..]));
    let report = recording.reports.iter().find(|report| report.body == body.id).expect("a report");
    let normal = report.hits[0].normal.expect("a normal");
    let normal = Vec3::new(normal.x, normal.y, normal.z);
    let mut pressed = old.mesh;
    pressed.vertices.iter_mut().for_each(|p| *p -= normal * (0.1 * p.dot(&normal)));
    let centre = pressed.mass_properties().centroid;
    pressed.vertices.iter_mut().for_each(|p| *p -= centre);
    assert_eq!(new.mesh, pressed);
    assert_eq!(shape.mass, body.mass);
    assert!((shape.volume / body.volume - 0.9).abs() < 1e-9, "{shape:?}");
    let detail = &report.details[0];
    assert_eq!((detail.name.as_str(), detail.unit.as_str()), ("plastic_work", "J"));
    let event = recording.events.iter().find(|event| event.kind() == EventKind::Deformed);
    let ledger = event.and_then(|event| event.ledger).expect("a ledger");
    assert_eq!(ledger.fracture_energy, detail.value);
    // A later hit finds a body of the same mass.
    assert!(masses.iter().all(|mass| (mass / body.mass - 1.0).abs() < 1e-12), "{masses:?}");
    assert_eq!(dented().1.summary.digest, summary.digest);
}
