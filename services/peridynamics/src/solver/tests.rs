//! Dents and parts by hand, what is refused, and what must not depend on threads and processors.

use super::Peridynamics;
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BodyShape, BondGrain, BondedSolid, BrittleProblem, Deformation, Failure, Fragmentation,
    Hardening, Impact, Law, Material, Problem, Progress, Settings, SolveOutcome, Solver, Support,
};
use cullet_simd::SimdLevel;
use std::sync::Arc;

const METAL: Material = Material {
    density: 2700.0,
    young: 70e9,
    poisson: 0.3,
    failure_stress: 300e6,
    fracture_energy: 1e4,
};
const GLASS: Material = Material {
    density: 2500.0,
    young: 70e9,
    poisson: 0.22,
    failure_stress: 50e6,
    fracture_energy: 8.0,
};
const SOFT: Hardening = Hardening { yield_stress: 200e6, hardening: 400e6, exponent: 1.0 };

fn elastic() -> BondedSolid {
    BondedSolid { breaks: false, ..BondedSolid::default() }
}

fn yielding() -> BondedSolid {
    BondedSolid { hardening: Some(SOFT), ..elastic() }
}

/// Of a stiff ball at a speed \[m/s\].
fn hit(point: Vec3, normal: Vec3, [radius, mass]: [f64; 2], speed: f64) -> Impact {
    let modulus = 70e9 / (1.0 - 0.3 * 0.3);
    let energy = 0.5 * mass * speed * speed;
    let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
    let deepest = libm::pow(2.5 * energy / stiffness, 0.4);
    Impact {
        point,
        normal,
        impulse: 2.0 * mass * speed,
        duration: 2.943 * deepest / speed,
        radius: (radius * deepest).sqrt(),
        energy,
        closing_speed: speed,
        crushing_pressure: 1e12,
    }
}

/// A free panel of 10 × 10 × 2 cm that a ball of 2 cm radius meets in its middle from above.
fn panel(material: Material, bonds: BondedSolid, speed: f64) -> Problem {
    let size = Vec3::new(0.1, 0.1, 0.02);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a panel");
    let top = Vec3::new(0.0, 0.0, 0.01);
    Problem {
        body: BodyShape::Solid(Arc::new(Solid::outer(mesh))),
        law: Law::Bonded { material, bonds },
        impacts: vec![hit(top, -Vec3::z(), [0.02, 0.15], speed)],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings { spacing: Some(0.008), ..Settings::default() },
        seed: 1,
    }
}

fn ended(problem: Problem) -> Result<SolveOutcome, Failure> {
    run(Peridynamics::begin(problem).expect("accepted"))
}

fn run(mut solve: Peridynamics) -> Result<SolveOutcome, Failure> {
    loop {
        match solve.advance() {
            Progress::Running(share) => assert!((0.0..=1.0).contains(&share)),
            Progress::Done(outcome) => return Ok(outcome),
            Progress::Failed(failure) => return Err(failure),
        }
    }
}

fn deformed(problem: Problem) -> Deformation {
    match ended(problem) {
        Ok(SolveOutcome::Deformed(found)) => *found,
        other => panic!("not deformed: {:?}", other.map(|it| it.report().clone())),
    }
}

/// Mass \[kg\], momentum \[kg m/s\] and angular momentum about the origin of what there is now.
fn sums(found: &Fragmentation, density: f64) -> (f64, Vec3, Vec3) {
    let mut sum = (0.0, Vec3::zeros(), Vec3::zeros());
    for fragment in &found.fragments {
        let whole = fragment.solid.mesh.mass_properties();
        let mass = density * whole.volume;
        sum.0 += mass;
        sum.1 += fragment.velocity * mass;
        sum.2 += whole.centroid.cross(&fragment.velocity) * mass;
        sum.2 += whole.inertia * fragment.spin * density;
    }
    for grain in &found.debris {
        sum.0 += density * grain.volume;
        sum.1 += grain.velocity * density * grain.volume;
        sum.2 += grain.position.cross(&grain.velocity) * density * grain.volume;
    }
    sum
}

