//! Control points beyond the rim of a mesh of triangles: one across each edge of the rim, and more
//! at corners of it, so that a vertex of the rim has six neighbours where it can.

use super::triangle_net::TriangleNet;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Neighbours of a vertex that all others go by.
const REGULAR: usize = 6;

/// Rings of vertices that a control point beyond the rim continues the shape of.
const RINGS: usize = 2;

/// What a fit by least squares adds to its diagonal, over its scale: with few vertices in a row it
/// has no unique answer, and takes the flattest.
const RIDGE: f64 = 1e-9;

/// Control points beyond a rim.
#[derive(Clone, Debug)]
pub(super) struct Rim {
    /// The first of them.
    first: u32,
    /// By the rim's edges, with the surface on their right.
    edges: BTreeMap<(u32, u32), u32>,
    /// Those at corners of the rim, by the vertex there, counter-clockwise.
    corners: BTreeMap<u32, Vec<u32>>,
    /// Vertices that each continues, and their shares.
    shares: Vec<Vec<(u32, f64)>>,
    /// Triangles at the rim that each lies across from.
    across: Vec<[u32; 3]>,
}

impl Rim {
    pub(super) fn new(net: &TriangleNet<'_>) -> Self {
        let first = net.vertices.len() as u32;
        let (edges, corners) = (BTreeMap::new(), BTreeMap::new());
        let mut rim = Self { first, edges, corners, shares: Vec::new(), across: Vec::new() };
        let at = |v: u32| net.vertices[v as usize];
        // Vertices of the rim with so many triangles that the two edges share one.
        for vertex in (0..first).filter(|&v| net.is_rim(v)) {
            let fan = &net.fans[vertex as usize];
            let ends = [(vertex, fan[fan.len() - 1]), (fan[0], vertex)];
            let across = ends.map(|(a, b)| net.left[&(b, a)]);
            let crowded = fan.len() > REGULAR - 2;
            if crowded && ends.iter().all(|end| !rim.edges.contains_key(end)) {
                let place = |k: usize| at(ends[k].0) + at(ends[k].1) - at(across[k]);
                let place = 0.5 * (place(0) + place(1));
                let new = rim.add(net, place, vertex, [ends[0].1, ends[0].0, across[0]]);
                ends.into_iter().for_each(|end| {
                    rim.edges.insert(end, new);
                });
            }
        }
        let outer = net.left.iter().map(|(&(a, b), &c)| ((b, a), c));
        for ((a, b), across) in outer.filter(|(edge, _)| !net.left.contains_key(edge)) {
            if !rim.edges.contains_key(&(a, b)) {
                let new = rim.add(net, at(a) + at(b) - at(across), a, [b, a, across]);
                rim.edges.insert((a, b), new);
            }
        }
        // Corners with few triangles: each more is a neighbour turned about the corner.
        for vertex in (0..first).filter(|&v| net.is_rim(v)) {
            let fan = &net.fans[vertex as usize];
            let more = (REGULAR - 2).saturating_sub(fan.len());
            let inner = if more == 1 { 1 } else { 0 };
            for k in inner..inner + more {
                let place = 2.0 * at(vertex) - at(fan[k]);
                let new = rim.add(net, place, vertex, [vertex, fan[0], fan[1]]);
                rim.corners.entry(vertex).or_default().push(new);
            }
        }
        rim
    }

    fn add(&mut self, net: &TriangleNet<'_>, place: Vec3, at: u32, across: [u32; 3]) -> u32 {
        self.shares.push(continued(net, place, at, across));
        self.across.push(across);
        self.first + self.shares.len() as u32 - 1
    }

