//! Sheets with known answers, and what is refused.

use super::FAMILY;
use cullet_geometry::{Mat3, Quat, Vec3, shapes};
use cullet_model::strength::{EVEN, Region};
use cullet_model::{Material, PointPrecision, StrengthField, SurfaceLaw};
use cullet_specimen::{
    Amplitude, Ending, Hold, InitialState, Load, LoadKind, Matter, Notch, Output, PointField,
    PointLayout, PointSettings, Probe, Reduce, SpecimenBody, SpecimenOutcome, SpecimenProblem,
    SpecimenRun, SpecimenSettings, Spot, TensorPart, Where,
};

const PAPER: Material = Material {
    density: 800.0,
    young: 1e6,
    poisson: 0.2,
    failure_stress: 1e5,
    fracture_energy: 10.0,
};

/// A free strip of 100 × 30 × 0.2 mm, whose length lies along the axis `along` and whose thickness
/// along the axis `across`, that cannot break.
fn strip(along: usize, across: usize) -> SpecimenProblem {
    let mut size = Vec3::repeat(0.03);
    (size[along], size[across]) = (0.1, 2e-4);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    let strength = StrengthField { weibull: EVEN, ..StrengthField::default() };
    SpecimenProblem {
        family: FAMILY.name.to_owned(),
        body: SpecimenBody {
            mesh,
            parts: Vec::new(),
            turn: Quat::identity(),
            shift: Vec3::zeros(),
        },
        matter: Matter {
            material: PAPER,
            surface: SurfaceLaw::of(&PAPER),
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
            end: 0.02,
            probes: Vec::new(),
            samples: 10,
            frames: 2,
            colour: (PointField::Damage, TensorPart::Size),
        },
        settings: SpecimenSettings {
            spacing: 3e-3,
            step_factor: 0.4,
            precision: PointPrecision::Double,
            breaks: false,
            damping: 0.0,
            damped_until: None,
            max_points: 1e6,
            max_steps: 1e6,
            threads: 1,
            seed: 1,
            points: PointSettings {
                per_cell: 8.0,
                layout: PointLayout::Scattered,
                welded: false,
                softening_length: None,
                look: 4,
            },
            horizon: None,
        },
    }
}

fn run(specimen: SpecimenProblem) -> SpecimenOutcome {
    let outcome = SpecimenRun::begin(specimen, &[FAMILY]).expect("taken").finished();
    assert_eq!(outcome.ending, Ending::Ok);
    outcome
}

fn refused(specimen: SpecimenProblem) -> String {
    SpecimenRun::begin(specimen, &[FAMILY]).expect_err("none").to_string()
}

fn last(outcome: &SpecimenOutcome, probe: usize) -> f64 {
    *outcome.rows[probe].last().expect("a sample")
}

/// Beyond a plane across an axis, on the side where `out` is positive.
fn side(axis: usize, at: f64, out: f64) -> Where {
    let point = Vec3::ith(axis, at);
    vec![Region::HalfSpace { point, normal: Vec3::ith(axis, -out) }]
}

fn hold(part: Where, axes: [bool; 3], velocity: Vec3) -> Hold {
    Hold {
        part,
        axes,
        velocity,
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::constant(),
        until: None,
    }
}

/// The strip along any axes, pulled at one end, while the other is held: stress, reaction and
/// strain agree, and the books close.
#[test]
fn a_pulled_strip_bears_what_its_supports_feel() {
    for (along, across) in [(0, 2), (1, 0), (2, 1)] {
        let mut specimen = strip(along, across);
        let axis = TensorPart::Axis(along as u8);
        let pair = TensorPart::Pair(along as u8);
        let pull = Vec3::ith(along, 1e3);
        specimen.loads = vec![Load {
            part: side(along, 0.05, 1.0),
            push: LoadKind::Traction(pull),
            course: Amplitude::Table(vec![(0.0, 0.0), (0.01, 1.0)]),
        }];
        specimen.holds = vec![hold(side(along, -0.05, -1.0), [true; 3], Vec3::zeros())];
        specimen.settings.damping = 800.0;
        specimen.output.end = 0.06;
        let middle = vec![Region::Sphere { centre: Vec3::zeros(), radius: 0.015 }];
        specimen.output.probes = vec![
            Probe::Points(PointField::Stress, pair, Spot::Over(middle.clone(), Reduce::Mean)),
            Probe::Points(PointField::Strain, pair, Spot::Over(middle, Reduce::Mean)),
            Probe::Reaction(0, axis),
            Probe::Applied(0, axis),
            Probe::Balance,
            Probe::Work,
            Probe::Points(PointField::Displacement, axis, Spot::At(Vec3::ith(along, 0.05))),
        ];
        let outcome = run(specimen);
        let force = 1e3 * 0.03 * 2e-4;
        let near = |k: usize, due: f64, bound: f64| {
            let found = last(&outcome, k);
            assert!((found / due - 1.0).abs() < bound, "{along} {k}: {found} {due}");
        };
        near(0, 1e3, 0.02);
        near(1, 1e-3, 0.02);
        near(2, -force, 0.01);
        near(3, force, 1e-9);
        // Both ends are those of the rows, half a spacing from the edges.
        near(6, 0.97e-4, 0.02);
        assert!(last(&outcome, 4).abs() < 0.005 * last(&outcome, 5), "{along}");
    }
}

