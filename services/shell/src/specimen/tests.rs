//! Beams and plates with known answers, and what is refused.

use super::FAMILY;
use cullet_geometry::{Mat3, Quat, Vec3, shapes};
use cullet_model::strength::Region;
use cullet_model::{Material, PointPrecision, StrengthField, SurfaceLaw};
use cullet_specimen::{
    Amplitude, Ending, Hold, InitialState, Load, LoadKind, Matter, Notch, Output, PointField,
    PointLayout, PointSettings, Probe, SpecimenBody, SpecimenOutcome, SpecimenProblem, SpecimenRun,
    SpecimenSettings, Spot, StrengthPatch, TensorPart, Where,
};

const GLASS: Material = Material {
    density: 2500.0,
    young: 70e9,
    poisson: 0.0,
    failure_stress: 30e6,
    fracture_energy: 8.0,
};

/// A free strip of 100 × 20 × 2 mm whose length lies along the axis `along` and whose thickness
/// along the axis `across`.
fn strip(along: usize, across: usize) -> SpecimenProblem {
    let mut size = Vec3::repeat(0.02);
    (size[along], size[across]) = (0.1, 0.002);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    let strength = StrengthField { weibull: f64::INFINITY, ..StrengthField::default() };
    let (turn, shift) = (Quat::identity(), Vec3::zeros());
    SpecimenProblem {
        family: "shell".to_owned(),
        body: SpecimenBody { mesh, parts: Vec::new(), turn, shift },
        matter: Matter {
            material: GLASS,
            surface: SurfaceLaw::of(&GLASS),
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
            end: 6e-3,
            probes: Vec::new(),
            samples: 10,
            frames: 0,
            colour: (PointField::Damage, TensorPart::Size),
        },
        settings: settings(),
    }
}

fn settings() -> SpecimenSettings {
    SpecimenSettings {
        spacing: 5e-3,
        step_factor: 0.8,
        precision: PointPrecision::Double,
        breaks: false,
        // About critical for a beam of this length that is held at both ends.
        damping: 3e3,
        damped_until: None,
        max_points: 1e6,
        max_steps: 1e6,
        threads: 1,
        seed: 1,
        points: PointSettings {
            per_cell: 8.0,
            layout: PointLayout::Rows,
            welded: false,
            softening_length: None,
            look: 4,
        },
        horizon: None,
    }
}

fn run(specimen: SpecimenProblem) -> SpecimenOutcome {
    let outcome = SpecimenRun::begin(specimen, &[FAMILY]).expect("taken").finished();
    assert_eq!(outcome.ending, Ending::Ok);
    outcome
}

fn last(outcome: &SpecimenOutcome, row: usize) -> f64 {
    *outcome.rows[row].last().expect("samples")
}

/// The face at an end of the strip.
fn end(along: usize, up: bool) -> Where {
    let normal = Vec3::ith(along, if up { -1.0 } else { 1.0 });
    vec![Region::HalfSpace { point: normal * -0.05, normal }]
}

