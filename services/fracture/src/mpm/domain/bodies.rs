//! Several bodies on one grid: what belongs to which, and how they face each other.

use super::Domain;
use crate::mpm::contact::Facing;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::{TriMesh, Vec3};

/// Lines that run along an edge of a triangle count as through it, by this share of its size.
const SEAM: f64 = 1e-9;

/// A body's surface, for queries of inside and distance.
pub(crate) struct BodySurface {
    inside: Inside,
    nearest: Nearest,
    mesh: TriMesh,
}

impl BodySurface {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let (inside, nearest) = (Inside::new(mesh), Nearest::new(mesh));
        Self { inside, nearest, mesh: mesh.clone() }
    }

    pub(crate) fn contains(&self, x: &Vec3) -> bool {
        self.inside.contains(*x)
    }

    /// Where the surface is on the line through `x` along the unit vector `n`, nearest to `x`
    /// \[m\]: where `n` comes out of the body, or goes in. Beside the body, the place of its
    /// nearest point along the line.
    fn along(&self, x: &Vec3, n: &Vec3, out: bool) -> f64 {
        let all = (0..self.mesh.triangles.len()).filter_map(|t| {
            let [a, b, c] = self.mesh.corners(t);
            let facing = (b - a).cross(&(c - a)).dot(n);
            let ahead = if out { facing > 0.0 } else { facing < 0.0 };
            ahead.then(|| crossing(x, n, [a, b, c])).flatten()
        });
        let best = all.reduce(|best, s| if s.abs() < best.abs() { s } else { best });
        best.unwrap_or_else(|| {
            self.nearest.closest(*x).map_or(f64::INFINITY, |(point, _, _)| (point - x).dot(n))
        })
    }
}

/// Where the line through `x` along `n` meets a triangle.
fn crossing(x: &Vec3, n: &Vec3, [a, b, c]: [Vec3; 3]) -> Option<f64> {
    let (u, v) = (b - a, c - a);
    let across = n.cross(&v);
    let det = u.dot(&across);
    let from = x - a;
    let first = from.dot(&across) / det;
    let turned = from.cross(&u);
    let second = n.dot(&turned) / det;
    let inside = first >= -SEAM && second >= -SEAM && first + second <= 1.0 + SEAM;
    inside.then(|| v.dot(&turned) / det)
}

impl Domain {
    /// Parts the nodes that several bodies reach, and lets these touch where their surfaces are:
    /// `of` names the body of each point by id.
    pub(crate) fn part_bodies(&mut self, of: &[u8], surfaces: &[BodySurface]) {
        let key = |x: &Vec3| [x.x, x.y, x.z].map(f64::to_bits);
        let mut bodies: Vec<([u64; 3], u8)> =
            (0..of.len()).map(|id| (key(&self.place(id)), of[id])).collect();
        bodies.sort_unstable();
        let body = |x: &Vec3| {
            let at = bodies.binary_search_by_key(&key(x), |row| row.0);
            at.map_or(0, |at| bodies[at].1)
        };
        self.sever(|a, b| body(a) != body(b));
        for element in &self.grid.elements {
            let own = of[self.particles.id[element.first as usize] as usize];
            for &node in &element.nodes {
                self.grid.nodes.body[node as usize] = own;
            }
        }
        self.contact.facings = self.faced(surfaces);
        self.touch();
    }

    fn place(&self, id: usize) -> Vec3 {
        self.particles.reference[self.slot(id as u32)]
    }

    /// How the bodies at each node lie that has several: across them is from where the points of
    /// one lie to where those of the other do.
    fn faced(&self, surfaces: &[BodySurface]) -> Vec<Facing> {
        let nodes = &self.grid.nodes;
        let mut rows: Vec<(u32, u8, usize)> =
            (0..nodes.len()).map(|n| (nodes.origin[n], nodes.body[n], n)).collect();
        rows.sort_unstable();
        let mut facings = Vec::new();
        for own in rows.chunk_by(|a, b| a.0 == b.0) {
            let parts: Vec<_> = own.chunk_by(|a, b| a.1 == b.1).collect();
            let x = self.grid.place(own[0].0 as usize);
            let offset = |part: &[(u32, u8, usize)]| {
                let sum: Vec3 =
                    part.iter().map(|row| nodes.points_offset[row.2] * nodes.mass[row.2]).sum();
                sum / part.iter().map(|row| nodes.mass[row.2]).sum::<f64>()
            };
            for (i, j) in (0..parts.len()).flat_map(|i| (i + 1..parts.len()).map(move |j| (i, j))) {
                let across =
                    (offset(parts[j]) - offset(parts[i])).component_div(&self.grid.spacing);
                if let Some(normal) = across.try_normalize(0.0) {
                    let bodies = [parts[i][0].1, parts[j][0].1];
                    let [first, second] = bodies.map(|body| &surfaces[usize::from(body)]);
                    let apart = second.along(&x, &normal, false) - first.along(&x, &normal, true);
                    let (node, apart) = (own[0].0, apart.max(0.0));
                    facings.push(Facing { node, bodies, normal, apart });
                }
            }
        }
        facings
    }
}
