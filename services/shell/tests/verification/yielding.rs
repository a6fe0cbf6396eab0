//! Sheets that yield: limit loads, the ledger of a dent, the same bits everywhere.

use crate::equilibrium::Grid;
use crate::kernel::same_everywhere;
use crate::pane::pane;
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_model::{
    BodyShape, Hardening, Law, Material, Problem, Progress, Settings, SolveOutcome, Solver,
};
use cullet_shell::ShellSolver;
use cullet_shell::domain::{ShellDomain, ShellMaterial};
use cullet_shell::midsurface::Midsurface;
use cullet_shell::section::SectionLaw;
use cullet_simd::{Real, SimdLevel};

const YIELD: f64 = 250e6;
const T: f64 = 1e-3;

fn sheet<R: Real>(patch: &NurbsPatch, hardening: f64, level: SimdLevel) -> ShellDomain<R, 9> {
    let surface = Midsurface::of_patch(patch);
    let points = surface.points();
    let steel = Material {
        density: 7850.0,
        young: 210e9,
        poisson: 0.3,
        failure_stress: f64::INFINITY,
        fracture_energy: f64::INFINITY,
    };
    let law = Hardening { yield_stress: YIELD, hardening, exponent: 0.5 };
    let material = ShellMaterial {
        law: SectionLaw::new(&steel).yielding(law),
        density: steel.density,
        thickness: vec![T; points],
        strength: vec![f64::INFINITY; points],
        softening_cells: 1.1,
    };
    ShellDomain::new(surface, material, level)
}

/// How far the end of a strip sinks that is held at the other and bears `share` of its limit load
/// w σ_y t²/4L there, put on slowly, and how fast it still sinks \[m, m/s\].
fn loaded(share: f64) -> (f64, f64) {
    let (length, width) = (0.05, 0.01);
    let patch = NurbsPatch::sheet([length, width], [20, 4], 2).unwrap();
    let grid = Grid::of(&patch);
    let mut shell: ShellDomain<f64, 9> = sheet(&patch, 0.0, SimdLevel::best());
    let held: Vec<usize> = grid.column(0).into_iter().chain(grid.column(1)).collect();
    // The line load of a row of control points of degree 2 that are open at both ends.
    let tip = grid.column(grid.columns - 1);
    let shares: Vec<f64> = tip.iter().map(|&n| shell.mass[n]).collect();
    let all: f64 = shares.iter().sum();
    let load = share * width * YIELD * T * T / 4.0 / length;
    let (rise, end) = (0.02, 0.03);
    let steps = (end / shell.step) as usize;
    for step in 0..steps {
        let now = load * (step as f64 * shell.step / rise).min(1.0);
        for (&n, share) in tip.iter().zip(&shares) {
            shell.external[n] = Vec3::z() * (-now * share / all);
        }
        // The first flexural mode of the strip is damped by a tenth in each of its periods.
        shell.advance(|n, v| if held.contains(&n) { Vec3::zeros() } else { v * 0.9999 });
    }
    (-shell.moved(tip[2]).z, -shell.velocity[tip[2]].z)
}

/// A strip stands below its limit load as beam theory has it, PL³/3EI, and sinks far above it.
#[test]
fn a_strip_bears_its_limit_load() {
    let limit = 0.01 * YIELD * T * T / 4.0 / 0.05;
    let compliance = 0.05_f64.powi(3) * 4.0 / (210e9 * 0.01 * T.powi(3));
    let elastic = |share: f64| compliance * share * limit;
    for share in [0.6, 0.9] {
        let (sunk, speed) = loaded(share);
        let wanted = elastic(share);
        println!("{share} of the limit load: sunk {sunk:.3e} of {wanted:.3e} m, {speed:.2e} m/s");
        assert!(speed.abs() < 0.02, "{share}: {speed} m/s");
        assert!((sunk / wanted - 1.0).abs() < 0.05, "{share}: {sunk}, {wanted}");
    }
    // Where it is held it cannot narrow, so that it bears up to 2/√3 as much there.
    let (sunk, speed) = loaded(1.3);
    println!("1.3 of the limit load: sunk {sunk:.3e} m, {speed:.2e} m/s");
    assert!(sunk > 4.0 * elastic(1.3), "it stands at {sunk} m");
}

/// Control points along a side of the square sheet.
const SIDE: usize = 22;

/// Whether a control point of the square sheet is held: two rows, so that its rim does not turn.
fn is_rim(node: usize) -> bool {
    let from = |k: usize| k.min(SIDE - 1 - k);
    from(node % SIDE) < 2 || from(node / SIDE) < 2
}

