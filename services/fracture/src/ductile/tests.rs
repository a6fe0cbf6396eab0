//! Dents by hand, what is refused, and what must not depend on threads and processors.

mod torn;

use super::Ductile;
use cullet_geometry::{Solid, TriMesh, Vec3, shapes};
use cullet_model::{
    BodyShape, BrittleProblem, Deformation, Fragmentation, Hardening, Impact, Law, Material,
    PointPrecision, Problem, Progress, Settings, SolveOutcome, Solver, Support,
};
use cullet_simd::SimdLevel;
use std::sync::Arc;

const LEAD: Material = Material {
    density: 11340.0,
    young: 16e9,
    poisson: 0.44,
    failure_stress: 20e6,
    fracture_energy: 2e4,
};
const SOFT: Hardening = Hardening { yield_stress: 20e6, hardening: 0.0, exponent: 1.0 };

/// Of a ball on the middle of a face, at a speed \[m/s\].
fn hit(point: Vec3, normal: Vec3, [radius, mass]: [f64; 2], speed: f64) -> Impact {
    // Hertz's, of a stiff ball on lead.
    let modulus = 16e9 / (1.0 - 0.44 * 0.44);
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

/// A block of 8 × 8 × 4 cm on a plane; on its upper face falls a ball of 2 cm radius and 100 g.
fn block(speed: f64) -> Problem {
    let size = Vec3::new(0.08, 0.08, 0.04);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a block");
    let top = Vec3::new(0.0, 0.0, 0.02);
    // The block is heavy beside the ball: m* is nearly the ball's.
    let impact = hit(top, -Vec3::z(), [0.02, 0.0966], speed);
    let support = Support { point: -top, normal: Vec3::z(), radius: 0.1, mobility: 0.0 };
    Problem {
        body: BodyShape::Solid(Arc::new(Solid::outer(mesh))),
        law: Law::Yielding { material: LEAD, hardening: SOFT },
        impacts: vec![impact],
        supports: vec![support],
        spin: Vec3::zeros(),
        settings: Settings { spacing: Some(0.006), ..Settings::default() },
        seed: 1,
    }
}

fn end(mut solve: Ductile) -> SolveOutcome {
    loop {
        match solve.advance() {
            Progress::Running(share) => assert!((0.0..=1.0).contains(&share)),
            Progress::Done(outcome) => return outcome,
            Progress::Failed(failure) => panic!("{failure}"),
        }
    }
}

fn deformed(problem: Problem) -> Deformation {
    match end(Ductile::begin(problem).expect("accepted")) {
        SolveOutcome::Deformed(found) => *found,
        other => panic!("not deformed: {:?}", other.report()),
    }
}

fn unchanged(problem: Problem) -> Fragmentation {
    match end(Ductile::begin(problem).expect("accepted")) {
        SolveOutcome::Unchanged(found) => *found,
        other => panic!("deformed: {:?}", other.report()),
    }
}

fn mesh(found: &Deformation) -> &TriMesh {
    &found.body.solid().expect("a solid").mesh
}

/// How deep the upper face lies at its middle \[m\].
fn depth(found: &Deformation) -> f64 {
    let near = mesh(found).vertices.iter().filter(|x| x.xy().norm() < 0.004 && x.z > 0.0);
    0.02 - near.map(|x| x.z).fold(f64::INFINITY, f64::min)
}

/// A ball's dent: E = 3πσ_yRδ² where all around the contact flows \[Tabor 1951\], were it as wide
/// as the ball is there; what piles up at its rim makes it wider, and it springs back. The volume
/// stays, and the energy is accounted for.
#[test]
fn a_ball_leaves_its_dent() {
    let problem = block(20.0);
    let energy = problem.impacts[0].energy;
    let found = deformed(problem);
    let pressed = 3.0 * std::f64::consts::PI * SOFT.yield_stress * 0.02;
    let wanted = (energy / pressed).sqrt();
    let found_depth = depth(&found);
    assert!((0.78..1.0).contains(&(found_depth / wanted)), "{found_depth} m, about {wanted}");
    let volume = mesh(&found).signed_volume() / (0.08 * 0.08 * 0.04);
    assert!((volume - 1.0).abs() < 1e-12, "{volume}");
    let detail = |name| found.report.detail(name).expect("told");
    assert!(detail("volume_change").abs() < 2e-3, "{:?}", found.report);
    assert!((detail("energy_balance") - 1.0).abs() < 0.03, "{:?}", found.report);
    assert!(found.work < energy && found.work > 0.6 * energy, "{} of {energy} J", found.work);
    // What the ball gave less what the plane took moves the block.
    let mass = LEAD.density * 0.08 * 0.08 * 0.04;
    let given = detail("delivered_impulse") - found.reactions[0];
    assert!((found.velocity.z * mass + given).abs() < 1e-6 * given.abs().max(0.1), "{given}");
    assert!(detail("delivered_impulse") > 0.9 * 0.0966 * 20.0);
}

/// Too slow to flow: the same body, moved as the hit moves it.
#[test]
fn a_slow_ball_leaves_nothing() {
    let mut problem = block(0.02);
    problem.supports.clear();
    let before = Arc::clone(problem.body.solid().expect("a solid"));
    let found = unchanged(problem);
    assert_eq!(found.fragments[0].solid, *before);
    let mass = LEAD.density * 0.08 * 0.08 * 0.04;
    let given = found.report.detail("delivered_impulse").expect("told");
    assert!(given > 0.9 * 0.0966 * 0.02, "{given}");
    assert!((found.fragments[0].velocity.z * mass + given).abs() < 1e-9);
}

/// The dent is that of any step, on any processor, with any number of threads.
#[test]
fn dents_do_not_depend_on_how_they_are_worked_out() {
    let begin = |level| {
        let mut problem = block(20.0);
        problem.settings.spacing = Some(0.008);
        problem.settings.precision = PointPrecision::Single;
        let (problem, flow) = BrittleProblem::yielding(problem, "ductile").expect("yields");
        Ductile::with(problem, flow, level).expect("accepted")
    };
    let found = |solve| match end(solve) {
        SolveOutcome::Deformed(found) => *found,
        other => panic!("{:?}", other.report()),
    };
    let first = found(begin(SimdLevel::best()));
    for level in SimdLevel::all() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let again = pool.expect("threads").install(|| found(begin(level)));
            assert_eq!(again, first, "{level:?}, {threads} threads");
        }
    }
    let mut short = begin(SimdLevel::best());
    short.setup.step *= 0.5;
    let half = found(short);
    let ratio = depth(&half) / depth(&first);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn what_cannot_be_solved_is_refused_with_its_bound() {
    let refused = |change: fn(&mut Problem)| {
        let mut problem = block(20.0);
        change(&mut problem);
        Ductile::accepts(&problem).expect_err("refused").to_string()
    };
    for (change, words) in [
        ((|p| p.impacts.clear()) as fn(&mut Problem), "the number of impacts"),
        (|p| p.settings.max_steps = 10, "the number of steps"),
        (|p| p.settings.spacing = Some(1e-4), "the number of particles"),
        (|p| p.settings.spacing = Some(0.03), "the number of particles"),
        (|p| p.law = Law::even(LEAD), "a law"),
        (
            |p| {
                let hardening = Hardening { yield_stress: 9e9, ..SOFT };
                p.law = Law::Yielding { material: LEAD, hardening };
            },
            "yield stress over Young's modulus",
        ),
        (
            |p| {
                let hardening = Hardening { exponent: 2.0, ..SOFT };
                p.law = Law::Yielding { material: LEAD, hardening };
            },
            "exponent of hardening",
        ),
    ] {
        let found = refused(change);
        assert!(found.contains(words), "{found}");
    }
    // A layer of cells has no bending.
    let mut thin = block(20.0);
    thin.settings.spacing = Some(0.016);
    assert!(Ductile::begin(thin).is_err());
}

