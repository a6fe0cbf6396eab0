//! T14: a strip that is stretched between clamps and drawn in at its sides wrinkles along.

use cullet_geometry::{Mat3, Quat, Vec3, shapes};
use cullet_membrane::specimen::FAMILY;
use cullet_model::strength::{EVEN, Region};
use cullet_model::{Material, PointPrecision, StrengthField, SurfaceLaw};
use cullet_specimen::{
    Amplitude, Ending, Hold, InitialState, Matter, Output, PointField, PointLayout, PointSettings,
    Probe, SpecimenBody, SpecimenProblem, SpecimenRun, SpecimenSettings, Spot, Start, TensorPart,
    Where,
};

const LENGTH: f64 = 0.25;
/// Depth of a clamp \[m\].
const CLAMP: f64 = 0.0125;
const POISSON: f64 = 1.0 / 3.0;
/// How much nearer its sides are than the pull draws them \[1\].
const DRAWN: f64 = 1.6e-3;
/// How long drawing them in takes \[s\].
const DRAWING: f64 = 0.4;
/// A strip.
#[derive(Clone, Copy, Debug)]
struct Strip {
    width: f64,
    thickness: f64,
    spacing: f64,
    stretch: f64,
}

/// Places across the strip at which its height is read.
const PLACES: u32 = 60;

/// Beyond a plane across an axis, on the side where `out` is positive.
fn side(axis: usize, at: f64, out: f64) -> Where {
    let point = Vec3::ith(axis, at);
    vec![Region::HalfSpace { point, normal: Vec3::ith(axis, -out) }]
}

fn hold(part: Where, axes: [bool; 3], inward: f64) -> Hold {
    Hold {
        part,
        axes,
        velocity: Vec3::y() * inward,
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        course: Amplitude::Table(vec![(0.0, 1.0), (DRAWING, 1.0), (DRAWING, 0.0)]),
        until: None,
    }
}

fn height(width: f64, k: u32) -> f64 {
    0.9 * width * (f64::from(k) / f64::from(PLACES - 1) - 0.5)
}

/// The strip, stretched along x.
fn problem(strip: Strip, seed: u64) -> SpecimenProblem {
    let Strip { width, thickness, spacing, stretch } = strip;
    let size = Vec3::new(LENGTH, width, thickness);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).unwrap();
    let material = Material {
        density: 1000.0,
        young: 1e6,
        poisson: POISSON,
        failure_stress: 1e6,
        fracture_energy: 1e3,
    };
    let drawn = Mat3::from_diagonal(&Vec3::new(stretch, -POISSON * stretch, 0.0));
    let inward = 0.5 * width * DRAWN / DRAWING;
    let (half, clamp) = (0.5 * width, 0.5 * LENGTH - CLAMP);
    let across = |k: u32| {
        let at = Spot::At(Vec3::new(0.0, height(width, k), 0.0));
        Probe::Points(PointField::Displacement, TensorPart::Axis(2), at)
    };
    let noise = Start {
        part: Where::new(),
        velocity: Vec3::zeros(),
        gradient: Mat3::zeros(),
        centre: Vec3::zeros(),
        noise: 1e-3,
    };
    SpecimenProblem {
        family: FAMILY.name.to_owned(),
        body: SpecimenBody { mesh, parts: vec![], turn: Quat::identity(), shift: Vec3::zeros() },
        matter: Matter {
            material,
            surface: SurfaceLaw::of(&material),
            flow: None,
            zones: vec![],
            strength: StrengthField { weibull: EVEN, ..StrengthField::default() },
            patches: vec![],
        },
        initial: InitialState { stretch: drawn, starts: vec![noise], notches: vec![] },
        holds: vec![
            hold(side(0, clamp, 1.0), [true; 3], 0.0),
            hold(side(0, -clamp, -1.0), [true; 3], 0.0),
            hold(side(1, half, 1.0), [false, true, false], -inward),
            hold(side(1, -half, -1.0), [false, true, false], inward),
        ],
        symmetries: vec![],
        loads: vec![],
        output: Output {
            end: 0.6,
            probes: (0..PLACES).map(across).collect(),
            samples: 6,
            frames: 0,
            colour: (PointField::Damage, TensorPart::Size),
        },
        settings: settings(spacing, seed),
    }
}

