//! A manifold triangle mesh whose edges can be split, collapsed and flipped.

use crate::divide::key;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::remesh::curved::{triangles_around, unit_or};

/// The index of no vertex: the corners of a triangle that is no more.
const GONE: u32 = u32::MAX;

/// Where a vertex may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VertexRole {
    /// Over the surface.
    Interior,
    /// Along a boundary.
    Border,
    /// Nowhere: the boundary turns sharply.
    Corner,
}

/// The triangle on one side of an edge and its corner across.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeSide {
    pub(crate) triangle: u32,
    pub(crate) across: u32,
}

/// Triangles with the lists of those around each vertex.
#[derive(Clone, Debug)]
pub(crate) struct EditableMesh {
    pub(crate) points: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) around: Vec<Vec<u32>>,
    pub(crate) role: Vec<VertexRole>,
    /// The valence that each vertex should have.
    pub(crate) target: Vec<usize>,
}

impl EditableMesh {
    /// All vertices interior, until [`EditableMesh::role`] says otherwise.
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let count = mesh.vertices.len();
        Self {
            points: mesh.vertices.clone(),
            triangles: mesh.triangles.clone(),
            around: triangles_around(mesh),
            role: vec![VertexRole::Interior; count],
            target: vec![6; count],
        }
    }

    /// The mesh and, for each of its vertices, the index here.
    pub(crate) fn compacted(&self) -> TriMesh {
        let alive: Vec<usize> =
            (0..self.triangles.len()).filter(|&t| self.triangles[t][0] != GONE).collect();
        let mesh = TriMesh { vertices: self.points.clone(), triangles: self.triangles.clone() };
        mesh.submesh(&alive)
    }

    pub(crate) fn at(&self, v: u32) -> Vec3 {
        self.points[v as usize]
    }

    pub(crate) fn corners(&self, t: u32) -> [Vec3; 3] {
        self.triangles[t as usize].map(|v| self.at(v))
    }

    pub(crate) fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.at(b) - self.at(a)).norm()
    }

    pub(crate) fn is_alive(&self, t: u32) -> bool {
        self.triangles[t as usize][0] != GONE
    }

    pub(crate) fn is_interior(&self, v: u32) -> bool {
        self.role[v as usize] == VertexRole::Interior
    }

    /// Half the cross product of two edges \[m²\].
    pub(crate) fn area_vector(&self, t: u32) -> Vec3 {
        let [a, b, c] = self.corners(t);
        0.5 * (b - a).cross(&(c - a))
    }

    /// The unit normal at a vertex, weighted by area.
    pub(crate) fn normal(&self, v: u32) -> Vec3 {
        let sum: Vec3 = self.around[v as usize].iter().map(|&t| self.area_vector(t)).sum();
        unit_or(sum, Vec3::zeros())
    }

    /// Edges at a vertex; zero for a vertex that is no more.
    pub(crate) fn valence(&self, v: u32) -> usize {
        let triangles = self.around[v as usize].len();
        triangles + usize::from(triangles > 0 && !self.is_interior(v))
    }

    /// The vertices that share an edge with `v`, in order of index.
    pub(crate) fn neighbours(&self, v: u32) -> Vec<u32> {
        let corners = self.around[v as usize].iter().flat_map(|&t| self.triangles[t as usize]);
        let mut found: Vec<u32> = corners.filter(|&w| w != v).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// All edges, the smaller index first, in order.
    pub(crate) fn edges(&self) -> Vec<[u32; 2]> {
        let alive = self.triangles.iter().filter(|t| t[0] != GONE);
        let mut edges: Vec<[u32; 2]> =
            alive.flat_map(|&[a, b, c]| [key(a, b), key(b, c), key(c, a)]).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The triangles beside an edge: first that through which it runs from `a` to `b`, then the
    /// other.
    pub(crate) fn sides(&self, [a, b]: [u32; 2]) -> [Option<EdgeSide>; 2] {
        let mut sides = [None; 2];
        for &triangle in &self.around[a as usize] {
            let corners = self.triangles[triangle as usize];
            let k = corners.iter().position(|&v| v == a).unwrap_or(0);
            let (next, previous) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            if next == b {
                sides[0] = Some(EdgeSide { triangle, across: previous });
            } else if previous == b {
                sides[1] = Some(EdgeSide { triangle, across: next });
            }
        }
        sides
    }

    pub(crate) fn is_edge(&self, a: u32, b: u32) -> bool {
        self.around[a as usize].iter().any(|&t| self.triangles[t as usize].contains(&b))
    }

    /// Puts a vertex at `p` \[m\] on an edge.
    pub(crate) fn split(&mut self, [a, b]: [u32; 2], p: Vec3) -> u32 {
        let sides = self.sides([a, b]);
        let is_border = sides.iter().any(Option::is_none);
        let m = self.points.len() as u32;
        self.points.push(p);
        self.around.push(Vec::with_capacity(6));
        self.role.push(if is_border { VertexRole::Border } else { VertexRole::Interior });
        self.target.push(if is_border { 4 } else { 6 });
        for EdgeSide { triangle, across } in sides.into_iter().flatten() {
            let new = self.triangles.len() as u32;
            let corners = self.triangles[triangle as usize];
            let with = |out: u32| corners.map(|v| if v == out { m } else { v });
            self.triangles[triangle as usize] = with(b);
            self.triangles.push(with(a));
            self.around[b as usize].retain(|&t| t != triangle);
            self.around[b as usize].push(new);
            self.around[across as usize].push(new);
            self.around[m as usize].extend([triangle, new]);
        }
        m
    }

    /// Whether `gone` can be merged into `keep` without a change of topology or of the boundary's
    /// shape: the link condition \[Dey et al. 1999\].
    pub(crate) fn can_collapse(&self, gone: u32, keep: u32) -> bool {
        let sides = self.sides([gone, keep]);
        let count = sides.iter().flatten().count();
        let along_border = count == 1;
        let may = match self.role[gone as usize] {
            VertexRole::Interior => true,
            VertexRole::Border => along_border && !self.is_interior(keep),
            VertexRole::Corner => false,
        };
        let least = |v: u32| if self.is_interior(v) { 4 } else { 3 };
        if !may || sides.iter().flatten().any(|s| self.valence(s.across) < least(s.across)) {
            return false;
        }
        let near = self.neighbours(keep);
        let common = self.neighbours(gone).into_iter().filter(|v| near.contains(v)).count();
        // A border of three edges would close.
        let loop_closes = along_border
            && sides.iter().flatten().any(|s| {
                let open = |v: u32| self.sides([v, s.across]).iter().any(Option::is_none);
                open(gone) && open(keep)
            });
        common == count && !loop_closes
    }

    /// Merges `gone` into `keep`, which moves to `p` \[m\].
    pub(crate) fn collapse(&mut self, gone: u32, keep: u32, p: Vec3) {
        for t in std::mem::take(&mut self.around[gone as usize]) {
            let corners = self.triangles[t as usize];
            if corners.contains(&keep) {
                for v in corners {
                    self.around[v as usize].retain(|&s| s != t);
                }
                self.triangles[t as usize] = [GONE; 3];
            } else {
                self.triangles[t as usize] = corners.map(|v| if v == gone { keep } else { v });
                self.around[keep as usize].push(t);
            }
        }
        self.points[keep as usize] = p;
    }

    /// The two triangles that a flip of an edge would make; `None` where it cannot be flipped.
    pub(crate) fn flipped(&self, [a, b]: [u32; 2]) -> Option<[[u32; 3]; 2]> {
        let [Some(left), Some(right)] = self.sides([a, b]) else {
            return None;
        };
        let (c, d) = (left.across, right.across);
        let is_thin =
            |v: u32| self.around[v as usize].len() < if self.is_interior(v) { 4 } else { 2 };
        if c == d || is_thin(a) || is_thin(b) || self.is_edge(c, d) {
            return None;
        }
        Some([[a, d, c], [d, b, c]])
    }

    /// Turns an edge within its two triangles into that between their other corners.
    pub(crate) fn flip(&mut self, [a, b]: [u32; 2]) {
        let (sides, made) = (self.sides([a, b]), self.flipped([a, b]));
        if let ([Some(left), Some(right)], Some(made)) = (sides, made) {
            self.triangles[left.triangle as usize] = made[0];
            self.triangles[right.triangle as usize] = made[1];
            self.around[a as usize].retain(|&t| t != right.triangle);
            self.around[b as usize].retain(|&t| t != left.triangle);
            self.around[left.across as usize].push(right.triangle);
            self.around[right.across as usize].push(left.triangle);
        }
    }
}
