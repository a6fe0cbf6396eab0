//! A net of quads while it is being made, and the check that it is a manifold.

use crate::divide::key;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::remesh::editable::VertexRole;
use crate::remesh::reference_surface::boundary_loops;

/// Quads whose vertices know where they may move.
#[derive(Clone, Debug, Default)]
pub(super) struct QuadNet {
    pub(super) points: Vec<Vec3>,
    pub(super) role: Vec<VertexRole>,
    pub(super) quads: Vec<[u32; 4]>,
}

/// What the shape of a surface is, apart from lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SurfaceTopology {
    /// Vertices − edges + faces.
    euler: i64,
    rims: usize,
}

impl SurfaceTopology {
    pub(super) fn of_triangles(mesh: &TriMesh) -> Self {
        let [v, e, f] = [mesh.vertices.len(), mesh.edges().len(), mesh.triangles.len()];
        Self { euler: v as i64 - e as i64 + f as i64, rims: boundary_loops(mesh).len() }
    }
}

impl QuadNet {
    pub(super) fn add(&mut self, p: Vec3, role: VertexRole) -> u32 {
        self.points.push(p);
        self.role.push(role);
        self.points.len() as u32 - 1
    }

    pub(super) fn corners(&self, q: usize) -> [Vec3; 4] {
        self.quads[q].map(|v| self.points[v as usize])
    }

    /// The quads at each vertex, in order.
    pub(super) fn around(&self) -> Vec<Vec<u32>> {
        let mut around = vec![Vec::new(); self.points.len()];
        for (q, corners) in (0u32..).zip(&self.quads) {
            corners.iter().for_each(|&v| around[v as usize].push(q));
        }
        around
    }

    /// All edges, the smaller index first, in order.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let ends = |c: &[u32; 4]| [0, 1, 2, 3].map(|k| key(c[k], c[(k + 1) % 4]));
        let mut edges: Vec<[u32; 2]> = self.quads.iter().flat_map(ends).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The number of interior vertices without four quads.
    pub(super) fn irregular(&self) -> usize {
        let around = self.around();
        let is_odd =
            |(v, fan): (usize, &Vec<u32>)| self.role[v] == VertexRole::Interior && fan.len() != 4;
        around.iter().enumerate().filter(|&pair| is_odd(pair)).count()
    }

    /// The topology, if this is one manifold: no vertex twice in a quad, each edge at most once
    /// each way, one fan of quads at each vertex.
    pub(super) fn topology(&self) -> Option<SurfaceTopology> {
        let mut ways: Vec<[u32; 2]> = Vec::with_capacity(4 * self.quads.len());
        for c in &self.quads {
            ways.extend([0, 1, 2, 3].map(|k| [c[k], c[(k + 1) % 4]]));
            let mut sorted = *c;
            sorted.sort_unstable();
            if sorted.windows(2).any(|w| w[0] == w[1]) {
                return None;
            }
        }
        ways.sort_unstable();
        let is_used = |way: [u32; 2]| ways.binary_search(&way).is_ok();
        let is_doubled = ways.windows(2).any(|w| w[0] == w[1]);
        let mut rim: Vec<[u32; 2]> =
            ways.iter().copied().filter(|&[a, b]| !is_used([b, a])).collect();
        rim.sort_unstable();
        // At most one rim leaves a vertex, and all quads there hang together.
        let is_pinched = rim.windows(2).any(|w| w[0][0] == w[1][0])
            || (0u32..).zip(&self.around()).any(|(v, fan)| !self.is_fan(v, fan));
        if is_doubled || is_pinched {
            return None;
        }
        let [v, e, f] = [self.points.len(), self.edges().len(), self.quads.len()];
        Some(SurfaceTopology { euler: v as i64 - e as i64 + f as i64, rims: loops(&rim) })
    }

    /// Whether the quads at `v` are one fan.
    fn is_fan(&self, v: u32, around: &[u32]) -> bool {
        let beside = |q: u32| {
            let c = self.quads[q as usize];
            let k = c.iter().position(|&w| w == v).unwrap_or(0);
            [c[(k + 1) % 4], c[(k + 3) % 4]]
        };
        let mut left = around.to_vec();
        let Some(first) = left.pop() else {
            return false;
        };
        let mut ends = beside(first);
        while let Some(i) = left.iter().position(|&q| beside(q).iter().any(|w| ends.contains(w))) {
            let next = beside(left.swap_remove(i));
            for k in 0..2 {
                if ends.contains(&next[k]) {
                    let end = usize::from(ends[1] == next[k]);
                    ends[end] = next[1 - k];
                    break;
                }
            }
        }
        left.is_empty()
    }
}

/// The number of loops of directed edges sorted by their first vertex, each vertex in one.
fn loops(edges: &[[u32; 2]]) -> usize {
    let mut used = vec![false; edges.len()];
    let mut count = 0;
    for first in 0..edges.len() {
        count += usize::from(!used[first]);
        let mut at = first;
        while !used[at] {
            used[at] = true;
            at = edges.binary_search_by_key(&edges[at][1], |e| e[0]).unwrap_or(at);
        }
    }
    count
}
