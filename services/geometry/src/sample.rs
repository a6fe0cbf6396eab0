//! Points that fill a body evenly: a periodic tile of Poisson-disk points, cut to shape.

use crate::inside::Inside;
use crate::math::{Quat, Vec3, unit};

/// Points along a side of the tile; 16³ points repeat only in bodies wider than that, and the tile
/// takes a few milliseconds.
const SIDE: usize = 16;
/// Least distance of two points, in spacings, that the tile is started with. Random darts jam at
/// 0.90 spacings at this density [random sequential addition: packing fraction 0.384].
const START_DISTANCE: f64 = 0.80;
/// Least distance of two points that every tile keeps, in spacings.
pub const MIN_DISTANCE: f64 = 0.72;
/// Darts in a row that may miss before the distance is lowered by [`EASING`].
const PATIENCE: u32 = 2_000;
/// Factor by which the distance is lowered.
const EASING: f64 = 0.99;
/// Most points looked at; at this many, sampling takes tens of seconds and gigabytes.
pub const MAX_CANDIDATES: f64 = 2e8;

/// Why a body cannot be sampled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SampleError {
    /// The spacing is not a positive number.
    #[error("the spacing of sample points is {spacing} m; it must be finite and > 0")]
    Spacing {
        /// What was given \[m\].
        spacing: f64,
    },
    /// The box around the body holds too many points of that spacing.
    #[error("a spacing of {spacing:e} m means {candidates:.2e} points, over {MAX_CANDIDATES:e}")]
    TooMany {
        /// What was given \[m\].
        spacing: f64,
        /// Points in the body's box.
        candidates: f64,
    },
}

/// Points inside a body such that each stands for `spacing`³ of volume \[m³\]: their number times
/// `spacing`³ is the body's volume within about 1/√(20 n) for n points. No two are closer than
/// [`MIN_DISTANCE`] · `spacing`. Walls thinner than the spacing get their share too, in a random
/// pattern. The same body, spacing and seed give the same points in the same order.
///
/// # Errors
/// [`SampleError`].
pub fn poisson(inside: &Inside, spacing: f64, seed: u64) -> Result<Vec<Vec3>, SampleError> {
    if !(spacing.is_finite() && spacing > 0.0) {
        return Err(SampleError::Spacing { spacing });
    }
    let (low, high) = inside.bounds();
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low) / spacing;
    if half.min() < 0.0 {
        return Ok(Vec::new());
    }
    // Turned askew, so that a flat body does not cut every tile at the same height.
    let turn = Quat::from_euler_angles(0.7, 0.4, 1.1);
    let matrix = turn.to_rotation_matrix();
    let reach = matrix.matrix().map(f64::abs).tr_mul(&half);
    let period = SIDE as f64;
    let candidates = reach.iter().map(|r| 2.0 * r + 2.0 * period).product::<f64>();
    if candidates > MAX_CANDIDATES {
        return Err(SampleError::TooMany { spacing, candidates });
    }
    let tile = tile(seed);
    let tiles = reach.map(|r| (r / period).ceil() as i32);
    let mut points = Vec::new();
    for (k, j) in (-tiles.z..tiles.z).flat_map(|k| (-tiles.y..tiles.y).map(move |j| (k, j))) {
        for i in -tiles.x..tiles.x {
            let corner = Vec3::new(f64::from(i), f64::from(j), f64::from(k)) * period;
            let centre = matrix * (corner + Vec3::repeat(0.5 * period));
            let clearance = 0.5 * period * 3.0_f64.sqrt();
            if (0..3).any(|a| centre[a].abs() > half[a] + clearance) {
                continue;
            }
            let placed = tile.iter().map(|p| middle + matrix * (corner + p) * spacing);
            points.extend(placed.filter(|&p| inside.contains(p)));
        }
    }
    Ok(points)
}

/// [`SIDE`]³ points in a cube of that side, no two closer than [`MIN_DISTANCE`], also across its
/// faces, where it repeats.
fn tile(seed: u64) -> Vec<Vec3> {
    let side = SIDE as f64;
    let wanted = SIDE * SIDE * SIDE;
    let mut distance = START_DISTANCE;
    // A cell's diagonal is less than the least distance: a cell holds one point at most.
    let cells = (side * 3.0_f64.sqrt() / MIN_DISTANCE).ceil() as usize;
    let per_unit = cells as f64 / side;
    let mut grid = vec![u32::MAX; cells * cells * cells];
    let mut points: Vec<Vec3> = Vec::with_capacity(wanted);
    let mut misses = 0;
    for dart in 0.. {
        if points.len() == wanted {
            break;
        }
        let p = Vec3::new(unit(seed, 0, dart), unit(seed, 1, dart), unit(seed, 2, dart)) * side;
        let cell = [0, 1, 2].map(|i| ((p[i] * per_unit) as usize).min(cells - 1));
        let reach = (distance * per_unit).ceil() as usize;
        if fits(&points, &grid, cells, cell, reach, p, distance) {
            grid[(cell[2] * cells + cell[1]) * cells + cell[0]] = points.len() as u32;
            points.push(p);
            misses = 0;
        } else {
            misses += 1;
            if misses == PATIENCE {
                misses = 0;
                distance = (distance * EASING).max(MIN_DISTANCE);
            }
        }
    }
    points
}

