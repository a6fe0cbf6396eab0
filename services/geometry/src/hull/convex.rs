//! Convex hulls, grown by the farthest point, with exact predicates.

use crate::math::Vec3;
use robust::{Coord3D, orient3d};

/// A convex polyhedron: corners and outward triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    points: Vec<Vec3>,
    faces: Vec<[usize; 3]>,
}

/// A face under construction and the plane that measures how far points are outside it.
struct HullFace {
    corners: [usize; 3],
    normal: Vec3,
    offset: f64,
}

impl Hull {
    /// The hull of `points`, or, where that has more than `max_vertices` corners, a smaller one
    /// inside it: points are added by falling distance from what is there. `None` if the points lie
    /// in a plane or are not finite.
    #[must_use]
    pub fn of(points: &[Vec3], max_vertices: usize) -> Option<Self> {
        if !points.iter().flatten().all(|c| c.is_finite()) {
            return None;
        }
        let start = tetrahedron(points)?;
        let [a, b, c, d] = start;
        let corners = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]];
        let mut faces: Vec<HullFace> = corners.iter().map(|&c| HullFace::new(points, c)).collect();
        let mut heights: Vec<Height> = points.iter().map(|p| Height::of(p, &faces)).collect();
        let mut used = start.to_vec();
        while used.len() < max_vertices {
            let Some(next) = farthest_outside(&heights) else {
                break;
            };
            if !insert(points, &mut faces, next, &mut heights) {
                break;
            }
            used = corners_of(&faces);
        }
        used.sort_unstable();
        let slot = |i: usize| used.binary_search(&i).unwrap_or(0);
        Some(Self {
            points: used.iter().map(|&i| points[i]).collect(),
            faces: faces.iter().map(|f| f.corners.map(slot)).collect(),
        })
    }

    /// Its corners \[m\].
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.points
    }

    /// Its outward triangles.
    #[must_use]
    pub fn faces(&self) -> &[[usize; 3]] {
        &self.faces
    }

    /// Its volume \[m³\].
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.tetrahedra().map(|(v, _)| v).sum()
    }

    /// Its centroid \[m\].
    #[must_use]
    pub fn centroid(&self) -> Vec3 {
        let (volume, moment) = self
            .tetrahedra()
            .fold((0.0, Vec3::zeros()), |(volume, moment), (v, m)| (volume + v, moment + v * m));
        let origin = self.points[0];
        if volume > 0.0 { origin + moment / volume } else { origin }
    }

    /// The outward normal and offset \[m\] of each face's plane: `normal · x <= offset` inside.
    #[must_use]
    pub fn planes(&self) -> Vec<(Vec3, f64)> {
        let plane = |face: &[usize; 3]| {
            let HullFace { normal, offset, .. } = HullFace::new(&self.points, *face);
            (normal, offset)
        };
        self.faces.iter().map(plane).collect()
    }

    /// How deep `p` lies under the nearest face plane \[m\]; negative outside.
    #[must_use]
    pub fn depth(&self, p: Vec3) -> f64 {
        depth(&self.planes(), p)
    }

    /// Volume and centroid, from the first corner, of the tetrahedra under the faces.
    fn tetrahedra(&self) -> impl Iterator<Item = (f64, Vec3)> + '_ {
        let origin = self.points[0];
        self.faces.iter().map(move |f| {
            let [a, b, c] = f.map(|i| self.points[i] - origin);
            (a.dot(&b.cross(&c)) / 6.0, (a + b + c) / 4.0)
        })
    }
}

/// How deep `p` lies under the nearest of some planes \[m\].
pub(super) fn depth(planes: &[(Vec3, f64)], p: Vec3) -> f64 {
    planes.iter().map(|(normal, offset)| offset - normal.dot(&p)).fold(f64::INFINITY, f64::min)
}

/// Volume of the convex hull of `points` \[m³\]; zero if they lie in a plane.
#[must_use]
pub fn hull_volume(points: &[Vec3]) -> f64 {
    Hull::of(points, usize::MAX).map_or(0.0, |h| h.volume())
}

