//! Division of a faceted mesh that follows the smooth surface its facets stand for.

use crate::divide::{divide_triangle, key};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Faces that meet at more than this are a crease: cosine of 40°. The facets of a lathe with nine
/// segments a turn or more are smooth.
const CREASE: f64 = 0.766;

/// Triangles that meet at less than this are one flat face: cosine of 0.03°.
const FLAT: f64 = 1.0 - 1e-7;

/// Passes after which division stops; each halves the longest edges.
const MAX_PASSES: usize = 24;

/// Edges of over this share of the longest of their triangle are divided with it.
const LONG: f64 = 0.7;

/// Edges are divided down to half the wanted length where the surface lies further from their
/// middle than this times that length.
const LIFTED: f64 = 0.01;

/// A mesh with a normal at each corner of each triangle; across a crease they differ.
#[derive(Clone, Debug)]
pub(crate) struct CurvedMesh {
    pub(crate) mesh: TriMesh,
    normals: Vec<[Vec3; 3]>,
    /// The triangle that each was divided from.
    pub(crate) origin: Vec<u32>,
}

/// One triangle's view of an edge: its ends' normals, the smaller vertex index first.
#[derive(Clone, Copy, Debug)]
struct EdgeView {
    edge: [u32; 2],
    normals: [Vec3; 2],
}

/// A divided edge and the vertex in its middle.
type EdgeMiddle = ([u32; 2], u32);

