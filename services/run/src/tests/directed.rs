//! Joints, driven bodies and fields of a scene, as the recording tells of them.

use super::super::{JobPool, Outcome, PoolLoad, RunOptions, WantedJob, run};
use cullet_pool::Settlement;
use cullet_proto::JobId;
use cullet_proto::recording::{EventKind, JointType, RunEvent};
use cullet_record::{PoseRow, Recording, inspect};
use cullet_scene::load;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A pool that is never asked.
struct Unasked;

impl JobPool for Unasked {
    fn open(&self, _: WantedJob<'_>) -> JobId {
        panic!("nothing here can break")
    }

    fn settled(&self, _: Duration) -> Option<(JobId, Settlement)> {
        None
    }

    fn load(&self) -> PoolLoad {
        PoolLoad::default()
    }

    fn cancel(&self) {}
}

/// The run of the scene, its recording, and the lines of `inspect`.
fn directed(sets: &[&str]) -> (Outcome, Recording, Vec<String>) {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/corpus/directed.toml");
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let scene = load(Path::new(scene), &sets).unwrap_or_else(|why| panic!("{why}"));
    let (stop, out) = (AtomicBool::new(false), tempfile::tempdir().expect("a folder"));
    let options = RunOptions::new(out.path(), &stop);
    let outcome = run(&scene, &Unasked, &options, &mut |_| {}).expect("a run");
    let recording = Recording::open(&outcome.recording).expect("a recording");
    let told = inspect(&outcome.recording).expect("a recording").events;
    (outcome, recording, told)
}

fn id_of(recording: &Recording, name: &str) -> u64 {
    recording.bodies.iter().find(|body| body.name == name).expect(name).id
}

fn last_row(recording: &Recording, name: &str) -> PoseRow {
    let id = id_of(recording, name);
    let rows = recording.poses.iter().flat_map(PoseRow::of).filter(|row| row.id == id);
    rows.last().expect("a row")
}

fn events(recording: &Recording, kind: EventKind) -> Vec<&RunEvent> {
    recording.events.iter().filter(|event| event.kind() == kind).collect()
}

/// Of two ropes under one weight the weaker one breaks in the first step, by that weight.
#[test]
fn a_rope_breaks_by_the_weight_that_it_does_not_bear() {
    let (outcome, recording, told) = directed(&[]);
    let ropes = recording.joints.iter().filter(|joint| joint.kind() == JointType::Rope);
    let ropes: Vec<_> = ropes.collect();
    assert_eq!(ropes.len(), 2);
    assert_eq!((ropes[0].length, ropes[0].force, ropes[0].other), (1.0, Some(30.0), None));
    assert!(!ropes[0].glue && !ropes[0].inherited && ropes[0].step == 0);
    let broken = events(&recording, EventKind::JointBroken);
    let [broken] = broken[..] else { panic!("{told:#?}") };
    let heavy = id_of(&recording, "heavy");
    assert_eq!((broken.joint, broken.body, broken.striker), (Some(ropes[1].id), Some(heavy), None));
    let weight = recording.bodies[1].mass * 9.81;
    assert!((broken.force / weight - 1.0).abs() < 0.01, "{} of {weight} N", broken.force);
    assert!((broken.load_share - broken.force / 4.0).abs() < 1e-9 && broken.step <= 2);
    assert!(last_row(&recording, "heavy").pose.translation.z < 0.0, "it fell");
    assert!((last_row(&recording, "light").pose.translation.z - 1.0).abs() < 1e-3, "it hangs");
    let totals = outcome.summary.directed.expect("it is directed");
    assert_eq!((totals.joints, totals.glue_joints, totals.joints_broken), (4, 2, 1));
    assert!(told.iter().any(|line| line.contains("of heavy and the world breaks")), "{told:#?}");
    assert!(told.iter().any(|line| line.starts_with("directed: 1 body moved")), "{told:#?}");
}

