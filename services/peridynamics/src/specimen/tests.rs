use super::{FAMILY, read};
use cullet_geometry::{Mat3, Quat, Vec3, shapes};
use cullet_model::strength::Region;
use cullet_model::{Hardening, JohnsonCook, Material, PointPrecision, StrengthField, SurfaceLaw};
use cullet_specimen::{
    Amplitude, Ending, Hold, InitialState, Load, LoadKind, Matter, Notch, Output, PointField,
    PointLayout, PointSettings, Probe, Reduce, SpecimenBody, SpecimenOutcome, SpecimenProblem,
    SpecimenRun, SpecimenSettings, Spot, Start, StrengthPatch, SymmetryPlane, TensorPart,
};

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};

/// A bar along x from 0, 12 by 4 by 4 spacings of 1 cm, free, that cannot break.
fn bar() -> SpecimenProblem {
    let size = Vec3::new(0.12, 0.04, 0.04);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    let strength = StrengthField { weibull: f64::INFINITY, ..StrengthField::default() };
    SpecimenProblem {
        family: FAMILY.name.to_owned(),
        body: SpecimenBody {
            mesh: mesh.translated(size / 2.0),
            parts: Vec::new(),
            turn: Quat::identity(),
            shift: Vec3::zeros(),
        },
        matter: Matter {
            material: STONE,
            surface: SurfaceLaw::of(&STONE),
            flow: None,
            zones: Vec::new(),
            strength,
            patches: Vec::new(),
        },
        initial: InitialState::default(),
        holds: Vec::new(),
        symmetries: Vec::new(),
        loads: Vec::new(),
        output: Output {
            end: 1e-4,
            probes: Vec::new(),
            samples: 10,
            frames: 0,
            colour: (PointField::Damage, TensorPart::Size),
        },
        settings: SpecimenSettings {
            spacing: 0.01,
            step_factor: 0.8,
            precision: PointPrecision::Single,
            breaks: false,
            damping: 0.0,
            damped_until: None,
            max_points: 1e6,
            max_steps: 1e6,
            threads: 1,
            seed: 1,
            points: PointSettings {
                per_cell: 1.0,
                layout: PointLayout::Rows,
                welded: false,
                softening_length: None,
                look: 4,
            },
            horizon: None,
        },
    }
}

fn run(problem: SpecimenProblem) -> SpecimenOutcome {
    SpecimenRun::begin(problem, &[FAMILY]).expect("a specimen").finished()
}

fn refused(problem: SpecimenProblem) -> String {
    SpecimenRun::begin(problem, &[FAMILY]).expect_err("none").to_string()
}

/// A side of the bar, x = `at`, and what lies beyond it.
fn side(at: f64) -> Vec<Region> {
    let normal = if at > 0.0 { -Vec3::x() } else { Vec3::x() };
    vec![Region::HalfSpace { point: Vec3::x() * at, normal }]
}

fn hold(part: Vec<Region>, axes: [bool; 3], speed: f64) -> Hold {
    Hold {
        part,
        axes,
        velocity: Vec3::x() * speed,
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::constant(),
        until: None,
    }
}

/// As a bar that is pulled at a rate \[1/s\].
fn pulled(rate: f64) -> Start {
    Start {
        part: Vec::new(),
        velocity: Vec3::zeros(),
        gradient: Mat3::from_diagonal(&Vec3::new(rate, -0.2 * rate, -0.2 * rate)),
        centre: Vec3::zeros(),
        noise: 0.0,
    }
}

fn last(outcome: &SpecimenOutcome, probe: usize) -> f64 {
    *outcome.rows[probe].last().expect("a sample")
}

fn over(field: PointField, part: TensorPart) -> Probe {
    Probe::Points(field, part, Spot::Over(Vec::new(), Reduce::Mean))
}

