//! A piece of a body's surface, clipped by planes.

use crate::math::{Mat3, Vec3};
use crate::mesh::Solid;
use std::sync::LazyLock;

type Triangle = [Vec3; 3];

/// Clipped surface triangles, and the fans that close the cuts. The fans may overlap themselves,
/// but as an oriented chain they bound exactly the clipped solid, so volume integrals over both are
/// right. Only the surface has corners that count for the hull.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece {
    surface: Vec<Triangle>,
    fans: Vec<Triangle>,
    origin: Vec3,
}

impl Piece {
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

    /// The parts above and below the plane `normal · x = offset`.
    pub(super) fn split(&self, normal: Vec3, offset: f64) -> (Self, Self) {
        let mut sides = [Self { origin: self.origin, ..Self::default() }, Self::default()];
        sides[1].origin = self.origin;
        let mut cut: Vec<(Vec3, Vec3)> = Vec::new();
        for (triangles, is_fan) in [(&self.surface, false), (&self.fans, true)] {
            for &triangle in triangles {
                let [above, below] = &mut sides;
                let lists = if is_fan {
                    (&mut above.fans, &mut below.fans)
                } else {
                    (&mut above.surface, &mut below.surface)
                };
                cut.extend(clip(triangle, normal, offset, lists.0, lists.1));
            }
        }
        let [mut above, mut below] = sides;
        if let Some(&(hub, _)) = cut.first() {
            // The cut runs p → q along the rim of the upper part; its cap runs back.
            above.fans.extend(cut.iter().map(|&(p, q)| [hub, q, p]));
            below.fans.extend(cut.iter().map(|&(p, q)| [hub, p, q]));
        }
        (above, below)
    }

    /// Signed volume of each tetrahedron on the origin, and its other corners relative to it.
    fn chain(&self) -> impl Iterator<Item = (f64, Triangle)> + '_ {
        self.surface.iter().chain(&self.fans).map(|t| {
            let [a, b, c] = t.map(|p| p - self.origin);
            (a.dot(&b.cross(&c)) / 6.0, [a, b, c])
        })
    }
}

/// Puts the parts of one triangle where they belong; returns the side of the upper part along the
/// cut.
fn clip(
    triangle: Triangle,
    normal: Vec3,
    offset: f64,
    above: &mut Vec<Triangle>,
    below: &mut Vec<Triangle>,
) -> Option<(Vec3, Vec3)> {
    let height = triangle.map(|p| normal.dot(&p) - offset);
    let up = height.map(|h| h >= 0.0);
    let lone = match up {
        [true, true, true] => {
            above.push(triangle);
            return None;
        }
        [false, false, false] => {
            below.push(triangle);
            return None;
        }
        [a, b, c] if b == c && a != b => 0,
        [a, b, c] if a == c && b != c => 1,
        _ => 2,
    };
    let at = |i: usize| triangle[(lone + i) % 3];
    let [a, b, c] = [at(0), at(1), at(2)];
    let h = [0, 1, 2].map(|i| height[(lone + i) % 3]);
    let (p, q) = (crossing(a, h[0], b, h[1]), crossing(a, h[0], c, h[2]));
    let (tip, base) = if up[lone] { (above, below) } else { (below, above) };
    tip.push([a, p, q]);
    base.extend([[p, b, c], [p, c, q]]);
    Some(if up[lone] { (p, q) } else { (q, p) })
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