/// Whether `p` keeps its distance from all points in the cells around its own.
fn fits(
    points: &[Vec3],
    grid: &[u32],
    cells: usize,
    cell: [usize; 3],
    reach: usize,
    p: Vec3,
    distance: f64,
) -> bool {
    let side = SIDE as f64;
    let near = |axis: usize| (0..=2 * reach).map(move |o| (cell[axis] + cells + o - reach) % cells);
    for (z, y) in near(2).flat_map(|z| near(1).map(move |y| (z, y))) {
        for x in near(0) {
            let other = grid[(z * cells + y) * cells + x];
            if other != u32::MAX {
                let d = points[other as usize] - p;
                let wrapped = d.map(|c| c - side * (c / side).round());
                if wrapped.norm_squared() < distance * distance {
                    return false;
                }
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{Detail, cuboid, lathe_shell, sphere, torus};
    use std::f64::consts::PI;

    fn least_distance(points: &[Vec3]) -> f64 {
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| a.x.total_cmp(&b.x));
        let mut least = f64::INFINITY;
        for (i, p) in sorted.iter().enumerate() {
            let near = sorted[i + 1..].iter().take_while(|q| q.x - p.x < least);
            least = near.map(|q| (q - p).norm()).fold(least, f64::min);
        }
        least
    }

    #[test]
    fn a_point_stands_for_its_share_of_volume() {
        let detail = Detail { segments: 64, edge: None };
        let pot = lathe_shell(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]], 0.12, detail).unwrap();
        let bodies = [
            ("ball", sphere(1.0, detail).unwrap(), 0.09),
            ("ring", torus(1.0, 0.3, detail).unwrap(), 0.07),
            ("wall of two spacings", pot.clone(), 0.06),
            ("wall of half a spacing", cuboid(Vec3::new(6.0, 6.0, 0.05), detail).unwrap(), 0.1),
            ("box of many tiles", cuboid(Vec3::new(4.0, 1.0, 1.0), detail).unwrap(), 0.05),
        ];
        for (name, mesh, spacing) in bodies {
            let volume = mesh.signed_volume();
            let inside = Inside::new(&mesh);
            for seed in 0..3 {
                let points = poisson(&inside, spacing, seed).unwrap();
                assert!(points.len() > 1000, "{name}: {}", points.len());
                let ratio = points.len() as f64 * spacing * spacing * spacing / volume;
                assert!((ratio - 1.0).abs() < 0.03, "{name}, seed {seed}: {ratio}");
                assert!(
                    least_distance(&points) >= MIN_DISTANCE * spacing * (1.0 - 1e-12),
                    "{name}"
                );
                assert!(points.iter().all(|&p| inside.contains(p)));
            }
        }
    }

    #[test]
    fn the_points_have_the_centre_and_spread_of_the_body() {
        let inside = Inside::new(&sphere(1.0, Detail { segments: 120, edge: None }).unwrap());
        let points = poisson(&inside, 0.06, 3).unwrap();
        let n = points.len() as f64;
        assert!((points.iter().sum::<Vec3>() / n).norm() < 0.01);
        let spread = points.iter().map(Vec3::norm_squared).sum::<f64>() / n;
        assert!((spread - 0.6).abs() < 0.006, "{spread}");
        assert!((n * 0.06_f64.powi(3) / (4.0 / 3.0 * PI) - 1.0).abs() < 0.02);
    }

    #[test]
    fn equal_seeds_give_equal_points_and_others_do_not() {
        let inside = Inside::new(&cuboid(Vec3::repeat(1.0), Detail::default()).unwrap());
        let a = poisson(&inside, 0.08, 1).unwrap();
        assert_eq!(a, poisson(&inside, 0.08, 1).unwrap());
        assert_ne!(a, poisson(&inside, 0.08, 2).unwrap());
        assert!(matches!(poisson(&inside, 0.0, 1), Err(SampleError::Spacing { .. })));
        assert!(matches!(poisson(&inside, f64::NAN, 1), Err(SampleError::Spacing { .. })));
        assert!(matches!(poisson(&inside, 1e-4, 1), Err(SampleError::TooMany { .. })));
        let nothing = Inside::new(&crate::mesh::TriMesh::default());
        assert_eq!(poisson(&nothing, 0.1, 1), Ok(Vec::new()));
    }

    #[test]
    fn the_tile_is_full_and_keeps_its_distance_across_its_faces() {
        for seed in 0..8 {
            let points = tile(seed);
            assert_eq!(points.len(), SIDE.pow(3));
            let shift = Vec3::repeat(SIDE as f64 / 2.0);
            let wrapped: Vec<Vec3> =
                points.iter().map(|p| (p + shift).map(|c| c % SIDE as f64)).collect();
            assert!(least_distance(&points) >= MIN_DISTANCE);
            assert!(least_distance(&wrapped) >= MIN_DISTANCE - 1e-12);
        }
    }
}
