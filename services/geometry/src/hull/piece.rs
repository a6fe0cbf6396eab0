//! A piece of a body's surface, clipped by planes.

use crate::math::{Mat3, Vec3};
use crate::mesh::Solid;
use std::sync::LazyLock;

type Triangle = [Vec3; 3];

/// Clipped surface triangles, and the fans that close the cuts. The fans may overlap themselves,
/// but as an oriented chain they bound exactly the clipped solid, so volume integrals over both are
/// right. Only the surface has corners that count for the hull.
#[derive(Clone, Debug, Default)]
pub(super) struct HullPiece {
    surface: Vec<Triangle>,
    fans: Vec<Triangle>,
    origin: Vec3,
}

impl HullPiece {
    /// The whole boundary of a solid; `None` where its arrays are wrong.
    pub(super) fn of(solid: &Solid) -> Option<Self> {
        solid.mesh.validate().ok()?;
        let surface = (0..solid.mesh.triangles.len()).map(|t| solid.mesh.corners(t)).collect();
        let (low, high) = solid.mesh.bounds()?;
        Some(Self { surface, fans: Vec::new(), origin: 0.5 * (low + high) })
    }

    /// Enclosed volume \[m³\].
    pub(super) fn volume(&self) -> f64 {
        self.chain().map(|(v, _)| v).sum()
    }

    /// Centroid \[m\] and second moment about it \[m⁵\] of the enclosed space.
    pub(super) fn moments(&self) -> (Vec3, Mat3) {
        let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
        for (v, [a, b, c]) in self.chain() {
            let s = a + b + c;
            volume += v;
            first += v / 4.0 * s;
            second += v / 20.0
                * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
        }
        let arm = first / volume;
        (self.origin + arm, second - volume * arm * arm.transpose())
    }

    /// Corners of the surface, each once, in the order of its triangles.
    pub(super) fn corners(&self) -> Vec<Vec3> {
        // Corners are shared by six triangles or so.
        let key = |p: &Vec3| [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()];
        let mut places: Vec<([u64; 3], u32)> =
            self.surface.iter().flatten().map(key).zip(0..).collect();
        places.sort_unstable();
        places.dedup_by_key(|place| place.0);
        places.sort_unstable_by_key(|place| place.1);
        places.into_iter().map(|(bits, _)| Vec3::from(bits.map(f64::from_bits))).collect()
    }

    /// The parts above and below the plane `normal · x = offset`. Corners that nearly lie in the
    /// plane do: a face in it goes to the side that it bounds, and no sliver comes off.
    pub(super) fn split(&self, normal: Vec3, offset: f64) -> (Self, Self) {
        let plane = DividingPlane { normal, offset, slack: IN_PLANE * self.extent(normal) };
        let empty = || Self { origin: self.origin, ..Self::default() };
        let (mut above, mut below) = (empty(), empty());
        let mut rim: Vec<(Vec3, Vec3)> = Vec::new();
        for &triangle in &self.surface {
            plane.clip(triangle, (&mut above.surface, &mut below.surface), &mut rim);
        }
        for &triangle in &self.fans {
            plane.clip(triangle, (&mut above.fans, &mut below.fans), &mut rim);
        }
        if let Some(&(hub, _)) = rim.first() {
            // The rim of the upper part runs p → q; its cap runs back.
            above.fans.extend(rim.iter().map(|&(p, q)| [hub, q, p]));
            below.fans.extend(rim.iter().map(|&(p, q)| [hub, p, q]));
        }
        (above, below)
    }

    /// Extent along a direction \[m\].
    fn extent(&self, normal: Vec3) -> f64 {
        let heights = self.surface.iter().flatten().map(|p| normal.dot(p));
        let far = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = heights.fold(far, |(low, high), h| (low.min(h), high.max(h)));
        (high - low).max(0.0)
    }

    /// Signed volume of each tetrahedron on the origin, and its other corners relative to it.
    fn chain(&self) -> impl Iterator<Item = (f64, Triangle)> + '_ {
        self.surface.iter().chain(&self.fans).map(|t| {
            let [a, b, c] = t.map(|p| p - self.origin);
            (a.dot(&b.cross(&c)) / 6.0, [a, b, c])
        })
    }
}

/// Corners within this share of a piece's extent across a plane lie in it: more than the rounding
/// of coordinates in f32, less than what a stand-in must follow.
const IN_PLANE: f64 = 1e-4;

/// A plane that divides a piece.
struct DividingPlane {
    normal: Vec3,
    offset: f64,
    /// Corners no farther from it lie in it \[m\].
    slack: f64,
}

impl DividingPlane {
    /// Height above the plane \[m\]; zero in it.
    fn height(&self, p: &Vec3) -> f64 {
        let height = self.normal.dot(p) - self.offset;
        if height.abs() <= self.slack { 0.0 } else { height }
    }