impl CurvedMesh {
    /// With normals from the faces around each vertex that no crease parts from one another.
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let normals = corner_normals(mesh);
        let origin = (0..mesh.triangles.len() as u32).collect();
        Self { mesh: mesh.clone(), normals, origin }
    }

    /// Divided until no edge is longer than `edge` \[m\], or half of it where the surface is
    /// bent, or there are `most` triangles. The middle
    /// of an edge is put on the arc that the normals at its ends belong to: exact for quadratic
    /// surfaces, like the Phong patch with its factor at 1/2 \[Boubekeur & Alexa 2008\].
    pub(crate) fn refined(mut self, edge: f64, most: usize) -> Self {
        for _ in 0..MAX_PASSES {
            let middles = self.divide_edges(edge);
            if middles.is_empty() || self.mesh.triangles.len() >= most {
                break;
            }
            self.divide_triangles(&middles);
        }
        self
    }

    /// Adds the middle of each edge that is too long and among the longest of one of its triangles.
    /// Both long edges of a thin triangle are divided at once, or it would become ever thinner.
    fn divide_edges(&mut self, limit: f64) -> Vec<EdgeMiddle> {
        let mut long: Vec<[u32; 2]> = Vec::new();
        for (&corners, normals) in self.mesh.triangles.iter().zip(&self.normals) {
            let ends = [0, 1, 2].map(|k| [k, (k + 1) % 3]);
            let lengths = ends.map(|[i, j]| (self.at(corners[i]) - self.at(corners[j])).norm());
            let longest = lengths.into_iter().fold(0.0, f64::max);
            for (k, [i, j]) in ends.into_iter().enumerate() {
                let points = [self.at(corners[i]), self.at(corners[j])];
                let lift = || lift(0.5 * (points[0] + points[1]), points, [normals[i], normals[j]]);
                let is_long = lengths[k] > limit
                    || (lengths[k] > 0.5 * limit && lift().1.abs() > LIFTED * limit);
                if is_long && lengths[k] > LONG * longest {
                    long.push(key(corners[i], corners[j]));
                }
            }
        }
        long.sort_unstable();
        long.dedup();
        let mut views: Vec<EdgeView> = Vec::with_capacity(2 * long.len());
        for (corners, normals) in self.mesh.triangles.iter().zip(&self.normals) {
            for k in 0..3 {
                let (i, j) = if corners[k] < corners[(k + 1) % 3] {
                    (k, (k + 1) % 3)
                } else {
                    ((k + 1) % 3, k)
                };
                let edge = [corners[i], corners[j]];
                if long.binary_search(&edge).is_ok() {
                    views.push(EdgeView { edge, normals: [normals[i], normals[j]] });
                }
            }
        }
        views.sort_by_key(|view| view.edge);
        let mut middles = Vec::with_capacity(long.len());
        for views in views.chunk_by(|a, b| a.edge == b.edge) {
            middles.push((views[0].edge, self.mesh.vertices.len() as u32));
            let middle = self.middle(views);
            self.mesh.vertices.push(middle);
        }
        middles
    }

    fn at(&self, v: u32) -> Vec3 {
        self.mesh.vertices[v as usize]
    }

    /// The middle of an edge, lifted so that it fits the triangles on both of its sides.
    fn middle(&self, views: &[EdgeView]) -> Vec3 {
        let [a, b] = views[0].edge.map(|v| self.at(v));
        let middle = 0.5 * (a + b);
        let lifts: Vec<(Vec3, f64)> =
            views.iter().map(|view| lift(middle, [a, b], view.normals)).collect();
        match lifts[..] {
            [(m, s), (n, r)] if m.dot(&n) < 0.95 && m.dot(&n) > -0.95 => {
                // The least move δ with δ·m = s and δ·n = r.
                let c = m.dot(&n);
                let whole = 1.0 - c * c;
                middle + m * ((s - c * r) / whole) + n * ((r - c * s) / whole)
            }
            _ => {
                let sum: Vec3 = lifts.iter().map(|(n, s)| n * *s).sum();
                middle + sum / lifts.len() as f64
            }
        }
    }

    fn divide_triangles(&mut self, middles: &[EdgeMiddle]) {
        let of = |edge: [u32; 2]| {
            middles.binary_search_by_key(&edge, |m| m.0).ok().map(|i| middles[i].1)
        };
        let mut triangles = Vec::with_capacity(2 * self.mesh.triangles.len());
        let mut normals = Vec::with_capacity(2 * self.mesh.triangles.len());
        let mut origins = Vec::with_capacity(2 * self.mesh.triangles.len());
        let all = self.mesh.triangles.iter().zip(&self.normals).zip(&self.origin);
        for ((&corners, here), &origin) in all {
            let first = triangles.len();
            divide_triangle(&self.mesh.vertices, corners, of, &mut triangles);
            let mut known: [(u32, Vec3); 6] = [(u32::MAX, Vec3::zeros()); 6];
            for k in 0..3 {
                let next = (k + 1) % 3;
                known[k] = (corners[k], here[k]);
                if let Some(m) = of(key(corners[k], corners[next])) {
                    known[3 + k] = (m, unit_or(here[k] + here[next], here[k]));
                }
            }
            let normal = |v: u32| known.iter().find(|(w, _)| *w == v).map_or(here[0], |(_, n)| *n);
            normals.extend(triangles[first..].iter().map(|t: &[u32; 3]| t.map(normal)));
            origins.resize(triangles.len(), origin);
        }
        (self.mesh.triangles, self.normals, self.origin) = (triangles, normals, origins);
    }
}

/// Along which normal, and how far \[m\], the middle of the chord from `a` to `b` lies below the
/// surface. Where the two ends disagree on it, the smaller lift counts, and none if they disagree
/// on its sign: a straight line that runs into an arc stays straight.
fn lift(middle: Vec3, [a, b]: [Vec3; 2], [m, n]: [Vec3; 2]) -> (Vec3, f64) {
    let (s, r) = ((middle - a).dot(&m), (middle - b).dot(&n));
    let least = if s * r <= 0.0 {
        0.0
    } else if s.abs() < r.abs() {
        s
    } else {
        r
    };
    (unit_or(m + n, m), -0.5 * least)
}

/// Half of the cross product of two edges \[m²\].
pub(crate) fn area_vector(mesh: &TriMesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    0.5 * (b - a).cross(&(c - a))
}

