//! From the artist's mesh to the skin of a fragment, by place.
//!
//! A cut leaves the skin of a fragment on the surface of the body. Where triangles of the body lie
//! in one plane the cut may join them, so a triangle of the skin can span several of the artist's:
//! it is divided again along their edges where they do not continue each other.

use super::SurfaceAttributes;
use super::islands::islands;
use crate::inside::{Nearest, closest_on_triangle};
use crate::math::Vec3;
use crate::surface::barycentric;

/// Points closer than this share of the mesh's diagonal are one: a hundred times what the boolean
/// kernel works to.
const TOLERANCE: f64 = 1e-10;
/// Texture coordinates that differ by less than this share of their size continue each other: some
/// units in the last place of those in files.
const SAME_UV: f64 = 2e-6;

/// A triangle of a skin, or the part of one that lies in one triangle of the artist's mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinTriangle {
    /// Which of the triangles given it is of.
    pub of: usize,
    /// Its corners \[m\]; those of the triangle given, bit for bit, if it was not divided.
    pub corners: [Vec3; 3],
    /// Texture coordinates at them; 0 where the mesh has none.
    pub uv: [[f32; 2]; 3],
    /// Unit normals at them; that of the triangle where the mesh has none.
    pub normals: [[f32; 3]; 3],
    /// Place of its material.
    pub slot: u32,
    /// Place of its object.
    pub object: u32,
}

/// A mesh with its attributes, made ready to be asked for them by place.
#[derive(Clone, Debug)]
pub struct AttributeTransfer<'a> {
    surface: &'a SurfaceAttributes,
    tree: Nearest,
    islands: Vec<u32>,
    /// Points closer than this are one \[m\].
    tolerance: f64,
}

/// The part of a triangle that lies in one of the artist's.
struct SourcePart {
    source: usize,
    polygon: Vec<Vec3>,
    area: f64,
}

impl<'a> AttributeTransfer<'a> {
    /// Makes a mesh ready: O(n log n) for n triangles.
    #[must_use]
    pub fn new(surface: &'a SurfaceAttributes) -> Self {
        let tolerance = TOLERANCE * surface.mesh.diagonal();
        let (tree, islands) = (Nearest::new(&surface.mesh), islands(surface));
        Self { surface, tree, islands, tolerance }
    }

    /// The attributes of triangles that lie on the surface \[m\], in its frame. A triangle that
    /// spans triangles of the mesh which do not continue each other is divided along their edges;
    /// the parts fill it, and its neighbours are divided at the same points if they lie in its
    /// plane. Off the surface, where a repair moved it, the closest point of the same island of
    /// texture coordinates serves.
    #[must_use]
    pub fn transfer(&self, triangles: &[[Vec3; 3]]) -> Vec<SkinTriangle> {
        let mut skin = Vec::with_capacity(triangles.len());
        for (of, &corners) in triangles.iter().enumerate() {
            self.triangle(of, corners, &mut skin);
        }
        skin
    }

    fn triangle(&self, of: usize, corners: [Vec3; 3], skin: &mut Vec<SkinTriangle>) {
        let middle = corners.iter().sum::<Vec3>() / 3.0;
        let across = normal(corners);
        let Some(source) = self.closest(middle, across) else {
            let normals = [narrow(across); 3];
            skin.push(SkinTriangle { of, corners, uv: [[0.0; 2]; 3], normals, slot: 0, object: 0 });
            return;
        };
        let own = self.surface.mesh.corners(source);
        let near = |p: &Vec3| (closest_on_triangle(*p, own) - p).norm() <= self.tolerance;
        if corners.iter().all(near) {
            skin.push(self.within(of, corners, source, across));
            return;
        }
        let allowed = 10.0 * self.tolerance * perimeter(&corners);
        let fill = |pieces: &Vec<SourcePart>| {
            let covered: f64 = pieces.iter().map(|piece| piece.area).sum();
            !pieces.is_empty() && (covered - area(&corners)).abs() <= allowed
        };
        // A repair turns over faces that faced inward.
        let ways = [across, -across].into_iter();
        let Some(pieces) = ways.map(|way| self.pieces(corners, way)).find(fill) else {
            skin.push(self.beside(of, corners, source, across));
            return;
        };
        if self.continue_each_other(&pieces) {
            // All of one island or not, they are one map: each corner takes its own triangle's.
            let among = |t: usize| pieces.iter().any(|piece| piece.source == t);
            skin.push(self.by_corners(of, corners, (pieces[0].source, across), among));
        } else {
            for piece in &pieces {
                let [first, rest @ ..] = &piece.polygon[..] else { continue };
                for pair in rest.windows(2) {
                    let part = [*first, pair[0], pair[1]];
                    if area(&part) > 0.0 {
                        skin.push(self.within(of, part, piece.source, across));
                    }
                }
            }
        }
    }

