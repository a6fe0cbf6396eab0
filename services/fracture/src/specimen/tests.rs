mod refusals;

use super::FAMILY;
use crate::mpm::domain::stable_step;
use cullet_geometry::{Mat3, Quat, Vec3, shapes};
use cullet_model::strength::Region;
use cullet_model::{Material, PointPrecision, StrengthField, SurfaceLaw};
use cullet_specimen::{
    Amplitude, Ending, Hold, InitialState, Load, LoadKind, Matter, Output, PointField, PointLayout,
    PointSettings, Probe, Reduce, SpecimenBody, SpecimenOutcome, SpecimenProblem, SpecimenRun,
    SpecimenSettings, Spot, Start, SymmetryPlane, TensorPart, Unfit, Where, Zone,
};

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.0,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};

/// A bar along x from 0, free, that cannot break.
fn bar(length: f64, side: f64, spacing: f64) -> SpecimenProblem {
    let size = Vec3::new(length, side, side);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    let mesh = mesh.translated(size / 2.0);
    let strength = StrengthField { weibull: f64::INFINITY, ..StrengthField::default() };
    SpecimenProblem {
        family: "brittle".to_owned(),
        body: SpecimenBody {
            mesh,
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
            samples: 100,
            frames: 0,
            colour: (PointField::Damage, TensorPart::Size),
        },
        settings: settings(spacing),
    }
}

fn settings(spacing: f64) -> SpecimenSettings {
    SpecimenSettings {
        spacing,
        step_factor: 0.8,
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
            layout: PointLayout::Rows,
            welded: false,
            softening_length: None,
            look: 4,
        },
        horizon: None,
    }
}

/// A specimen with other numbers to be sampled.
fn watching(mut specimen: SpecimenProblem, probes: Vec<Probe>) -> SpecimenProblem {
    specimen.output.probes = probes;
    specimen
}

fn begun(specimen: SpecimenProblem) -> Result<SpecimenRun, Unfit> {
    SpecimenRun::begin(specimen, &[FAMILY])
}

fn run(specimen: SpecimenProblem) -> SpecimenOutcome {
    begun(specimen).expect("taken").finished()
}

fn face(axis: usize, place: f64, up: bool) -> Where {
    let sign = if up { -1.0 } else { 1.0 };
    let normal = Vec3::ith(axis, sign);
    vec![Region::HalfSpace { point: Vec3::ith(axis, place), normal }]
}

fn everywhere(field: PointField, part: TensorPart) -> Probe {
    Probe::Points(field, part, Spot::Over(Vec::new(), Reduce::Mean))
}