/// A dent narrower than the cells is told.
#[test]
fn a_dent_that_the_cells_cannot_show_is_told() {
    let warned = |speed| {
        let solve = Ductile::begin(block(speed)).expect("accepted");
        solve.record.warnings.iter().any(|line| line.contains("(F101)"))
    };
    assert!(warned(0.5) && !warned(20.0));
}

/// What flow cannot have done to a volume is told.
#[test]
fn a_volume_that_changes_is_told() {
    let mut solve = Ductile::begin(block(20.0)).expect("accepted");
    solve.domain.displace(|x| x * 0.02);
    solve.domain.set_node_velocities(&vec![Vec3::zeros(); solve.domain.grid.nodes.len()]);
    // Energy from nowhere would end it first.
    solve.problem.impacts[0].energy = 1e9;
    solve.record.plastic = 1.5e7;
    let SolveOutcome::Deformed(found) = solve.finish().expect("a shape") else { panic!("whole") };
    assert!(found.report.warnings.iter().any(|line| line.contains("(F102)")), "{:?}", found.report);
    assert!((found.report.detail("volume_change").expect("told") - 0.0612).abs() < 2e-3);
}

/// The step follows what is pressed flat, and the report has words for what is pressed flatter than
/// weights of the body at rest hold for.
#[test]
fn what_is_pressed_too_flat_is_told() {
    let mut problem = block(30.0);
    problem.settings.spacing = Some(0.01);
    problem.supports.clear();
    let hardening = Hardening { yield_stress: 1e5, ..SOFT };
    problem.law = Law::Yielding { material: LEAD, hardening };
    let mut solve = Ductile::begin(problem).expect("accepted");
    let mut thinnest = 0.0_f64;
    for _ in 0..40 {
        if !matches!(solve.advance(), Progress::Running(_)) {
            break;
        }
        thinnest = thinnest.max(solve.record.thinnest);
    }
    assert!(thinnest > 1.5, "{thinnest}");
    // The step follows as far as that.
    assert!(solve.domain.step < 0.9 * solve.setup.step);
    solve.record.thinnest = 500.0;
    solve.problem.impacts[0].energy = 1e9;
    solve.record.plastic = 1.5e7;
    let found = solve.finish().expect("a shape");
    let told = found.report().warnings.iter().any(|line| line.contains("(F103)"));
    assert!(told, "{:?}", found.report());
}

