//! Panes of glass under a ball: what parts, what it costs, and that all of it adds up.

use cullet_geometry::shapes::{self, Detail};
use cullet_geometry::{Quat, Solid, Vec3};
use cullet_model::{
    BrittleProblem, Fragment, FragmentOrigin, Fragmentation, Impact, Material, Problem, Progress,
    Settings, Solver, StrengthField, Support, SurfaceLaw,
};
use cullet_shell::ShellSolver;
use cullet_shell::solve::ShellSolve;
use cullet_simd::SimdLevel;
use std::sync::Arc;

pub(super) const GLASS: Material = Material {
    density: 2440.0,
    young: 72e9,
    poisson: 0.22,
    failure_stress: 50e6,
    fracture_energy: 8.0,
};

/// A steel ball that meets the upper face of a pane: H1.
fn ball(radius: f64, speed: f64, pane: f64, point: Vec3) -> Impact {
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let reduced = 1.0 / (1.0 / mass + 1.0 / pane);
    let modulus = 1.0 / ((1.0 - 0.09) / 200e9 + (1.0 - 0.22 * 0.22) / 72e9);
    let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
    let approach = (1.25 * reduced * speed * speed / stiffness).powf(0.4);
    Impact {
        point,
        normal: -Vec3::z(),
        impulse: 2.0 * reduced * speed,
        duration: 2.943_3 * approach / speed,
        radius: (radius * approach).sqrt(),
        energy: 0.5 * reduced * speed * speed,
        closing_speed: speed,
        crushing_pressure: 1e12,
    }
}

/// A pane under a ball, on supports at its corners.
pub(super) fn pane(size: [f64; 3], radius: f64, speed: f64, settings: Settings) -> BrittleProblem {
    let mesh = shapes::cuboid(Vec3::from(size), Detail::default()).unwrap();
    let mass = GLASS.density * mesh.signed_volume();
    let [x, y, z] = size.map(|s| 0.5 * s);
    let corner = |k: usize| Support {
        point: Vec3::new(if k.is_multiple_of(2) { -x } else { x }, if k < 2 { -y } else { y }, -z)
            * 0.97,
        normal: Vec3::z(),
        radius: 5e-3,
        mobility: 0.0,
    };
    BrittleProblem {
        solid: Arc::new(Solid::outer(mesh)),
        material: GLASS,
        strength: StrengthField { weibull: 7.0, seed: 4, ..StrengthField::even() },
        surface: SurfaceLaw::of(&GLASS),
        impacts: vec![ball(radius, speed, mass, Vec3::new(0.006, -0.004, z))],
        supports: (0..4).map(corner).collect(),
        spin: Vec3::zeros(),
        settings,
        seed: 1,
    }
}

pub(super) fn solve(problem: BrittleProblem) -> Fragmentation {
    let mut solve = ShellSolver::begin(Problem::from(problem)).expect("accepted");
    finished(|| solve.advance())
}

pub(super) fn finished(mut advance: impl FnMut() -> Progress) -> Fragmentation {
    loop {
        match advance() {
            Progress::Running(_) => {}
            Progress::Done(outcome) => return outcome.fracture().expect("not deformed"),
            Progress::Failed(failure) => panic!("{failure}"),
        }
    }
}

/// All of a pane is there afterwards, closed, and the ball's push is what the parts carry.
pub(super) fn adds_up(problem: &BrittleProblem, found: &Fragmentation) {
    let mesh = &problem.solid.mesh;
    let volume = |f: &Fragment| f.solid.mesh.signed_volume();
    let sum: f64 = found.fragments.iter().map(volume).sum::<f64>()
        + found.debris.iter().map(|grain| grain.volume).sum::<f64>();
    assert!((sum / mesh.signed_volume() - 1.0).abs() < 1e-9, "{sum}");
    assert!(found.fragments.iter().all(|f| f.solid.mesh.is_closed()));
    let carried: Vec3 = found.fragments.iter().map(|f| f.velocity * volume(f)).sum::<Vec3>()
        + found.debris.iter().map(|grain| grain.velocity * grain.volume).sum::<Vec3>();
    let given = found.report.detail("delivered_impulse").unwrap();
    let held: f64 = found.reactions.iter().sum();
    let wanted = Vec3::z() * (held - given);
    assert!((carried * GLASS.density - wanted).norm() < 1e-3 * given, "{carried} of {wanted}");
    let balance = found.report.detail("energy_balance").unwrap();
    assert!((balance - 1.0).abs() < 0.02, "energy off by {balance}");
}