/// Too slow for anything: the same body, moved as the hit moves it.
#[test]
fn a_slow_ball_leaves_a_panel_as_it_was() {
    let problem = panel(GLASS, BondedSolid::default(), 0.05);
    let before = Arc::clone(problem.body.solid().expect("a solid"));
    let outcome = ended(problem).expect("solved");
    let SolveOutcome::Unchanged(found) = outcome else { panic!("{:?}", outcome.report()) };
    assert_eq!(found.fragments[0].solid, *before);
    let given = found.report.detail("delivered_impulse").expect("told");
    let (mass, momentum, _) = sums(&found, GLASS.density);
    assert!((mass - GLASS.density * 2e-4).abs() < 1e-9 * mass);
    assert!((momentum.z + given).abs() < 1e-9 * given, "{momentum}, {given}");
    assert!((0.9..2.0).contains(&(given / (0.15 * 0.05))), "{given}");
    assert!((found.report.detail("energy_balance").expect("told") - 1.0).abs() < 0.01);
}

/// A dent keeps the volume, its energy is accounted for, and the ball's momentum moves the panel.
#[test]
fn a_ball_leaves_a_dent_in_metal() {
    let problem = panel(METAL, yielding(), 25.0);
    let energy = problem.impacts[0].energy;
    let found = deformed(problem);
    let mesh = &found.body.solid().expect("a solid").mesh;
    assert!((mesh.signed_volume() / 2e-4 - 1.0).abs() < 1e-12, "{}", mesh.signed_volume());
    let detail = |name| found.report.detail(name).expect("told");
    assert!((detail("energy_balance") - 1.0).abs() < 0.01, "{:?}", found.report);
    assert!(detail("dent") > 1e-4 && detail("dent") < 5e-3, "{:?}", found.report);
    assert!(found.work > 0.1 * energy && found.work < energy, "{} of {energy} J", found.work);
    let middle = mesh.vertices.iter().filter(|x| x.xy().norm() < 0.005 && x.z > 0.0);
    let deep = middle.map(|x| 0.01 - x.z).fold(f64::NEG_INFINITY, f64::max);
    assert!(deep > 1e-4, "the face lies {deep} m deep in its middle");
    let momentum = found.velocity * METAL.density * mesh.signed_volume();
    let given = detail("delivered_impulse");
    assert!((momentum.z + given).abs() < 1e-9 * given, "{momentum}, {given}");
    // What does not yield springs back.
    let outcome = ended(panel(METAL, elastic(), 25.0)).expect("solved");
    assert!(matches!(outcome, SolveOutcome::Unchanged(_)), "{:?}", outcome.report());
}

/// A horizon that is too short for weights that bear alike in all directions is told.
#[test]
fn loose_bonds_are_told() {
    let told = |horizon: f64| {
        let problem = panel(METAL, BondedSolid { horizon, ..yielding() }, 5.0);
        let outcome = ended(problem).expect("solved");
        let report = outcome.report();
        let loose = report.detail("points_with_loose_bonds").expect("told");
        (loose, report.warnings.iter().any(|line| line.contains("bear alike")))
    };
    let (few, many) = (told(3.015), told(2.0));
    assert!(few.0 > 0.0 && !few.1, "{few:?}");
    assert!(many.0 > 2.0 * few.0 && many.1, "{many:?}");
}

/// Where a step strains by more than what yields, the work of flow is still what was lost.
#[test]
fn the_energy_of_fast_flow_is_accounted_for() {
    let hardening = Some(Hardening { yield_stress: 50e6, hardening: 300e6, exponent: 1.0 });
    let found = deformed(panel(METAL, BondedSolid { hardening, ..elastic() }, 15.0));
    let detail = |name| found.report.detail(name).expect("told");
    let energy = 0.5 * 0.15 * 15.0 * 15.0;
    println!("fast flow: {} of {energy} J, {}", detail("plastic_work"), detail("energy_balance"));
    assert!(detail("plastic_work") > 0.4 * energy, "{:?}", found.report);
    assert!((detail("energy_balance") - 1.0).abs() < 0.01, "{:?}", found.report);
}

