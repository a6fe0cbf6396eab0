//! Bodies of points and bonds against formulas: C2, C5, C6, E2 and E11 of the catalogue.

mod anisotropy;
mod cracks;
mod fragments;
mod limits;
mod moduli;
mod motion;
mod yielding;

use cullet_geometry::Vec3;
use cullet_peridynamics::{PeridynamicDomain, PeridynamicLaw};

/// δ over the spacing of the points that are looked at.
const HORIZONS: [f64; 3] = [2.04, 3.015, 4.0];

/// A block of points, `counts` of them, about the origin, each moved from its place in a lattice by
/// up to `shake` of the spacing.
fn block(
    counts: [usize; 3],
    spacing: f64,
    shake: f64,
    horizon: f64,
    law: PeridynamicLaw,
) -> PeridynamicDomain {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    };
    let [nx, ny, nz] = counts;
    let middle = Vec3::new(nx as f64, ny as f64, nz as f64) * 0.5;
    let places: Vec<Vec3> = (0..nx * ny * nz)
        .map(|k| Vec3::new((k % nx) as f64, (k / nx % ny) as f64, (k / nx / ny) as f64))
        .map(|at| at + Vec3::repeat(0.5) - middle)
        .map(|at| (at + Vec3::new(random(), random(), random()) * shake) * spacing)
        .collect();
    let volumes = vec![spacing.powi(3); places.len()];
    PeridynamicDomain::new(places, volumes, horizon * spacing, law).expect("a block")
}
