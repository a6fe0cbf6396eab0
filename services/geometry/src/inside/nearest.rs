//! Distance to a surface through a tree of boxes.

use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Nodes that a search keeps open at most, in a tree of any size that fits memory.
pub(super) const OPEN_NODES: usize = 64;

/// A node: its box, and either its first child (the second follows the first's subtree) or its
/// triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct BvhNode {
    low: Vec3,
    high: Vec3,
    /// First triangle in `order`.
    pub(super) start: u32,
    /// One past the last triangle in `order`.
    pub(super) end: u32,
    /// Index of the second child; zero in a leaf.
    pub(super) second: u32,
}

/// A tree of boxes around the triangles of a mesh.
#[derive(Clone, Debug)]
pub struct Nearest {
    pub(super) corners: Vec<[Vec3; 3]>,
    pub(super) order: Vec<u32>,
    pub(super) nodes: Vec<BvhNode>,
}

impl Nearest {
    /// Builds the tree: O(n log n) for n triangles.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        let corners: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let middles: Vec<Vec3> = corners.iter().map(|[a, b, c]| (a + b + c) / 3.0).collect();
        let mut tree = Self { order: (0..corners.len() as u32).collect(), corners, nodes: vec![] };
        if !tree.order.is_empty() {
            let end = tree.order.len();
            tree.build(&middles, 0, end);
        }
        tree
    }

    /// Distance from `p` to the nearest point of the surface \[m\]; infinite for an empty mesh.
    #[must_use]
    pub fn distance(&self, p: Vec3) -> f64 {
        self.closest(p).map_or(f64::INFINITY, |(_, distance, _)| distance)
    }

    /// Thickness for bending \[m\] of the body of which `points` \[m\] are an even sample: 2.5
    /// times the depth above which four fifths of it lie. That of a plate is its thickness t, of a
    /// bar of square section 0.69 t, of a cube 0.52 t. At most 1000 of the points are looked at.
    #[must_use]
    pub fn thickness(&self, points: &[Vec3]) -> f64 {
        let stride = points.len().div_ceil(1000).max(1);
        let mut depths: Vec<f64> =
            points.iter().step_by(stride).map(|&p| self.distance(p)).collect();
        depths.sort_unstable_by(f64::total_cmp);
        depths.get(depths.len() * 4 / 5).copied().unwrap_or(0.0) / 0.4
    }

    /// The unit normal of a triangle; `None` if it has no area.
    #[must_use]
    pub fn normal(&self, triangle: usize) -> Option<Vec3> {
        let [a, b, c] = self.corners.get(triangle)?;
        (b - a).cross(&(c - a)).try_normalize(0.0)
    }

    /// The nearest point of the surface \[m\], its distance \[m\] and its triangle.
    #[must_use]
    pub fn closest(&self, p: Vec3) -> Option<(Vec3, f64, usize)> {
        self.closest_of(p, |_| true)
    }

    /// As [`Nearest::closest`], among the triangles that `of` takes.
    #[must_use]
    pub fn closest_of(&self, p: Vec3, of: impl Fn(usize) -> bool) -> Option<(Vec3, f64, usize)> {
        self.closest_within(p, f64::INFINITY, of)
    }

    /// As [`Nearest::closest_of`], among points nearer than `reach` \[m\].
    #[must_use]
    pub fn closest_within(
        &self,
        p: Vec3,
        reach: f64,
        of: impl Fn(usize) -> bool,
    ) -> Option<(Vec3, f64, usize)> {
        let (mut best, mut least): (Option<(Vec3, usize)>, f64) = (None, reach * reach);
        let mut stack: Vec<(u32, f64)> = Vec::with_capacity(OPEN_NODES);
        if let Some(root) = self.nodes.first() {
            stack.push((0, root.squared_distance(p)));
        }
        while let Some((at, bound)) = stack.pop() {
            if bound >= least {
                continue;
            }
            let node = self.nodes[at as usize];
            if node.second == 0 {
                let leaf = &self.order[node.start as usize..node.end as usize];
                for &t in leaf.iter().filter(|&&t| of(t as usize)) {
                    let q = closest_on_triangle(p, self.corners[t as usize]);
                    let d = (q - p).norm_squared();
                    if d < least {
                        (best, least) = (Some((q, t as usize)), d);
                    }
                }
                continue;
            }
            let [a, b] = [at + 1, node.second]
                .map(|child| (child, self.nodes[child as usize].squared_distance(p)));
            stack.extend(if a.1 <= b.1 { [b, a] } else { [a, b] });
        }
        best.map(|(q, t)| (q, least.sqrt(), t))
    }

    /// Pairs of triangles whose boxes overlap, the smaller index first, in a fixed order.
    pub(crate) fn overlapping_pairs(&self, mut visit: impl FnMut(usize, usize)) {
        for t in 0..self.corners.len() {
            let (low, high) = box_of(&self.corners[t]);
            self.in_box(low, high, |other| {
                if other > t {
                    visit(t, other);
                }
            });
        }
    }

    /// Visits the triangles whose boxes overlap the box from `low` to `high` \[m\], in a fixed
    /// order.
    pub(crate) fn in_box(&self, low: Vec3, high: Vec3, mut visit: impl FnMut(usize)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = vec![0u32];
        while let Some(at) = stack.pop() {
            let node = self.nodes[at as usize];
            if (0..3).any(|i| node.low[i] > high[i] || node.high[i] < low[i]) {
                continue;
            }
            if node.second != 0 {
                stack.extend([node.second, at + 1]);
                continue;
            }
            for &other in &self.order[node.start as usize..node.end as usize] {
                let (l, h) = box_of(&self.corners[other as usize]);
                if (0..3).all(|i| l[i] <= high[i] && h[i] >= low[i]) {
                    visit(other as usize);
                }
            }
        }
    }

    fn build(&mut self, middles: &[Vec3], start: usize, end: usize) -> u32 {
        let at = self.nodes.len();
        let (low, high) = self.order[start..end].iter().fold(
            (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)),
            |(low, high), &t| {
                let (l, h) = box_of(&self.corners[t as usize]);
                (low.inf(&l), high.sup(&h))
            },
        );
        self.nodes.push(BvhNode { low, high, start: start as u32, end: end as u32, second: 0 });
        if end - start > LEAF {
            let axis = (high - low).imax();
            let key = |&t: &u32| middles[t as usize][axis];
            let half = (end - start) / 2;
            self.order[start..end]
                .select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
            self.build(middles, start, start + half);
            let second = self.build(middles, start + half, end);
            self.nodes[at].second = second;
        }
        at as u32
    }
}

