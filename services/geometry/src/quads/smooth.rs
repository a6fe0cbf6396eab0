//! Moves the vertices of a net of quads so that each quad is nearly a square.

use super::net::QuadNet;
use crate::math::Vec3;
use crate::remesh::curved::unit_or;
use crate::remesh::editable::VertexRole;
use crate::remesh::reference_surface::ReferenceSurface;

/// Passes; lengths settle in some tens.
const PASSES: usize = 40;
/// How much of the wanted side goes into a square's, beside its own size.
const SIZE_SHARE: f64 = 0.5;

/// Moves each vertex to the mean of what its quads would have as squares of about this `side`
/// \[m\], on the surface; those of a rim stay on it \[Bouaziz et al. 2012, *Shape-Up*\].
pub(super) fn smooth(net: &mut QuadNet, surface: &ReferenceSurface, side: f64) {
    let around = net.around();
    for _ in 0..PASSES {
        let mut sums = vec![Vec3::zeros(); net.points.len()];
        for q in 0..net.quads.len() {
            let wanted = square(net.corners(q), side);
            for (v, p) in net.quads[q].into_iter().zip(wanted) {
                sums[v as usize] += p;
            }
        }
        for v in 0..net.points.len() {
            let p = sums[v] / around[v].len().max(1) as f64;
            net.points[v] = placed(net.role[v], surface, net.points[v], p);
        }
    }
}

/// `p` \[m\] on the surface or the rim; `here` for a corner.
pub(super) fn placed(role: VertexRole, surface: &ReferenceSurface, here: Vec3, p: Vec3) -> Vec3 {
    match role {
        VertexRole::Interior => surface.project(p),
        VertexRole::Border => surface.project_on_border(p),
        VertexRole::Corner => here,
    }
}

/// The square that fits a quad best, with a side between its size and `side` \[m\].
fn square(corners: [Vec3; 4], side: f64) -> [Vec3; 4] {
    let [a, b, c, d] = corners;
    let centre = 0.25 * (a + b + c + d);
    let (first, second) = (a - c, b - d);
    let normal = unit_or(first.cross(&second), Vec3::zeros());
    let arm = 0.25 * (first + second.cross(&normal));
    let wanted = side * std::f64::consts::FRAC_1_SQRT_2;
    let radius = (1.0 - SIZE_SHARE) * arm.norm() + SIZE_SHARE * wanted;
    let x = unit_or(arm, Vec3::zeros()) * radius;
    let y = normal.cross(&x);
    [centre + x, centre + y, centre - x, centre - y]
}
