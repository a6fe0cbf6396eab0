//! Triangle meshes, solids with the origin of each face, and their exact mass properties.

use crate::math::{Mat3, Pose, Vec3};
pub use crate::surface::Surface;

/// Vertices \[m\] and counter-clockwise triangles (normals point outward).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Corner positions \[m\].
    pub vertices: Vec<Vec3>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
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

/// What is wrong with the arrays of a mesh or solid, with the place.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The mesh has no triangle.
    #[error("the mesh is empty: {vertices} vertices, no triangle")]
    Empty {
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite: ({x}, {y}, {z})")]
    NonFinite {
        /// Which vertex.
        vertex: usize,
        /// Its coordinates \[m\].
        x: f64,
        /// Its coordinates \[m\].
        y: f64,
        /// Its coordinates \[m\].
        z: f64,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} uses vertex {index}, but there are only {vertices}")]
    IndexOutOfRange {
        /// Which triangle.
        triangle: usize,
        /// The index it uses.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// The surface list does not have one entry a triangle.
    #[error("{surfaces} surface entries for {triangles} triangles; there must be one a triangle")]
    SurfaceLength {
        /// Entries given.
        surfaces: usize,
        /// Triangles given.
        triangles: usize,
    },
    /// A sheet does not have one damage time and one front speed a vertex.
    #[error("{marks} times or speeds for {vertices} vertices; there must be one a vertex")]
    Marks {
        /// Times or speeds given.
        marks: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// A damage time or front speed of a sheet is negative, NaN or infinite.
    #[error("the damage time or front speed of vertex {vertex} is {value}; it must be >= 0")]
    Mark {
        /// Which vertex.
        vertex: usize,
        /// The time \[s\] or speed \[m/s\].
        value: f32,
    },
    /// A damage time or front speed is negative, NaN or infinite.
    #[error("the damage time or front speed of triangle {triangle} is {value}; it must be >= 0")]
    DamageTime {
        /// Which triangle.
        triangle: usize,
        /// The time \[s\] or speed \[m/s\].
        value: f32,
    },
}

/// How the triangles use one undirected edge; `from < to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// The smaller vertex index.
    pub from: u32,
    /// The larger vertex index.
    pub to: u32,
    /// Triangles that run through it from `from` to `to`.
    pub forward: u32,
    /// Triangles that run through it from `to` to `from`.
    pub backward: u32,
}

impl TriMesh {
    /// The corner positions of triangle `t` \[m\].
    #[must_use]
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|i| self.vertices[i as usize])
    }

    /// Checks that every vertex is finite and every index in range.
    ///
    /// # Errors
    /// [`MeshError::NonFinite`] or [`MeshError::IndexOutOfRange`], the first found.
    pub fn validate(&self) -> Result<(), MeshError> {
        if let Some((vertex, p)) =
            self.vertices.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite()))
        {
            return Err(MeshError::NonFinite { vertex, x: p.x, y: p.y, z: p.z });
        }
        let vertices = self.vertices.len();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle, index, vertices });
            }
        }
        Ok(())
    }

    /// Least and greatest corner of the axis-aligned box around all vertices \[m\]; `None` if
    /// empty.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        bounds(&self.vertices)
    }

    /// Length of the diagonal of [`TriMesh::bounds`] \[m\]; zero if empty.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(0.0, |(low, high)| (high - low).norm())
    }

    /// Sum of the triangles' areas \[m²\].
    #[must_use]
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                0.5 * (b - a).cross(&(c - a)).norm()
            })
            .sum()
    }

    /// Enclosed volume \[m³\]: positive where normals point outward. Meaningful for closed meshes.
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        let origin = self.middle();
        let sum: f64 = (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - origin);
                a.dot(&b.cross(&c))
            })
            .sum();
        sum / 6.0
    }

    /// The mesh moved by `offset` \[m\].
    #[must_use]
    pub fn translated(&self, offset: Vec3) -> Self {
        self.mapped(|p| p + offset)
    }

    /// The mesh turned and moved by `pose`.
    #[must_use]
    pub fn transformed(&self, pose: &Pose) -> Self {
        self.mapped(|p| pose.rotation * p + pose.translation.vector)
    }

    /// The mesh scaled about the origin by `factor` (a negative one turns it inside out).
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        self.mapped(|p| p * factor)
    }

    /// The mesh with every triangle's direction reversed.
    #[must_use]
    pub fn flipped(&self) -> Self {
        let triangles = self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        Self { vertices: self.vertices.clone(), triangles }
    }

    /// Volume, centroid and inertia of the enclosed body at unit density; exact for a closed mesh
    /// up to rounding. Integrals over the tetrahedra (origin, a, b, c) with the origin in the
    /// middle of the bounds, so a body far from the world's origin loses no digits. A mesh that
    /// encloses no volume has its centroid in the middle of its bounds.
    #[must_use]
    pub fn mass_properties(&self) -> MassProperties {
        let origin = self.middle();
        let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.corners(t).map(|p| p - origin);
            let v = a.dot(&b.cross(&c)) / 6.0;
            let s = a + b + c;
            volume += v;
            first += v / 4.0 * s;
            // ∫ x xᵀ dV over a tetrahedron with a corner at 0 is V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ).
            second += v / 20.0
                * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
        }
        if volume == 0.0 {
            return MassProperties { volume, centroid: origin, inertia: Mat3::zeros() };
        }
        let arm = first / volume;
        let central = second - volume * (arm * arm.transpose());
        let inertia = Mat3::identity() * central.trace() - central;
        MassProperties { volume, centroid: origin + arm, inertia }
    }

    /// Every undirected edge with its uses, in order of `(from, to)`. Edges of a triangle that
    /// names one vertex twice are left out where both ends are the same.
    #[must_use]
    pub fn edges(&self) -> Vec<EdgeUse> {
        let mut directed: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            for (i, j) in [(a, b), (b, c), (c, a)] {
                if i != j {
                    directed.push((i.min(j), i.max(j), i < j));
                }
            }
        }
        directed.sort_unstable();
        let mut edges: Vec<EdgeUse> = Vec::with_capacity(directed.len() / 2 + 1);
        for (from, to, forward) in directed {
            if edges.last().is_none_or(|e| (e.from, e.to) != (from, to)) {
                edges.push(EdgeUse { from, to, forward: 0, backward: 0 });
            }
            if let Some(e) = edges.last_mut() {
                if forward {
                    e.forward += 1;
                } else {
                    e.backward += 1;
                }
            }
        }
        edges
    }

    /// Edges that only one triangle uses, in the direction in which it uses them.
    #[must_use]
    pub fn open_edges(&self) -> Vec<[u32; 2]> {
        let lone = |e: &EdgeUse| match (e.forward, e.backward) {
            (1, 0) => Some([e.from, e.to]),
            (0, 1) => Some([e.to, e.from]),
            _ => None,
        };
        self.edges().iter().filter_map(lone).collect()
    }

    /// Edges that more than two triangles use.
    #[must_use]
    pub fn non_manifold_edges(&self) -> Vec<[u32; 2]> {
        let crowded = |e: &&EdgeUse| e.forward + e.backward > 2;
        self.edges().iter().filter(crowded).map(|e| [e.from, e.to]).collect()
    }

    /// Whether the mesh has triangles and uses each edge exactly once in each direction.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let distinct = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        !self.triangles.is_empty()
            && self.triangles.iter().all(distinct)
            && self.edges().iter().all(|e| e.forward == 1 && e.backward == 1)
    }

    /// Triangles grouped by shared vertices; groups and their members in order of first triangle.
    #[must_use]
    pub fn components(&self) -> Vec<Vec<usize>> {
        let mut root: Vec<u32> = (0..self.vertices.len() as u32).collect();
        for &[a, b, c] in &self.triangles {
            join(&mut root, a, b);
            join(&mut root, b, c);
        }
        let mut group_of = vec![usize::MAX; self.vertices.len()];
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (t, corners) in self.triangles.iter().enumerate() {
            let r = find(&mut root, corners[0]) as usize;
            if group_of[r] == usize::MAX {
                group_of[r] = groups.len();
                groups.push(Vec::new());
            }
            groups[group_of[r]].push(t);
        }
        groups
    }

    /// The mesh of the given triangles alone, with only the vertices that they use, in order of
    /// use.
    #[must_use]
    pub fn submesh(&self, triangles: &[usize]) -> Self {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        let mut part = Self::default();
        for &t in triangles {
            let corners = self.triangles[t].map(|i| {
                let slot = &mut new_index[i as usize];
                if *slot == u32::MAX {
                    *slot = part.vertices.len() as u32;
                    part.vertices.push(self.vertices[i as usize]);
                }
                *slot
            });
            part.triangles.push(corners);
        }
        part
    }

    /// Adds the vertices and triangles of `other`; nothing is welded.
    pub fn append(&mut self, other: &Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    fn mapped(&self, map: impl Fn(Vec3) -> Vec3) -> Self {
        let vertices = self.vertices.iter().map(|&p| map(p)).collect();
        Self { vertices, triangles: self.triangles.clone() }
    }

    fn middle(&self) -> Vec3 {
        self.bounds().map_or_else(Vec3::zeros, |(low, high)| 0.5 * (low + high))
    }
}