/// Glass falls into parts, whose mass and momenta are those of what was given.
#[test]
fn a_ball_breaks_a_panel_of_glass() {
    let mut problem = panel(GLASS, BondedSolid::default(), 20.0);
    problem.impacts[0].point = Vec3::new(0.01, 0.005, 0.01);
    let mut solve = Peridynamics::begin(problem).expect("accepted");
    while !matches!(solve.advance(), Progress::Done(_) | Progress::Failed(_)) {}
    let given = solve.given();
    let found = match solve.finish() {
        Ok(SolveOutcome::Broken(found)) => *found,
        other => panic!("{:?}", other.map(|it| it.report().clone())),
    };
    assert!(found.fragments.len() > 3, "{:?}", found.report);
    let (mass, momentum, angular) = sums(&found, GLASS.density);
    assert!((mass / (GLASS.density * 2e-4) - 1.0).abs() < 1e-9, "{mass}");
    assert!((momentum - given[0]).norm() < 1e-9 * given[0].norm(), "{momentum}, {given:?}");
    let about = angular - middle(&found).cross(&momentum);
    let scale = given[0].norm() * 0.05;
    assert!((about - given[1]).norm() < 1e-3 * scale, "{about}, {given:?}");
    assert!((found.report.detail("energy_balance").expect("told") - 1.0).abs() < 0.05);
    assert!(found.fragments.iter().all(|it| it.solid.mesh.is_closed()));
}

fn middle(found: &Fragmentation) -> Vec3 {
    let mut sum = (0.0, Vec3::zeros());
    for fragment in &found.fragments {
        let whole = fragment.solid.mesh.mass_properties();
        sum = (sum.0 + whole.volume, sum.1 + whole.centroid * whole.volume);
    }
    for grain in &found.debris {
        sum = (sum.0 + grain.volume, sum.1 + grain.position * grain.volume);
    }
    sum.1 / sum.0
}

/// The points carry what presses gave them.
#[test]
fn points_carry_what_was_given() {
    let mut problem = panel(GLASS, BondedSolid::default(), 20.0);
    problem.impacts[0].point = Vec3::new(0.02, -0.01, 0.01);
    let mut solve = Peridynamics::begin(problem).expect("accepted");
    while !matches!(solve.advance(), Progress::Done(_) | Progress::Failed(_)) {}
    let [momentum, about] = solve.given();
    let (sums, masses) = (solve.body.domain.sums(), solve.body.masses());
    let places = solve.body.domain.places.iter().zip(&masses);
    let middle = places.map(|(x, m)| x * *m).sum::<Vec3>() / masses.iter().sum::<f64>();
    let own = sums.angular - middle.cross(&sums.momentum);
    assert!((sums.momentum - momentum).norm() < 1e-6 * momentum.norm(), "{sums:?}, {momentum}");
    assert!((own - about).norm() < 1e-3 * about.norm(), "{own}, {about}");
}

/// The same bits on any processor, with any number of threads.
#[test]
fn outcomes_do_not_depend_on_threads_and_processors() {
    let found = |level| {
        let mut problem = panel(GLASS, BondedSolid::default(), 40.0);
        let size = Vec3::new(0.05, 0.05, 0.025);
        let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a block");
        problem.body = BodyShape::Solid(Arc::new(Solid::outer(mesh)));
        problem.impacts[0].point.z = 0.0125;
        let (problem, bonds) = BrittleProblem::bonded(problem, "peridynamics").expect("bonds");
        run(Peridynamics::with(problem, bonds, level).expect("accepted")).expect("solved")
    };
    let first = found(SimdLevel::best());
    for level in SimdLevel::all() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let again = pool.expect("threads").install(|| found(level));
            assert_eq!(again, first, "{level:?}, {threads} threads");
        }
    }
}