impl HullFace {
    fn new(points: &[Vec3], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|i| points[i]);
        let cross = (b - a).cross(&(c - a));
        let length = cross.norm();
        let normal = if length > 0.0 { cross / length } else { Vec3::zeros() };
        Self { corners, normal, offset: normal.dot(&a) }
    }

    fn sees(&self, points: &[Vec3], p: usize) -> bool {
        let [a, b, c] = self.corners.map(|i| points[i]);
        is_above(a, b, c, points[p]) > 0.0
    }
}

/// Positive where `p` is on the side from which a, b, c turn left; exact in sign.
fn is_above(a: Vec3, b: Vec3, c: Vec3, p: Vec3) -> f64 {
    let at = |p: Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
    -orient3d(at(a), at(b), at(c), at(p))
}

/// Four far corners of a tetrahedron with positive volume: (a, b, c) turns left seen from outside.
fn tetrahedron(points: &[Vec3]) -> Option<[usize; 4]> {
    let most = |value: &dyn Fn(&Vec3) -> f64| {
        let mut best = (0.0, None);
        for (i, p) in points.iter().enumerate() {
            let v = value(p);
            if v > best.0 {
                best = (v, Some(i));
            }
        }
        best.1
    };
    let first = *points.first()?;
    let a = most(&|p| (p - first).norm_squared())?;
    let b = most(&|p| (p - points[a]).norm_squared())?;
    let along = points[b] - points[a];
    let c = most(&|p| (p - points[a]).cross(&along).norm_squared())?;
    let normal = along.cross(&(points[c] - points[a]));
    let d = most(&|p| (p - points[a]).dot(&normal).abs())?;
    let above = is_above(points[a], points[b], points[c], points[d]);
    if above == 0.0 {
        return None;
    }
    Some(if above > 0.0 { [a, c, b, d] } else { [a, b, c, d] })
}

/// How far a point is outside the face that it is farthest outside of \[m\], and which that is.
#[derive(Clone, Copy)]
struct Height {
    out: f64,
    corners: [usize; 3],
}

impl Height {
    fn of(p: &Vec3, faces: &[HullFace]) -> Self {
        Self { out: f64::MIN, corners: [0; 3] }.among(p, faces)
    }

    /// With these faces too.
    fn among(mut self, p: &Vec3, faces: &[HullFace]) -> Self {
        for face in faces {
            let out = face.normal.dot(p) - face.offset;
            if out > self.out {
                self = Self { out, corners: face.corners };
            }
        }
        self
    }
}

/// The point farthest outside any face, if one is outside at all.
fn farthest_outside(heights: &[Height]) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for (i, height) in heights.iter().enumerate() {
        if best.is_none_or(|(most, _)| height.out > most) {
            best = Some((height.out, i));
        }
    }
    best.filter(|(out, _)| *out > 0.0).map(|(_, i)| i)
}

/// Adds a point: the faces that see it go, and it is joined to the edge of the hole. Says whether
/// the point was outside. A horizon edge has a face that sees the point strictly, so no new face is
/// flat.
fn insert(points: &[Vec3], faces: &mut Vec<HullFace>, p: usize, heights: &mut [Height]) -> bool {
    let (seen, kept): (Vec<HullFace>, Vec<HullFace>) =
        std::mem::take(faces).into_iter().partition(|f| f.sees(points, p));
    *faces = kept;
    let edges = |f: &HullFace| {
        let [a, b, c] = f.corners;
        [(a, b), (b, c), (c, a)]
    };
    let mut rim: Vec<(usize, usize)> = seen.iter().flat_map(edges).collect();
    rim.sort_unstable();
    let horizon = rim.iter().filter(|(a, b)| rim.binary_search(&(*b, *a)).is_err());
    let old = faces.len();
    faces.extend(horizon.map(|&(a, b)| HullFace::new(points, [a, b, p])));
    let gone = |height: &Height| seen.iter().any(|face| face.corners == height.corners);
    for (p, height) in points.iter().zip(heights) {
        *height = match gone(height) {
            true => Height::of(p, faces),
            false => height.among(p, &faces[old..]),
        };
    }
    !seen.is_empty()
}

fn corners_of(faces: &[HullFace]) -> Vec<usize> {
    let mut used: Vec<usize> = faces.iter().flat_map(|f| f.corners).collect();
    used.sort_unstable();
    used.dedup();
    used
}
