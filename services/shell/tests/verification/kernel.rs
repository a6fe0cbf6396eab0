//! The kernel: forces are the slope of the energy, nothing is made, and the bits are the same on
//! every path.

use crate::equilibrium::elastic;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_shell::domain::ShellDomain;
use cullet_shell::midsurface::Midsurface;
use cullet_simd::{Real, SimdLevel};
use std::f64::consts::FRAC_PI_2;

fn cylinder() -> NurbsPatch {
    let line = [[0.1, 0.0, 1.0], [0.1, 0.1, 1.0], [0.1, 0.2, 1.0]];
    NurbsPatch::revolved(line, FRAC_PI_2).unwrap().divided([12, 9])
}

fn noisy<R: Real, const N: usize>(patch: &NurbsPatch, level: SimdLevel) -> ShellDomain<R, N> {
    let mut shell: ShellDomain<R, N> =
        elastic(Midsurface::of_patch(patch), [70e9, 0.22, 2e-3], level);
    for (n, u) in shell.displacement.iter_mut().enumerate() {
        for (axis, u) in u.iter_mut().enumerate().take(3) {
            *u = 2e-4 * (unit(5, axis as u64, n as u64) - 0.5);
        }
    }
    shell
}

/// S18: f = −∂W/∂x, and neither force nor torque on the whole.
#[test]
fn s18_forces_are_the_slope_of_the_energy() {
    let patches = [cylinder(), NurbsPatch::sheet([0.2, 0.1], [9, 7], 2).unwrap()];
    for patch in patches {
        let mut shell: ShellDomain<f64, 9> = noisy(&patch, SimdLevel::best());
        shell.strain();
        let (mut net, mut torque, mut size) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for (n, point) in patch.points().iter().enumerate() {
            let force = shell.force(n);
            net += force;
            torque += (point + shell.moved(n)).cross(&force);
            size += force.norm();
        }
        assert!(net.norm() < 1e-14 * size && torque.norm() < 1e-14 * size, "{net} {torque}");
        for n in [0, 17, 40, patch.points().len() - 3] {
            let force = shell.force(n);
            for axis in 0..3 {
                let here = shell.displacement[n][axis];
                let step = 1e-8;
                let mut at = |u: f64| {
                    shell.displacement[n][axis] = u;
                    shell.elastic_energy()
                };
                let slope = (at(here + step) - at(here - step)) / (2.0 * step);
                at(here);
                let off = (force[axis] + slope).abs() / force.norm();
                assert!(off < 1e-6, "{n}, {axis}: {} and {slope}", force[axis]);
            }
        }
    }
}

/// What a run gives, which is the same on every path and for one or two threads.
pub(crate) fn same_everywhere<T: PartialEq + Send>(run: impl Fn(SimdLevel) -> T + Sync) -> T {
    let pooled = |level: SimdLevel, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(level))
    };
    let first = pooled(SimdLevel::portable(), 1);
    for level in SimdLevel::all() {
        for threads in [1, 2] {
            assert!(pooled(level, threads) == first, "{level}, {threads} threads");
        }
    }
    first
}

/// The same bits on every path and for one or two threads, in both precisions; f32 is near f64.
#[test]
fn the_bits_do_not_depend_on_registers_or_threads() {
    fn run<R: Real>(level: SimdLevel) -> Vec<Vec3> {
        let mut shell: ShellDomain<R, 9> = noisy(&cylinder(), level);
        for _ in 0..50 {
            shell.advance(|_, v| v);
        }
        (0..shell.mass.len()).map(|n| shell.moved(n)).collect()
    }
    let (double, single) = (same_everywhere(run::<f64>), same_everywhere(run::<f32>));
    let far = double.iter().zip(&single).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(far < 1e-6 * 1e-2 && far > 0.0, "{far}");
}

/// S19: a plate at 0.95 of the stable step keeps its energy for ten thousand steps, and at 1.05 it
/// does not.
#[test]
fn s19_the_step_is_stable_up_to_its_bound() {
    for cells in [0.25, 1.0, 4.0] {
        let thickness = 0.01 / cells;
        for (share, holds) in [(0.95, true), (1.05, false)] {
            let patch = NurbsPatch::sheet([0.1, 0.1], [10, 10], 2).unwrap();
            let mut shell: ShellDomain<f64, 9> =
                elastic(Midsurface::of_patch(&patch), [1e6, 0.22, thickness], SimdLevel::best());
            shell.step = share * shell.stable_step();
            for (n, v) in shell.velocity.iter_mut().enumerate() {
                *v = Vec3::from([0, 1, 2].map(|k| 1e-6 * (unit(3, k, n as u64) - 0.5)));
            }
            let mean = |shell: &mut ShellDomain<f64, 9>| {
                let mut sum = 0.0;
                for _ in 0..200 {
                    shell.strain();
                    let before = shell.velocity.clone();
                    let elastic = shell.elastic_energy();
                    shell.advance(|_, v| v);
                    let pairs = before.iter().zip(&shell.velocity).zip(&shell.mass);
                    // Leapfrog keeps v₋·v₊, not v².
                    sum += elastic + pairs.map(|((a, b), m)| 0.5 * m * a.dot(b)).sum::<f64>();
                }
                sum / 200.0
            };
            let first = mean(&mut shell);
            for _ in 0..10_000 {
                shell.advance(|_, v| v);
            }
            let ratio = mean(&mut shell) / first;
            let kept = (ratio - 1.0).abs() < 1e-3;
            assert_eq!(kept, holds, "l/t {cells}, {share} of the step: energy times {ratio}");
        }
    }
}
