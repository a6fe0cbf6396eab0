use super::read::rows;
use super::{Ran, ending};
use crate::process::ProcessEnd;
use crate::specimen::whole::ResolvedProbe;
use crate::specimen::whole::format::SceneProbeKind;
use crate::{Limits, status};
use cullet_proto::specimen::{Price, TensorPart};
use cullet_record::{Recording, synthetic};

const BREAK: usize = synthetic::BREAK as usize;

/// What a probe of the cube reads in the run made by hand, a sample a step.
fn read(kind: SceneProbeKind, part: TensorPart) -> Vec<f64> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.mcap");
    synthetic::run(&path, &synthetic::meta()).expect("it records");
    let recording = Recording::open(&path).expect("it reads");
    let bodies = (kind != SceneProbeKind::Balance).then(|| ["cube".to_owned()].into());
    let watch = ResolvedProbe { kind, bodies, others: None, part, nth: 0, share: 0.0 };
    let steps: Vec<u64> = (0..=synthetic::STEPS).collect();
    rows(&[watch], &recording, &steps).remove(0)
}

fn near(value: f64, wanted: f64) {
    assert!((value - wanted).abs() <= 1e-9 * wanted.abs().max(1.0), "{value} is not {wanted}");
}

/// A cube of 15.2 kg falls from 0.9 m, and at step 48 two halves and two grains take its place.
#[test]
fn a_body_is_all_that_came_of_it() {
    let height = read(SceneProbeKind::Position, TensorPart::Axis(2));
    near(height[0], 0.9);
    near(height[BREAK - 1], 0.9 - 4.905 * ((BREAK - 1) as f64 * synthetic::STEP).powi(2));
    let mass = read(SceneProbeKind::Mass, TensorPart::Size);
    near(mass[0], 15.2);
    near(mass[BREAK], 15.2 + 2.0 * 0.015);
    let speed = read(SceneProbeKind::Velocity, TensorPart::Axis(0));
    near(speed[BREAK], 0.0);
    let (pieces, bodies) = (
        read(SceneProbeKind::Pieces, TensorPart::Size),
        read(SceneProbeKind::Bodies, TensorPart::Size),
    );
    assert_eq!([pieces[BREAK - 1], pieces[BREAK], bodies[BREAK]], [1.0, 2.0, 2.0]);
    near(read(SceneProbeKind::Largest, TensorPart::Size)[BREAK], 7.6 / 15.23);
    let drift = read(SceneProbeKind::Displacement, TensorPart::Size);
    near(drift[BREAK - 1], 0.9 - height[BREAK - 1]);
    assert!(drift[BREAK].is_nan(), "the cube is no more: {}", drift[BREAK]);
    assert!(read(SceneProbeKind::Spin, TensorPart::Size)[BREAK].is_nan());
}

/// ½ m v² while it falls, and the halves' 0.8 m/s and the grains' 1 m/s after.
#[test]
fn energies_and_momenta_are_sums_over_parts() {
    let kinetic = read(SceneProbeKind::Kinetic, TensorPart::Size);
    let speed = 9.81 * (BREAK - 1) as f64 * synthetic::STEP;
    near(kinetic[BREAK - 1], 0.5 * 15.2 * speed * speed);
    near(kinetic[BREAK], 0.5 * 15.2 * 0.64 + 0.5 * 0.03);
    let energy = read(SceneProbeKind::Energy, TensorPart::Size);
    near(energy[0], 15.2 * 9.81 * 0.9);
    near(energy[BREAK - 1], energy[0]);
    near(read(SceneProbeKind::Momentum, TensorPart::Axis(2))[BREAK - 1], -15.2 * speed);
    // The cube falls along the z axis: about the origin there is no angular momentum.
    near(read(SceneProbeKind::AngularMomentum, TensorPart::Size)[BREAK - 1], 0.0);
}

