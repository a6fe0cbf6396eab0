//! Which faces of a thin-walled body face each other across the wall.

use super::not_wall::{NotWall, OPPOSED};
use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::{TriMesh, find, join};
use crate::remesh::curved::{area_vector, unit_or};

/// A face whose opposite is further than this times the median length of rays through the wall has
/// none: what it sees lies beyond a rim, a rib or the hollow of the body.
const FAR: f64 = 2.5;

/// Faces that meet at an edge with their normals this opposed are two walls that end in a sharp
/// rim: cosine of 120°.
const SHARP_RIM: f64 = -0.5;

/// Greatest area of a rim, over the thickness times its length: a round one has π/2, a flat one 1.
const RIM: f64 = 4.0;

/// Steps in which the ball inscribed at a face shrinks; three or four are common.
const SHRINKS: usize = 24;

/// What a face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WallFace {
    /// On the wall that the midsurface is made from.
    Side,
    /// On a wall across.
    Opposite,
    /// Between the two walls.
    Rim,
    /// None of them: it has no partner, or one on its own wall.
    Unpaired,
}

/// The faces of a body sorted into walls.
#[derive(Clone, Debug)]
pub(super) struct WallPairs {
    pub(super) kind: Vec<WallFace>,
    /// Distance from the middle of each face to the wall across \[m\]; infinite if there is none.
    pub(super) thickness: Vec<f64>,
    /// Median of the thickness over the area of the paired faces \[m\].
    pub(super) median: f64,
    /// Paired area over area without rims \[1\].
    pub(super) share: f64,
}

/// Faces with their neighbours over edges.
struct FaceGraph {
    area: Vec<f64>,
    normal: Vec<Vec3>,
    /// Two faces that share an edge, and its length \[m\].
    edges: Vec<(u32, u32, f64)>,
}

impl WallPairs {
    /// Pairs the faces of a finely divided closed mesh; those of `rims` are rims for sure.
    pub(super) fn of_mesh(mesh: &TriMesh, rims: &[bool]) -> Result<Self, NotWall> {
        let faces = FaceGraph::new(mesh);
        let (nearest, normals) = (Nearest::new(mesh), &faces.normal[..]);
        let search = OppositeSearch { mesh, normals, rims, nearest, skin: 1e-9 * mesh.diagonal() };
        let rays: Vec<_> = (0..normals.len()).map(|t| search.ray(t)).collect();
        let lengths = rays.iter().zip(&faces.area).filter_map(|(ray, a)| Some(((*ray)?.0, *a)));
        let most =
            FAR * quantile(lengths.collect(), 0.5).ok_or(NotWall::Unpaired { share: 0.0 })?;
        let pairs: Vec<_> = (0..rays.len()).map(|t| search.ball(t, rays[t], most)).collect();
        let thickness: Vec<f64> = pairs.iter().map(|p| p.map_or(f64::INFINITY, |p| p.0)).collect();
        let paired = (0..pairs.len()).filter(|&t| pairs[t].is_some());
        let samples = paired.map(|t| (thickness[t], faces.area[t])).collect();
        let median = quantile(samples, 0.5).ok_or(NotWall::Unpaired { share: 0.0 })?;
        let is_near: Vec<bool> = pairs.iter().map(Option::is_some).collect();
        let walls = faces.groups(|s, t| {
            is_near[s] && is_near[t] && faces.normal[s].dot(&faces.normal[t]) > SHARP_RIM
        });
        let side = largest_group(&walls, &faces.area, &is_near).unwrap_or(0);
        // Pairs within one wall, or between two others, are ribs, handles, corners of a block.
        let is_paired: Vec<bool> = (0..pairs.len())
            .map(|t| pairs[t].is_some_and(|(_, s)| (walls[s] == side) != (walls[t] == side)))
            .collect();
        let kind = (0..walls.len())
            .map(|t| match (is_near[t], walls[t] == side) {
                _ if rims[t] => WallFace::Rim,
                (false, _) => WallFace::Unpaired,
                (true, true) => WallFace::Side,
                (true, false) => WallFace::Opposite,
            })
            .collect();
        let mut sorted = Self { kind, thickness, median, share: 0.0 };
        sorted.sort_unpaired(&faces);
        let area = |of: &dyn Fn(usize) -> bool| -> f64 {
            (0..walls.len()).filter(|&t| of(t)).map(|t| faces.area[t]).sum()
        };
        let outside = area(&|t| sorted.kind[t] != WallFace::Rim);
        sorted.share = area(&|t| is_paired[t]) / outside;
        Ok(sorted)
    }

