//! Plates that are pierced.

use super::{Ductile, end};
use cullet_geometry::{Solid, TriMesh, Vec3, shapes};
use cullet_model::{
    BodyShape, BrittleProblem, DuctileFailure, Fragmentation, Hardening, Impact, JohnsonCook, Law,
    Material, Problem, Settings, SolveOutcome, Solver, Support,
};
use cullet_simd::SimdLevel;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Aluminium 6061-T6.
const ALUMINIUM: Material = Material {
    density: 2700.0,
    young: 69e9,
    poisson: 0.33,
    failure_stress: 3e8,
    fracture_energy: 2e4,
};
const FLOW: JohnsonCook = JohnsonCook {
    hardening: Hardening { yield_stress: 324e6, hardening: 114e6, exponent: 0.42 },
    rate: 0.002,
    reference_rate: 1.0,
    softening: None,
    failure: Some(DuctileFailure { d: [-0.77, 1.45, -0.47, 0.0, 1.6] }),
};

/// A plate of 5 × 5 × 0.9 cm that a steel ball of 6 mm radius and 7 g hits in the middle.
fn plate(speed: f64) -> Problem {
    let size = Vec3::new(0.05, 0.05, 0.009);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a plate");
    let (mass, ball) = (0.007, 0.006);
    let own = ALUMINIUM.density * size.product();
    let reduced = mass * own / (mass + own);
    let energy = 0.5 * reduced * speed * speed;
    let modulus = 69e9 / (1.0 - 0.33 * 0.33);
    let deepest = libm::pow(2.5 * energy / (4.0 / 3.0 * modulus * libm::sqrt(ball)), 0.4);
    let impact = Impact {
        point: Vec3::new(0.0, 0.0, 0.0045),
        normal: -Vec3::z(),
        impulse: 2.0 * reduced * speed,
        duration: 2.943 * deepest / speed,
        radius: (ball * deepest).sqrt(),
        energy,
        closing_speed: speed,
        crushing_pressure: 1e12,
    };
    Problem {
        body: BodyShape::Solid(Arc::new(Solid::outer(mesh))),
        law: Law::JohnsonCook { material: ALUMINIUM, flow: FLOW },
        impacts: vec![impact],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { spacing: Some(0.003), ..Settings::default() },
        seed: 1,
    }
}

/// What is left of a plate, with the instructions of a processor.
fn pierced(level: SimdLevel) -> Fragmentation {
    let (problem, flow) = BrittleProblem::yielding(plate(500.0), "ductile").expect("yields");
    match end(Ductile::with(problem, flow, level).expect("accepted")) {
        SolveOutcome::Broken(found) => *found,
        other => panic!("whole: {:#?}", other.report()),
    }
}

/// V − E + F of a closed mesh: 2 for a ball, 0 for a ring.
fn euler(mesh: &TriMesh) -> i64 {
    let used: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
    used.len() as i64 - mesh.triangles.len() as i64 / 2
}

/// The plate has a hole, and what was there flies on; nothing of its volume, of the momentum or of
/// the energy is lost, and threads and processors make no difference.
#[test]
fn a_fast_ball_pierces_a_plate() {
    let found = pierced(SimdLevel::best());
    let plate = &found.fragments[0].solid.mesh;
    assert_eq!(euler(plate), 0, "one hole");
    // It lies where it was, and what flew drew nothing of it along.
    let (low, high) = plate.bounds().expect("a plate");
    let size = high.sup(&-low);
    assert!(size.x < 0.026 && size.y < 0.026 && size.z < 0.012, "{size}");
    let volume = 0.05 * 0.05 * 0.009;
    let parts = found.fragments.iter().map(|it| it.solid.mesh.signed_volume());
    let all = parts.sum::<f64>() + found.debris.iter().map(|it| it.volume).sum::<f64>();
    assert!((all / volume - 1.0).abs() < 1e-9, "{all} of {volume}");
    let share = plate.signed_volume() / volume;
    // A cylinder of the ball's radius would leave 0.955.
    assert!((0.9..0.98).contains(&share), "{share}");
    let moved = found.fragments.iter().map(|it| it.velocity * it.solid.mesh.signed_volume());
    let flown = found.debris.iter().map(|it| it.velocity * it.volume);
    let momentum = moved.chain(flown).sum::<Vec3>() * ALUMINIUM.density;
    let detail = |name| found.report.detail(name).expect("told");
    let given = detail("delivered_impulse");
    assert!((momentum.z / given + 1.0).abs() < 1e-9, "{momentum}, given {given}");
    // The ball keeps a part of its speed.
    assert!((0.2..0.9).contains(&(given / (0.007 * 500.0))), "{given} N s");
    assert!((detail("energy_balance") - 1.0).abs() < 0.03, "{:?}", found.report);
    assert!(detail("torn_points") > 100.0 && found.report.crack_area > 0.0);
    let fly = found.debris.iter().all(|it| it.velocity.z < found.fragments[0].velocity.z);
    assert!(fly, "the plate would outrun its debris");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let other = *SimdLevel::all().last().expect("a level");
    assert_eq!(pool.install(|| pierced(other)), found);
}

/// What tears over a support is pressed on both sides.
#[test]
fn a_plate_tears_over_its_support() {
    let mut problem = plate(500.0);
    let (point, normal) = (Vec3::new(0.0, 0.0, -0.0045), Vec3::z());
    problem.supports = vec![Support { point, normal, radius: 0.03, mobility: 0.0 }];
    let found = end(Ductile::begin(problem).expect("accepted"));
    let detail = |name| found.report().detail(name).expect("told");
    assert!(detail("torn_points") > 50.0, "{:#?}", found.report());
    assert!((detail("energy_balance") - 1.0).abs() < 0.05, "{:#?}", found.report());
}
