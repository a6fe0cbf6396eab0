//! Triangles of a polygon in space, of any number of corners.

mod ears;

use crate::math::Vec3;
use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{
    ConstrainedDelaunayTriangulation, Intersection, LineIntersectionIterator, Point2,
    Triangulation, mitigate_underflow,
};
use std::collections::{BTreeMap, VecDeque};

type PlaneNet = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// How far off their plane the corners of a flat polygon may lie \[of its extent\].
const FLAT: f64 = 1e-8;
/// Corners beyond which a polygon is taken for a flat one. Looking for ears takes the square of
/// their number at worst.
const MOST_EARS: usize = 20_000;

/// Triangles of a polygon in space, which need be neither convex nor flat and may touch itself:
/// three places in `corners` each, the way round that the polygon goes. Each corner is used, also
/// one in the middle of a straight side. A polygon of four is split from its first corner unless
/// half of it lay outside. A larger one that is flat is triangulated as Delaunay says, within its
/// sides: O(n log n). Of one that is not, ears are cut. One that crosses itself gives a fan.
#[must_use]
pub fn triangulate_polygon(corners: &[Vec3]) -> Vec<[u32; 3]> {
    match corners {
        [] | [_] | [_, _] => Vec::new(),
        [_, _, _] => vec![[0, 1, 2]],
        [a, b, c, d] => {
            let half = |p: &Vec3, q: &Vec3| (p - a).cross(&(q - a));
            if half(b, c).dot(&half(c, d)) < 0.0 {
                vec![[0, 1, 3], [1, 2, 3]]
            } else {
                vec![[0, 1, 2], [0, 2, 3]]
            }
        }
        _ => cut_bent(corners)
            .or_else(|| triangulate_uncrossed(corners))
            .unwrap_or_else(|| (2..corners.len() as u32).map(|k| [0, k - 1, k]).collect()),
    }
}

/// Nothing for a flat polygon.
fn cut_bent(corners: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    let normal = area_vector(corners).try_normalize(0.0)?;
    let about: Vec<Vec3> = corners.iter().map(|corner| corner - corners[0]).collect();
    let extent = about.iter().map(Vec3::norm).fold(0.0, f64::max);
    let heights = about.iter().map(|corner| corner.dot(&normal));
    let (low, high) = heights.fold((0.0, 0.0), |(l, h), height| (height.min(l), height.max(h)));
    let bent = high - low > FLAT * extent && corners.len() <= MOST_EARS;
    bent.then(|| ears::cut_ears(corners, &normal)).flatten()
}

/// Twice the area, along the normal: the sum of p × q over the sides (Newell), about the first
/// corner.
fn area_vector(corners: &[Vec3]) -> Vec3 {
    let about = |k: usize| corners[k % corners.len()] - corners[0];
    (0..corners.len()).map(|k| about(k).cross(&about(k + 1))).sum()
}

/// As [`triangulate_polygon`] for more than four corners; nothing for a polygon that crosses itself
/// or encloses no area.
#[must_use]
pub fn triangulate_uncrossed(corners: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    PlanePolygon::of(corners)?.triangles()
}

/// A polygon as seen along an axis, from where it goes round to the left.
struct PlanePolygon {
    /// Places, each once.
    places: Vec<Point2<f64>>,
    /// The place of each corner.
    of_corner: Vec<usize>,
    /// A corner at each place.
    corner: Vec<u32>,
}

impl PlanePolygon {
    /// Nothing for corners that enclose no area.
    fn of(corners: &[Vec3]) -> Option<Self> {
        let area = area_vector(corners);
        let axis = area.iamax();
        if !area[axis].is_finite() || area[axis] == 0.0 {
            return None;
        }
        let (mut right, mut up) = ((axis + 1) % 3, (axis + 2) % 3);
        if area[axis] < 0.0 {
            (right, up) = (up, right);
        }
        let mut known = BTreeMap::new();
        let mut polygon = Self { places: Vec::new(), of_corner: Vec::new(), corner: Vec::new() };
        for (k, corner) in corners.iter().enumerate() {
            let place = mitigate_underflow(Point2::new(corner[right], corner[up]));
            // Adding zero makes -0 and 0 one place.
            let bits = [place.x + 0.0, place.y + 0.0].map(f64::to_bits);
            let at = *known.entry(bits).or_insert_with(|| {
                polygon.places.push(place);
                polygon.corner.push(k as u32);
                polygon.places.len() - 1
            });
            polygon.of_corner.push(at);
        }
        Some(polygon)
    }

    fn sides(&self) -> impl Iterator<Item = [usize; 2]> {
        let next = self.of_corner.iter().cycle().skip(1);
        let sides = self.of_corner.iter().zip(next).map(|(&a, &b)| [a, b]);
        sides.filter(|[a, b]| a != b)
    }

    /// Nothing for sides that cross.
    fn triangles(&self) -> Option<Vec<[u32; 3]>> {
        let mut sides: Vec<[usize; 2]> = self.sides().map(|[a, b]| [a.min(b), a.max(b)]).collect();
        sides.sort_unstable();
        sides.dedup();
        let mut crosses = false;
        let cdt =
            PlaneNet::try_bulk_load_cdt(self.places.clone(), sides, |_| crosses = true).ok()?;
        if crosses || cdt.num_vertices() != self.places.len() {
            return None;
        }
        let inside = self.windings(&cdt);
        let faces = cdt.inner_faces().filter(|face| inside[face.fix().index()] > 0);
        Some(faces.map(|face| face.vertices().map(|v| self.corner[v.fix().index()])).collect())
    }