/// A hit beside the middle of a free body: what the grid carries is what was given, and the result
/// moves and turns as that.
#[test]
fn the_result_carries_what_was_given() {
    let mut problem = block(20.0);
    problem.supports.clear();
    problem.settings.spacing = Some(0.008);
    problem.impacts[0].point = Vec3::new(0.025, 0.01, 0.02);
    let mut solve = Ductile::begin(problem).expect("accepted");
    while !matches!(solve.advance(), Progress::Done(_)) {}
    let given = solve.strikers[0].given;
    let grid = solve.domain.momentum();
    assert!((grid - given).norm() < 1e-10 * given.norm(), "{grid}, given {given}");
    let moment = solve.strikers[0].moment;
    let (turning, twice) = (solve.domain.angular_momentum(), moment.norm());
    assert!((turning - moment).norm() < 1e-9 * twice, "{turning}, given {moment}");
    let SolveOutcome::Deformed(found) = solve.finish().expect("a shape") else { panic!("whole") };
    let whole = mesh(&found).mass_properties();
    let velocity = grid / (LEAD.density * whole.volume);
    assert!((found.velocity - velocity).norm() < 1e-6 * velocity.norm());
    // About the middle, which has moved a little.
    let wanted = Vec3::new(0.01, -0.025, 0.0) * given.z;
    let spin = whole.inertia * found.spin * LEAD.density;
    assert!((spin - wanted).norm() < 0.1 * wanted.norm(), "{spin}, about {wanted}");
}

/// A contact that crushes takes the energy, and the ball gives no more than the world found.
#[test]
fn a_soft_ball_dents_less_and_a_hit_is_spent() {
    let crushed = |pressure| {
        let mut problem = block(20.0);
        problem.impacts[0].crushing_pressure = pressure;
        deformed(problem)
    };
    let (hard, soft) = (crushed(1e12), crushed(45e6));
    let taken = soft.report.detail("energy_of_crushed_contact").expect("told");
    assert!(taken > 2.0 && soft.work < hard.work - 1.5, "{taken} J, {} {}", soft.work, hard.work);
    assert!((soft.report.detail("energy_balance").expect("told") - 1.0).abs() < 0.05);
    let mut problem = block(20.0);
    problem.impacts[0].impulse = 1.0;
    let spent = deformed(problem).report.detail("delivered_impulse").expect("told");
    assert!((spent - 1.0).abs() < 1e-12, "{spent}");
}

/// Supports that lie on one another are no stiffer than one.
#[test]
fn supports_do_not_add_up() {
    let mut problem = block(20.0);
    let once = deformed(problem.clone());
    problem.supports = vec![problem.supports[0]; 4];
    let often = deformed(problem);
    assert_eq!(often.body, once.body);
    assert_eq!(often.reactions[1..], [0.0; 3]);
}