    /// The closest triangle to a point; of several as close, the one that faces most like `across`.
    fn closest(&self, p: Vec3, across: Vec3) -> Option<usize> {
        let (_, distance, first) = self.tree.closest(p)?;
        let reach = distance + self.tolerance;
        let (mut best, mut most) = (first, f64::NEG_INFINITY);
        self.tree.in_box(p.add_scalar(-reach), p.add_scalar(reach), |t| {
            let own = self.surface.mesh.corners(t);
            if (closest_on_triangle(p, own) - p).norm() > reach {
                return;
            }
            let alike = normal(own).dot(&across);
            // Rounding must not choose among equals: the first one is taken.
            if alike > most + 1e-9 || alike > most - 1e-9 && t < best {
                (best, most) = (t, alike);
            }
        });
        Some(best)
    }

    /// The parts of a triangle in those of the mesh that lie in its plane and face as `across`
    /// does, the largest first.
    fn pieces(&self, corners: [Vec3; 3], across: Vec3) -> Vec<SourcePart> {
        let mut pieces = Vec::new();
        let [a, b, c] = corners;
        let low = a.inf(&b).inf(&c).add_scalar(-self.tolerance);
        let high = a.sup(&b).sup(&c).add_scalar(self.tolerance);
        let least = self.tolerance * perimeter(&corners);
        self.tree.in_box(low, high, |source| {
            let own = self.surface.mesh.corners(source);
            let facing = normal(own);
            let level = own.iter().all(|p| (p - a).dot(&across).abs() <= self.tolerance)
                || corners.iter().all(|p| (p - own[0]).dot(&facing).abs() <= self.tolerance);
            if !level || facing.dot(&across) < 0.5 {
                return;
            }
            let polygon = self.clipped(corners, own, facing);
            let area = polygon_area(&polygon);
            if area > least {
                pieces.push(SourcePart { source, polygon, area });
            }
        });
        pieces.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.source.cmp(&q.source)));
        pieces
    }

    /// What of a triangle lies inside of another one of its plane
    /// \[Sutherland and Hodgman, Reentrant Polygon Clipping, 1974\].
    fn clipped(&self, corners: [Vec3; 3], own: [Vec3; 3], facing: Vec3) -> Vec<Vec3> {
        let mut polygon = corners.to_vec();
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let inward = facing.cross(&(own[to] - own[from])).normalize();
            let depth = |p: &Vec3| (p - own[from]).dot(&inward);
            let mut inside = Vec::with_capacity(polygon.len() + 1);
            for (k, p) in polygon.iter().enumerate() {
                let q = &polygon[(k + 1) % polygon.len()];
                let (d, e) = (depth(p), depth(q));
                if d >= -self.tolerance {
                    inside.push(*p);
                }
                if d.abs() > self.tolerance && e.abs() > self.tolerance && d * e < 0.0 {
                    inside.push(p + d / (d - e) * (q - p));
                }
            }
            polygon = inside;
        }
        polygon
    }

    /// Whether one piece's texture coordinates, material and object go on over all of them.
    fn continue_each_other(&self, pieces: &[SourcePart]) -> bool {
        let Some((main, others)) = pieces.split_first() else { return true };
        let look = |t: usize| (self.surface.slot_of(t), self.surface.object_of(t));
        others.iter().all(|piece| {
            look(piece.source) == look(main.source)
                && piece.polygon.iter().all(|&p| {
                    let (a, b) = (self.extended(main.source, p), self.extended(piece.source, p));
                    let size = 1.0 + a[0].abs().max(a[1].abs());
                    (0..2).all(|k| (a[k] - b[k]).abs() <= SAME_UV * size)
                })
        })
    }

    /// The texture coordinates of a triangle, continued over its plane.
    fn extended(&self, source: usize, p: Vec3) -> [f64; 2] {
        let Some(uv) = self.surface.uv.get(source) else { return [0.0; 2] };
        let [a, b, c] = self.surface.mesh.corners(source);
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let facing = ab.cross(&ac);
        let whole = facing.norm_squared();
        if whole <= 0.0 {
            return uv[0].map(f64::from);
        }
        let v = ap.cross(&ac).dot(&facing) / whole;
        let w = ab.cross(&ap).dot(&facing) / whole;
        let at = |k: usize| {
            let [a, b, c] = uv.map(|corner| f64::from(corner[k]));
            a + v * (b - a) + w * (c - a)
        };
        [at(0), at(1)]
    }

    /// A triangle that lies in one of the mesh.
    fn within(&self, of: usize, corners: [Vec3; 3], source: usize, across: Vec3) -> SkinTriangle {
        self.made(of, corners, across, [source; 3])
    }

    /// A triangle that lies beside the surface: each corner takes the closest point of the island.
    fn beside(&self, of: usize, corners: [Vec3; 3], source: usize, across: Vec3) -> SkinTriangle {
        let island = self.islands[source];
        self.by_corners(of, corners, (source, across), |t| self.islands[t] == island)
    }

    fn by_corners(
        &self,
        of: usize,
        corners: [Vec3; 3],
        (source, across): (usize, Vec3),
        among: impl Fn(usize) -> bool,
    ) -> SkinTriangle {
        let closest = |p| self.tree.closest_of(p, &among).map_or(source, |(_, _, t)| t);
        self.made(of, corners, across, corners.map(closest))
    }

    /// `sources`: the triangle of the mesh that each corner is read from.
    fn made(
        &self,
        of: usize,
        corners: [Vec3; 3],
        across: Vec3,
        sources: [usize; 3],
    ) -> SkinTriangle {
        let surface = self.surface;
        let mut skin = SkinTriangle {
            of,
            corners,
            uv: [[0.0; 2]; 3],
            normals: [narrow(across); 3],
            slot: surface.slot_of(sources[0]),
            object: surface.object_of(sources[0]),
        };
        for (k, (&p, source)) in corners.iter().zip(sources).enumerate() {
            let own = surface.mesh.corners(source);
            let weights = barycentric(closest_on_triangle(p, own), own);
            if let Some(uv) = surface.uv.get(source) {
                skin.uv[k] = mixed(uv, weights).map(|x| x as f32);
            }
            if let Some(normals) = surface.normals.get(source) {
                let mean = Vec3::from(mixed(normals, weights));
                // Faces that a repair turned over face outward, whatever the file says.
                let outward = if mean.dot(&across) < 0.0 { -mean } else { mean };
                skin.normals[k] = narrow(outward.try_normalize(1e-6).unwrap_or(across));
            }
        }
        skin
    }
}

/// Values at the corners, weighted.
fn mixed<const N: usize>(values: &[[f32; N]; 3], weights: [f64; 3]) -> [f64; N] {
    std::array::from_fn(|k| {
        values.iter().zip(weights).map(|(value, weight)| weight * f64::from(value[k])).sum()
    })
}

fn narrow(v: Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// Unit normal; zero for a triangle without area.
fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

fn area(&[a, b, c]: &[Vec3; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn perimeter(&[a, b, c]: &[Vec3; 3]) -> f64 {
    (b - a).norm() + (c - b).norm() + (a - c).norm()
}

/// Area of a flat polygon \[m²\].
fn polygon_area(polygon: &[Vec3]) -> f64 {
    let [first, rest @ ..] = polygon else { return 0.0 };
    let crosses = rest.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first)));
    0.5 * crosses.sum::<Vec3>().norm()
}