/// The same bar driven by hand, without any of this module: the mean velocity is the same number.
#[test]
fn a_driven_bar_agrees_with_one_written_by_hand() {
    use crate::damage::Softening;
    use crate::mpm::Domain;
    use crate::mpm::domain::PrescribedVelocity;
    use crate::particles::Particles;
    let (h, length) = (0.01, 0.2);
    let hold = Hold {
        part: face(0, 0.0, false),
        axes: [true; 3],
        velocity: Vec3::x(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::constant(),
        until: None,
    };
    let probes = vec![everywhere(PointField::Velocity, TensorPart::Axis(0)), Probe::Elastic];
    let bar = bar(length, 2.0 * h, h);
    let specimen = watching(SpecimenProblem { holds: vec![hold], ..bar }, probes);
    let step = 0.8 * stable_step(&STONE, h);
    let steps = (specimen.output.end / step).ceil();
    let outcome = run(specimen);
    assert_eq!((outcome.ending, outcome.steps), (Ending::Ok, steps as u64));

    let mut points = Vec::new();
    for (i, j, k) in (0..40).flat_map(|i| (0..16).map(move |n| (i, n / 4, n % 4))) {
        points
            .push(Vec3::new(f64::from(i) + 0.5, f64::from(j) + 0.5, f64::from(k) + 0.5) * h / 2.0);
    }
    let volume = length * 4.0 * h * h;
    let strong = Material { failure_stress: 1e20, fracture_energy: 1e40, ..STONE };
    let particles = Particles::at_rest(&points, volume, STONE.density);
    let mut domain = Domain::new(particles, &STONE, Softening::new(&strong, h), Vec3::repeat(h));
    domain.step = 1e-4 / steps;
    let grip = |x: Vec3| (x.x < 1e-9).then(Vec3::x);
    domain.prescribed = Some(PrescribedVelocity(std::sync::Arc::new(grip)));
    (0..steps as u64).for_each(|_| _ = domain.advance());
    let mean = domain.motions().iter().map(|m| m.velocity.x).sum::<f64>() / 640.0;
    let sampled = outcome.rows[0].last().expect("a sample");
    assert!((mean / sampled - 1.0).abs() < 1e-9, "{mean} and {sampled}");
    let (elastic, sampled) = (domain.elastic_energy(), outcome.rows[1].last().expect("a sample"));
    assert!((elastic / sampled - 1.0).abs() < 1e-9, "{elastic} and {sampled}");
}

/// A free bar under a steady pull at one end: its momentum is the force times the time, and the
/// work done is the energy that it has.
#[test]
fn loads_give_their_impulse_and_their_work() {
    let pull = |push| Load { part: face(0, 0.2, true), push, course: Amplitude::constant() };
    let traction = LoadKind::Traction(Vec3::new(1e5, 2e4, 0.0));
    for push in [traction, LoadKind::Pressure(-1e5)] {
        let probes = vec![
            Probe::Momentum(TensorPart::Axis(0)),
            Probe::Applied(0, TensorPart::Axis(0)),
            Probe::Work,
            Probe::Balance,
        ];
        let loaded = SpecimenProblem { loads: vec![pull(push)], ..bar(0.2, 0.02, 0.01) };
        let outcome = run(watching(loaded, probes));
        let last = |row: usize| *outcome.rows[row].last().expect("a sample");
        let force = 1e5 * 0.02 * 0.02;
        assert!((last(1) / force - 1.0).abs() < 1e-9, "{} of {force} N", last(1));
        assert!((last(0) / (force * 1e-4) - 1.0).abs() < 1e-9, "{}", last(0));
        assert!(last(2) > 0.0 && last(3).abs() < 0.02 * last(2), "{} of {}", last(3), last(2));
    }
}

/// A load on a part of a face is its pressure times the area of that part, however the facets and
/// the grid lie: of a disc far smaller than a spacing too, and on both sides of a line.
#[test]
fn the_force_on_a_part_of_a_face_is_that_of_its_area() {
    let tip = |y: f64, z: f64| Vec3::new(0.05, y, z);
    let disc = |radius: f64| {
        let (from, to) = (tip(0.013, 0.022) - Vec3::x() * 0.001, tip(0.013, 0.022));
        vec![Region::Cylinder { from, to, radius }]
    };
    let ball = Region::Sphere { centre: Vec3::new(0.053, 0.02, 0.02), radius: 0.005 };
    let patch = Region::Box { low: tip(0.0031, 0.0052), high: tip(0.0103, 0.0079) };
    let right = Region::HalfSpace { point: tip(0.01, 0.01), normal: -Vec3::y() };
    let below = Region::HalfSpace { point: tip(0.0, 0.0171), normal: Vec3::z() };
    let end = || face(0, 0.05, true);
    let pi = std::f64::consts::PI;
    let parts = [
        (disc(0.0007), pi * 0.0007 * 0.0007, 1e-4),
        (disc(0.0083), pi * 0.0083 * 0.0083, 1e-4),
        (vec![ball], pi * 0.004 * 0.004, 1e-4),
        (vec![patch], 0.0072 * 0.0027, 1e-9),
        ([end(), vec![right]].concat(), 0.03 * 0.04, 1e-9),
        ([end(), vec![right, below]].concat(), 0.03 * 0.0171, 1e-9),
        (end(), 0.04 * 0.04, 1e-9),
    ];
    for spacing in [0.0097, 0.005, 0.0023] {
        for degrees in [0.0_f64, 31.0] {
            let turn = Quat::from_axis_angle(&Vec3::z_axis(), degrees.to_radians());
            let loads = parts.iter().flat_map(|(part, ..)| {
                let pushes =
                    [LoadKind::Pressure(1e6), LoadKind::Traction(Vec3::new(0.0, 1e6, 0.0))];
                pushes.map(|push| Load { part: part.clone(), push, course: Amplitude::constant() })
            });
            let loads: Vec<Load> = loads.collect();
            let count = loads.len() as u32;
            let axis = |k: u32| TensorPart::Axis((k % 2) as u8);
            let mut specimen = SpecimenProblem { loads, ..bar(0.05, 0.04, spacing) };
            specimen.output.probes = (0..count).map(|k| Probe::Applied(k, axis(k))).collect();
            (specimen.output.end, specimen.output.samples) = (1e-8, 1);
            specimen.body.turn = turn;
            let outcome = run(specimen);
            for (k, (part, area, most)) in parts.iter().enumerate() {
                let told = [0, 1].map(|way| outcome.rows[2 * k + way][0]);
                let off = [told[0] / (-1e6 * area) - 1.0, told[1] / (1e6 * area) - 1.0];
                assert!(off.iter().all(|o| o.abs() < *most), "{part:?} at {spacing}: {off:?}");
            }
        }
    }
}

/// Half a bar with a plane of symmetry moves as the whole one does.
#[test]
fn a_plane_of_symmetry_stands_for_the_other_half() {
    let ends = |x: f64, up| Load {
        part: face(0, x, up),
        push: LoadKind::Pressure(-1e6),
        course: Amplitude::constant(),
    };
    let at = |x: f64| {
        let at = Spot::At(Vec3::new(x, 0.012, 0.013));
        Probe::Points(PointField::Displacement, TensorPart::Axis(0), at)
    };
    let probes = vec![at(0.195), at(0.111)];
    let mut whole = watching(bar(0.2, 0.04, 0.01), probes.clone());
    whole.matter.material.poisson = 0.2;
    whole.loads = vec![ends(0.0, false), ends(0.2, true)];
    let mut half = watching(bar(0.1, 0.04, 0.01), probes);
    half.matter.material.poisson = 0.2;
    half.body.mesh = half.body.mesh.translated(Vec3::x() * 0.1);
    half.loads = vec![ends(0.2, true)];
    half.symmetries = vec![SymmetryPlane { axis: 0, at: 0.1 }];
    let (whole, half) = (run(whole), run(half));
    for (a, b) in whole.rows.iter().zip(&half.rows) {
        let scale = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() < 1e-9 * scale, "{x} and {y}, of {scale}");
        }
    }
}