/// Least and greatest corner of the axis-aligned box around `points` \[m\]; `None` if there are
/// none.
#[must_use]
pub fn bounds(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = *points.first()?;
    Some(points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
}

/// The root of `i` in a forest of parents, with path halving.
pub(crate) fn find(root: &mut [u32], mut i: u32) -> u32 {
    while root[i as usize] != i {
        root[i as usize] = root[root[i as usize] as usize];
        i = root[i as usize];
    }
    i
}

/// Joins two trees of a forest of parents; the smaller index becomes the root.
pub(crate) fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
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

    /// Checks the arrays: finite vertices, indices in range, one valid surface entry a triangle.
    /// Closedness is the business of [`TriMesh::is_closed`].
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn validate(&self) -> Result<(), MeshError> {
        self.mesh.validate()?;
        let (surfaces, triangles) = (self.surface.len(), self.mesh.triangles.len());
        if surfaces != triangles {
            return Err(MeshError::SurfaceLength { surfaces, triangles });
        }
        for (triangle, surface) in self.surface.iter().enumerate() {
            if let Surface::Crack { damage_time, front_speed, .. } = *surface {
                let bad = |value: &f32| !(value.is_finite() && *value >= 0.0);
                let mut values = damage_time.into_iter().chain(front_speed);
                if let Some(value) = values.find(bad) {
                    return Err(MeshError::DamageTime { triangle, value });
                }
            }
        }
        Ok(())
    }

    /// The solid moved by `offset` \[m\].
    #[must_use]
    pub fn translated(&self, offset: Vec3) -> Self {
        Self { mesh: self.mesh.translated(offset), surface: self.surface.clone() }
    }

    /// The solid turned and moved by `pose`.
    #[must_use]
    pub fn transformed(&self, pose: &Pose) -> Self {
        Self { mesh: self.mesh.transformed(pose), surface: self.surface.clone() }
    }

    /// Names the body that broke for all crack faces that have no name yet.
    pub fn name_parent(&mut self, body: u32) {
        for surface in &mut self.surface {
            if let Surface::Crack { parent, .. } = surface
                && *parent == 0
            {
                *parent = body.saturating_add(1);
            }
        }
    }

    /// Enclosed volume \[m³\].
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.mesh.signed_volume()
    }

    /// Area of the crack faces \[m²\], this side only.
    #[must_use]
    pub fn crack_area(&self) -> f64 {
        let cracks = self.surface.iter().enumerate().filter(|(_, s)| s.is_crack());
        cracks
            .map(|(t, _)| {
                let [a, b, c] = self.mesh.corners(t);
                0.5 * (b - a).cross(&(c - a)).norm()
            })
            .sum()
    }
}

#[cfg(test)]
mod tests;
