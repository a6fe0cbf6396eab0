//! The surface that is remeshed: what new vertices are projected onto.

use super::curved::unit_or;
use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::surface::barycentric;

/// Where a boundary turns by more than this it has a corner: cosine of 40°.
const CORNER: f64 = 0.766;

/// A mesh with thickness and boundary, prepared for projections.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceSurface {
    pub(crate) mesh: TriMesh,
    thickness: Vec<f64>,
    nearest: Nearest,
    border: Nearest,
    /// The boundaries, each in the direction of its triangles.
    pub(crate) loops: Vec<Vec<u32>>,
}

impl ReferenceSurface {
    pub(crate) fn new(mesh: TriMesh, thickness: Vec<f64>) -> Self {
        let nearest = Nearest::new(&mesh);
        let loops = boundary_loops(&mesh);
        // An edge is a triangle with two equal corners.
        let edges = loops.iter().flat_map(|points| {
            (0..points.len()).map(|i| (points[i], points[(i + 1) % points.len()]))
        });
        let triangles = edges.map(|(a, b)| [a, b, b]).collect();
        let border = Nearest::new(&TriMesh { vertices: mesh.vertices.clone(), triangles });
        Self { mesh, thickness, nearest, border, loops }
    }

    /// The nearest point of the surface \[m\].
    pub(crate) fn project(&self, p: Vec3) -> Vec3 {
        self.nearest.closest(p).map_or(p, |(q, _, _)| q)
    }

    /// The nearest point of the boundary \[m\].
    pub(crate) fn project_on_border(&self, p: Vec3) -> Vec3 {
        self.border.closest(p).map_or(p, |(q, _, _)| q)
    }

    /// Thickness at the point of the surface nearest to `p` \[m\].
    pub(crate) fn thickness(&self, p: Vec3) -> f64 {
        self.nearest.closest(p).map_or(0.0, |(q, _, t)| {
            let weights = barycentric(q, self.mesh.corners(t));
            let corners = self.mesh.triangles[t];
            (0..3).map(|k| weights[k] * self.thickness[corners[k] as usize]).sum()
        })
    }

    /// Vertices in which a boundary turns sharply, none closer than `reach` \[m\] to a sharper
    /// one. The turn is also seen over `reach` to both sides, so that a ragged boundary has none.
    pub(crate) fn corners(&self, reach: f64) -> Vec<u32> {
        let mut found: Vec<(f64, u32)> = Vec::new();
        for points in &self.loops {
            let turns = (0..points.len()).map(|i| (self.turn(points, i, reach), points[i]));
            found.extend(turns.filter(|(cosine, _)| *cosine < CORNER));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let at = |v: u32| self.mesh.vertices[v as usize];
        let mut corners: Vec<u32> = Vec::new();
        for (_, v) in found {
            if corners.iter().all(|&c| (at(c) - at(v)).norm() >= reach) {
                corners.push(v);
            }
        }
        corners
    }

    /// The cosine of the angle by which a boundary turns at its point `i`: of the lesser of the
    /// turn between its edges there and that over `reach` \[m\].
    fn turn(&self, points: &[u32], i: usize, reach: f64) -> f64 {
        let n = points.len();
        let at = |i: usize| self.mesh.vertices[points[i % n] as usize];
        let here = at(i);
        let far = |step: usize| {
            let mut walk = (1..n).map(|k| at(i + k * step));
            walk.find(|p| (p - here).norm() >= reach).unwrap_or(here)
        };
        let way = |v: Vec3| unit_or(v, Vec3::zeros());
        let turn = |a: Vec3, b: Vec3| way(here - a).dot(&way(b - here));
        let local = turn(at(i + n - 1), at(i + 1));
        if local >= CORNER { local } else { local.max(turn(far(n - 1), far(1))) }
    }

    /// The angle that the surface takes at one of its vertices \[rad\].
    pub(crate) fn angle_at(&self, v: u32) -> f64 {
        let of = |corners: &[u32; 3]| {
            let k = corners.iter().position(|&c| c == v)?;
            let [p, q, r] = [0, 1, 2].map(|i| self.mesh.vertices[corners[(k + i) % 3] as usize]);
            let (e, f) = (q - p, r - p);
            Some(libm::atan2(e.cross(&f).norm(), e.dot(&f)))
        };
        self.mesh.triangles.iter().filter_map(of).sum()
    }
}

/// The boundaries of a manifold mesh as loops of vertices, in the direction of the triangles.
pub(crate) fn boundary_loops(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut edges = mesh.open_edges();
    edges.sort_unstable();
    let mut used = vec![false; edges.len()];
    let mut loops = Vec::new();
    for first in 0..edges.len() {
        let mut points = Vec::new();
        let mut at = first;
        while !used[at] {
            used[at] = true;
            points.push(edges[at][0]);
            match edges.binary_search_by_key(&edges[at][1], |e| e[0]) {
                Ok(next) => at = next,
                Err(_) => break,
            }
        }
        if !points.is_empty() {
            loops.push(points);
        }
    }
    loops
}