/// The upper face bears 15.4 N over 25 cm², 6.2 kPa: with less strength the chain falls as one.
#[test]
fn glue_bears_what_its_strength_times_its_face_is() {
    let (_, recording, _) = directed(&["glue.0.tensile=8 kPa"]);
    let faces: Vec<f64> = recording.joints.iter().filter(|j| j.glue).map(|j| j.area).collect();
    assert!(faces.len() == 2 && faces.iter().all(|area| (area - 0.0025).abs() < 1e-9), "{faces:?}");
    assert_eq!(events(&recording, EventKind::JointBroken).len(), 1, "the rope alone");
    let (_, recording, told) = directed(&["glue.0.tensile=5 kPa"]);
    let broken = events(&recording, EventKind::JointBroken);
    assert_eq!(broken.len(), 2, "{told:#?}");
    let ends = [Some(id_of(&recording, "beam")), Some(id_of(&recording, "link-0"))];
    let chain = broken.iter().filter(|event| event.body != Some(id_of(&recording, "heavy")));
    let chain: Vec<_> = chain.collect();
    assert!(ends.contains(&chain[0].body) && ends.contains(&chain[0].striker), "{told:#?}");
    let fell = ["link-0", "link-1"].map(|name| last_row(&recording, name).pose.translation.z);
    assert!((fell[0] - fell[1] - 0.04).abs() < 1e-3 && fell[0] < 1.5, "{fell:?}");
}

/// The arm meets a ball that does not bounce much at 1 m/s; the ball goes on at least so fast.
#[test]
fn a_driven_body_pushes_and_its_work_is_told() {
    let (outcome, recording, _) = directed(&[]);
    let arm = last_row(&recording, "arm");
    assert!((arm.pose.translation.x + 2.6).abs() < 1e-9, "{}", arm.pose);
    let ball = last_row(&recording, "pushed");
    assert!(ball.velocity.x > 0.99 && ball.velocity.z.abs() < 1e-2, "{}", ball.velocity);
    let told = events(&recording, EventKind::Driven);
    let [told] = told[..] else { panic!("one body is driven") };
    assert_eq!(told.body, Some(id_of(&recording, "arm")));
    let mass = recording.bodies.iter().find(|body| body.name == "pushed").expect("it").mass;
    // All of its energy is work of the arm: at the speed of the arm an impulse does J·v.
    let work = mass * ball.velocity.x;
    assert!((told.energy / work - 1.0).abs() < 0.02, "{} J, not {work} J", told.energy);
    assert_eq!(outcome.summary.directed.map(|it| it.driven), Some(1));
}

#[test]
fn fields_move_and_remove_the_bodies_that_they_name() {
    let (outcome, recording, told) = directed(&[]);
    let blown = last_row(&recording, "blown").velocity;
    // ½ ρ C A v²/m = 0.5·1.2·0.47·π·1e-4·900 / 0.0329 kg = 2.4 m/s², less as it speeds up.
    assert!((1.1..1.25).contains(&blown.x) && blown.z.abs() < 1e-2, "{blown}");
    let gone: Vec<(u64, &str)> = events(&recording, EventKind::Removed)
        .iter()
        .map(|event| (event.body.expect("a body"), &event.text[..]))
        .collect();
    let wanted = [
        (id_of(&recording, "lost"), "it is outside of the bounds of the world"),
        (id_of(&recording, "dropped"), "it is behind the plane of a field"),
    ];
    assert_eq!(gone, wanted, "{told:#?}");
    assert_eq!(outcome.summary.directed.map(|it| it.removed), Some(2));
    assert_eq!(outcome.summary.bodies_initial - outcome.summary.bodies_final, 2);
}

/// A joint whose body is removed goes with it; two runs of one scene are equal to the last bit.
#[test]
fn a_joint_goes_with_its_body_and_runs_repeat() {
    let sets = ["field.2.bodies=[\"heavy\"]", "field.2.point=[0, 0, 0.9]"];
    let (first, recording, told) = directed(&sets);
    assert!(events(&recording, EventKind::JointGone).is_empty(), "it broke before: {told:#?}");
    let sets = ["field.2.bodies=[\"light\"]", "field.2.point=[0, 0, 1.5]"];
    let (_, recording, told) = directed(&sets);
    let gone = events(&recording, EventKind::JointGone);
    let [gone] = gone[..] else { panic!("{told:#?}") };
    assert_eq!(gone.body, Some(id_of(&recording, "light")));
    let (again, ..) = directed(&["field.2.bodies=[\"heavy\"]", "field.2.point=[0, 0, 0.9]"]);
    assert_eq!(first.summary.digest, again.summary.digest);
}
