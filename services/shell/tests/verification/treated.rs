//! Treated glass: what starts it, what it breaks into, and that all of it adds up.

use super::pane::{adds_up, finished, pane};
use cullet_geometry::Vec3;
use cullet_model::{
    BrittleProblem, Fragment, FragmentOrigin, Fragmentation, Interlayer, Law, Problem, Settings,
    Solver, Treatment,
};
use cullet_shell::ShellSolver;
use cullet_shell::solve::ShellSolve;
use cullet_simd::SimdLevel;
use std::collections::BTreeSet;

const TOUGHENED: Treatment = Treatment::Toughened { surface_stress: 90e6 };

/// The problem of a pane whose glass was treated.
fn treated(problem: BrittleProblem, treatment: Treatment) -> Problem {
    let mut problem = Problem::from(problem);
    let Law::Brittle { material, strength, .. } = problem.law else { panic!("another law") };
    problem.law = Law::Treated { material, strength, treatment };
    problem
}

fn solve(problem: BrittleProblem, treatment: Treatment) -> Fragmentation {
    let mut solve = ShellSolver::begin(treated(problem, treatment)).expect("accepted");
    finished(|| solve.advance())
}

/// A pane of 200 × 200 × 4 mm under a steel ball of 30 mm.
fn small_pane(speed: f64, settings: Settings) -> BrittleProblem {
    let settings = Settings { spacing: Some(4e-3), ..settings };
    pane([0.2, 0.2, 0.004], 0.015, speed, settings)
}

/// A free pane of 300 × 300 × 8 mm under a steel ball of 50 mm.
fn free_pane(speed: f64, settings: Settings) -> BrittleProblem {
    let problem = pane([0.3, 0.3, 0.008], 0.025, speed, settings);
    BrittleProblem { supports: Vec::new(), ..problem }
}

/// Every piece a body of its own.
fn every_piece() -> Settings {
    Settings { max_fragments: 3000, debris: 0.0, ..Settings::default() }
}

/// Pieces of 4 mm with their middles in windows of 50 × 50 mm, away from the hit and the rim.
fn counts(found: &Fragmentation) -> Vec<usize> {
    let middle = |f: &Fragment| f.solid.mesh.mass_properties().centroid;
    let middles: Vec<Vec3> = found.fragments.iter().map(middle).collect();
    let corners = [[-0.075, -0.075], [0.025, -0.075], [-0.075, 0.025], [0.025, 0.025]];
    let within =
        |[x, y]: [f64; 2], p: &Vec3| (x..x + 0.05).contains(&p.x) && (y..y + 0.05).contains(&p.y);
    corners.iter().map(|c| middles.iter().filter(|p| within(*c, p)).count()).collect()
}

/// Vertices − edges + faces of a closed mesh: 2 for each ball, 0 for each ring.
fn euler(fragment: &Fragment) -> i64 {
    let mesh = &fragment.solid.mesh;
    let used: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
    used.len() as i64 - mesh.triangles.len() as i64 / 2
}

/// T1: a toughened plate of 4 mm with 90 MPa at its faces breaks into 40 to 100 pieces in
/// 50 × 50 mm, the fronts of which run as fast as they do in glass. V1: each of these hundreds of
/// pieces is closed and without a hole, and their volumes sum to that of the plate.
#[test]
fn a_toughened_pane_dices_as_the_standard_counts() {
    let problem = small_pane(20.0, every_piece());
    let found = solve(problem.clone(), TOUGHENED);
    let (counts, all) = (counts(&found), found.fragments.len());
    let detail = |name: &str| found.report.detail(name).unwrap();
    let [start, end] = ["start_of_dicing", "end_of_dicing"].map(detail);
    println!("{all} pieces, {counts:?} in 50 x 50 mm, from {start:.2e} s to {end:.2e} s");
    println!("{:?}", found.report.warnings);
    adds_up(&problem, &found);
    assert!(counts.iter().all(|count| (40..=100).contains(count)), "{counts:?}");
    assert!(all > 100 && found.fragments.iter().all(|f| euler(f) == 2));
    assert!(found.origins.iter().all(|origin| *origin == FragmentOrigin::Sampled));
    assert!(found.report.warnings.iter().any(|line| line.contains("F90")));
    // From about the middle to a corner at some 1500 m/s.
    let speed = 0.141 / (end - start);
    assert!((1200.0..1900.0).contains(&speed), "{speed} m/s");
    assert!(detail("energy_of_walls") >= found.report.crack_area * 8.0 * 0.8);
}