impl BvhNode {
    fn squared_distance(&self, p: Vec3) -> f64 {
        (p - p.sup(&self.low).inf(&self.high)).norm_squared()
    }

    /// Where a ray enters the box, given one over each part of its unit vector \[m\].
    pub(super) fn entry(&self, origin: Vec3, inverse: Vec3) -> Option<f64> {
        let low = (self.low - origin).component_mul(&inverse);
        let high = (self.high - origin).component_mul(&inverse);
        let (mut enters, mut leaves) = (0.0_f64, f64::INFINITY);
        for i in 0..3 {
            // 0/0: the ray runs in a face of the box.
            if !low[i].is_nan() && !high[i].is_nan() {
                enters = enters.max(low[i].min(high[i]));
                leaves = leaves.min(low[i].max(high[i]));
            }
        }
        (enters <= leaves * (1.0 + 1e-12)).then_some(enters)
    }
}

fn box_of([a, b, c]: &[Vec3; 3]) -> (Vec3, Vec3) {
    (a.inf(b).inf(c), a.sup(b).sup(c))
}

/// The point of a triangle nearest to `p`, by the region of its plane that `p` projects into
/// \[Ericson, Real-Time Collision Detection, §5.1.5\].
#[must_use]
pub fn closest_on_triangle(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + d1 / (d1 - d3) * ab;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + d2 / (d2 - d6) * ac;
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    }
    let whole = va + vb + vc;
    a + vb / whole * ab + vc / whole * ac
}