    /// Puts the parts of one triangle where they belong, and adds to `rim` what the upper part
    /// loses of it: the edges in the plane, as the upper part runs along them. They are those of
    /// what goes below, run back, so that both parts close whatever lies in the plane.
    fn clip(
        &self,
        triangle: Triangle,
        (above, below): (&mut Vec<Triangle>, &mut Vec<Triangle>),
        rim: &mut Vec<(Vec3, Vec3)>,
    ) {
        let height = triangle.map(|p| self.height(&p));
        let (is_up, is_down) = (height.iter().any(|h| *h > 0.0), height.iter().any(|h| *h < 0.0));
        if is_up && is_down {
            return cut(triangle, height, (above, below), rim);
        }
        let [a, b, c] = triangle;
        // What a face in the plane bounds lies behind it.
        let faces_up = || (b - a).cross(&(c - a)).dot(&self.normal) > 0.0;
        if is_up || !(is_down || faces_up()) {
            return above.push(triangle);
        }
        below.push(triangle);
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            if height[from] == 0.0 && height[to] == 0.0 {
                rim.push((triangle[to], triangle[from]));
            }
        }
    }
}

/// Cuts a triangle with corners on both sides, at these heights \[m\].
fn cut(
    triangle: Triangle,
    height: [f64; 3],
    (above, below): (&mut Vec<Triangle>, &mut Vec<Triangle>),
    rim: &mut Vec<(Vec3, Vec3)>,
) {
    let turned = |first: usize| [0, 1, 2].map(|i| (first + i) % 3);
    if let Some(level) = height.iter().position(|h| *h == 0.0) {
        let [i, j, k] = turned(level);
        let (a, b, c) = (triangle[i], triangle[j], triangle[k]);
        let p = crossing(b, height[j], c, height[k]);
        let (first, second) = ([a, b, p], [a, p, c]);
        if height[j] > 0.0 {
            above.push(first);
            below.push(second);
            rim.push((p, a));
        } else {
            below.push(first);
            above.push(second);
            rim.push((a, p));
        }
        return;
    }
    let up = height.map(|h| h > 0.0);
    let lone = (0..3).find(|&i| up[i] != up[(i + 1) % 3] && up[i] != up[(i + 2) % 3]);
    let [i, j, k] = turned(lone.unwrap_or(0));
    let (a, b, c) = (triangle[i], triangle[j], triangle[k]);
    let p = crossing(a, height[i], b, height[j]);
    let q = crossing(a, height[i], c, height[k]);
    let (tip, base) = if up[i] { (above, below) } else { (below, above) };
    tip.push([a, p, q]);
    base.extend([[p, b, c], [p, c, q]]);
    rim.push(if up[i] { (p, q) } else { (q, p) });
}

/// Where an edge crosses the plane; the same bits from either end.
fn crossing(a: Vec3, ha: f64, b: Vec3, hb: f64) -> Vec3 {
    let (low, hl, high, hh) = if ha < hb { (a, ha, b, hb) } else { (b, hb, a, ha) };
    low + hl / (hl - hh) * (high - low)
}

/// Those of some corners that lie farthest out in each of a fixed fan of directions, each once, by
/// the first direction.
pub(super) fn extremes(corners: &[Vec3]) -> Vec<Vec3> {
    let mut best = vec![(f64::NEG_INFINITY, 0); DIRECTIONS.len()];
    for (i, p) in corners.iter().enumerate() {
        for (slot, d) in best.iter_mut().zip(DIRECTIONS.iter()) {
            let reach = d.dot(p);
            if reach > slot.0 {
                *slot = (reach, i);
            }
        }
    }
    let mut found: Vec<usize> = Vec::new();
    for (reach, i) in best {
        if reach > f64::NEG_INFINITY && !found.contains(&i) {
            found.push(i);
        }
    }
    found.into_iter().map(|i| corners[i]).collect()
}

/// 50 directions spread evenly over the sphere: the axes, diagonals and points between.
static DIRECTIONS: LazyLock<Vec<Vec3>> = LazyLock::new(|| {
    let mut directions = Vec::new();
    for (x, y, z) in
        (-2..=2).flat_map(|x| (-2..=2).flat_map(move |y| (-2..=2).map(move |z| (x, y, z))))
    {
        let d: [i32; 3] = [x, y, z];
        let greatest = d.iter().map(|c| c.abs()).max().unwrap_or(0);
        let even = d.iter().all(|c| c % 2 == 0);
        let on_edge = d.iter().filter(|c| c.abs() == 2).count();
        let odd = d.iter().filter(|c| c.abs() == 1).count();
        // Corners, edges and faces of a cube of side 4, and the middles of its face diagonals.
        if greatest == 2 && (even || (on_edge == 1 && odd == 2)) {
            directions.push(Vec3::new(f64::from(x), f64::from(y), f64::from(z)).normalize());
        }
    }
    directions
});
