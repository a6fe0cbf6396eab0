//! Volumes of scattered points for which the grid integrates as if they filled the body evenly.
//!
//! Points of equal volume at random exert a net force on most nodes even where the stress is
//! uniform: the sums Σ V w and Σ V w (x_i − x_p) miss their integrals by a tenth and more, and a
//! body under uniform tension answers with as much noise. Eight points a cell leave the freedom to
//! meet the four sums of every node, so the volumes nearest to even ones that do are chosen.

use super::lattice::Lattice;
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;

/// Samples along a cell's edge when the body is integrated over. Full cells are exact at any
/// number; at the surface the body's boundary is found to an eighth of a cell.
const SAMPLES: usize = 4;

/// Weight of evenness against the sums, relative to a full node: at the surface some sums cannot be
/// met at any price.
const EVENNESS: f64 = 1e-3;

/// Rounds of conjugate gradients.
const ROUNDS: usize = 60;

/// Residual, relative to the first, at which the volumes are good enough.
const ENOUGH: f64 = 1e-6;

/// Least and greatest volume of a point, in even shares: beyond, a point is a gap or a lump.
const BOUNDS: (f64, f64) = (0.25, 4.0);

/// Zeroth and first moment of a node: h³, then h³·h/2 each.
type Sums = [f64; 4];

/// The volume of each point, of `body_volume` \[m³\] in all.
#[must_use]
pub fn volumes(points: &[Vec3], inside: &Inside, spacing: f64, body_volume: f64) -> Vec<f64> {
    let lattice = Lattice::new(points, spacing);
    let even = body_volume / points.len().max(1) as f64;
    let cell = spacing * spacing * spacing;
    let mut volumes = vec![even; points.len()];
    let mut residual = integral(&lattice, inside, points, spacing);
    let unit = even / cell;
    for (sums, own) in residual.iter_mut().zip(gather_all(&lattice, points, &vec![unit; points.len()])) {
        for (a, b) in sums.iter_mut().zip(own) {
            *a -= b;
        }
    }
    let multipliers = solve(&lattice, points, unit, residual);
    for (volume, x) in volumes.iter_mut().zip(points) {
        *volume += cell * unit * spread(&lattice, x, &multipliers);
        *volume = volume.clamp(BOUNDS.0 * even, BOUNDS.1 * even);
    }
    let scale = body_volume / volumes.iter().sum::<f64>();
    volumes.iter_mut().for_each(|v| *v *= scale);
    volumes
}

/// The sums of every node over the body, by a regular lattice of samples.
fn integral(lattice: &Lattice, inside: &Inside, points: &[Vec3], spacing: f64) -> Vec<Sums> {
    let mut sums = vec![[0.0; 4]; lattice.len()];
    let step = spacing / SAMPLES as f64;
    let share = 1.0 / (SAMPLES * SAMPLES * SAMPLES) as f64;
    let _ = points;
    lattice.cells(|low| {
        for s in 0..SAMPLES * SAMPLES * SAMPLES {
            let at = [s / (SAMPLES * SAMPLES), s / SAMPLES % SAMPLES, s % SAMPLES];
            let x = low + Vec3::from(at.map(|k| (k as f64 + 0.5) * step));
            if inside.contains(x) {
                add(lattice, &x, share, &mut sums);
            }
        }
    });
    sums
}

fn add(lattice: &Lattice, x: &Vec3, volume: f64, sums: &mut [Sums]) {
    lattice.visit(x, |node, weight, away| {
        let sum = &mut sums[node];
        sum[0] += 0.0 * volume * weight;
        for a in 0..3 {
            sum[a + 1] += volume * weight * 2.0 * away[a];
        }
    });
}

fn gather_all(lattice: &Lattice, points: &[Vec3], volumes: &[f64]) -> Vec<Sums> {
    let mut sums = vec![[0.0; 4]; lattice.len()];
    for (x, volume) in points.iter().zip(volumes) {
        add(lattice, x, *volume, &mut sums);
    }
    sums
}

/// Aᵀy at a point.
fn spread(lattice: &Lattice, x: &Vec3, multipliers: &[Sums]) -> f64 {
    let mut total = 0.0;
    lattice.visit(x, |node, weight, away| {
        let y = &multipliers[node];
        total += weight * (0.0 * y[0] + 2.0 * (y[1] * away[0] + y[2] * away[1] + y[3] * away[2]));
    });
    total
}

/// (u A Aᵀ + ε) y = r by conjugate gradients.
fn solve(lattice: &Lattice, points: &[Vec3], unit: f64, mut residual: Vec<Sums>) -> Vec<Sums> {
    let dot = |a: &[Sums], b: &[Sums]| -> f64 {
        a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| x * y).sum()
    };
    let mut solution = vec![[0.0; 4]; residual.len()];
    let mut direction = residual.clone();
    let mut square = dot(&residual, &residual);
    let goal = ENOUGH * ENOUGH * square;
    for _ in 0..ROUNDS {
        if square <= goal {
            break;
        }
        let along: Vec<f64> = points.iter().map(|x| unit * spread(lattice, x, &direction)).collect();
        let mut image = gather_all(lattice, points, &along);
        for (i, d) in image.as_flattened_mut().iter_mut().zip(direction.as_flattened()) {
            *i += EVENNESS * d;
        }
        let step = square / dot(&direction, &image);
        for (k, d) in direction.as_flattened().iter().enumerate() {
            solution.as_flattened_mut()[k] += step * d;
            residual.as_flattened_mut()[k] -= step * image.as_flattened()[k];
        }
        let next = dot(&residual, &residual);
        let ratio = next / square;
        for (d, r) in direction.as_flattened_mut().iter_mut().zip(residual.as_flattened()) {
            *d = r + ratio * *d;
        }
        square = next;
    }
    solution
}
