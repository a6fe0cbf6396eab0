//! Counting pairs of triangles that cross.

use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use robust::{Coord3D, orient3d};

/// Pairs of triangles without a common corner of which one pierces the other, and where the first
/// is \[m\]. At least one is reported: the exact test that sent us here also sees touching and
/// folded pairs, which are not counted.
pub(super) fn count(mesh: &TriMesh) -> (usize, Vec3) {
    let mut found = 0;
    let mut first = None;
    Nearest::new(mesh).overlapping_pairs(|s, t| {
        if mesh.triangles[s].iter().any(|i| mesh.triangles[t].contains(i)) {
            return;
        }
        let (p, q) = (mesh.corners(s), mesh.corners(t));
        if pierces(p, q) || pierces(q, p) {
            found += 1;
            first.get_or_insert((p[0] + p[1] + p[2]) / 3.0);
        }
    });
    (found.max(1), first.unwrap_or_else(|| mesh.vertices[0]))
}

/// Whether an edge of the first triangle passes through the inside of the second.
fn pierces(edges: [Vec3; 3], [a, b, c]: [Vec3; 3]) -> bool {
    let at = |p: Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
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