/// A bar between supports on both ends, or one and a plane of symmetry, that starts with the
/// gradient of their velocities: E by the reaction and the whole length, within 2 % (C5).
#[test]
fn a_bar_between_supports_has_its_modulus() {
    // As wide as a horizon of 4 the bar is edges all through.
    let cases =
        [(2.04, false, 0.01), (3.015, false, 0.02), (3.015, true, 0.02), (4.0, false, 0.04)];
    for (horizon, mirrored, tolerance) in cases {
        let mut problem = bar();
        let rate = 10.0;
        problem.holds = vec![hold(side(0.12), [true, false, false], 0.12 * rate)];
        if mirrored {
            problem.symmetries = vec![SymmetryPlane { axis: 0, at: 0.0 }];
        } else {
            problem.holds.push(hold(side(0.0), [true, false, false], 0.0));
        }
        problem.initial.starts = vec![pulled(rate)];
        problem.settings.horizon = Some(horizon);
        problem.output.probes = vec![
            Probe::Reaction(0, TensorPart::Axis(0)),
            over(PointField::Strain, TensorPart::Pair(0)),
            Probe::Balance,
            Probe::Work,
        ];
        let outcome = run(problem);
        assert_eq!(outcome.ending, Ending::Ok);
        let strain = rate * 1e-4;
        // The force is a mean over the last of ten samples.
        let modulus = last(&outcome, 0) / (0.04 * 0.04 * 0.95 * strain) / STONE.young;
        let found = last(&outcome, 1) / strain;
        println!("m {horizon}, mirrored {mirrored}: {modulus:.4} E, strain {found:.4}");
        assert!((modulus - 1.0).abs() < tolerance, "{horizon}, {mirrored}: {modulus} E");
        assert!((found - 1.0).abs() < 0.01, "{horizon}, {mirrored}: strain {found}");
        assert!((last(&outcome, 2) / last(&outcome, 3)).abs() < 0.02);
    }
}

