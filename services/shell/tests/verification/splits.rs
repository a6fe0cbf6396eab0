//! What a split changes: no strain (S14), and hardly the highest frequency (S20).

use crate::equilibrium::{Grid, elastic};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_shell::domain::ShellDomain;
use cullet_shell::midsurface::Midsurface;
use cullet_simd::SimdLevel;

type Shell = ShellDomain<f64, 9>;

const CELLS: usize = 10;
const CELL: f64 = 1e-2;

fn sheet(thickness: f64) -> (Shell, Grid) {
    let patch = NurbsPatch::sheet([CELLS as f64 * CELL; 2], [CELLS; 2], 2).unwrap();
    let surface = Midsurface::of_patch(&patch);
    (elastic(surface, [70e9, 0.22, thickness], SimdLevel::best()), Grid::of(&patch))
}

/// Breaks the points just under the line y = `place` + `slope` x and parts the control points, all
/// at rest.
fn cut(shell: &mut Shell, place: f64, slope: f64) {
    for point in 0..shell.points() {
        let at = shell.surface.surface_point(point).place;
        let off = at.y - place - slope * at.x;
        if (-0.5 * CELL..0.0).contains(&off) {
            let length = (1.0 + slope * slope).sqrt();
            shell.notch(point, [-slope / length, 1.0 / length]);
        }
    }
    shell.advance(|_, _| Vec3::zeros());
}

/// S14: beside a cut w = ½κx² + ½λy² has the curvature that it had, within 1e-12.
#[test]
fn s14_a_cut_changes_no_strain() {
    let (mut shell, grid) = sheet(1e-3);
    let knot = |k: usize| k.clamp(0, CELLS) as f64 * CELL;
    // The control points of ½x² on quadratic splines: products of neighbouring knots.
    let half_square = |k: usize| 0.5 * knot(k.saturating_sub(1)) * knot(k);
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let w = 0.03 * half_square(column) + 0.05 * half_square(row);
            shell.displacement[grid.at(column, row)][2] = w;
        }
    }
    let before = shell.strains();
    for strain in &before {
        let [along, across, twist] = strain.bending;
        assert!((along.abs() - 0.03).abs() < 1e-4 && (across.abs() - 0.05).abs() < 1e-4);
        assert!(twist.abs() < 1e-4, "{strain:?}");
    }
    cut(&mut shell, 2e-3, 0.3);
    assert!(shell.splits() > 10, "{} splits", shell.splits());
    // Rounding goes by what lies together in a block, which a split changes.
    for (now, then) in shell.strains().iter().zip(&before) {
        let off = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f64>();
        assert!(off(&now.bending, &then.bending) < 1e-12 * 0.05, "{now:?}, {then:?}");
        assert!(off(&now.membrane, &then.membrane) < 1e-12 * 0.05 * CELL, "{now:?}, {then:?}");
    }
}

/// The square of the highest frequency at which a shell at rest swings, by power iteration on M⁻¹K
/// \[1/s²\].
fn highest(shell: &mut Shell) -> f64 {
    let noise = |n: usize| Vec3::from([0, 1, 2].map(|axis| unit(3, axis, n as u64) - 0.5));
    let mut swing: Vec<Vec3> = (0..shell.mass.len()).map(noise).collect();
    let mut square = 0.0;
    for _ in 0..400 {
        let nudge = 1e-5 * CELL;
        for (u, x) in shell.displacement.iter_mut().zip(&swing) {
            *u = [x.x * nudge, x.y * nudge, x.z * nudge, 0.0];
        }
        shell.strain();
        let pull: Vec<Vec3> =
            (0..swing.len()).map(|n| -shell.force(n) / (shell.mass[n] * nudge)).collect();
        let weighted = |a: &[Vec3], b: &[Vec3]| -> f64 {
            a.iter().zip(b).zip(&shell.mass).map(|((a, b), m)| m * a.dot(b)).sum()
        };
        square = weighted(&pull, &swing) / weighted(&swing, &swing);
        let most = pull.iter().map(Vec3::norm).fold(0.0, f64::max);
        swing = pull.into_iter().map(|x| x / most).collect();
    }
    shell.displacement.fill([0.0; 4]);
    square
}

/// S20: wherever a cut runs, its copies swing hardly faster than the whole sheet did, in a thin one
/// and in one four times as thick as its cells.
#[test]
fn s20_a_cut_hardly_raises_the_highest_frequency() {
    for thickness in [1e-3, 4.0 * CELL] {
        let whole = highest(&mut sheet(thickness).0);
        for (place, slope) in [(0.0, 0.0), (-5e-3, 0.0), (2e-3, 0.1), (-2e-3, 0.4), (1e-3, 0.9)] {
            let (mut shell, _) = sheet(thickness);
            cut(&mut shell, place, slope);
            assert!(shell.splits() > 5);
            let ratio = (highest(&mut shell) / whole).sqrt();
            println!("S20: t = {thickness} m, cut at {place} + {slope} x: {ratio:.3}");
            // A slanted cut leaves corners of cells; the step has room for 1.25.
            let bar = if slope < 0.5 { 1.1 } else { 1.2 };
            assert!(ratio < bar, "{place}, {slope}: {ratio}");
        }
    }
}
