//! Volumes of scattered points with which the grid integrates as if they filled the body evenly.
//!
//! A point of volume V puts the force −(4/h²) V τ w (x_i − x_p) on node i. In a body under uniform
//! stress these must cancel, so the first moment Σ V w (x_i − x_p) of a node must be its integral
//! over the body: zero inside. With equal volumes at random places it is not, and the body answers
//! a uniform pull with a stress that scatters by an eighth; it breaks at 0.75 to 0.8 of its
//! strength. Eight points a cell leave the freedom to meet three sums a node: of all volumes that
//! do, those nearest to equal ones are taken.

use super::lattice::KernelLattice;
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;

/// Samples along a cell's edge when the body is integrated over: inside, any number is exact; at
/// the surface the boundary is found to an eighth of a cell.
const SAMPLES: usize = 4;

/// Weight of evenness against the moments: less buys exactness at nodes that only touch the body
/// with lumps and gaps everywhere.
const EVENNESS: f64 = 1e-2;

/// Rounds of conjugate gradients at most.
const ROUNDS: usize = 40;

/// Share of the first residual at which the volumes are good enough.
const ENOUGH: f64 = 1e-2;

/// Least and greatest volume of a point in even shares; inside, they stay within 0.4 and 1.6.
const BOUNDS: (f64, f64) = (0.25, 4.0);

/// The volume of each point, of `body_volume` \[m³\] in all.
#[must_use]
pub fn volumes(points: &[Vec3], inside: &Inside, spacing: Vec3, body_volume: f64) -> Vec<f64> {
    let lattice = KernelLattice::new(points, spacing);
    let even = body_volume / points.len().max(1) as f64;
    let share = even / spacing.product();
    let mut residual = integral(&lattice, inside, points);
    let have = moments(&lattice, points, |_| share);
    residual.iter_mut().zip(&have).for_each(|(wanted, have)| *wanted -= have);
    let multipliers = solve(&lattice, points, share, residual);
    let mut volumes: Vec<f64> = points
        .iter()
        .map(|x| even * (1.0 + at(&lattice, x, &multipliers)))
        .map(|volume| volume.clamp(BOUNDS.0 * even, BOUNDS.1 * even))
        .collect();
    let scale = body_volume / volumes.iter().sum::<f64>();
    volumes.iter_mut().for_each(|volume| *volume *= scale);
    volumes
}

/// First moment of each node over the body, in h⁴, from a regular set of samples.
fn integral(lattice: &KernelLattice, inside: &Inside, points: &[Vec3]) -> Vec<Vec3> {
    let mut near = vec![false; lattice.len()];
    for x in points {
        lattice.visit(x, |node, _, _| near[node] = true);
    }
    let step = lattice.spacing / SAMPLES as f64;
    let mut samples = Vec::new();
    lattice.nodes(|node, corner| {
        if near[node] {
            for s in 0..SAMPLES * SAMPLES * SAMPLES {
                let place = [s / (SAMPLES * SAMPLES), s / SAMPLES % SAMPLES, s % SAMPLES];
                let x = corner + Vec3::from(place.map(|k| k as f64 + 0.5)).component_mul(&step);
                if inside.contains(x) {
                    samples.push(x);
                }
            }
        }
    });
    let share = 1.0 / (SAMPLES * SAMPLES * SAMPLES) as f64;
    moments(lattice, &samples, |_| share)
}

/// Σ V w (x_i − x_p) of each node, in h⁴; `volume` is a point's, in h³.
fn moments(lattice: &KernelLattice, points: &[Vec3], volume: impl Fn(usize) -> f64) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); lattice.len()];
    for (p, x) in points.iter().enumerate() {
        let share = volume(p);
        lattice.visit(x, |node, weight, away| sums[node] += away * (share * weight));
    }
    sums
}

/// Σ w y·(x_i − x_p) over the nodes around a point: the transpose of [`moments`].
fn at(lattice: &KernelLattice, x: &Vec3, multipliers: &[Vec3]) -> f64 {
    let mut sum = 0.0;
    lattice.visit(x, |node, weight, away| sum += weight * multipliers[node].dot(&away));
    sum
}

/// Lagrange's multipliers: (V A Aᵀ + ε I) y = r by conjugate gradients.
fn solve(
    lattice: &KernelLattice,
    points: &[Vec3],
    volume: f64,
    mut residual: Vec<Vec3>,
) -> Vec<Vec3> {
    let dot = |a: &[Vec3], b: &[Vec3]| -> f64 { a.iter().zip(b).map(|(x, y)| x.dot(y)).sum() };
    let mut solution = vec![Vec3::zeros(); residual.len()];
    let mut direction = residual.clone();
    let mut square = dot(&residual, &residual);
    let goal = ENOUGH * ENOUGH * square;
    for _ in 0..ROUNDS {
        if square <= goal {
            break;
        }
        let along: Vec<f64> = points.iter().map(|x| volume * at(lattice, x, &direction)).collect();
        let mut image = moments(lattice, points, |p| along[p]);
        image.iter_mut().zip(&direction).for_each(|(i, d)| *i += d * EVENNESS);
        let step = square / dot(&direction, &image);
        solution.iter_mut().zip(&direction).for_each(|(s, d)| *s += d * step);
        residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= i * step);
        let next = dot(&residual, &residual);
        let ratio = next / square;
        direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + *d * ratio);
        square = next;
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::{integral, moments, volumes};
    use crate::mpm::lattice::KernelLattice;
    use cullet_geometry::inside::Inside;
    use cullet_geometry::{Vec3, sample, shapes};

    /// Root mean square of the moments that a uniform stress leaves, in h⁴.
    fn noise(points: &[Vec3], inside: &Inside, spacing: f64, volumes: &[f64]) -> f64 {
        let lattice = KernelLattice::new(points, Vec3::repeat(spacing));
        let cell = spacing * spacing * spacing;
        let wanted = integral(&lattice, inside, points);
        let have = moments(&lattice, points, |p| volumes[p] / cell);
        let sum: f64 = wanted.iter().zip(&have).map(|(w, h)| (w - h).norm_squared()).sum();
        (sum / points.len() as f64).sqrt()
    }

    #[test]
    fn forces_of_a_uniform_stress_cancel() {
        let detail = shapes::Detail::default();
        let ball = shapes::sphere(0.1, detail).expect("a ball");
        let plate = shapes::cuboid(Vec3::new(0.3, 0.2, 0.06), detail).expect("a plate");
        for (mesh, spacing) in [(ball, 0.02), (plate, 0.015)] {
            let inside = Inside::new(&mesh);
            let points = sample::poisson(&inside, 0.5 * spacing, 3).expect("points");
            let body = mesh.signed_volume();
            let even = body / points.len() as f64;
            let before = noise(&points, &inside, spacing, &vec![even; points.len()]);
            let fitted = volumes(&points, &inside, Vec3::repeat(spacing), body);
            let after = noise(&points, &inside, spacing, &fitted);
            assert!(after < 0.35 * before, "{after} of {before}");
            assert!((fitted.iter().sum::<f64>() / body - 1.0).abs() < 1e-12);
            assert!(fitted.iter().all(|v| (0.2 * even..4.5 * even).contains(v)));
            assert_eq!(fitted, volumes(&points, &inside, Vec3::repeat(spacing), body));
        }
    }

    #[test]
    fn no_points_have_no_volumes() {
        let mesh = shapes::sphere(0.1, shapes::Detail::default()).expect("a ball");
        assert!(volumes(&[], &Inside::new(&mesh), Vec3::repeat(0.02), 1.0).is_empty());
    }
}
