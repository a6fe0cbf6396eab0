//! Is a point inside a closed mesh, and how far is it from the surface?

mod nearest;
mod ray;

pub use nearest::{Nearest, closest_on_triangle};

use crate::math::Vec3;
use crate::mesh::TriMesh;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Most buckets a side. 1024² lists of `u32` starts take 4 MiB; beyond that the cache suffers more
/// than the shorter lists help.
const MAX_SIDE: usize = 1024;

/// One triangle as the ray along +z sees it.
#[derive(Clone, Copy, Debug)]
struct RayTriangle {
    corners: [Vec3; 3],
    low: [f64; 2],
    high: [f64; 2],
    top: f64,
}

/// Answers point-in-mesh by the parity of crossings of a ray along +z, with triangles bucketed by
/// their shadow on the xy plane. Every decision is an exact predicate with one tie rule an edge, so
/// a ray through an edge or corner counts once: no cracks, no epsilon.
#[derive(Clone, Debug)]
pub struct Inside {
    facets: Vec<RayTriangle>,
    low: Vec3,
    high: Vec3,
    side: [usize; 2],
    per_metre: [f64; 2],
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Inside {
    /// Prepares a mesh, which should be closed and finite: O(triangles).
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        let (low, high) = mesh.bounds().unwrap_or((Vec3::repeat(1.0), Vec3::repeat(-1.0)));
        let facets: Vec<RayTriangle> =
            (0..mesh.triangles.len()).map(|t| RayTriangle::new(mesh.corners(t))).collect();
        let (side, per_metre) = layout(high - low, facets.len());
        let mut inside =
            Self { facets, low, high, side, per_metre, starts: Vec::new(), members: Vec::new() };
        inside.fill();
        inside
    }

    /// Whether `p` \[m\] is inside. A point exactly on the surface may be counted either way,
    /// always the same way.
    #[must_use]
    pub fn contains(&self, p: Vec3) -> bool {
        let within = (0..3).all(|i| p[i] >= self.low[i] && p[i] <= self.high[i]);
        if !within || self.starts.is_empty() {
            return false;
        }
        let bucket = self.column(p.y, 1) * self.side[0] + self.column(p.x, 0);
        let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
        let crossed =
            self.members[range].iter().filter(|&&t| self.facets[t as usize].is_above(p)).count();
        crossed % 2 == 1
    }

    /// Least and greatest corner of the mesh's axis-aligned box \[m\].
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.low, self.high)
    }

    fn column(&self, x: f64, axis: usize) -> usize {
        let i = ((x - self.low[axis]) * self.per_metre[axis]) as usize;
        i.min(self.side[axis] - 1)
    }

    /// Counting sort of the facets into the buckets that their shadows touch.
    fn fill(&mut self) {
        let mut counts = vec![0u32; self.side[0] * self.side[1] + 1];
        self.for_each_bucket(|bucket, _| counts[bucket + 1] += 1);
        for i in 1..counts.len() {
            counts[i] += counts[i - 1];
        }
        let mut next = counts.clone();
        let mut members = vec![0u32; counts.last().map_or(0, |&n| n as usize)];
        self.for_each_bucket(|bucket, t| {
            members[next[bucket] as usize] = t;
            next[bucket] += 1;
        });
        (self.starts, self.members) = (counts, members);
    }

    fn for_each_bucket(&self, mut visit: impl FnMut(usize, u32)) {
        for (t, f) in self.facets.iter().enumerate() {
            let [x, y] = [0, 1].map(|i| self.column(f.low[i], i)..=self.column(f.high[i], i));
            for row in y {
                for column in x.clone() {
                    visit(row * self.side[0] + column, t as u32);
                }
            }
        }
    }
}

impl RayTriangle {
    fn new(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        Self { corners, low: [low.x, low.y], high: [high.x, high.y], top: high.z }
    }

    /// Whether the ray from `p` along +z passes through this triangle.
    fn is_above(&self, p: Vec3) -> bool {
        let outside = p.x < self.low[0]
            || p.x > self.high[0]
            || p.y < self.low[1]
            || p.y > self.high[1]
            || p.z > self.top;
        if outside {
            return false;
        }
        let [a, b, c] = self.corners;
        let in_shadow = crosses(a, b, p) ^ crosses(b, c, p) ^ crosses(c, a, p);
        if !in_shadow {
            return false;
        }
        // orient3d > 0: p is below the plane of a, b, c seen counter-clockwise from above.
        let turn = orient2d(flat(a), flat(b), flat(c));
        let depth = orient3d(solid(a), solid(b), solid(c), solid(p));
        if turn > 0.0 { depth > 0.0 } else { depth < 0.0 }
    }
}

/// Whether a ray from `p` along +x crosses the shadow of the edge. One undirected edge gives one
/// answer, so the triangles beside it share the plane without gap or overlap.
fn crosses(a: Vec3, b: Vec3, p: Vec3) -> bool {
    if (a.y <= p.y) == (b.y <= p.y) {
        return false;
    }
    let (lower, upper) = if a.y <= p.y { (a, b) } else { (b, a) };
    orient2d(flat(lower), flat(upper), flat(p)) > 0.0
}

fn flat(p: Vec3) -> Coord<f64> {
    Coord { x: p.x, y: p.y }
}

fn solid(p: Vec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// Buckets a side, and buckets a metre, for about one bucket a triangle.
fn layout(size: Vec3, triangles: usize) -> ([usize; 2], [f64; 2]) {
    let area = size.x * size.y;
    let pitch = (area / triangles.max(1) as f64).sqrt();
    let count = |length: f64| {
        if pitch > 0.0 && length > 0.0 { ((length / pitch) as usize).clamp(1, MAX_SIDE) } else { 1 }
    };
    let side = [count(size.x), count(size.y)];
    let per_metre = [0, 1].map(|i| if size[i] > 0.0 { side[i] as f64 / size[i] } else { 0.0 });
    (side, per_metre)
}

#[cfg(test)]
mod tests;