/// A ball just above the threshold: radial cracks from the hit to the rim, all of them solved.
#[test]
fn a_pane_breaks_into_a_star() {
    let settings = Settings { spacing: Some(4e-3), ..Settings::default() };
    let problem = pane([0.3, 0.3, 0.008], 0.025, 2.5, settings);
    let found = solve(problem.clone());
    let count = found.fragments.len();
    println!("{count} fragments, crack {:.3e} m2", found.report.crack_area);
    adds_up(&problem, &found);
    assert!((5..=20).contains(&count), "{count} fragments");
    // Sectors between radials reach the rim, all of them solved; others lie within the ring.
    let far =
        |f: &Fragment| f.solid.mesh.vertices.iter().fold(0.0, |m: f64, x| m.max(x.xy().amax()));
    let parts = found.fragments.iter().zip(&found.origins);
    let sectors: Vec<FragmentOrigin> =
        parts.filter(|(f, _)| far(f) > 0.1499).map(|(_, s)| *s).collect();
    assert!(sectors.iter().all(|origin| *origin == FragmentOrigin::Solved));
    let sectors = sectors.len();
    assert!(sectors >= 5, "{sectors} sectors");
}

/// Below the threshold nothing breaks, whatever stands in space how: the same pane, turned.
#[test]
fn a_gentle_touch_leaves_a_pane_whole() {
    let settings = Settings { spacing: Some(8e-3), ..Settings::default() };
    let mut problem = pane([0.3, 0.2, 0.008], 0.01, 0.3, settings);
    let turn = Quat::from_scaled_axis(Vec3::new(0.4, -1.1, 0.3));
    let mut solid = Solid::clone(&problem.solid);
    solid.mesh.vertices.iter_mut().for_each(|x| *x = turn * *x);
    problem.solid = Arc::new(solid);
    for hit in &mut problem.impacts {
        (hit.point, hit.normal) = (turn * hit.point, turn * hit.normal);
    }
    problem.supports.clear();
    let found = solve(problem.clone());
    assert_eq!((found.fragments.len(), found.debris.len()), (1, 0));
    let given = found.report.detail("delivered_impulse").unwrap();
    let volume = problem.solid.mesh.signed_volume();
    let carried = found.fragments[0].velocity * volume * GLASS.density;
    let along = carried.dot(&problem.impacts[0].normal);
    assert!((along / given - 1.0).abs() < 1e-6 && given > 0.0, "{along} of {given}");
}

/// A round pane takes as many points as it may have, as a square one does, and no more.
#[test]
fn a_round_pane_keeps_to_its_points() {
    let most = 1000;
    let settings = Settings { max_particles: most, ..Settings::default() };
    let square = pane([0.3, 0.3, 0.008], 0.01, 3.0, settings);
    let mut round = square.clone();
    let outline: Vec<[f64; 2]> = (0..48)
        .map(|k| f64::from(k) / 48.0 * std::f64::consts::TAU)
        .map(|a| [0.15 * a.cos(), 0.15 * a.sin()])
        .collect();
    let mesh = shapes::extrude(&outline, 0.008, Detail::default()).unwrap();
    round.solid = Arc::new(Solid::outer(mesh));
    for problem in [square, round] {
        let cost = ShellSolver::accepts(&Problem::from(problem)).expect("accepted");
        assert!((0.5..=1.1).contains(&(cost.particles / f64::from(most))), "{cost:?}");
    }
}

/// What is no thin plate, or asks for what a shell does not know, is refused with the bound.
#[test]
fn what_is_no_shell_is_refused() {
    let refused = |problem: BrittleProblem| {
        ShellSolver::accepts(&Problem::from(problem)).expect_err("refused").to_string()
    };
    let thick = pane([0.1, 0.1, 0.03], 0.01, 5.0, Settings::default());
    assert!(refused(thick).contains("thickness over the smaller extent of the plate is 3"));
    let mut ball = pane([0.3, 0.3, 0.004], 0.01, 5.0, Settings::default());
    let mesh = shapes::sphere(0.1, Detail::default()).unwrap();
    ball.solid = Arc::new(Solid::outer(mesh));
    let text = refused(ball);
    assert!(text.contains("parallel faces"), "{text}");
    let mut spun = pane([0.3, 0.3, 0.004], 0.01, 5.0, Settings::default());
    spun.spin = Vec3::x();
    assert!(refused(spun).contains("angular velocity of a shell"));
    let few = Settings { max_steps: 10, ..Settings::default() };
    let text = refused(pane([0.3, 0.3, 0.004], 0.01, 5.0, few));
    assert!(text.contains("the number of steps would be"), "{text}");
}

/// Same bits for any registers and threads, cracks and all.
#[test]
fn a_broken_pane_has_the_same_bits_everywhere() {
    let settings = Settings { spacing: Some(8e-3), ..Settings::default() };
    let run = |level: SimdLevel, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let problem = pane([0.24, 0.24, 0.008], 0.025, 3.0, settings);
        pool.install(|| {
            let mut solve =
                ShellSolve::<f64, 9>::of_plate(&problem, None, level).expect("accepted");
            finished(|| solve.advance())
        })
    };
    let one = run(SimdLevel::portable(), 1);
    assert!(one.fragments.len() > 1);
    for level in SimdLevel::all() {
        assert_eq!(one, run(level, 2), "{level}");
    }
}