/// What flows beyond what bonds hold for is another family's, with the figure.
#[test]
fn what_flows_too_far_is_handed_over() {
    let hardening = Some(Hardening { yield_stress: 20e6, hardening: 0.0, exponent: 1.0 });
    let bonds = BondedSolid { hardening, ..elastic() };
    let failure = ended(panel(METAL, bonds, 60.0)).expect_err("beyond");
    assert!(matches!(failure, Failure::Beyond { .. }), "{failure}");
    let words = failure.to_string();
    assert!(words.contains("bonds hold up to") || words.contains("bonds hold down to"), "{words}");
}

#[test]
fn what_cannot_be_solved_is_refused_with_its_bound() {
    let refused = |change: fn(&mut Problem, &mut BondedSolid)| {
        let mut problem = panel(GLASS, BondedSolid::default(), 20.0);
        let Law::Bonded { material, mut bonds } = problem.law.clone() else { panic!("bonds") };
        change(&mut problem, &mut bonds);
        if let Law::Bonded { .. } = problem.law {
            problem.law = Law::Bonded { material, bonds };
        }
        match Peridynamics::accepts(&problem) {
            Ok(_) => Peridynamics::begin(problem).map(|_| ()).expect_err("refused").to_string(),
            Err(refusal) => refusal.to_string(),
        }
    };
    for (change, words) in [
        ((|p, _| p.impacts.clear()) as fn(&mut Problem, &mut BondedSolid), "the number of impacts"),
        (|p, _| p.settings.max_steps = 10, "the number of steps"),
        (|p, _| p.settings.spacing = Some(1e-4), "the number of particles"),
        (|p, _| p.settings.spacing = Some(0.03), "the number of particles"),
        (|p, _| p.settings.spacing = Some(0.0125), "too thin"),
        (|p, _| p.spin = Vec3::z() * 100.0, "it knows no stress of a spin"),
        (|_, b| b.horizon = 5.0, "horizon over the distance of points"),
        (
            |p, _| {
                p.settings.spacing = Some(4e-4);
                p.settings.max_particles = 50_000_000;
                p.settings.max_steps = 10_000_000;
            },
            "the memory of bonds",
        ),
        (
            |_, b| {
                let (axis, strength) = (Vec3::x() * 3.0, 1.0);
                b.grain = Some(BondGrain { axis, strength, stretch: 1.0 });
            },
            "length of the grain's axis",
        ),
        (
            |p, _| p.law = Law::Yielding { material: METAL, hardening: SOFT },
            "takes no yielding as a law",
        ),
        (
            |_, b| b.hardening = Some(Hardening { yield_stress: 9e9, ..SOFT }),
            "yield stress over Young's modulus",
        ),
    ] {
        let found = refused(change);
        assert!(found.contains(words), "{found}, not {words}");
    }
}

/// A support takes what the ball brings: the panel stays where it is.
#[test]
fn a_support_holds_the_panel() {
    let mut problem = panel(METAL, yielding(), 15.0);
    let (point, normal) = (Vec3::new(0.0, 0.0, -0.01), Vec3::z());
    problem.supports = vec![Support { point, normal, radius: 0.1, mobility: 0.0 }];
    let outcome = ended(problem).expect("solved");
    let (reaction, velocity) = match &outcome {
        SolveOutcome::Deformed(it) => (it.reactions[0], it.velocity),
        SolveOutcome::Unchanged(it) => (it.reactions[0], it.fragments[0].velocity),
        SolveOutcome::Broken(_) => panic!("{:?}", outcome.report()),
    };
    let brought = 0.15 * 15.0;
    assert!(reaction > 0.8 * brought, "{reaction} of {brought}, {velocity}");
    let momentum = velocity * METAL.density * 2e-4;
    let given = outcome.report().detail("delivered_impulse").expect("told");
    assert!(
        (momentum.z + given - reaction).abs() < 1e-6 * given,
        "{momentum}, {given}, {reaction}"
    );
}
