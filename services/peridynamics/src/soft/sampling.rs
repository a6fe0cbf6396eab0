//! Points that fill a body: relaxed, with a layer under the surface.
//!
//! A body touches others by its points. In random ones the outermost lie anywhere down to a
//! spacing under the surface, and it would rest on nothing, or inside of what bears it.

use super::grid::PointCells;
use crate::bonds::neighbours::in_rows;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::sample::{self, SampleError};
use cullet_geometry::{TriMesh, Vec3};
use rayon::prelude::*;

/// Depth of the outermost layer, in spacings. Bonds of a point there reach inwards only, so that it
/// strains as what lies a sixth of the horizon deeper: at half a spacing, where a lattice has it, a
/// cantilever with seven points across and δ = 2.5 spacings swings 9 % too slowly and a bar with
/// eight twists by 12 % too little torque; here 5 % and 4 %, and a bar rings 2 % too slowly along
/// its length.
pub const LAYER: f64 = 0.3;
/// Points down to this depth, in spacings, are drawn to the layer.
const DRAWN: f64 = LAYER + 0.25;
/// Rounds of relaxation, and share of a push that is followed in one.
const ROUNDS: usize = 40;
const FOLLOWED: f64 = 0.35;
/// Distance up to which points push each other, in spacings.
const REACH: f64 = 1.3;
/// Times that a point is moved away from a wall in a round: it may be near three.
const WALLS: usize = 4;

/// Points about `spacing` \[m\] apart, those that are near each other near in the list.
///
/// # Errors
///
/// If the spacing is none, or there would be too many.
pub fn relaxed(mesh: &TriMesh, spacing: f64, seed: u64) -> Result<Vec<Vec3>, SampleError> {
    let (inside, nearest) = (Inside::new(mesh), Nearest::new(mesh));
    let mut points = sample::poisson(&inside, spacing, seed)?;
    let layered = |x: Vec3| layer(x, spacing, &inside, &nearest);
    points.par_iter_mut().for_each(|x| *x = layered(*x));
    for _ in 0..ROUNDS {
        let cells = PointCells::new(&points, REACH * spacing);
        let moved = |(p, x): (usize, &Vec3)| {
            let mut push = Vec3::zeros();
            cells.around(x, 1, |q| {
                let apart = x - points[q as usize];
                let distance = apart.norm();
                if q as usize != p && distance > 0.0 && distance < REACH * spacing {
                    push += apart * ((REACH * spacing - distance) / distance);
                }
            });
            layered(x + push * FOLLOWED)
        };
        points = points.par_iter().enumerate().map(moved).collect();
    }
    Ok(in_rows(&points, spacing))
}

/// A place that is not nearer to the surface than the layer, and in it where it is nearly.
fn layer(mut x: Vec3, spacing: f64, inside: &Inside, nearest: &Nearest) -> Vec3 {
    let depth = LAYER * spacing;
    for round in 0..WALLS {
        let most = if round == 0 { DRAWN * spacing } else { 0.999 * depth };
        let within = inside.contains(x);
        let reach = if within { most } else { f64::INFINITY };
        let Some((foot, distance, _)) = nearest.closest_within(x, reach, |_| true) else { break };
        if distance <= 1e-9 * spacing || (within && distance >= most) {
            break;
        }
        let inward = (x - foot) * if within { 1.0 / distance } else { -1.0 / distance };
        x = foot + inward * depth;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::{LAYER, relaxed};
    use cullet_geometry::Vec3;
    use cullet_geometry::inside::Nearest;
    use cullet_geometry::shapes::{Detail, cuboid};

    /// Nothing above the layer, many points in it, none too near another.
    #[test]
    fn points_keep_their_distance_from_the_surface_and_from_each_other() {
        let mesh = cuboid(Vec3::new(0.2, 0.12, 0.08), Detail::default()).unwrap();
        let spacing = 0.01;
        let points = relaxed(&mesh, spacing, 3).unwrap();
        assert!((points.len() as f64 / 1920.0 - 1.0).abs() < 0.03, "{}", points.len());
        let nearest = Nearest::new(&mesh);
        let depths: Vec<f64> = points.iter().map(|x| nearest.distance(*x) / spacing).collect();
        let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least > 0.98 * LAYER, "{least}");
        let layer = depths.iter().filter(|&&d| d < 1.02 * LAYER).count() as f64;
        let wanted = 20.0 * 12.0 * 8.0 - 18.0 * 10.0 * 6.0;
        assert!((layer / wanted - 1.0).abs() < 0.2, "{layer} of {wanted}");
        let mut closest = f64::INFINITY;
        for (p, x) in points.iter().enumerate() {
            for y in &points[..p] {
                closest = closest.min((x - y).norm() / spacing);
            }
        }
        assert!(closest > 0.6, "{closest}");
    }
}
