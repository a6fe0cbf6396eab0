//! A step that a few small or ill-shaped cells do not dictate: control points that would need a
//! smaller one are made heavier.

use super::state::ShellDomain;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_simd::Real;

/// Share of the greatest frequency 2/Δt that control points may have.
const HIGHEST: f64 = 0.95;

/// Rounds of the power iteration without a control point that is too light after which there is
/// none, and all of them.
const ROUNDS: (usize, usize) = (60, 3000);

/// Displacements that are tried, over the size of a cell \[1\].
const NUDGE: f64 = 1e-7;

/// How much heavier a control point becomes at once, beyond what the estimate asks  \[1\].
const MARGIN: f64 = 1.05;

/// Stream of the numbers that the search starts from.
const STREAM: u64 = 0x57ea;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Takes steps of `step` \[s\] from here on; the mass that control points have got for it over
    /// the mass of the shell \[1\], nothing if they want more than `most` of that: the masses, but
    /// not the step, are then what they were. The shell must be at rest, as it was made.
    ///
    /// Power iteration on M⁻¹K finds the highest frequency and where it swings; the control point
    /// that swings most there gets the mass that lowers it \[local mass scaling: Belytschko, Liu &
    /// Moran 2000, §6.2.8\].
    pub(crate) fn steady(&mut self, step: f64, most: f64) -> Option<f64> {
        self.step = step;
        let limit = (2.0 * HIGHEST / step).powi(2);
        let before = (self.mass.clone(), self.split.mass.clone());
        let states = self.states.clone();
        // What is tried must not crack a weak point: it would count as soft from then on.
        self.states.iter_mut().for_each(|state| state.flaw = f64::INFINITY);
        (0..self.states.len()).for_each(|seat| self.watch(seat));
        let whole: f64 = before.0.iter().sum();
        let size = self.setup[0].surface.extent;
        let (mut added, mut calm) = (0.0, 0);
        let noise = |n: usize| Vec3::from([0, 1, 2].map(|axis| unit(STREAM, axis, n as u64) - 0.5));
        let mut swing: Vec<Vec3> = (0..self.mass.len()).map(noise).collect();
        // `Real::FAINT` strains a shell at rest.
        self.strain();
        let still: Vec<Vec3> = (0..self.mass.len()).map(|n| self.force(n)).collect();
        for _ in 0..ROUNDS.1 {
            let scale = NUDGE * size;
            for (u, x) in self.displacement.iter_mut().zip(&swing) {
                *u = [x.x * scale, x.y * scale, x.z * scale, 0.0];
            }
            self.strain();
            let pull: Vec<Vec3> = (0..swing.len())
                .map(|n| (still[n] - self.force(n)) / (self.mass[n] * scale))
                .collect();
            let weighted = |a: &[Vec3], b: &[Vec3]| -> f64 {
                a.iter().zip(b).zip(&self.mass).map(|((a, b), m)| m * a.dot(b)).sum()
            };
            let square = weighted(&pull, &swing) / weighted(&swing, &swing);
            let greatest = pull.iter().map(Vec3::norm).fold(0.0, f64::max);
            swing = pull.into_iter().map(|x| x / greatest).collect();
            calm += 1;
            if square > limit {
                let energy = |n: &usize| self.mass[*n] * swing[*n].norm_squared();
                let lightest = (0..swing.len()).max_by(|a, b| energy(a).total_cmp(&energy(b)));
                let Some(node) = lightest else { break };
                let factor = MARGIN * square / limit;
                added += (factor - 1.0) * self.mass[node];
                self.mass[node] *= factor;
                self.split.mass[node] *= factor;
                calm = 0;
            }
            if calm == ROUNDS.0 || added > most * whole {
                break;
            }
        }
        self.displacement.fill([0.0; 4]);
        self.states = states;
        (0..self.states.len()).for_each(|seat| self.watch(seat));
        self.strain();
        let holds = calm == ROUNDS.0 && added <= most * whole;
        if !holds {
            (self.mass, self.split.mass) = before;
        }
        holds.then_some(added / whole)
    }
}