/// A cantilever swings for thousands of steps, its grip fed by no energy and feeding none.
#[test]
fn a_cantilever_swings_and_keeps_its_energy() {
    let mut problem = bar();
    problem.holds = vec![hold(side(0.0), [true; 3], 0.0)];
    problem.initial.starts = vec![Start {
        part: Vec::new(),
        velocity: Vec3::zeros(),
        gradient: Mat3::new(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        centre: Vec3::zeros(),
        noise: 0.0,
    }];
    problem.output.end = 2e-2;
    problem.output.samples = 200;
    problem.output.probes = vec![Probe::Balance, Probe::Kinetic, Probe::Work];
    let outcome = run(problem);
    assert_eq!(outcome.ending, Ending::Ok);
    let first = outcome.rows[1][0];
    let worst = outcome.rows[0].iter().map(|x| x.abs()).fold(0.0, f64::max);
    println!("{} steps: {worst:.3e} J of {first:.3e} J are not booked", outcome.steps);
    assert!(outcome.steps > 10_000 && worst < 0.02 * first, "{worst} of {first}");
    assert!(last(&outcome, 2) == 0.0);
}

/// All of a load arrives, and its work is in the books.
#[test]
fn loads_are_whole() {
    for push in [
        LoadKind::Traction(Vec3::new(1e5, 2e4, 0.0)),
        LoadKind::Force(Vec3::new(160.0, 32.0, 0.0)),
        LoadKind::Acceleration(Vec3::new(1e5, 2e4, 0.0) / (2450.0 * 0.12)),
    ] {
        for layout in [PointLayout::Rows, PointLayout::Scattered] {
            let mut problem = bar();
            problem.settings.points.layout = layout;
            let part = match push {
                LoadKind::Traction(_) => side(0.12),
                _ => Vec::new(),
            };
            problem.loads = vec![Load { part, push, course: Amplitude::constant() }];
            problem.output.probes = vec![
                Probe::Momentum(TensorPart::Size),
                Probe::Balance,
                Probe::Work,
                Probe::Applied(0, TensorPart::Axis(0)),
            ];
            let outcome = run(problem);
            let impulse = 160.0 * libm::hypot(1.0, 0.2) * 1e-4;
            let found = last(&outcome, 0) / impulse;
            assert!((found - 1.0).abs() < 1e-3, "{push:?}: {found}");
            assert!((last(&outcome, 3) / 160.0 - 1.0).abs() < 1e-3);
            let share = last(&outcome, 1) / last(&outcome, 2);
            assert!(share.abs() < 0.02, "{push:?}, {layout:?}: {share} of the work is not booked");
        }
    }
}

/// What bonds do not hold for ends the run in words, with the strain and the time.
#[test]
fn a_bar_that_is_crushed_is_refused_with_strain_and_time() {
    let hardening = Hardening { yield_stress: 1e6, hardening: 0.0, exponent: 1.0 };
    let mut problem = bar();
    problem.matter.flow = Some(JohnsonCook::from(hardening));
    problem.symmetries = vec![SymmetryPlane { axis: 0, at: 0.0 }];
    problem.initial.starts = vec![Start {
        part: Vec::new(),
        velocity: -Vec3::x() * 200.0,
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        noise: 0.0,
    }];
    problem.output.end = 1e-3;
    problem.output.probes = vec![over(PointField::PlasticStrain, TensorPart::Size)];
    let outcome = run(problem);
    let Ending::Refused(why) = &outcome.ending else { panic!("{:?}", outcome.ending) };
    assert!(why.starts_with("at ") && why.contains("plastic strain of 0.3"), "{why}");
    assert!(outcome.steps > 0 && why.contains(&format!("step {} of", outcome.steps)), "{why}");
    assert!(last(&outcome, 0) > 0.0);
}

/// A notch that goes through makes two pieces, whose damage it is not.
#[test]
fn a_notch_parts_the_body_and_is_no_damage() {
    let mut problem = bar();
    let whole = vec![Region::Box { low: -Vec3::repeat(1.0), high: Vec3::repeat(1.0) }];
    let half = vec![Region::Box { low: -Vec3::repeat(1.0), high: Vec3::new(1.0, 0.02, 1.0) }];
    problem.output.probes = vec![Probe::Pieces(0.01), Probe::Broken(Vec::new())];
    let notch =
        |part: &[Region]| Notch { point: Vec3::x() * 0.04, normal: Vec3::x(), part: part.to_vec() };
    problem.initial.notches = vec![notch(&half)];
    let outcome = run(problem.clone());
    assert_eq!((last(&outcome, 0), last(&outcome, 1)), (1.0, 0.0));
    problem.initial.notches = vec![notch(&whole)];
    let outcome = run(problem.clone());
    assert_eq!((last(&outcome, 0), last(&outcome, 1)), (2.0, 0.0));
    assert!((outcome.pieces[0] - 2.0 / 3.0).abs() < 1e-9, "{:?}", outcome.pieces);
    problem.initial.notches[0].point = Vec3::x();
    assert!(refused(problem).contains("notch 1"));
}

/// A bar that is pulled tears at s_c: where a patch is weak before it tears elsewhere, and later
/// where it is strong.
#[test]
fn a_bar_tears_where_it_is_weak() {
    let all = |low: f64, high: f64| {
        let (low, high) = (Vec3::new(low, -1.0, -1.0), Vec3::new(high, 1.0, 1.0));
        vec![Region::Box { low, high }]
    };
    let middle = all(0.05, 0.07);
    let cases = [
        (middle.clone(), 0.5, 55e-6, [true, false]),
        (middle.clone(), 1.0, 55e-6, [false, false]),
        (middle.clone(), 2.0, 110e-6, [false, true]),
        (all(-1.0, 1.0), 2.0, 110e-6, [false, false]),
    ];
    for (part, strength, end, torn) in cases {
        let mut problem = bar();
        problem.settings.breaks = true;
        problem.matter.patches = vec![StrengthPatch { part, strength, damage: 0.0 }];
        let rate = 1.0;
        problem.holds = vec![
            hold(side(0.0), [true, false, false], 0.0),
            hold(side(0.12), [true, false, false], 0.12 * rate),
        ];
        problem.initial.starts = vec![pulled(rate)];
        problem.output.end = end;
        let ends = [all(-1.0, 0.04), all(0.08, 1.0)].map(Probe::Broken);
        problem.output.probes = vec![Probe::Broken(middle.clone()), Probe::Pieces(0.01)];
        problem.output.probes.extend(ends);
        let outcome = run(problem);
        assert_eq!(outcome.ending, Ending::Ok);
        let [inside, pieces, left, right] = [0, 1, 2, 3].map(|k| last(&outcome, k));
        println!("{strength}, {end}: {inside}, {left} and {right} broken, {pieces} pieces");
        assert_eq!([inside > 0.0, left + right > 0.0], torn, "{strength}, {end}");
        assert_eq!(pieces > 1.0, torn != [false, false], "{strength}, {end}");
    }
}

#[test]
fn what_does_not_hold_is_refused_in_words() {
    let mut short = bar();
    short.settings.horizon = Some(1.2);
    assert!(refused(short).contains("the horizon over the spacing is 1.200e0"));
    let mut double = bar();
    double.settings.precision = PointPrecision::Double;
    assert!(refused(double).contains("no precision double; it has: precision single"));
    let mut split = bar();
    split.symmetries = vec![SymmetryPlane { axis: 0, at: 0.05 }];
    assert!(refused(split).contains("on both sides of the plane"));
    let mut thin = bar();
    thin.settings.spacing = 0.05;
    assert!(refused(thin).contains("not for `peridynamics`: point"));
}

/// Share of weights beyond a plane: half of them at the point, none at the horizon.
#[test]
fn a_plane_takes_half_of_the_bonds_at_most() {
    assert!((read::beyond(0.0) - 0.5).abs() < 1e-12 && read::beyond(1.0).abs() < 1e-12);
    // By the middle of a thousand shells.
    let near = |off: f64| {
        let shell = |k: u32| (f64::from(k) + 0.5) * 1e-3;
        let radii = (0..1000).map(shell).filter(|r| *r > off);
        radii.map(|r| 2.0 * r.powi(3) * (1.0 - off / r) * 1e-3).sum::<f64>()
    };
    assert!((read::beyond(0.3) - near(0.3)).abs() < 1e-5, "{}", near(0.3));
}
