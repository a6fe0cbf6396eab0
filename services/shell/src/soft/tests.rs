//! Forces of soft walls against their energy.

use crate::domain::{ShellDomain, ShellMaterial};
use crate::midsurface::Midsurface;
use crate::section::{NeoHookean, SectionLaw, SoftElasticity, SoftSection};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::Material;
use cullet_simd::SimdLevel;

const RUBBER: Material = Material {
    density: 1000.0,
    young: 3e5,
    poisson: 0.3,
    failure_stress: 1e5,
    fracture_energy: 300.0,
};

/// A quarter of a tube that is strained by a fifth, some of whose points are half broken and some
/// have healed.
fn noisy(level: SimdLevel) -> ShellDomain<f64, 9> {
    let (n, m) = (12, 9);
    let at = |i: u32, j: u32| {
        let (s, c) = libm::sincos(std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(n));
        Vec3::new(0.1 * c, 0.1 * s, 0.12 * f64::from(j) / f64::from(m))
    };
    let vertices: Vec<Vec3> = (0..=m).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    let number = |i: u32, j: u32| j * (n + 1) + i;
    let cells = (0..m).flat_map(|j| (0..n).map(move |i| (i, j)));
    let quads: Vec<[u32; 4]> = cells
        .map(|(i, j)| [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)])
        .collect();
    let surface = Midsurface::of_quads(&vertices, &quads).unwrap();
    let elastic = SoftElasticity::NeoHookean(NeoHookean::new(RUBBER.young, RUBBER.poisson));
    let section = SoftSection { elastic, bend: 1.3, viscosity: 0.0 };
    let shell = ShellMaterial {
        law: SectionLaw::new(&RUBBER).soft(section),
        density: RUBBER.density,
        thickness: vec![5e-3; surface.points()],
        strength: vec![f64::INFINITY; surface.points()],
        softening_cells: 1.1,
    };
    let mut shell = ShellDomain::new(surface, shell, level);
    let law = shell.law.clone();
    for p in (0..shell.points()).step_by(7) {
        shell.change(p, |state| {
            state.cut(&law, [0.6, 0.8]);
            state.damage = 0.5;
            if p % 2 == 0 {
                state.damage = 1.0;
                state.set = Some(crate::kernel::SurfaceStrain {
                    membrane: [0.1, -0.05, 0.02],
                    bending: [3.0, -1.0, 0.5],
                });
            }
        });
    }
    for (n, u) in shell.displacement.iter_mut().enumerate() {
        for (axis, u) in u.iter_mut().enumerate().take(3) {
            *u = 4e-3 * (unit(5, axis as u64, n as u64) - 0.5);
        }
    }
    shell
}

/// S18: f = −∂W/∂x, and neither force nor torque on the whole; the bits are the same on every path.
#[test]
fn s18_soft_forces_are_the_slope_of_the_energy() {
    let mut shell = noisy(SimdLevel::best());
    shell.strain();
    let (_, places) = shell.node_places();
    let (mut net, mut torque, mut size) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    for (n, place) in places.iter().enumerate() {
        let force = shell.force(n);
        net += force;
        torque += place.cross(&force);
        size += force.norm();
    }
    assert!(net.norm() < 1e-14 * size && torque.norm() < 1e-14 * size, "{net} {torque} {size}");
    for n in [0, 17, 40, 77, 101] {
        let force = shell.force(n);
        for axis in 0..3 {
            let here = shell.displacement[n][axis];
            let step = 1e-7;
            let mut at = |u: f64| {
                shell.displacement[n][axis] = u;
                shell.elastic_energy()
            };
            let slope = (at(here + step) - at(here - step)) / (2.0 * step);
            at(here);
            let off = (force[axis] + slope).abs() / force.norm();
            assert!(off < 1e-7, "{n}, {axis}: {} and {slope}, {off:.1e}", force[axis]);
        }
    }
    for level in SimdLevel::all() {
        let mut other = noisy(level);
        other.strain();
        (0..places.len()).for_each(|n| assert_eq!(other.force(n), shell.force(n)));
    }
}
