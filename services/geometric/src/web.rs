//! The pattern of a plate that is hit on its face: radial cracks and rings around the impact.
//!
//! Bending opens radial cracks first; the sectors between them then bend outward and break along
//! rings, farther apart the farther out (thesis Fig. 3.23, and D9 for the radials). Cells keep
//! their shape from ring to ring, so rings grow in proportion to their radius.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::{BrittleProblem, Impact};
use std::f64::consts::TAU;

/// A body whose least extent is at most this share of the next is a plate.
const PLATE: f64 = 0.125;
/// Length of a cell along the radius over its width: shards are long.
const SLENDER: f64 = 2.0;
/// Fewest and most radial cracks.
const RADIALS: (usize, usize) = (5, 36);
/// How far a radial may lie from its even place, in their distances; a ring, in its widths; and a
/// cell's corner from its radial.
const JITTER: (f64, f64, f64) = (0.3, 0.25, 0.1);
/// Stream of the seed's numbers.
const STREAM: u64 = 0x3eb;

/// At most `most` sites of such a pattern, from the impact outward; `None` where the body is no
/// plate or nothing hits its face.
pub(super) fn sites(problem: &BrittleProblem, most: usize) -> Option<Vec<Vec3>> {
    let (low, high) = problem.solid.mesh.bounds()?;
    let extent = high - low;
    let axis = extent.imin();
    let next = (0..3).filter(|&a| a != axis).fold(f64::INFINITY, |m, a| m.min(extent[a]));
    let hits = problem.impacts.iter().filter(|hit| hit.normal[axis].abs() > 0.7);
    let hit: &Impact = hits.max_by(|a, b| a.energy.total_cmp(&b.energy))?;
    if extent[axis] > PLATE * next || most < 2 {
        return None;
    }
    let inner = (2.0 * hit.radius).max(0.5 * extent[axis]);
    let outer = (0..8).map(|k| {
        let corner = Vec3::from([0, 1, 2].map(|a| if k >> a & 1 == 0 { low[a] } else { high[a] }));
        (corner - hit.point).norm()
    });
    let span = libm::log(outer.fold(inner, f64::max) / inner);
    let rings = |radials: usize| (span / libm::log1p(SLENDER * TAU / radials as f64)).ceil();
    let fits = |radials: &usize| (*radials as f64) * rings(*radials) < most as f64;
    let radials = (RADIALS.0..=RADIALS.1).rev().find(fits).unwrap_or(RADIALS.0);
    let (growth, seed) = (SLENDER * TAU / radials as f64, problem.seed);
    let middle = 0.5 * (low + high);
    let mut sites = vec![hit.point];
    let mut radius = inner;
    for ring in 0..rings(radials) as u64 {
        for radial in 0..radials as u64 {
            let draw = |stream, index| 2.0 * unit(seed, STREAM + stream, index) - 1.0;
            let turn = radial as f64
                + JITTER.0 * draw(0, radial)
                + JITTER.2 * draw(1, ring << 32 | radial);
            let (sin, cos) = libm::sincos(TAU * turn / radials as f64);
            let r = radius * (1.0 + growth * (0.5 + JITTER.1 * draw(2, ring << 32 | radial)));
            let mut site = hit.point;
            site[(axis + 1) % 3] += r * cos;
            site[(axis + 2) % 3] += r * sin;
            sites.push(site);
        }
        radius *= 1.0 + growth;
    }
    sites.iter_mut().for_each(|site| site[axis] = middle[axis]);
    // Cells without a share of the body would only blur those at its rim.
    let near = |site: &Vec3| (0..3).all(|a| (low[a] - inner..=high[a] + inner).contains(&site[a]));
    sites.retain(near);
    sites.truncate(most);
    Some(sites)
}
