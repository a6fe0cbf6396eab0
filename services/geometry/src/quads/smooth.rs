//! Moves the vertices of a net of quads so that each quad is nearly a square.

use super::crosses::tangent;
use super::net::QuadNet;
use crate::math::Vec3;
use crate::remesh::curved::unit_or;
use crate::remesh::editable::VertexRole;
use crate::remesh::reference_surface::ReferenceSurface;

/// Passes; lengths settle in some tens.
const PASSES: usize = 40;
/// How much of the wanted side goes into a square's, beside its own size.
const SIZE_SHARE: f64 = 0.5;
/// Rounds in which bad quads are improved.
const POLISHES: usize = 12;
/// How far a vertex is moved in the rounds in turn, over the wanted edge.
const STEPS: [f64; 3] = [0.2, 0.1, 0.05];
/// A quad is good if the sine of each of its angles is at least this, 50° to 130°, …
const SINE: f64 = 0.766;
/// … and each of its edges between these, over the wanted.
const EDGES: [f64; 2] = [0.65, 1.5];

/// Moves each vertex to the mean of what its quads would have as squares of about this `side`
/// \[m\], on the surface; those of a rim stay on it \[Bouaziz et al. 2012, *Shape-Up*\].
pub(super) fn smooth(net: &mut QuadNet, surface: &ReferenceSurface, side: f64) {
    let around = net.around();
    for _ in 0..PASSES {
        let mut sums = vec![Vec3::zeros(); net.points.len()];
        let normals = normals(net);
        for q in 0..net.quads.len() {
            let up = net.quads[q].iter().map(|&v| normals[v as usize]).sum();
            let wanted = square(net.corners(q), up, side);
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

/// The normals at the vertices, weighted by area.
fn normals(net: &QuadNet) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); net.points.len()];
    for q in 0..net.quads.len() {
        let [a, b, c, d] = net.corners(q);
        let area = (c - a).cross(&(d - b));
        net.quads[q].iter().for_each(|&v| sums[v as usize] += area);
    }
    sums
}

/// The square that fits a quad best, with a side between its size and `side` \[m\], in its plane;
/// in that across `up` if it lies the wrong way round.
fn square(corners: [Vec3; 4], up: Vec3, side: f64) -> [Vec3; 4] {
    let [a, b, c, d] = corners;
    let centre = 0.25 * (a + b + c + d);
    let (first, second) = (a - c, b - d);
    let own = first.cross(&second);
    let normal = unit_or(if own.dot(&up) > 0.0 { own } else { up }, Vec3::zeros());
    let arm = 0.25 * (first + second.cross(&normal));
    let wanted = side * std::f64::consts::FRAC_1_SQRT_2;
    let radius = (1.0 - SIZE_SHARE) * arm.norm() + SIZE_SHARE * wanted;
    let x = unit_or(arm - normal * arm.dot(&normal), Vec3::zeros()) * radius;
    let y = normal.cross(&x);
    [centre + x, centre + y, centre - x, centre - y]
}

/// Moves the vertices of bad quads to better places nearby.
pub(super) fn polish(net: &mut QuadNet, surface: &ReferenceSurface, side: f64) {
    let around = net.around();
    for round in 0..POLISHES {
        let step = side * STEPS[round % STEPS.len()];
        let normals = normals(net);
        let mut moves = 0;
        for v in (0..net.points.len()).filter(|&v| net.role[v] != VertexRole::Corner) {
            let normal = unit_or(normals[v], Vec3::zeros());
            let first = score(net, &around[v], normal, side);
            if first >= 1.0 {
                continue;
            }
            let here = net.points[v];
            let mut best = (first * (1.0 + 1e-9), here);
            for way in ways(normal) {
                net.points[v] = placed(net.role[v], surface, here, here + way * step);
                let score = score(net, &around[v], normal, side);
                if score > best.0 {
                    best = (score, net.points[v]);
                }
            }
            net.points[v] = best.1;
            moves += usize::from(best.1 != here);
        }
        if moves == 0 && round + 1 >= STEPS.len() {
            break;
        }
    }
}

/// Eight directions across a normal.
fn ways(normal: Vec3) -> [Vec3; 8] {
    let x = tangent(Vec3::ith(normal.iamin(), 1.0), normal);
    let y = normal.cross(&x);
    let slant = std::f64::consts::FRAC_1_SQRT_2;
    let [p, q] = [(x + y) * slant, (x - y) * slant];
    [x, -x, y, -y, p, -p, q, -q]
}

/// How good the worst of some quads is: at least 1 if all are good, negative if one is not convex.
fn score(net: &QuadNet, quads: &[u32], normal: Vec3, side: f64) -> f64 {
    let of = |&q: &u32| {
        let p = net.corners(q as usize);
        let mut least = f64::INFINITY;
        for k in 0..4 {
            let (e, f) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            let (length, other) = (e.norm(), f.norm());
            let sine = e.cross(&f).dot(&normal) / (length * other).max(f64::MIN_POSITIVE);
            let lengths = (length / (EDGES[0] * side)).min(EDGES[1] * side / length);
            least = least.min(sine / SINE).min(lengths);
        }
        least
    };
    quads.iter().map(of).fold(f64::INFINITY, f64::min)
}
