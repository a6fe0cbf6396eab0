//! Where a surface goes through itself: contact between points keeps folds apart, but does not stop
//! a fast wall.

use crate::tree::{BoxTree, SpaceBox};
use cullet_geometry::Vec3;

/// An end of an edge that is nearer to a triangle's plane than this share of their size is in it:
/// a flat surface does not cross itself \[1\].
const FLAT: f64 = 1e-6;

/// An edge between points that goes through a triangle between points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCrossing {
    /// Numbers of its ends, rising.
    pub edge: [u32; 2],
    /// Numbers of its corners.
    pub triangle: [u32; 3],
}

/// Finds all of them, by the edges' numbers. `places` has the place of each point \[m\].
#[must_use]
pub fn crossings(triangles: &[[u32; 3]], places: &[Vec3]) -> Vec<SurfaceCrossing> {
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