    /// How often the polygon goes round each face, to the left.
    fn windings(&self, cdt: &PlaneNet) -> Vec<i32> {
        // A side on which other corners lie is split at them.
        let mut net: BTreeMap<[usize; 2], i32> = BTreeMap::new();
        for side in self.sides() {
            let [from, to] = side.map(FixedVertexHandle::from_index);
            let mut at = side[0];
            for met in LineIntersectionIterator::new_from_handles(cdt, from, to) {
                if let Intersection::VertexIntersection(vertex) = met
                    && vertex.fix().index() != at
                {
                    let next = vertex.fix().index();
                    *net.entry([at, next]).or_default() += 1;
                    *net.entry([next, at]).or_default() -= 1;
                    at = next;
                }
            }
        }
        let outer = cdt.outer_face().fix();
        let mut windings = vec![None; cdt.num_all_faces()];
        windings[outer.index()] = Some(0);
        let mut next = VecDeque::new();
        // Across each edge of the outer face lies a face to begin with.
        for edge in cdt.directed_edges().filter(DirectedEdgeHandle::is_outer_edge) {
            let [a, b] = edge.vertices().map(|v| v.fix().index());
            let beyond = edge.rev().face().fix().index();
            if windings[beyond].is_none() {
                windings[beyond] = Some(net.get(&[b, a]).copied().unwrap_or(0));
                next.extend(edge.rev().face().as_inner().map(|face| face.fix()));
            }
        }
        while let Some(face) = next.pop_front() {
            let own = windings[face.index()].unwrap_or(0);
            for edge in cdt.face(face).adjacent_edges() {
                let [a, b] = edge.vertices().map(|v| v.fix().index());
                let beyond = edge.rev().face();
                if windings[beyond.fix().index()].is_none() {
                    // To the left of a side the polygon goes round once more than to its right.
                    let side = net.get(&[a, b]).copied().unwrap_or(0);
                    windings[beyond.fix().index()] = Some(own - side);
                    next.extend(beyond.as_inner().map(|face| face.fix()));
                }
            }
        }
        windings.into_iter().map(|winding| winding.unwrap_or(0)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::triangulate_polygon;
    use crate::math::Vec3;

    fn area(corners: &[Vec3]) -> f64 {
        let doubled = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|k| corners[k as usize]);
            (b - a).cross(&(c - a)).z
        };
        let triangles = triangulate_polygon(corners);
        assert!(triangles.iter().all(|&t| doubled(t) > 0.0), "{triangles:?}");
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), corners.len(), "each corner is used");
        triangles.into_iter().map(|t| 0.5 * doubled(t)).sum()
    }

    fn flat(corners: &[[f64; 2]]) -> Vec<Vec3> {
        corners.iter().map(|&[x, y]| Vec3::new(x, y, 0.3 * x - 0.2 * y)).collect()
    }

    #[test]
    fn polygons_have_their_area_and_use_each_corner() {
        // A channel, from each of its corners; a corner lies in the middle of its lowest side.
        let channel = [
            [0., 0.],
            [1.5, 0.],
            [3., 0.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        for first in 0..channel.len() {
            let mut turned = channel;
            turned.rotate_left(first);
            assert!((area(&flat(&turned)) - 7.0).abs() < 1e-12, "{first}");
        }
        let arrow = [[0., 0.], [2., 1.], [0., 2.], [1., 1.]];
        for first in 0..4 {
            let mut turned = arrow;
            turned.rotate_left(first);
            assert!((area(&flat(&turned)) - 1.0).abs() < 1e-12, "{first}");
        }
    }

    #[test]
    fn a_polygon_may_touch_itself() {
        // A frame that is cut open at one place, along which it goes twice.
        let corners = [
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [0., 4.],
            [0., 0.],
            [1., 1.],
            [1., 3.],
            [3., 3.],
            [3., 1.],
            [1., 1.],
        ];
        let corners = flat(&corners);
        let doubled: f64 = triangulate_polygon(&corners)
            .into_iter()
            .map(|t| {
                let [a, b, c] = t.map(|k| corners[k as usize]);
                (b - a).cross(&(c - a)).z
            })
            .sum();
        assert!((0.5 * doubled - 12.0).abs() < 1e-12, "{doubled}");
    }

    #[test]
    fn a_bent_polygon_is_split_where_blender_splits_it() {
        let heights = [0.0, 0.25, -0.5, 0.125, 0.5, -0.25, 0.375, -0.125];
        let channel =
            [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
        let corner = |([x, y], z): ([f64; 2], f64)| Vec3::new(x, y, z);
        let corners: Vec<Vec3> = channel.into_iter().zip(heights).map(corner).collect();
        // Mesh.calc_loop_triangles of Blender 5.0.1.
        let theirs = [[1, 2, 3], [1, 3, 4], [6, 7, 0], [1, 4, 5], [5, 6, 0], [0, 1, 5]];
        let sorted = |triangles: &[[u32; 3]]| {
            let mut sorted = triangles.to_vec();
            sorted.iter_mut().for_each(|triangle| triangle.sort_unstable());
            sorted.sort_unstable();
            sorted
        };
        assert_eq!(sorted(&triangulate_polygon(&corners)), sorted(&theirs));
    }

    #[test]
    fn what_encloses_nothing_or_crosses_itself_is_a_fan() {
        let line: Vec<Vec3> = (0..5).map(|k| Vec3::new(f64::from(k), 0.0, 0.0)).collect();
        assert_eq!(triangulate_polygon(&line).len(), 3);
        let star: Vec<Vec3> = (0..5)
            .map(|k| std::f64::consts::TAU * 2.0 * f64::from(k) / 5.0)
            .map(|angle| Vec3::new(angle.cos(), angle.sin(), 0.0))
            .collect();
        assert_eq!(triangulate_polygon(&star), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert!(triangulate_polygon(&line[..2]).is_empty());
    }
}