    /// Sorts the faces without a partner: regions between the two walls, no wider than rims are,
    /// are rims; what lies within the side is part of it, with the thickness around it.
    fn sort_unpaired(&mut self, faces: &FaceGraph) {
        let regions = faces.groups(|s, t| {
            self.kind[s] == WallFace::Unpaired && self.kind[t] == WallFace::Unpaired
        });
        // For each region: its area, and how long its borders with the side and the other are.
        let mut sums = vec![[0.0; 3]; regions.len()];
        for (t, &r) in regions.iter().enumerate() {
            sums[r as usize][0] += faces.area[t];
        }
        for &(s, t, length) in &faces.edges {
            for (s, t) in [(s as usize, t as usize), (t as usize, s as usize)] {
                let border = &mut sums[regions[s] as usize];
                match (self.kind[s], self.kind[t]) {
                    (WallFace::Unpaired, WallFace::Side) => border[1] += length,
                    (WallFace::Unpaired, WallFace::Opposite) => border[2] += length,
                    _ => {}
                }
            }
        }
        for t in 0..regions.len() {
            let [area, side, other] = sums[regions[t] as usize];
            if self.kind[t] == WallFace::Unpaired && side > 0.0 {
                let is_rim = other > 0.0 && area <= RIM * self.median * 0.5 * (side + other);
                if is_rim {
                    self.kind[t] = WallFace::Rim;
                } else if other == 0.0 {
                    (self.kind[t], self.thickness[t]) = (WallFace::Side, self.median);
                }
            }
        }
    }
}

impl FaceGraph {
    fn new(mesh: &TriMesh) -> Self {
        let vectors: Vec<Vec3> = (0..mesh.triangles.len()).map(|t| area_vector(mesh, t)).collect();
        let mut uses: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * vectors.len());
        for (t, &[a, b, c]) in (0u32..).zip(&mesh.triangles) {
            uses.extend([(a, b), (b, c), (c, a)].map(|(a, b)| ([a.min(b), a.max(b)], t)));
        }
        uses.sort_unstable();
        let pairs = uses.chunk_by(|x, y| x.0 == y.0).filter(|uses| uses.len() == 2);
        let edges = pairs.map(|pair| {
            let [a, b] = pair[0].0.map(|v| mesh.vertices[v as usize]);
            (pair[0].1, pair[1].1, (b - a).norm())
        });
        Self {
            area: vectors.iter().map(Vec3::norm).collect(),
            normal: vectors.iter().map(|&v| unit_or(v, Vec3::zeros())).collect(),
            edges: edges.collect(),
        }
    }

    /// The group of each face, by its first member: neighbours that belong together share one.
    fn groups(&self, together: impl Fn(usize, usize) -> bool) -> Vec<u32> {
        let mut root: Vec<u32> = (0..self.area.len() as u32).collect();
        for &(s, t, _) in &self.edges {
            if together(s as usize, t as usize) {
                join(&mut root, s, t);
            }
        }
        (0..root.len() as u32).map(|t| find(&mut root, t)).collect()
    }
}

/// The group of wanted faces that has the most area.
fn largest_group(group: &[u32], area: &[f64], wanted: &[bool]) -> Option<u32> {
    let mut sums = vec![0.0; group.len()];
    for t in (0..group.len()).filter(|&t| wanted[t]) {
        sums[group[t] as usize] += area[t];
    }
    (0..group.len()).max_by(|&a, &b| sums[a].total_cmp(&sums[b]).then(b.cmp(&a))).map(|t| t as u32)
}

/// Finds the face across the wall from each face.
struct OppositeSearch<'a> {
    mesh: &'a TriMesh,
    normals: &'a [Vec3],
    rims: &'a [bool],
    nearest: Nearest,
    /// How far within a face its ray starts \[m\].
    skin: f64,
}

impl OppositeSearch<'_> {
    fn faces_it(&self, t: usize, s: usize) -> bool {
        !self.rims[s] && !self.rims[t] && self.normals[s].dot(&self.normals[t]) < OPPOSED
    }

    fn middle(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.mesh.corners(t);
        (a + b + c) / 3.0
    }

    /// How far from the middle of a face a ray straight inwards meets another that faces it \[m\],
    /// and which.
    fn ray(&self, t: usize) -> Option<(f64, usize)> {
        let start = self.middle(t) - self.normals[t] * self.skin;
        let hit = self.nearest.first_hit(start, -self.normals[t], |s| s != t);
        hit.filter(|&(_, s)| self.faces_it(t, s))
    }

    /// The diameter \[m\], at most `most`, of the largest ball that touches the middle of a face
    /// from within and holds no point of a face turned the other way, and the face that it touches
    /// there. On parallel walls that is their distance also where they are curved, from either side
    /// \[shrinking ball: Ma, Bae & Choi 2012\].
    fn ball(&self, t: usize, ray: Option<(f64, usize)>, most: f64) -> Option<(f64, usize)> {
        let (x, n) = (self.middle(t), self.normals[t]);
        let near = ray.filter(|(distance, _)| *distance <= most);
        let (mut radius, mut across) = near.map_or((0.5 * most, None), |(d, s)| (0.5 * d, Some(s)));
        for _ in 0..SHRINKS {
            let reach = radius * (1.0 - 1e-6);
            let found = self.nearest.closest_within(x - n * radius, reach, |s| self.faces_it(t, s));
            let Some((q, _, s)) = found else {
                break;
            };
            radius = (x - q).norm_squared() / (2.0 * n.dot(&(x - q)));
            across = Some(s);
        }
        across.map(|s| (2.0 * radius, s))
    }
}

/// The value below which `share` of the weight of `(value, weight)` lies.
pub(super) fn quantile(mut samples: Vec<(f64, f64)>, share: f64) -> Option<f64> {
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = samples.iter().map(|s| s.1).sum();
    let mut sum = 0.0;
    let reached = samples.iter().find(|(_, weight)| {
        sum += weight;
        sum >= share * whole
    });
    reached.or(samples.last()).map(|s| s.0)
}