/// The triangles at each vertex, in order.
pub(crate) fn triangles_around(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (t, corners) in (0u32..).zip(&mesh.triangles) {
        corners.iter().for_each(|&v| around[v as usize].push(t));
    }
    around
}

/// The vector at length one, or `other` if it has none.
pub(crate) fn unit_or(vector: Vec3, other: Vec3) -> Vec3 {
    vector.try_normalize(0.0).unwrap_or(other)
}

/// The angle of a triangle at its corner `v` \[rad\].
fn angle(mesh: &TriMesh, t: u32, v: u32) -> f64 {
    let corners = mesh.triangles[t as usize];
    let k = corners.iter().position(|&c| c == v).unwrap_or(0);
    let [p, q, r] = [0, 1, 2].map(|i| mesh.vertices[corners[(k + i) % 3] as usize]);
    let (e, f) = (q - p, r - p);
    libm::atan2(e.cross(&f).norm(), e.dot(&f))
}

/// The weight of a flat face of one or more triangles in the normal of its corner `v`: the angle
/// there times the lengths of the two edges that bound the face. So a face counts the same however
/// it is divided into triangles, and a long one next to short ones of an arc keeps its direction.
fn weight(mesh: &TriMesh, face: &[u32], v: u32) -> f64 {
    let corners = face.iter().flat_map(|&t| mesh.triangles[t as usize]);
    let mut others: Vec<u32> = corners.filter(|&w| w != v).collect();
    others.sort_unstable();
    let ends = others.chunk_by(|a, b| a == b).filter(|uses| uses.len() == 1);
    let length = |w: u32| (mesh.vertices[w as usize] - mesh.vertices[v as usize]).norm();
    let edges: f64 = ends.map(|uses| length(uses[0])).product();
    face.iter().map(|&t| angle(mesh, t, v)).sum::<f64>() * edges
}

/// The normals of all corners: each over the fan of faces at its vertex, from crease to crease.
fn corner_normals(mesh: &TriMesh) -> Vec<[Vec3; 3]> {
    let faces: Vec<Vec3> = (0..mesh.triangles.len()).map(|t| area_vector(mesh, t)).collect();
    let mut normals = vec![[Vec3::zeros(); 3]; faces.len()];
    for (v, around) in (0u32..).zip(&triangles_around(mesh)) {
        let mut left = around.clone();
        while let Some(start) = left.pop() {
            let mut fan = joined(mesh, &faces, start, CREASE, &mut left);
            let whole = fan.clone();
            let mut sum = Vec3::zeros();
            while let Some(first) = fan.pop() {
                let face = joined(mesh, &faces, first, FLAT, &mut fan);
                let direction = unit_or(faces[first as usize], Vec3::zeros());
                sum += direction * weight(mesh, &face, v);
            }
            let normal = unit_or(sum, unit_or(faces[start as usize], Vec3::z()));
            for t in whole.into_iter().map(|t| t as usize) {
                for k in (0..3).filter(|&k| mesh.triangles[t][k] == v) {
                    normals[t][k] = normal;
                }
            }
        }
    }
    normals
}

/// Takes out of `left` the triangles that hang together with `start` over edges at which they turn
/// by less than the angle of this `cosine`.
fn joined(
    mesh: &TriMesh,
    faces: &[Vec3],
    start: u32,
    cosine: f64,
    left: &mut Vec<u32>,
) -> Vec<u32> {
    let beside = |s: u32, t: u32| {
        let (s, t) = (s as usize, t as usize);
        let corners = &mesh.triangles[t];
        let shared = mesh.triangles[s].iter().filter(|v| corners.contains(v)).count();
        shared >= 2 && faces[s].dot(&faces[t]) > cosine * faces[s].norm() * faces[t].norm()
    };
    let mut fan = vec![start];
    let mut next = 0;
    while next < fan.len() {
        let t = fan[next];
        next += 1;
        left.retain(|&s| {
            let joins = beside(s, t);
            if joins {
                fan.push(s);
            }
            !joins
        });
    }
    fan.sort_unstable();
    fan
}