/// Above the most fragments: single pieces about the hit, conglomerates elsewhere, and debris.
#[test]
fn more_pieces_than_may_be_come_as_conglomerates() {
    let settings = Settings { max_fragments: 60, ..Settings::default() };
    let problem = small_pane(20.0, settings);
    let found = solve(problem.clone(), TOUGHENED);
    println!("{} fragments, {} grains", found.fragments.len(), found.debris.len());
    adds_up(&problem, &found);
    assert!((30..=60).contains(&found.fragments.len()), "{}", found.fragments.len());
    let piece = found.report.detail("width_of_pieces").unwrap();
    let volumes = found.fragments.iter().map(|f| f.solid.mesh.signed_volume());
    let most = volumes.fold(0.0, f64::max);
    assert!(most > 8.0 * piece * piece * 0.004, "the largest is {most} m3");
}

/// What does not break the faces leaves a toughened pane whole, whatever is frozen into it; and one
/// that stores too little breaks as a plain pane does.
#[test]
fn a_toughened_pane_dices_only_once_it_is_cut_and_only_by_its_own_energy() {
    let coarse = Settings { spacing: Some(8e-3), ..every_piece() };
    let large = |speed| free_pane(speed, coarse);
    let gentle = solve(large(0.8), TOUGHENED);
    assert_eq!((gentle.fragments.len(), gentle.debris.len()), (1, 0));
    let weak = Treatment::Toughened { surface_stress: 10e6 };
    let plain = solve(large(6.0), weak);
    assert!(plain.report.detail("pieces").is_none() && plain.fragments.len() > 1);
    let hard = solve(large(20.0), TOUGHENED);
    assert!(hard.report.detail("pieces").is_some_and(|pieces| pieces > 1000.0));
}

/// A ball that breaks annealed glass leaves heat-strengthened glass whole, and a faster one breaks
/// it into large pieces; toughened glass needs a faster one still.
#[test]
fn heat_strengthened_glass_needs_a_faster_ball() {
    let settings = Settings { spacing: Some(8e-3), ..Settings::default() };
    let problem = |speed| free_pane(speed, settings);
    let annealed = |speed| {
        let problem = Problem::from(problem(speed));
        let mut solve = ShellSolver::begin(problem).expect("accepted");
        finished(|| solve.advance()).fragments.len()
    };
    let strengthened = Treatment::HeatStrengthened { surface_stress: 40e6 };
    let treated = |speed| solve(problem(speed), strengthened).fragments.len();
    let speeds = [0.8, 1.3, 1.5, 1.7, 2.0, 3.0, 4.5];
    let [plain, strong]: [Vec<usize>; 2] =
        [speeds.map(annealed).to_vec(), speeds.map(treated).to_vec()];
    println!("at {speeds:?} m/s: annealed {plain:?}, heat-strengthened {strong:?}");
    let tough = speeds.map(|speed| solve(problem(speed), TOUGHENED).fragments.len()).to_vec();
    println!("toughened {tough:?}");
    let first = |counts: &[usize]| counts.iter().position(|count| *count > 1);
    assert!(first(&plain).is_some() && first(&strong) > first(&plain));
    assert!(first(&tough) > first(&strong));
    assert!(strong.iter().all(|count| *count < 60));
}

