//! Treated glass: what starts it, what it breaks into, and that all of it adds up.

use super::pane::{adds_up, finished, pane};
use cullet_geometry::Vec3;
use cullet_model::{
    BrittleProblem, Fragment, Fragmentation, Interlayer, Law, Problem, Progress, Settings,
    SolveOutcome, Solver, Treatment,
};
use cullet_shell::ShellSolver;
use cullet_shell::solve::PlateSolve;
use cullet_simd::SimdLevel;

const TOUGHENED: Treatment = Treatment::Toughened { surface_stress: 90e6 };

/// The problem of a pane whose glass was treated.
fn treated(problem: BrittleProblem, treatment: Treatment) -> Problem {
    let mut problem = Problem::from(problem);
    let Law::Brittle { material, strength } = problem.law else { panic!("another law") };
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

/// T1: a toughened plate of 4 mm with 90 MPa at its faces breaks into 40 to 100 pieces in
/// 50 × 50 mm, the fronts of which run as fast as they do in glass.
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
    assert!(found.sampled.iter().all(|sampled| *sampled));
    assert!(found.report.warnings.iter().any(|line| line.contains("F90")));
    // From about the middle to a corner at some 1500 m/s.
    let speed = 0.141 / (end - start);
    assert!((1200.0..1900.0).contains(&speed), "{speed} m/s");
    assert!(detail("energy_of_walls") >= found.report.crack_area * 8.0 * 0.8);
}
