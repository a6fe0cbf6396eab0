//! The surface between the two walls of a thin body.

use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::remesh::reference_surface::boundary_loops;

/// The surface half way between the two walls of a thin body, in triangles of about one size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallSurface {
    /// Vertices \[m\].
    pub vertices: Vec<Vec3>,
    /// Three vertex indices each; normals point the way of the larger wall, outward on a vessel.
    pub triangles: Vec<[u32; 3]>,
    /// Thickness of the wall at each vertex \[m\].
    pub thickness: Vec<f64>,
}

impl WallSurface {
    /// As a mesh without thickness.
    #[must_use]
    pub fn mesh(&self) -> TriMesh {
        TriMesh { vertices: self.vertices.clone(), triangles: self.triangles.clone() }
    }

    /// Area of the midsurface \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.triangle_area(t)).sum()
    }

    /// Thickness times area, Σ t A \[m³\]: the volume of the wall to O((t/R)²).
    #[must_use]
    pub fn volume(&self) -> f64 {
        let mean = |t: usize| -> f64 {
            self.triangles[t].iter().map(|&v| self.thickness[v as usize]).sum::<f64>() / 3.0
        };
        (0..self.triangles.len()).map(|t| mean(t) * self.triangle_area(t)).sum()
    }

    /// The boundaries as loops of vertices, each with the surface on its left seen from the side
    /// that the normals point to. A closed surface has none.
    #[must_use]
    pub fn boundary(&self) -> Vec<Vec<u32>> {
        boundary_loops(&self.mesh())
    }

    /// Area of a triangle \[m²\].
    pub(crate) fn triangle_area(&self, t: usize) -> f64 {
        let [a, b, c] = self.triangles[t].map(|v| self.vertices[v as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    }
}