/// S10: a strip that is held at one end hangs as an elastica does, Γ = 5. The kernel reckons in
/// whole numbers: a weight that bends the strip by a hundredth would be lost among them.
#[test]
fn a_cantilever_hangs_by_its_bending_stiffness() {
    let mut specimen = strip(0, 2);
    specimen.matter.material.poisson = 0.0;
    let size = Vec3::new(0.1, 0.03, 1e-3);
    specimen.body.mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    let length = 0.09;
    let by_area = 1e6 * 1e-9 / 12.0;
    let weight = 5.0 * by_area / (800.0 * 1e-3 * length * length * length);
    specimen.loads = vec![Load {
        part: Where::new(),
        push: LoadKind::Acceleration(-Vec3::z() * weight),
        course: Amplitude::Table(vec![(0.0, 0.0), (0.5, 1.0)]),
    }];
    specimen.holds = vec![hold(side(0, -0.04, -1.0), [true; 3], Vec3::zeros())];
    // Nearly critical.
    specimen.settings.damping = 8.0;
    specimen.settings.step_factor = 0.8;
    specimen.output.end = 2.5;
    let end = |axis: u8| {
        let spot = Spot::At(Vec3::x() * 0.05);
        Probe::Points(PointField::Displacement, TensorPart::Axis(axis), spot)
    };
    specimen.output.probes = vec![end(0), end(2), Probe::Balance, Probe::Work];
    let outcome = run(specimen);
    let (along, down) = (1.0 + last(&outcome, 0) / length, -last(&outcome, 1) / length);
    println!("{along} {down} {} {}", last(&outcome, 2), last(&outcome, 3));
    assert!((along / 0.8467 - 1.0).abs() < 0.03, "{along}");
    assert!((down / 0.4959 - 1.0).abs() < 0.05, "{down}");
    assert!(last(&outcome, 2).abs() < 0.02 * last(&outcome, 3));
}

/// Torn apart at a notch: two pieces, the damage lies on the way, and the books close.
#[test]
fn a_notched_strip_is_torn_in_two() {
    let mut specimen = strip(1, 2);
    specimen.settings.breaks = true;
    specimen.settings.damping = 100.0;
    specimen.initial.notches =
        vec![Notch { point: Vec3::zeros(), normal: Vec3::y(), part: side(0, -0.005, -1.0) }];
    let speed = Vec3::y() * 0.3;
    let clamp = |at: f64, velocity| hold(side(1, at, at), [true, true, false], velocity);
    specimen.holds = vec![clamp(0.045, speed), clamp(-0.045, -speed)];
    specimen.output.end = 0.05;
    specimen.output.probes = vec![
        Probe::Pieces(0.3),
        Probe::Dissipated,
        Probe::Balance,
        Probe::Work,
        Probe::CrackArea(Where::new(), Vec3::y()),
        Probe::Broken(Where::new()),
    ];
    let outcome = run(specimen);
    assert_eq!(last(&outcome, 0), 2.0);
    assert_eq!(outcome.rows[5][0], 0.0);
    let cost = last(&outcome, 1) / (10.0 * 0.02 * 2e-4);
    assert!((0.9..1.6).contains(&cost), "{cost}");
    assert!(last(&outcome, 2).abs() < 0.02 * last(&outcome, 3));
    assert!(last(&outcome, 4) > 0.015 * 3e-3, "{}", last(&outcome, 4));
}

#[test]
fn what_is_no_flat_sheet_is_refused_in_words() {
    let mut ball = strip(0, 2);
    ball.body.mesh = shapes::cuboid(Vec3::repeat(0.05), shapes::Detail::default()).expect("a box");
    assert!(refused(ball).contains("thick"));
    let mut idle = strip(0, 2);
    idle.holds = vec![hold(side(0, 0.2, 1.0), [true; 3], Vec3::zeros())];
    assert!(refused(idle).contains("support 1 takes nothing"));
    let mut single = strip(0, 2);
    single.settings.precision = PointPrecision::Single;
    assert!(refused(single).contains("precision single"));
    let mut short = strip(0, 2);
    short.settings.horizon = Some(1.9);
    assert!(refused(short).contains("horizon"));
}