/// A turned specimen gives the same numbers in its own frame where the grid does not matter: a
/// stretched one has the stress of the stretch.
#[test]
fn a_turned_specimen_speaks_in_its_own_frame() {
    let stretch = Mat3::new(1e-4, 2e-5, 0.0, 2e-5, -3e-5, 0.0, 0.0, 0.0, 0.0);
    let material = Material { poisson: 0.25, ..STONE };
    let parts = [
        TensorPart::Pair(0),
        TensorPart::Pair(1),
        TensorPart::Pair(3),
        TensorPart::Greatest,
        TensorPart::Mises,
    ];
    let probes: Vec<Probe> =
        parts.iter().map(|&part| everywhere(PointField::Stress, part)).collect();
    let first = |turn| {
        let mut specimen = watching(bar(0.08, 0.04, 0.01), probes.clone());
        specimen.matter.material = material;
        (specimen.initial.stretch, specimen.body.turn) = (stretch, turn);
        specimen.output.end = 1e-6;
        run(specimen).rows.iter().map(|row| row[0]).collect::<Vec<_>>()
    };
    let straight = first(Quat::identity());
    let turned = first(Quat::from_euler_angles(0.3, -0.5, 0.9));
    for (a, b) in straight.iter().zip(&turned) {
        assert!((a - b).abs() < 1e-6 * straight[0], "{straight:?} and {turned:?}");
    }
    let (lame, shear) = (material.lame(), material.shear());
    let wanted = lame * (1e-4 - 3e-5) + 2.0 * shear * 1e-4;
    assert!((straight[0] / wanted - 1.0).abs() < 1e-3, "{} and {wanted}", straight[0]);
}

