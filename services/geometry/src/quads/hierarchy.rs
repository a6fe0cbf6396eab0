//! The graph of a surface's vertices, and coarser and coarser copies of it.

use super::crosses::{nearest_arm, tangent};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::midsurface::vertex_normals;
use crate::remesh::curved::{area_vector, unit_or};

/// A level of no more vertices than this is the coarsest: a field on it settles in a few sweeps.
const FEWEST: usize = 12;
/// Vertices whose normals have a lesser cosine than this are not merged.
const TURNED: f64 = 0.1;

/// How a rim holds the field at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimHold {
    /// A point of the rim \[m\].
    pub(super) at: Vec3,
    /// The unit direction of the rim there.
    pub(super) along: Vec3,
    /// Whether a lattice point has to lie at the point itself.
    pub(super) is_corner: bool,
}

/// One level: a graph with a place, a normal and an area at each vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct FieldLevel {
    pub(super) points: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) holds: Vec<Option<RimHold>>,
    areas: Vec<f64>,
    starts: Vec<usize>,
    links: Vec<(u32, f64)>,
    /// For each vertex its vertex of the next coarser level; empty on the coarsest.
    pub(super) parents: Vec<u32>,
}

impl FieldLevel {
    /// The finest level.
    fn of_mesh(mesh: &TriMesh, holds: Vec<Option<RimHold>>) -> Self {
        // A vertex of triangles without area still counts.
        let mut areas = vec![f64::MIN_POSITIVE; mesh.vertices.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let third = area_vector(mesh, t).norm() / 3.0;
            corners.iter().for_each(|&v| areas[v as usize] += third);
        }
        let edges = mesh.edges().into_iter().map(|e| (e.from, e.to, 1.0)).collect();
        let (points, normals) = (mesh.vertices.clone(), vertex_normals(mesh));
        let mut level = Self { points, normals, holds, areas, ..Self::default() };
        level.link(edges);
        level
    }

    /// The vertices next to `v` with their weights.
    pub(super) fn neighbours(&self, v: usize) -> &[(u32, f64)] {
        &self.links[self.starts[v]..self.starts[v + 1]]
    }

    /// Sets the links from undirected edges with weights; those of equal ends are added up.
    fn link(&mut self, edges: Vec<(u32, u32, f64)>) {
        let both = edges.into_iter().flat_map(|(a, b, w)| [(a, b, w), (b, a, w)]);
        let mut all: Vec<(u32, u32, f64)> = both.filter(|(a, b, _)| a != b).collect();
        all.sort_by_key(|&(a, b, _)| (a, b));
        let mut count = vec![0; self.points.len() + 1];
        for uses in all.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
            self.links.push((uses[0].1, uses.iter().map(|u| u.2).sum()));
            count[uses[0].0 as usize + 1] += 1;
        }
        for v in 1..count.len() {
            count[v] += count[v - 1];
        }
        self.starts = count;
    }

    /// Merges pairs of neighbours of like normals and areas into a level of about half as many
    /// vertices.
    fn coarser(&mut self) -> Self {
        let (parents, count) = self.pairs();
        let mut level = Self {
            points: vec![Vec3::zeros(); count],
            normals: vec![Vec3::zeros(); count],
            holds: vec![None; count],
            areas: vec![0.0; count],
            ..Self::default()
        };
        for (v, &p) in parents.iter().enumerate() {
            let p = p as usize;
            level.points[p] += self.areas[v] * self.points[v];
            level.normals[p] += self.areas[v] * self.normals[v];
            level.areas[p] += self.areas[v];
            level.holds[p] = merged(level.holds[p], self.holds[v], self.normals[v]);
        }
        for p in 0..count {
            level.points[p] /= level.areas[p];
            level.normals[p] = unit_or(level.normals[p], Vec3::z());
        }
        let mut edges = Vec::with_capacity(self.links.len() / 2);
        for v in 0..self.points.len() {
            let later = self.neighbours(v).iter().filter(|(w, _)| *w as usize > v);
            edges.extend(later.map(|&(w, weight)| (parents[v], parents[w as usize], weight)));
        }
        level.link(edges);
        self.parents = parents;
        level
    }

    /// For each vertex the index of its pair, and how many there are.
    fn pairs(&self) -> (Vec<u32>, usize) {
        let mut scored: Vec<(f64, u32, u32)> = Vec::with_capacity(self.links.len() / 2);
        for v in 0..self.points.len() {
            for &(w, _) in self.neighbours(v).iter().filter(|(w, _)| *w as usize > v) {
                let (a, b) = (self.areas[v], self.areas[w as usize]);
                let cosine = self.normals[v].dot(&self.normals[w as usize]);
                if cosine > TURNED {
                    scored.push((cosine * a.min(b) / a.max(b), v as u32, w));
                }
            }
        }
        scored.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut partner: Vec<Option<u32>> = vec![None; self.points.len()];
        for (_, v, w) in scored {
            if partner[v as usize].is_none() && partner[w as usize].is_none() {
                partner[v as usize] = Some(w);
                partner[w as usize] = Some(v);
            }
        }
        let mut parents = vec![0; self.points.len()];
        let mut count = 0;
        for v in 0..parents.len() {
            match partner[v] {
                Some(w) if (w as usize) < v => parents[v] = parents[w as usize],
                _ => {
                    parents[v] = count;
                    count += 1;
                }
            }
        }
        (parents, count as usize)
    }
}

/// One hold for two: a corner rather than a rim, and between two places of a rim.
fn merged(a: Option<RimHold>, b: Option<RimHold>, normal: Vec3) -> Option<RimHold> {
    match (a, b) {
        (Some(a), Some(b)) if !a.is_corner && !b.is_corner => {
            let [first, second] = [a.along, b.along].map(|way| tangent(way, normal));
            let along = tangent(first + nearest_arm(first, second, normal), normal);
            Some(RimHold { at: 0.5 * (a.at + b.at), along, is_corner: false })
        }
        (Some(a), Some(b)) => Some(if a.is_corner { a } else { b }),
        _ => a.or(b),
    }
}

/// The graph of a mesh and its coarser copies, the finest first.
pub(super) fn levels(mesh: &TriMesh, holds: Vec<Option<RimHold>>) -> Vec<FieldLevel> {
    let mut all = vec![FieldLevel::of_mesh(mesh, holds)];
    let mut fine = 0;
    while all[fine].points.len() > FEWEST {
        let level = all[fine].coarser();
        if 10 * level.points.len() > 9 * all[fine].points.len() {
            all[fine].parents.clear();
            break;
        }
        all.push(level);
        fine += 1;
    }
    all
}
