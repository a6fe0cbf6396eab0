//! Division of triangles at the middles of their edges.

use crate::math::Vec3;

/// Replaces one triangle by one to four, according to which of its edges were divided: `middles`
/// tells the new vertex of an edge, smaller index first. Neighbours that are asked the same fit.
pub fn divide_triangle(
    vertices: &[Vec3],
    [a, b, c]: [u32; 3],
    middles: impl Fn([u32; 2]) -> Option<u32>,
    out: &mut Vec<[u32; 3]>,
) {
    let middle = |i, j| middles(key(i, j));
    let squared = |i: u32, j: u32| (vertices[i as usize] - vertices[j as usize]).norm_squared();
    let corners = [a, b, c];
    let cut = [middle(a, b), middle(b, c), middle(c, a)];
    let turned = |first: usize| [0, 1, 2].map(|i| (corners[(first + i) % 3], cut[(first + i) % 3]));
    match cut.iter().flatten().count() {
        0 => out.push(corners),
        1 => {
            let first = cut.iter().position(Option::is_some).unwrap_or(0);
            if let [(p, Some(m)), (q, _), (r, _)] = turned(first) {
                out.extend([[p, m, r], [m, q, r]]);
            }
        }
        2 => {
            let whole = cut.iter().position(Option::is_none).unwrap_or(0);
            // p–q is whole; m divides q–r, n divides r–p. The shorter diagonal closes the quad.
            if let [(p, _), (q, Some(m)), (r, Some(n))] = turned(whole) {
                out.push([m, r, n]);
                if squared(p, m) <= squared(q, n) {
                    out.extend([[p, q, m], [p, m, n]]);
                } else {
                    out.extend([[p, q, n], [q, m, n]]);
                }
            }
        }
        _ => {
            if let [Some(l), Some(m), Some(n)] = cut {
                out.extend([[a, l, n], [l, b, m], [n, m, c], [l, m, n]]);
            }
        }
    }
}

/// An edge by its vertices, the smaller index first.
#[must_use]
pub fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