/// The plies crack and the film holds them; one that is as good as none lets a plug go.
#[test]
fn laminated_glass_stays_one_body_with_its_cracks_in_it() {
    let settings = Settings { spacing: Some(4e-3), ..Settings::default() };
    let problem = pane([0.3, 0.3, 0.008], 0.025, 6.0, settings);
    let mut plain = ShellSolver::begin(Problem::from(problem.clone())).expect("accepted");
    assert!(finished(|| plain.advance()).fragments.len() > 4);
    let film = |strength| Treatment::Laminated {
        interlayer: Interlayer { thickness: 0.76e-3, strength, stretch: 2.0 },
    };
    let held = solve(problem.clone(), film(20e6));
    println!("{:?}", held.report.warnings);
    let mesh = &problem.solid.mesh;
    assert_eq!((held.fragments.len(), held.debris.len()), (1, 0));
    let whole = &held.fragments[0];
    assert!((whole.solid.mesh.signed_volume() / mesh.signed_volume() - 1.0).abs() < 1e-12);
    let area = whole.sheet.mesh.area();
    assert!(whole.sheet.validate().is_ok());
    let walls = held.report.detail("area_of_held_cracks").unwrap();
    // Beside those between pieces there are cracks that end in them.
    let share = area / walls;
    assert!((0.98..1.3).contains(&share), "{area} m2 of cracks in it, {walls} m2 between");
    let torn = solve(problem.clone(), film(1e3));
    println!("{} fragments: {:?}", torn.fragments.len(), torn.report.warnings);
    adds_up(&problem, &torn);
    let volume = |f: &Fragment| f.solid.mesh.signed_volume();
    assert!(torn.fragments.len() > 1 && !torn.fragments[0].sheet.is_empty());
    assert!(volume(&torn.fragments[0]) > 0.9 * mesh.signed_volume());
}

/// The seed moves the cells, and nothing else does: not the threads, not the registers.
#[test]
fn cells_are_the_seeds_and_the_same_bits_everywhere() {
    let run = |seed: u64, level: SimdLevel, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = Settings { max_fragments: 60, ..Settings::default() };
        let problem = BrittleProblem { seed, ..small_pane(20.0, settings) };
        pool.install(|| {
            let mut solve =
                ShellSolve::<f64, 9>::of_plate(&problem, Some(TOUGHENED), level).expect("accepted");
            finished(|| solve.advance())
        })
    };
    let one = run(1, SimdLevel::portable(), 1);
    for level in SimdLevel::all() {
        assert_eq!(one, run(1, level, 2), "{level}");
    }
    let volume = |found: &Fragmentation| found.fragments[0].solid.mesh.signed_volume();
    let (one, two) = (volume(&one), volume(&run(2, SimdLevel::best(), 2)));
    assert!((one / two - 1.0).abs() > 1e-6, "{one} m3 with either seed");
}

/// Numbers out of their bounds are refused, and so is treated glass as another family's law.
#[test]
fn treatments_that_are_none_are_refused() {
    let problem = small_pane(20.0, Settings::default());
    let refused = |treatment| {
        let problem = treated(problem.clone(), treatment);
        ShellSolver::accepts(&problem).expect_err("refused").to_string()
    };
    let none = refused(Treatment::Toughened { surface_stress: -90e6 });
    assert!(none.contains("surface stress [Pa] is -9.000e7"), "{none}");
    let interlayer = Interlayer { thickness: 0.76e-3, strength: 20e6, stretch: 0.5 };
    let short = refused(Treatment::Laminated { interlayer });
    assert!(short.contains("stretch of the interlayer [1] is 5.000e-1"), "{short}");
    let other = BrittleProblem::of(treated(problem.clone(), TOUGHENED), "brittle");
    let text = other.expect_err("refused").to_string();
    assert_eq!(text, "`brittle` takes no toughened glass as a law");
}
