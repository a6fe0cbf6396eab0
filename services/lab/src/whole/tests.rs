use super::read::rows;
use super::{Ran, ending};
use crate::process::End;
use crate::specimen::whole::Watch;
use crate::specimen::whole::format::ProbeKind;
use crate::{Limits, status};
use cullet_proto::specimen::{Price, TensorPart};
use cullet_record::{Recording, synthetic};

const BREAK: usize = synthetic::BREAK as usize;

/// What a probe of the cube reads in the run made by hand, a sample a step.
fn read(kind: ProbeKind, part: TensorPart) -> Vec<f64> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("run.mcap");
    synthetic::run(&path, &synthetic::meta()).expect("it records");
    let recording = Recording::open(&path).expect("it reads");
    let bodies = (kind != ProbeKind::Balance).then(|| ["cube".to_owned()].into());
    let watch = Watch { kind, bodies, others: None, part, nth: 0, share: 0.0 };
    let steps: Vec<u64> = (0..=synthetic::STEPS).collect();
    rows(&[watch], &recording, &steps).remove(0)
}

fn near(value: f64, wanted: f64) {
    assert!((value - wanted).abs() <= 1e-9 * wanted.abs().max(1.0), "{value} is not {wanted}");
}

/// A cube of 15.2 kg falls from 0.9 m, and at step 48 two halves and two grains take its place.
#[test]
fn a_body_is_all_that_came_of_it() {
    let height = read(ProbeKind::Position, TensorPart::Axis(2));
    near(height[0], 0.9);
    near(height[BREAK - 1], 0.9 - 4.905 * ((BREAK - 1) as f64 * synthetic::STEP).powi(2));
    let mass = read(ProbeKind::Mass, TensorPart::Size);
    near(mass[0], 15.2);
    near(mass[BREAK], 15.2 + 2.0 * 0.015);
    let speed = read(ProbeKind::Velocity, TensorPart::Axis(0));
    near(speed[BREAK], 0.0);
    let (pieces, bodies) =
        (read(ProbeKind::Pieces, TensorPart::Size), read(ProbeKind::Bodies, TensorPart::Size));
    assert_eq!([pieces[BREAK - 1], pieces[BREAK], bodies[BREAK]], [1.0, 2.0, 2.0]);
    near(read(ProbeKind::Largest, TensorPart::Size)[BREAK], 7.6 / 15.23);
    let drift = read(ProbeKind::Displacement, TensorPart::Size);
    near(drift[BREAK - 1], 0.9 - height[BREAK - 1]);
    assert!(drift[BREAK].is_nan(), "the cube is no more: {}", drift[BREAK]);
    assert!(read(ProbeKind::Spin, TensorPart::Size)[BREAK].is_nan());
}

/// ½ m v² while it falls, and the halves' 0.8 m/s and the grains' 1 m/s after.
#[test]
fn energies_and_momenta_are_sums_over_parts() {
    let kinetic = read(ProbeKind::Kinetic, TensorPart::Size);
    let speed = 9.81 * (BREAK - 1) as f64 * synthetic::STEP;
    near(kinetic[BREAK - 1], 0.5 * 15.2 * speed * speed);
    near(kinetic[BREAK], 0.5 * 15.2 * 0.64 + 0.5 * 0.03);
    let energy = read(ProbeKind::Energy, TensorPart::Size);
    near(energy[0], 15.2 * 9.81 * 0.9);
    near(energy[BREAK - 1], energy[0]);
    near(read(ProbeKind::Momentum, TensorPart::Axis(2))[BREAK - 1], -15.2 * speed);
    // The cube falls along the z axis: about the origin there is no angular momentum.
    near(read(ProbeKind::AngularMomentum, TensorPart::Size)[BREAK - 1], 0.0);
}

/// A cube's moments are m a²/6; two halves side by side and two grains beyond have more.
#[test]
fn inertia_is_that_of_all_parts_about_their_centre() {
    for part in [TensorPart::Least, TensorPart::Greatest, TensorPart::Mean, TensorPart::Pair(0)] {
        near(read(ProbeKind::Inertia, part)[BREAK - 1], 15.2 * 0.04 / 6.0);
    }
    let along_x = read(ProbeKind::Inertia, TensorPart::Pair(0))[BREAK];
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
        (ProbeKind::HitTime, 0.4),
        (ProbeKind::HitOrder, 1.0),
        (ProbeKind::HitSpeed, 3.92),
        (ProbeKind::HitImpulse, 59.6),
        (ProbeKind::HitEnergy, 116.8),
        (ProbeKind::HitTook, 0.91 * 116.8),
        (ProbeKind::HitMass, 2.0 * 116.8 / (3.92 * 3.92)),
        (ProbeKind::HitDuration, 1e-4),
        (ProbeKind::HitRadius, 0.003),
        (ProbeKind::HitForce, 1e6),
    ] {
        let row = read(kind, TensorPart::Size);
        assert!(row[BREAK - 1].is_nan(), "{kind:?}");
        near(row[BREAK], wanted);
        near(row[synthetic::STEPS as usize], wanted);
    }
    for (kind, wanted) in [
        (ProbeKind::Hits, 1.0),
        (ProbeKind::Breaks, 1.0),
        (ProbeKind::Failed, 0.0),
        (ProbeKind::HitLoss, 0.0),
        (ProbeKind::BreakLoss, 116.8 - 9.7),
        (ProbeKind::CrackEnergy, 3.2),
        (ProbeKind::MassError, 1e-16),
    ] {
        let row = read(kind, TensorPart::Size);
        assert_eq!(row[BREAK - 1], 0.0, "{kind:?}");
        near(row[BREAK], wanted);
    }
}

/// While it falls nothing is lost; what is there after the break and what went must be what was.
#[test]
fn the_balance_is_what_there_is_and_what_went_less_what_there_was() {
    let (balance, energy) =
        (read(ProbeKind::Balance, TensorPart::Size), read(ProbeKind::Energy, TensorPart::Size));
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
    assert_eq!(of(End::Complete, ""), "ok");
    assert_eq!(of(End::Refused, "there is no body"), "refused");
    assert_eq!(of(End::Late, ""), "timeout");
    assert_eq!(of(End::Broken, "the motion of body \"a\" is not finite at step 3"), "nan");
    assert_eq!(of(End::Broken, "signal: 9 (SIGKILL)"), "crashed");
}
