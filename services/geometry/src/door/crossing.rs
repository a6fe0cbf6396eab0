//! Counting pairs of triangles that cross.

use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use robust::{Coord3D, orient3d};

/// Pairs of triangles without a common corner of which one pierces the other, and where the first
/// is \[m\]. At least one is reported: the exact test that sent us here also sees touching and
/// folded pairs, which are not counted; where there are no others, the place is that of the first
/// two that lie in each other.
pub(super) fn count(mesh: &TriMesh) -> (usize, Vec3) {
    let mut found = 0;
    let (mut first, mut touch) = (None, None);
    Nearest::new(mesh).overlapping_pairs(|s, t| {
        if mesh.triangles[s].iter().any(|i| mesh.triangles[t].contains(i)) {
            return;
        }
        let (p, q) = (mesh.corners(s), mesh.corners(t));
        if pierces(p, q) || pierces(q, p) {
            found += 1;
            first.get_or_insert((p[0] + p[1] + p[2]) / 3.0);
        } else if touch.is_none() && cover(p, q) {
            touch = Some(middle(p, q));
        }
    });
    (found.max(1), first.or(touch).unwrap_or_else(|| mesh.vertices[0]))
}

/// Whether two triangles lie in one plane and cover some of it both: no edge of either parts them.
fn cover(p: [Vec3; 3], q: [Vec3; 3]) -> bool {
    let [a, b, c] = q;
    let flat = p.iter().all(|x| orient3d(at(a), at(b), at(c), at(*x)) == 0.0);
    let parts = |[a, b, c]: [Vec3; 3], other: [Vec3; 3]| {
        let normal = (b - a).cross(&(c - a));
        let mut edges = [(a, b), (b, c), (c, a)].into_iter();
        edges.any(|(from, to)| {
            let outward = (to - from).cross(&normal);
            other.iter().all(|x| outward.dot(&(x - from)) >= 0.0)
        })
    };
    flat && !parts(p, q) && !parts(q, p)
}

/// The middle of what the boxes of two triangles share.
fn middle(p: [Vec3; 3], q: [Vec3; 3]) -> Vec3 {
    let low = |[a, b, c]: [Vec3; 3]| a.inf(&b).inf(&c);
    let high = |[a, b, c]: [Vec3; 3]| a.sup(&b).sup(&c);
    0.5 * (low(p).sup(&low(q)) + high(p).inf(&high(q)))
}

fn at(p: Vec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// Whether an edge of the first triangle passes through the inside of the second.
fn pierces(edges: [Vec3; 3], [a, b, c]: [Vec3; 3]) -> bool {
    let side = |p: Vec3, q: Vec3, r: Vec3, s: Vec3| orient3d(at(p), at(q), at(r), at(s));
    (0..3).any(|i| {
        let (p, q) = (edges[i], edges[(i + 1) % 3]);
        if side(a, b, c, p) * side(a, b, c, q) >= 0.0 {
            return false;
        }
        let turns = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
        turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0)
    })
}
