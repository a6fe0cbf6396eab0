//! The slow twin of the points' pass, straight from the textbook.

use super::{Kernel, MaterialLaw, PointLaw};
use crate::damage::{DamageState, Softening};
use crate::mpm::elastic::{LameParameters, green_strain, matrix};
use crate::mpm::grid::{BackgroundGrid, GridElement};
use crate::mpm::stencil::{AROUND, Stencil, gather, packed, vector};
use crate::particles::Particles;
use cullet_geometry::{Mat3, Vec3, math::unit};
use cullet_model::{Material, PointPrecision};
use cullet_simd::SimdLevel;

const STONE: Material = Material {
    density: 2300.0,
    young: 40e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 25.0,
};

/// A cloud of points, some of them damaged, on nodes moved at random.
fn cloud() -> (BackgroundGrid, Particles, Vec3, Vec<MaterialLaw>) {
    let spacing = Vec3::new(0.1, 0.08, 0.13);
    let random = |stream, i| Vec3::from([0, 1, 2].map(|a| unit(stream, a, i) - 0.5));
    let points: Vec<Vec3> = (0..3000).map(|i| random(5, i)).collect();
    let mut particles = Particles::at_rest(&points, 1.0, STONE.density);
    for (p, damage) in particles.damage.iter_mut().enumerate() {
        *damage = [0.0, 0.0, 0.0, 0.4, 1.0][p % 5];
    }
    // Three materials, side by side in every cell.
    particles.kind.iter_mut().enumerate().for_each(|(p, kind)| *kind = (p % 3) as u8);
    particles.density = vec![STONE.density; 3];
    let mut grid = BackgroundGrid::new(&mut particles, spacing);
    for (n, u) in grid.nodes.displacement.iter_mut().enumerate() {
        *u = packed(Vec3::new(3.0, -1.0, 2.0) + random(6, n as u64) * 1e-3);
    }
    let kinds = [(1.0, 0.2), (0.1, 0.2), (3.0, -0.3)].map(|(share, poisson)| {
        let material = Material { young: share * STONE.young, poisson, ..STONE };
        let mut softening = Softening::new(&material, 0.2);
        softening.strength = 1e10;
        MaterialLaw { elastic: LameParameters::new(&material), softening, flow: None }
    });
    (grid, particles, spacing, kinds.to_vec())
}

/// Weight and MLS gradient 4 w (x_i − x_p)/h² of node `k` of an element for a point at `x`.
fn naive_weight(element: &GridElement, k: usize, x: &Vec3, spacing: &Vec3) -> (f64, Vec3) {
    let place = [k / 9, k / 3 % 3, k % 3];
    let place = Vec3::from([0, 1, 2].map(|a| f64::from(element.cell[a] + place[a] as i32)));
    let away = place.component_mul(spacing) - x;
    let n = |r: f64| match r.abs() {
        r if r < 0.5 => 0.75 - r * r,
        r if r < 1.5 => 0.5 * (1.5 - r) * (1.5 - r),
        _ => 0.0,
    };
    let w: f64 = (0..3).map(|a| n(away[a] / spacing[a])).product();
    let gradient = (0..3).map(|a| 4.0 * w * away[a] / (spacing[a] * spacing[a]));
    (w, Vec3::from_iterator(gradient))
}

/// Forces \[N\] on the nodes, point by point, node by node.
fn naive_forces(grid: &BackgroundGrid, particles: &Particles, law: &PointLaw<'_>) -> Vec<Vec3> {
    let mut forces = vec![Vec3::zeros(); grid.nodes.len()];
    for element in &grid.elements {
        for p in element.points() {
            let x = &particles.reference[p];
            let mut h = Mat3::zeros();
            for k in 0..AROUND {
                let u = vector(grid.nodes.displacement[element.nodes[k] as usize]);
                h += u * naive_weight(element, k, x, &law.spacing).1.transpose();
            }
            let kind = &law.kinds[particles.kind[p] as usize];
            let state = DamageState {
                damage: particles.damage[p],
                strength: 1e6,
                shielded: false,
                lone: 1.0,
            };
            let s = kind.softening.respond(&green_strain(&h), state).stress;
            let first = (Mat3::identity() + h) * matrix(&s) * particles.volume[p];
            for (k, &node) in element.nodes.iter().enumerate() {
                let (_, gradient) = naive_weight(element, k, x, &law.spacing);
                forces[node as usize] -= first * gradient;
            }
        }
    }
    forces
}

#[test]
fn forces_agree_with_the_textbook() {
    let (grid, particles, spacing, kinds) = cloud();
    let law = PointLaw { kinds: &kinds, spacing, time: 1.0, step: 1.0 };
    let wanted = naive_forces(&grid, &particles, &law);
    let size = wanted.iter().fold(0.0_f64, |m, f| m.max(f.norm()));
    for path in SimdLevel::all() {
        // The twin takes no differences: in f64 its own rounding is what is seen.
        for (precision, bound) in [(PointPrecision::Single, 2e-6), (PointPrecision::Double, 1e-11)]
        {
            let mut kernel = Kernel::new(&grid, &particles, precision, path);
            let mut particles = particles.clone();
            let tally = kernel.strain(&law, &grid, &mut particles);
            assert_eq!((tally.grown, tally.crushed), (0, 0));
            for (n, wanted) in wanted.iter().enumerate() {
                let error = (vector(kernel.force(n)) - wanted).norm() / size;
                assert!(error < bound, "{path} {precision:?} node {n}: {error}");
            }
        }
    }
}

#[test]
fn values_and_gradients_agree_with_the_textbook() {
    let (grid, particles, spacing, _) = cloud();
    let gain = spacing.map(|h| 4.0 / h);
    for element in &grid.elements {
        let nodes = element.nodes.map(|n| grid.nodes.displacement[n as usize]);
        for x in &particles.reference[element.points()] {
            let (mut sum, mut gradient) = (Vec3::zeros(), Mat3::zeros());
            for (k, node) in nodes.iter().enumerate() {
                let (w, g) = naive_weight(element, k, x, &spacing);
                sum += vector(*node) * w;
                gradient += vector(*node) * g.transpose();
            }
            let stencil = Stencil::new(x, &spacing);
            assert_eq!(stencil.cell, element.cell);
            let (value, slope) = gather(&nodes, &stencil, &gain);
            assert!((value - sum).norm() < 1e-14);
            assert!((slope - gradient).norm() < 1e-12);
        }
    }
}