/// A step far over its bound is reported as an instability, not as numbers.
#[test]
fn a_step_over_its_bound_ends_as_unstable() {
    let start = Start {
        part: Vec::new(),
        velocity: Vec3::zeros(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        noise: 1.0,
    };
    let mut specimen = bar(0.1, 0.04, 0.01);
    (specimen.initial.starts, specimen.output.end) = (vec![start], 1e-2);
    specimen.settings.step_factor = 2.5;
    let ending = run(specimen).ending;
    assert!(matches!(ending, Ending::Unstable(_) | Ending::NotFinite(_)), "{ending:?}");
}

/// A cube whose every node is made to move as an even stretch along x asks, until all of it is
/// broken; what is sampled is the dissipated energy and the stress along x.
fn stretched(length: f64) -> SpecimenProblem {
    let rate = 2.0;
    let hold = Hold {
        part: Vec::new(),
        axes: [true; 3],
        velocity: Vec3::zeros(),
        gradient: Mat3::from_diagonal(&Vec3::new(rate, 0.0, 0.0)),
        centre: Vec3::zeros(),
        course: Amplitude::constant(),
        until: None,
    };
    let probes = vec![
        Probe::Dissipated,
        Probe::Points(PointField::Stress, TensorPart::Pair(0), Spot::Over(Vec::new(), Reduce::Max)),
    ];
    let mut specimen = watching(bar(0.04, 0.04, 0.01), probes);
    specimen.holds = vec![hold];
    specimen.settings.breaks = true;
    specimen.settings.points.softening_length = Some(length);
    specimen.settings.step_factor = 0.1;
    specimen.output.samples = 1000;
    // The strain at which a point is fully broken is 2 G_f/(σ_f l).
    specimen.output.end =
        1.2 * 2.0 * STONE.fracture_energy / (STONE.failure_stress * length) / rate;
    specimen
}

/// The greatest stress along x over the strength.
fn peak(outcome: &SpecimenOutcome) -> f64 {
    outcome.rows[1].iter().fold(0.0_f64, |m, &s| m.max(s)) / STONE.failure_stress
}

/// Each point spends its own energy: that of F-U, G_f over the length.
#[test]
fn an_even_stretch_spends_the_energy_of_the_law_everywhere() {
    let length = 0.008;
    let outcome = run(stretched(length));
    let spent = *outcome.rows[0].last().expect("a sample");
    let wanted = STONE.fracture_energy / length * libm::pow(0.04, 3.0);
    assert!((spent / wanted - 1.0).abs() < 0.02, "{spent} of {wanted} J");
    assert!((peak(&outcome) - 1.0).abs() < 0.02, "{}", peak(&outcome));
}

/// Velocities of two supports of the same nodes add up, and the first of them feels the force.
#[test]
fn two_supports_of_the_same_nodes_are_one_of_their_sum() {
    let mut one = stretched(0.008);
    one.output.end *= 0.1;
    // It moves off as well, so that there is a force.
    one.holds[0].centre = Vec3::new(-1.0, 0.0, 0.0);
    one.output.probes.push(Probe::Reaction(0, TensorPart::Axis(0)));
    let mut two = one.clone();
    two.holds[0].gradient *= 0.25;
    let rest = Hold { gradient: two.holds[0].gradient * 3.0, ..two.holds[0].clone() };
    two.holds.push(rest);
    two.output.probes.push(Probe::Reaction(1, TensorPart::Axis(0)));
    let (one, two) = (run(one), run(two));
    let most = |row: &[f64]| row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(most(&one.rows[1]) > 1e5 && most(&one.rows[2]) > 0.0);
    for (first, second) in one.rows.iter().zip(&two.rows) {
        let apart: Vec<f64> = first.iter().zip(second).map(|(a, b)| a - b).collect();
        assert!(most(&apart) <= 1e-9 * most(first), "{first:?} is not {second:?}");
    }
    assert!(most(&two.rows[3]) < 1e-9 * most(&two.rows[2]), "{:?}", two.rows[3]);
}

/// A weak plane across the pull gives way at its share of the strength, one along it does not,
/// however the specimen lies on the grid.
#[test]
fn weak_planes_turn_with_the_specimen() {
    for (normal, wanted) in [(Vec3::x(), 0.6), (Vec3::y(), 1.0)] {
        for turn in [0.0, std::f64::consts::FRAC_PI_2] {
            let mut specimen = stretched(0.008);
            specimen.matter.strength.weak_plane =
                Some(cullet_model::PatternWeakPlane { normal, ratio: 0.6 });
            specimen.body.turn = Quat::from_axis_angle(&Vec3::z_axis(), turn);
            let peak = peak(&run(specimen));
            assert!((peak - wanted).abs() < 0.02, "{peak} of {wanted}, turned by {turn}");
        }
    }
}

/// Two bars that touch end to end, the second of another material: one body's motion, the other's
/// rest, and none of the books lost. At the end they part.
#[test]
fn two_bodies_of_two_materials_meet_and_part() {
    let h = 0.01;
    let mut specimen = bar(0.2, 2.0 * h, h);
    let other = specimen.body.mesh.translated(Vec3::x() * 0.2);
    specimen.body.parts = vec![specimen.body.mesh.triangles.len() as u32];
    specimen.body.mesh.append(&other);
    let right = vec![Region::HalfSpace { point: Vec3::x() * 0.2, normal: -Vec3::x() }];
    let left = vec![Region::HalfSpace { point: Vec3::x() * 0.2, normal: Vec3::x() }];
    // The same impedance at half the speed of waves: all the momentum goes over.
    let soft = Material { density: 2.0 * STONE.density, young: 0.5 * STONE.young, ..STONE };
    specimen.matter.zones = vec![Zone { part: right.clone(), material: soft }];
    specimen.initial.starts = vec![Start {
        part: left.clone(),
        velocity: Vec3::x(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        noise: 0.0,
    }];
    let mean = |part: &Where| {
        let spot = Spot::Over(part.clone(), Reduce::Mean);
        Probe::Points(PointField::Velocity, TensorPart::Axis(0), spot)
    };
    specimen.output.probes = vec![mean(&left), mean(&right), Probe::Momentum(TensorPart::Axis(0))];
    specimen.output.end = 2.0 * 0.2 / 3614.0 * 1.6;
    let outcome = run(specimen);
    assert_eq!(outcome.ending, Ending::Ok);
    let last = |row: usize| *outcome.rows[row].last().expect("a sample");
    // Masses 1 : 2; twenty spacings of a sharp front leave some ringing.
    assert!(last(0).abs() < 0.1, "the first stands: {}", last(0));
    assert!((last(1) - 0.5).abs() < 0.05, "the second flies: {}", last(1));
    let (first, end) = (outcome.rows[2][0], last(2));
    assert!((end / first - 1.0).abs() < 1e-12, "{first} {end}");
}

/// What is there then is rounding, and no instability.
#[test]
fn a_bar_on_which_nothing_acts_stays_at_rest_to_its_end() {
    for precision in [PointPrecision::Single, PointPrecision::Double] {
        let mut specimen = bar(0.1, 0.04, 0.01);
        specimen.output.end = 1e-3;
        specimen.settings.points.layout = PointLayout::Scattered;
        specimen.settings.precision = precision;
        let out = run(specimen);
        assert_eq!(out.ending, Ending::Ok, "{precision:?}");
        assert!(out.steps > 400, "{} steps", out.steps);
    }
}

/// Cracks put points in another order: a frame shows each where it is then, whenever the last
/// sample was.
#[test]
fn a_frame_between_two_samples_shows_points_where_they_are() {
    let end = |x: f64, up: bool| Hold {
        part: face(0, x, up),
        axes: [true, false, false],
        velocity: Vec3::x() * if up { 1.0 } else { -1.0 },
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::constant(),
        until: None,
    };
    let torn = |samples: u32| {
        let mut bar = bar(0.2, 0.04, 0.01);
        bar.holds = vec![end(0.0, false), end(0.2, true)];
        bar.settings.breaks = true;
        bar.output.end = 3e-4;
        (bar.output.samples, bar.output.frames) = (samples, 20);
        run(bar)
    };
    let (often, seldom) = (torn(20), torn(3));
    assert!(often.pieces[0] < 0.9, "it is not torn: {:?}", often.pieces);
    assert_eq!((often.frames.len(), seldom.times.len()), (21, 4));
    assert!(often.frames == seldom.frames);
}
