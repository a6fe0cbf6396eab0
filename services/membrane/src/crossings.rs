//! Where a sheet goes through itself: contact between points keeps folds and lips apart, but does
//! not stop a fast sheet (F95m). It is counted, and reported.

use crate::prepared::PreparedMembrane;
use cullet_continuum::tree::{BoxTree, SpaceBox};
use cullet_geometry::Vec3;

/// An end of an edge that is nearer to a triangle's plane than this share of their size is in it:
/// a flat sheet does not cross itself \[1\].
const FLAT: f64 = 1e-6;

/// Whether a bond still holds each of the pairs that hold the surface together.
pub(crate) fn live_pairs(prepared: &PreparedMembrane, damage: &[f64]) -> Vec<bool> {
    let whole = |b: &Option<usize>| b.is_some_and(|b| !prepared.bonds.cut[b] && damage[b] < 1.0);
    prepared.pairs.iter().map(whole).collect()
}

/// An edge between points that goes through a triangle between points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfaceCrossing {
    pub(crate) edge: [u32; 2],
    pub(crate) triangle: [u32; 3],
}

/// Finds all of them, by the edges' numbers.
pub(crate) fn crossings(triangles: &[[u32; 3]], places: &[Vec3]) -> Vec<SurfaceCrossing> {
    let place = |i: u32| places[i as usize];
    let around = |corners: &[u32]| -> SpaceBox {
        let first = place(corners[0]);
        let join = |[low, high]: SpaceBox, &i: &u32| [low.inf(&place(i)), high.sup(&place(i))];
        corners[1..].iter().fold([first, first], join)
    };
    let tree = BoxTree::new(triangles.iter().map(|corners| around(corners)));
    let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
    let sides = |&[a, b, c]: &[u32; 3]| [sorted(a, b), sorted(b, c), sorted(c, a)];
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    let mut all = Vec::new();
    for edge in edges {
        let first = all.len();
        tree.find(&around(&edge), |number| {
            let triangle = triangles[number as usize];
            let joined = triangle.iter().any(|corner| edge.contains(corner));
            if !joined && goes_through(edge.map(place), triangle.map(place)) {
                all.push(SurfaceCrossing { edge, triangle });
            }
            false
        });
        all[first..].sort_unstable_by_key(|crossing| crossing.triangle);
    }
    all
}

/// Points of the edges and triangles that cross.
pub(crate) fn crossed_points(triangles: &[[u32; 3]], places: &[Vec3]) -> Vec<u32> {
    let all = crossings(triangles, places);
    let points = |one: &SurfaceCrossing| {
        let ([a, b], [c, d, e]) = (one.edge, one.triangle);
        [a, b, c, d, e]
    };
    all.iter().flat_map(points).collect()
}

fn goes_through([p, q]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> bool {
    let normal = (b - a).cross(&(c - a));
    let (above, below) = (normal.dot(&(p - a)), normal.dot(&(q - a)));
    let size = normal.norm() * ((q - p).norm() + (b - a).norm());
    let apart = (above > FLAT * size && below < -FLAT * size)
        || (below > FLAT * size && above < -FLAT * size);
    if !apart {
        return false;
    }
    let at = p + (q - p) * (above / (above - below));
    let inside = |u: Vec3, v: Vec3| (v - u).cross(&(at - u)).dot(&normal) > 0.0;
    inside(a, b) && inside(b, c) && inside(c, a)
}
