//! Triangle meshes, solids with the origin of each face, and their exact mass properties.

use crate::math::{Mat3, Vec3};

/// Vertices \[m\] and counter-clockwise triangles (normals point outward).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Corner positions \[m\].
    pub vertices: Vec<Vec3>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
}

/// Where a face of a solid came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The surface the object was made with.
    Outer,
    /// A crack face: interior material, opened `damage_time` \[s\] after the impact that made it.
    Crack {
        /// Time from the impact to full damage \[s\]; zero where a method has no time.
        damage_time: f32,
    },
}

/// A closed mesh and the origin of each of its triangles (`surface.len() == mesh.triangles.len()`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solid {
    /// The closed, outward-oriented boundary.
    pub mesh: TriMesh,
    /// One entry a triangle.
    pub surface: Vec<Surface>,
}

impl Solid {
    /// A solid whose whole boundary is [`Surface::Outer`].
    #[must_use]
    pub fn outer(mesh: TriMesh) -> Self {
        let surface = vec![Surface::Outer; mesh.triangles.len()];
        Self { mesh, surface }
    }
}

/// Volume integrals of a closed mesh at unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Volume \[m³\].
    pub volume: f64,
    /// Centroid \[m\].
    pub centroid: Vec3,
    /// Inertia tensor about the centroid at unit density \[m⁵\].
    pub inertia: Mat3,
}

impl TriMesh {
    /// The corner positions of triangle `t` \[m\].
    #[must_use]
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|i| self.vertices[i as usize])
    }
}