/// A square sheet held along its rim whose middle is struck at `speed`; after some time.
fn struck<R: Real>(speed: f64, steps: usize, level: SimdLevel) -> (ShellDomain<R, 9>, f64, f64) {
    let patch = NurbsPatch::sheet([0.1, 0.1], [20, 20], 2).unwrap();
    let grid = Grid::of(&patch);
    let mut shell: ShellDomain<R, 9> = sheet(&patch, 300e6, level);
    assert_eq!([grid.columns, grid.rows], [SIDE; 2]);
    for n in (0..patch.points().len()).filter(|&n| !is_rim(n)) {
        let far = patch.points()[n].norm();
        shell.velocity[n] = Vec3::z() * (-speed * (-far * far / 4e-4).exp());
    }
    let given = shell.sums().kinetic;
    let mut dissipated = 0.0;
    for _ in 0..steps {
        let tally = shell.advance(|n, v| if is_rim(n) { Vec3::zeros() } else { v });
        dissipated += tally.points.dissipated;
    }
    (shell, given, dissipated)
}

/// What a blow gives is kinetic, elastic or dissipated at every moment: at 30 m/s some of it is
/// dissipated and a dent stays, at 1 m/s nothing is.
#[test]
fn the_ledger_of_a_dent_closes() {
    for (speed, most) in [(1.0, 0.0), (30.0, 1.0)] {
        let mut dent = 0.0;
        for steps in [200, 1000, 3000] {
            let (mut shell, given, dissipated) = struck::<f64>(speed, steps, SimdLevel::best());
            let sums = shell.sums();
            let off = (sums.kinetic + sums.elastic + dissipated) / given - 1.0;
            let share = dissipated / given;
            println!("{speed} m/s, {steps} steps: {share:.3} dissipated, ledger {off:+.2e}");
            assert!(off.abs() < 0.01, "{speed} m/s, {steps} steps: {off}");
            assert!(share <= most, "{speed}: {share}");
            assert!(speed < 2.0 || share > 0.2, "{share}");
            for _ in 0..if steps == 3000 { 6000 } else { 0 } {
                shell.advance(|n, v| if is_rim(n) { Vec3::zeros() } else { v * 0.998 });
            }
            dent = (0..shell.mass.len()).map(|n| -shell.moved(n).z).fold(0.0, f64::max);
        }
        println!("{speed} m/s: a dent of {:.4} of the thickness stays", dent / T);
        assert!(
            if speed < 2.0 { dent < 1e-3 * T } else { dent > 0.1 * T },
            "{speed} m/s: {dent} m"
        );
    }
}

/// The same bits on every path and for one or two threads; f32 is near f64.
#[test]
fn yielding_sheets_have_the_same_bits_everywhere() {
    fn run<R: Real>(level: SimdLevel) -> Vec<Vec3> {
        let (shell, _, dissipated) = struck::<R>(30.0, 300, level);
        assert!(dissipated > 0.0);
        (0..shell.mass.len()).map(|n| shell.moved(n)).collect()
    }
    let (double, single) = (same_everywhere(run::<f64>), same_everywhere(run::<f32>));
    let size = double.iter().map(Vec3::norm).fold(0.0, f64::max);
    let off = double.iter().zip(&single).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(off < 1e-3 * size, "{off} of {size}");
}

/// A square of sheet steel on its four corners under a ball, by the solver.
fn dented(speed: f64) -> SolveOutcome {
    let settings = Settings { spacing: Some(4e-3), ..Settings::default() };
    let problem = pane([0.16, 0.16, T], 0.015, speed, settings);
    let material = Material { density: 7850.0, young: 210e9, poisson: 0.3, ..problem.material };
    let hardening = Hardening { yield_stress: YIELD, hardening: 300e6, exponent: 0.5 };
    let law = Law::Yielding { material, hardening };
    let mut solve = ShellSolver::begin(Problem { law, ..problem.into() }).expect("accepted");
    loop {
        match solve.advance() {
            Progress::Running(_) => {}
            Progress::Done(outcome) => return outcome,
            Progress::Failed(failure) => panic!("{failure}"),
        }
    }
}

/// A ball leaves a dent in a sheet: a closed body of the same volume, whose middle lies lower, and
/// whose work is less than what the ball had. At a tenth of the speed nothing stays.
#[test]
fn a_ball_leaves_a_dent() {
    let SolveOutcome::Deformed(found) = dented(6.0) else { panic!("not deformed") };
    let BodyShape::Solid(solid) = &found.body else { panic!("another body") };
    assert!(solid.mesh.is_closed());
    let volume = solid.mesh.signed_volume() / (0.16 * 0.16 * T);
    let low = solid.mesh.vertices.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
    let (work, dent) = (found.work, found.report.detail("dent").unwrap());
    println!("dent {dent:.2e} m, lowest {low:.2e} m, work {work:.3} J, volume {volume:.5}");
    println!("{:?}", found.report.warnings);
    assert!((volume - 1.0).abs() < 1e-9, "{volume}");
    assert!(dent > T && low < -T, "{dent}, {low}");
    let balance = found.report.detail("energy_balance").unwrap();
    assert!((balance - 1.0).abs() < 0.02, "{balance}");
    assert!(!found.hulls.is_empty() && work > 0.0);
    assert!(matches!(dented(0.1), SolveOutcome::Unchanged(_)));
}