#[cfg(test)]
mod tests {
    use crate::domain::{STEP_SHARE, ShellDomain, ShellMaterial};
    use crate::midsurface::{Midsurface, StepBounds};
    use crate::section::SectionLaw;
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;
    use cullet_model::Material;
    use cullet_simd::{Real, SimdLevel};

    /// A sheet with three columns of cells a third as wide as the others.
    fn sheet() -> ShellDomain<f64, 9> {
        sheet_of(f64::INFINITY)
    }

    /// The same of a strength \[Pa\].
    fn sheet_of<R: Real>(strength: f64) -> ShellDomain<R, 9> {
        let place = |k: u32| match k {
            0..5 => f64::from(k) * 1e-2,
            5..8 => 0.04 + f64::from(k - 4) * 3.3e-3,
            _ => 0.0499 + f64::from(k - 7) * 1e-2,
        };
        let at = |i: u32, j: u32| j * 11 + i;
        let corners = (0..11).flat_map(|j| (0..11).map(move |i| (i, j)));
        let vertices: Vec<Vec3> =
            corners.map(|(i, j)| Vec3::new(place(i), f64::from(j) * 1e-2, 0.0)).collect();
        let cells = (0..10).flat_map(|j| (0..10).map(move |i| (i, j)));
        let quads: Vec<[u32; 4]> =
            cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let surface = Midsurface::of_quads(&vertices, &quads).unwrap();
        let material = Material {
            density: 2500.0,
            young: 70e9,
            poisson: 0.22,
            failure_stress: 1e9,
            fracture_energy: 8.0,
        };
        let shell = ShellMaterial {
            law: SectionLaw::new(&material),
            density: material.density,
            thickness: vec![1e-3; surface.points()],
            strength: vec![strength; surface.points()],
            softening_cells: 1.0,
        };
        ShellDomain::new(surface, shell, SimdLevel::best())
    }

    fn grows(shell: &mut ShellDomain<f64, 9>) -> bool {
        for (n, v) in shell.velocity.iter_mut().enumerate() {
            *v = Vec3::from([0, 1, 2].map(|axis| 1e-3 * (unit(1, axis, n as u64) - 0.5)));
        }
        let before = shell.sums().kinetic;
        for _ in 0..2000 {
            shell.advance(|_, v| v);
        }
        let after = shell.sums();
        let sum = after.kinetic + after.elastic;
        sum.is_nan() || sum > 1.5 * before
    }

    /// What is tried in the search would crack points of no strength.
    #[test]
    fn the_search_leaves_no_cracks() {
        let mut shell = sheet_of::<f64>(1.0);
        let step = 3.0 * shell.step;
        let added = shell.steady(step, 10.0).expect("it comes to an end");
        assert!(added > 0.0);
        assert_eq!(sheet().steady(step, 10.0), Some(added));
        assert!(shell.states.iter().all(|state| state.crack.is_none()));
        let weak: f64 = (0..100).map(|_| shell.advance(|_, v| v).points.dissipated).sum();
        assert_eq!(weak, 0.0, "a shell at rest dissipates");
    }

    #[test]
    fn a_row_of_narrow_cells_does_not_set_the_step() {
        let speed = (70e9_f64 / (1.0 - 0.22 * 0.22) / 2500.0).sqrt();
        let step = STEP_SHARE * StepBounds::EVEN.step(1e-2, 1e-3, speed);
        let mut shell = sheet();
        assert!(shell.step < 0.5 * step, "{} of {step}", shell.step);
        shell.step = step;
        assert!(grows(&mut shell), "no smaller step is needed");
        let mut shell = sheet();
        let added = shell.steady(step, 1.0).expect("it comes to an end");
        let single = sheet_of::<f32>(f64::INFINITY).steady(step, 1.0).expect("it comes to an end");
        assert!((single / added - 1.0).abs() < 0.1, "{single} in single, {added}");
        println!("{added:.4} of the mass added");
        assert!(added > 0.0 && added < 1.0, "{added}");
        assert!(!grows(&mut shell));
        assert_eq!(sheet().steady(0.3 * step, 1.0), Some(0.0), "all are heavy enough");
        let mut shell = sheet();
        let before = shell.mass.clone();
        assert_eq!(shell.steady(step, 0.1 * added), None, "they want more");
        assert_eq!(shell.mass, before);
    }
}