fn hold(part: Where, axes: [bool; 3]) -> Hold {
    Hold {
        part,
        axes,
        velocity: Vec3::zeros(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::constant(),
        until: None,
    }
}

fn load(part: Where, push: LoadKind) -> Load {
    Load { part, push, course: Amplitude::constant() }
}

fn moved(axis: usize, at: Vec3) -> Probe {
    Probe::Points(PointField::Displacement, TensorPart::Axis(axis as u8), Spot::At(at))
}

/// Sag of the middle of a strip under its weight that both ends hold, and what one of them bears.
fn sag(along: usize, across: usize, axes: [bool; 3]) -> [f64; 2] {
    let mut beam = strip(along, across);
    let push = LoadKind::Acceleration(Vec3::ith(across, -10.0));
    beam.loads = vec![load(Vec::new(), push)];
    beam.holds = [false, true].map(|up| hold(end(along, up), axes)).to_vec();
    let reaction = Probe::Reaction(0, TensorPart::Axis(across as u8));
    beam.output.probes = vec![moved(across, Vec3::zeros()), reaction];
    let outcome = run(beam);
    [last(&outcome, 0), last(&outcome, 1)]
}

/// ρ g t L⁴/EI for a width of one, over 384.
fn clamped() -> f64 {
    2500.0 * 10.0 * 0.002 * 0.1_f64.powi(4) / (70e9 * 0.002_f64.powi(3) / 12.0) / 384.0
}

/// What holds both faces along an axis of the plane clamps, what holds across it does not, however
/// the strip lies.
#[test]
fn a_support_of_both_faces_clamps_and_of_a_line_does_not() {
    let weight = 2500.0 * 10.0 * 0.002 * 0.1 * 0.02;
    for (along, across) in [(0, 2), (2, 0), (0, 1)] {
        let [stiff, force] = sag(along, across, [true; 3]);
        assert!((-stiff / clamped() - 1.0).abs() < 0.01, "{along} {across}: {stiff}");
        assert!((force / weight - 0.5).abs() < 0.005, "{along} {across}: {force}");
        let mut axes = [false; 3];
        axes[across] = true;
        let [soft, force] = sag(along, across, axes);
        assert!((-soft / clamped() / 5.0 - 1.0).abs() < 0.01, "{along} {across}: {soft}");
        assert!((force / weight - 0.5).abs() < 0.005, "{along} {across}: {force}");
    }
}

/// A support of one face, or of the middle, holds no slope.
#[test]
fn a_support_of_one_face_holds_no_slope() {
    for height in [-1e-3, 0.0, 1e-3] {
        let mut beam = strip(0, 2);
        beam.loads = vec![load(Vec::new(), LoadKind::Acceleration(Vec3::new(0.0, 0.0, -10.0)))];
        let ledge = |x: f64| {
            let (low, high) = (Vec3::new(x - 1e-4, -1.0, height), Vec3::new(x + 1e-4, 1.0, height));
            vec![Region::Box { low, high }]
        };
        beam.holds = [-0.05, 0.05].map(|x| hold(ledge(x), [false, true, true])).to_vec();
        beam.output.probes = vec![moved(2, Vec3::zeros())];
        let soft = last(&run(beam), 0);
        assert!((-soft / clamped() / 5.0 - 1.0).abs() < 0.01, "{height}: {soft}");
    }
}

/// A slope that is held where the deflection is not: a strip whose one end is clamped and whose
/// other slides bends by qL⁴/24EI there.
#[test]
fn a_slope_alone_can_be_held() {
    let mut beam = strip(0, 2);
    beam.loads = vec![load(Vec::new(), LoadKind::Acceleration(Vec3::new(0.0, 0.0, -10.0)))];
    beam.holds = vec![hold(end(0, false), [true; 3]), hold(end(0, true), [true, true, false])];
    beam.output.probes = vec![moved(2, Vec3::new(0.05, 0.0, 0.0))];
    (beam.settings.damping, beam.output.end) = (2e3, 15e-3);
    let slid = last(&run(beam), 0);
    assert!((-slid / clamped() / 16.0 - 1.0).abs() < 0.01, "{slid}");
}

/// Tractions on an end: their sum, and the couple of a pair of them; a cantilever bends as a beam.
#[test]
fn tractions_give_their_force_and_their_couple() {
    let mut beam = strip(0, 2);
    beam.holds = vec![hold(end(0, false), [true; 3])];
    let half = |up: bool| {
        let mut part = end(0, true);
        let normal = if up { -Vec3::z() } else { Vec3::z() };
        part.push(Region::HalfSpace { point: Vec3::zeros(), normal });
        part
    };
    let pull = |sign: f64| LoadKind::Traction(Vec3::new(sign * 1e5, 0.0, 0.0));
    beam.loads = vec![load(half(true), pull(1.0)), load(half(false), pull(-1.0))];
    beam.output.probes = vec![
        moved(2, Vec3::new(0.05, 0.0, 0.0)),
        Probe::Applied(0, TensorPart::Axis(0)),
        Probe::Points(PointField::Stress, TensorPart::Pair(0), Spot::At(Vec3::new(0.0, 0.0, 1e-3))),
    ];
    (beam.settings.damping, beam.output.end) = (2e3, 15e-3);
    let outcome = run(beam);
    // M = 2 · τ · t/2 · t/4 a width: w = −ML²/2EI, and σ = Mt/2I on the upper face.
    let moment = 1e5 * 0.002 * 0.002 / 4.0;
    let second = 0.002_f64.powi(3) / 12.0;
    let wanted = -moment * 0.01 / (2.0 * 70e9 * second);
    let (tip, force, stress) = (last(&outcome, 0), last(&outcome, 1), last(&outcome, 2));
    assert!((tip / wanted - 1.0).abs() < 0.01, "{tip} of {wanted}");
    assert!((force / (1e5 * 0.02 * 0.001) - 1.0).abs() < 1e-9, "{force}");
    let face = moment * 0.001 / second;
    assert!((stress / face - 1.0).abs() < 0.01, "{stress} of {face}");
}

/// A uniform displacement gradient is read as it is at any place: stress, strain, displacement.
#[test]
fn an_affine_displacement_is_exact() {
    let mut plate = strip(1, 0);
    plate.matter.material.poisson = 0.25;
    let stretch = Mat3::from_diagonal(&Vec3::new(0.0, 1e-6, -2e-6));
    plate.initial.stretch = stretch;
    (plate.settings.damping, plate.output.end) = (0.0, 1e-9);
    let at = Vec3::new(1e-3, 0.031, 0.0077);
    let part = |field, pair| Probe::Points(field, TensorPart::Pair(pair), Spot::At(at));
    plate.output.probes = vec![
        moved(1, at),
        moved(2, at),
        part(PointField::Stress, 1),
        part(PointField::Stress, 2),
        part(PointField::Stress, 0),
        part(PointField::Strain, 0),
    ];
    let outcome = run(plate);
    let stiff = 70e9 / (1.0 - 0.0625);
    let wanted = [
        1e-6 * at.y,
        -2e-6 * at.z,
        stiff * (1e-6 - 0.25 * 2e-6),
        stiff * (-2e-6 + 0.25 * 1e-6),
        0.0,
        0.25 / 0.75 * 1e-6,
    ];
    for (row, wanted) in wanted.into_iter().enumerate() {
        let first = outcome.rows[row][0];
        let scale = if wanted == 0.0 { 1.0 } else { wanted.abs() };
        assert!((first - wanted).abs() < 1e-5 * scale, "{row}: {first} of {wanted}");
    }
}

/// A notch severs what it crosses, and no more: the strip is then two pieces, whose energy is kept.
#[test]
fn a_notch_parts_a_strip() {
    let mut pieces = Vec::new();
    for reach in [0.0, 0.011] {
        let mut beam = strip(0, 2);
        let normal = Vec3::y();
        let part = vec![Region::HalfSpace { point: Vec3::y() * reach, normal }];
        let notch = Notch { point: Vec3::new(0.01, 0.0, 0.0), normal: Vec3::x(), part };
        beam.initial.notches = vec![notch];
        (beam.settings.breaks, beam.settings.damping, beam.output.end) = (true, 0.0, 1e-5);
        pieces.push(run(beam).pieces);
    }
    assert_eq!(pieces.iter().map(Vec::len).collect::<Vec<_>>(), [1, 2]);
    let [large, small] = pieces[1][..] else { panic!("two") };
    assert!((large - 0.6).abs() < 0.03 && (small - 0.4).abs() < 0.03, "{large} {small}");
}

/// What a plate has not is refused with the bound.
#[test]
fn what_is_no_plate_of_this_kind_is_refused() {
    let why = |change: &dyn Fn(&mut SpecimenProblem)| {
        let mut specimen = strip(0, 2);
        change(&mut specimen);
        SpecimenRun::begin(specimen, &[FAMILY]).expect_err("refused").to_string()
    };
    let thick = why(&|s| {
        let size = Vec3::new(0.1, 0.02, 0.01);
        s.body.mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    });
    assert!(thick.contains("thickness"), "{thick}");
    let turned = why(&|s| s.body.mesh = s.body.mesh.transformed(&tilted()));
    assert!(turned.contains("between the plate's normal and an axis"), "{turned}");
    let notch = |normal| Notch { point: Vec3::zeros(), normal, part: Vec::new() };
    let lean = why(&|s| s.initial.notches = vec![notch(Vec3::new(0.8, 0.0, 0.6))]);
    assert!(lean.contains("lean of a notch"), "{lean}");
    let away = Vec3::new(0.2, 0.0, 0.0);
    let idle = why(&|s| s.initial.notches = vec![Notch { point: away, ..notch(Vec3::x()) }]);
    assert!(idle.contains("notch 1 takes nothing"), "{idle}");
    let patch = StrengthPatch { part: Vec::new(), strength: 1.0, damage: 0.5 };
    let damaged = why(&|s| s.matter.patches = vec![patch.clone()]);
    assert!(damaged.contains("damage of a patch"), "{damaged}");
    let far = why(&|s| s.output.probes = vec![moved(0, away)]);
    assert!(far.contains("probe 1 takes nothing"), "{far}");
}

fn tilted() -> cullet_geometry::Pose {
    let axes = [Vec3::new(0.8, 0.0, -0.6), Vec3::y(), Vec3::new(0.6, 0.0, 0.8)];
    cullet_geometry::Pose::from_parts(Vec3::zeros().into(), Quat::from_basis_unchecked(&axes))
}