/// A cube's moments are m a²/6; two halves side by side and two grains beyond have more.
#[test]
fn inertia_is_that_of_all_parts_about_their_centre() {
    for part in [TensorPart::Least, TensorPart::Greatest, TensorPart::Mean, TensorPart::Pair(0)] {
        near(read(SceneProbeKind::Inertia, part)[BREAK - 1], 15.2 * 0.04 / 6.0);
    }
    let along_x = read(SceneProbeKind::Inertia, TensorPart::Pair(0))[BREAK];
    // The halves keep theirs about x; the grains lie 0.1 m off in y, the middle of all 0.2 mm.
    let middle = 0.03 * 0.1 / 15.23;
    near(
        along_x,
        15.2 * 0.04 / 6.0 + 15.2 * middle * middle + 0.03 * (0.1 - middle) * (0.1 - middle),
    );
}

/// The hit is there from its step on; its loss is the break's affair once the cube has broken.
#[test]
fn hits_and_breaks_are_in_the_books() {
    for (kind, wanted) in [
        (SceneProbeKind::HitTime, 0.4),
        (SceneProbeKind::HitOrder, 1.0),
        (SceneProbeKind::HitSpeed, 3.92),
        (SceneProbeKind::HitImpulse, 59.6),
        (SceneProbeKind::HitEnergy, 116.8),
        (SceneProbeKind::HitTook, 0.91 * 116.8),
        (SceneProbeKind::HitMass, 2.0 * 116.8 / (3.92 * 3.92)),
        (SceneProbeKind::HitDuration, 1e-4),
        (SceneProbeKind::HitRadius, 0.003),
        (SceneProbeKind::HitForce, 1e6),
    ] {
        let row = read(kind, TensorPart::Size);
        assert!(row[BREAK - 1].is_nan(), "{kind:?}");
        near(row[BREAK], wanted);
        near(row[synthetic::STEPS as usize], wanted);
    }
    for (kind, wanted) in [
        (SceneProbeKind::Hits, 1.0),
        (SceneProbeKind::Breaks, 1.0),
        (SceneProbeKind::Failed, 0.0),
        (SceneProbeKind::HitLoss, 0.0),
        (SceneProbeKind::BreakLoss, 116.8 - 9.7),
        (SceneProbeKind::CrackEnergy, 3.2),
        (SceneProbeKind::MassError, 1e-16),
    ] {
        let row = read(kind, TensorPart::Size);
        assert_eq!(row[BREAK - 1], 0.0, "{kind:?}");
        near(row[BREAK], wanted);
    }
}

/// While it falls nothing is lost; what is there after the break and what went must be what was.
#[test]
fn the_balance_is_what_there_is_and_what_went_less_what_there_was() {
    let (balance, energy) = (
        read(SceneProbeKind::Balance, TensorPart::Size),
        read(SceneProbeKind::Energy, TensorPart::Size),
    );
    near(balance[0], 0.0);
    near(balance[BREAK - 1], 0.0);
    near(balance[BREAK], energy[BREAK] + 116.8 - 9.7 - energy[0]);
}

/// However a process ends, its run has a status.
#[test]
fn the_end_of_a_process_is_a_status() {
    let limits = Limits {
        exe: "none".into(),
        words: Vec::new(),
        workers: 1,
        time: std::time::Duration::from_secs(7),
    };
    let of = |end, said: &str| {
        status(&ending(&Ran { end, price: Price::default(), said: said.to_owned() }, &limits))
    };
    assert_eq!(of(ProcessEnd::Complete, ""), "ok");
    assert_eq!(of(ProcessEnd::Refused, "there is no body"), "refused");
    assert_eq!(of(ProcessEnd::Late, ""), "timeout");
    let lost = "the motion of body \"a\" is not finite at step 3";
    assert_eq!(of(ProcessEnd::NotFinite, lost), "nan");
    assert_eq!(of(ProcessEnd::Broken, lost), "crashed", "words decide nothing");
    assert_eq!(of(ProcessEnd::Broken, "signal: 9 (SIGKILL)"), "crashed");
}