    /// All neighbours of a vertex, counter-clockwise.
    pub(super) fn ring(&self, net: &TriangleNet<'_>, vertex: u32) -> Vec<u32> {
        let mut ring = net.fans[vertex as usize].clone();
        if net.is_rim(vertex) {
            let (start, end) = (ring[0], ring[ring.len() - 1]);
            let [after, before] = [(vertex, end), (start, vertex)].map(|edge| self.edges[&edge]);
            ring.push(after);
            ring.extend(self.corners.get(&vertex).into_iter().flatten());
            if before != after {
                ring.push(before);
            }
        }
        ring
    }

    /// Appends the control points beyond the rim to those of the vertices.
    pub(super) fn extend(&self, points: &mut Vec<Vec3>) {
        for shares in &self.shares {
            points.push(shares.iter().map(|&(v, share)| points[v as usize] * share).sum());
        }
    }

    /// Area that each control point would see more if the surface went on \[m²\]: that of a whole
    /// one for those beyond the rim, which see next to nothing.
    pub(super) fn missing(&self, net: &TriangleNet<'_>) -> Vec<f64> {
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| net.vertices[v as usize]);
            (b - a).cross(&(c - a)).norm()
        };
        let inside = std::iter::repeat_n(0.0, self.first as usize);
        inside.chain(self.across.iter().map(area)).collect()
    }
}

/// Vertices near `at` and their shares in what continues them to `place`: exact where they are
/// quadratic over the plane of the triangle `across`.
fn continued(net: &TriangleNet<'_>, place: Vec3, at: u32, across: [u32; 3]) -> Vec<(u32, f64)> {
    let mut near = across.to_vec();
    let mut first = 0;
    for _ in 0..RINGS {
        let ring = first..near.len();
        first = ring.end;
        for k in ring {
            for &other in &net.fans[near[k] as usize] {
                if !near.contains(&other) {
                    near.push(other);
                }
            }
        }
    }
    near.sort_unstable();
    let point = |v: u32| net.vertices[v as usize];
    let [a, b, c] = across.map(point);
    let normal = (b - a).cross(&(c - a)).normalize();
    let along = (b - a).normalize();
    let size = (b - a).norm();
    let other = normal.cross(&along);
    let origin = point(at);
    let basis = |x: Vec3| {
        let (x, y) = ((x - origin).dot(&along) / size, (x - origin).dot(&other) / size);
        [1.0, x, y, x * x, y * y, x * y]
    };
    let rows: Vec<[f64; 6]> = near.iter().map(|&v| basis(point(v))).collect();
    // Near vertices count for more.
    let weight = |v: u32| 1.0 / (0.25 + (point(v) - place).norm_squared() / (size * size));
    let weights: Vec<f64> = near.iter().map(|&v| weight(v)).collect();
    let mut square = [[0.0; 6]; 6];
    for (row, weight) in rows.iter().zip(&weights) {
        for i in 0..6 {
            (0..6).for_each(|j| square[i][j] += weight * row[i] * row[j]);
        }
    }
    let scale: f64 = weights.iter().sum();
    (3..6).for_each(|i| square[i][i] += RIDGE * scale);
    let found = solved(square, basis(place));
    let share = |k: usize| weights[k] * (0..6).map(|i| rows[k][i] * found[i]).sum::<f64>();
    near.iter().enumerate().map(|(k, &v)| (v, share(k))).collect()
}

/// A positive definite system by Cholesky's decomposition.
fn solved(mut a: [[f64; 6]; 6], mut right: [f64; 6]) -> [f64; 6] {
    for j in 0..6 {
        for k in 0..j {
            let factor = a[j][k];
            (j..6).for_each(|i| a[i][j] -= a[i][k] * factor);
        }
        let pivot = a[j][j].max(f64::MIN_POSITIVE).sqrt();
        (j..6).for_each(|i| a[i][j] /= pivot);
    }
    for i in 0..6 {
        (0..i).for_each(|k| right[i] -= a[i][k] * right[k]);
        right[i] /= a[i][i];
    }
    for i in (0..6).rev() {
        (i + 1..6).for_each(|k| right[i] -= a[k][i] * right[k]);
        right[i] /= a[i][i];
    }
    right
}