fn settings(spacing: f64, seed: u64) -> SpecimenSettings {
    SpecimenSettings {
        spacing,
        step_factor: 0.7,
        precision: PointPrecision::Double,
        breaks: false,
        damping: 20.0,
        damped_until: None,
        max_points: 1e6,
        max_steps: 1e6,
        threads: 1,
        seed,
        points: PointSettings {
            per_cell: 8.0,
            layout: PointLayout::Scattered,
            welded: false,
            softening_length: None,
            look: 4,
        },
        horizon: None,
    }
}

/// Wavelength of the best fit of a line, a sine and a cosine \[m\].
fn dominant(rows: &[[f64; 2]]) -> f64 {
    let left = |wave: f64| {
        let k = std::f64::consts::TAU / wave;
        let matrix = nalgebra::DMatrix::from_fn(rows.len(), 4, |row, column| {
            let y = rows[row][0];
            [1.0, y / rows[0][0], (k * y).sin(), (k * y).cos()][column]
        });
        let heights = nalgebra::DVector::from_fn(rows.len(), |row, _| rows[row][1]);
        let fit = matrix.clone().svd(true, true).solve(&heights, 1e-12).unwrap();
        (matrix * fit - heights).norm()
    };
    let waves = (0..200).map(|k| 0.008 * 1.015_f64.powi(k)).take_while(|wave| *wave < 0.16);
    waves.min_by(|a, b| left(*a).total_cmp(&left(*b))).unwrap()
}

/// λ = 2√π (B/T)^¼ √L, that of the least pressure from the sides at which it buckles, does not
/// hold for a strip that is much thinner than its spacing. Bonds that reach δ across a strip with
/// the strain ε along add E h ε δ²/320 to B: those across are pressed, those aslant are pulled, and
/// a wrinkle makes shorter chords of the first. Wrinkles are those of both together.
#[test]
fn a_stretched_strip_wrinkles_by_the_bending_of_sheet_and_bonds() {
    let strip = Strip { width: 0.12, thickness: 2.5e-4, spacing: 3.4e-3, stretch: 0.1 };
    let Strip { width, thickness, spacing, stretch } = strip;
    let outcome = SpecimenRun::begin(problem(strip, 1), &[FAMILY]).unwrap().finished();
    assert_eq!(outcome.ending, Ending::Ok);
    let free = LENGTH - 2.0 * CLAMP;
    let own = thickness * thickness / (12.0 * (1.0 - POISSON * POISSON));
    let reach = 3.015 * spacing;
    let more = stretch * reach * reach / 320.0;
    let law = |bending: f64| {
        2.0 * std::f64::consts::PI.sqrt() * (bending / stretch).powf(0.25) * free.sqrt()
    };
    let at = |k: u32| [height(width, k), outcome.rows[k as usize][6]];
    let last: Vec<[f64; 2]> = (0..PLACES).map(at).collect();
    let size = last.iter().map(|row| row[1].abs()).fold(0.0, f64::max);
    // The width is drawn in, too.
    let wave = dominant(&last) * (1.0 - POISSON * stretch - DRAWN);
    println!(
        "{:.1} mm of {:.1} mm, with the bonds' {:.1} mm; {:.3} mm high",
        wave * 1e3,
        law(own) * 1e3,
        law(own + more) * 1e3,
        size * 1e3
    );
    assert!(size > thickness, "{size}");
    assert!((wave / law(own + more) - 1.0).abs() < 0.15, "{wave} {}", law(own + more));
}
