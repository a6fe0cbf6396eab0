//! Remeshed surfaces.

use super::passes::least_angle;
use crate::mesh::TriMesh;

/// How even the triangles of a surface are.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshQuality {
    /// Least and greatest edge over the spacing \[1\].
    pub(crate) edges: [f64; 2],
    /// Least angle of a triangle \[degrees\].
    pub(crate) angle: f64,
    /// Least and greatest valence inside.
    pub(crate) inside: [usize; 2],
    /// Least and greatest valence on the boundary.
    pub(crate) border: [usize; 2],
    /// Greatest sum of a triangle's interior valences.
    pub(crate) sum: usize,
    /// Share of interior vertices of valence 6 \[1\].
    pub(crate) regular: f64,
}

impl MeshQuality {
    pub(crate) fn of(mesh: &TriMesh, spacing: f64) -> Self {
        let mut valence = vec![0; mesh.vertices.len()];
        let mut is_border = vec![false; mesh.vertices.len()];
        let mut quality =
            Self { edges: [f64::MAX, 0.0], inside: [99, 0], border: [99, 0], ..Self::default() };
        for edge in mesh.edges() {
            let ends = [edge.from, edge.to].map(|v| v as usize);
            let length = (mesh.vertices[ends[0]] - mesh.vertices[ends[1]]).norm() / spacing;
            quality.edges = [quality.edges[0].min(length), quality.edges[1].max(length)];
            ends.iter().for_each(|&v| valence[v] += 1);
            if edge.forward + edge.backward == 1 {
                ends.iter().for_each(|&v| is_border[v] = true);
            }
        }
        let mut regular = [0, 0];
        for (v, &count) in valence.iter().enumerate() {
            let range = if is_border[v] { &mut quality.border } else { &mut quality.inside };
            *range = [range[0].min(count), range[1].max(count)];
            if !is_border[v] {
                regular = [regular[0] + usize::from(count == 6), regular[1] + 1];
            }
        }
        quality.regular = regular[0] as f64 / f64::from(regular[1].max(1) as u32);
        let angles = (0..mesh.triangles.len()).map(|t| least_angle(&mesh.corners(t)));
        quality.angle = angles.fold(f64::MAX, f64::min).to_degrees();
        let inner = mesh.triangles.iter().map(|t| t.map(|v| v as usize));
        let inner = inner.filter(|t| t.iter().all(|&v| !is_border[v]));
        quality.sum = inner.map(|t| t.iter().map(|&v| valence[v]).sum()).max().unwrap_or(0);
        quality
    }
}

#[test]
fn probe() {
    use super::curved::CurvedMesh;
    use crate::shapes::{Detail, lathe_shell};
    let pot = lathe_shell(&crate::midsurface::tests::bottle_profile(), 0.003, Detail { segments: 64, edge: None }).unwrap();
    for k in 0..8 {
        let fine = CurvedMesh::new(&pot).refined(0.0015 * f64::from(1u32 << (7 - k)), 1_000_000).mesh;
        let longest = fine.edges().iter().map(|e| (fine.vertices[e.from as usize] - fine.vertices[e.to as usize]).norm()).fold(0.0, f64::max);
        eprintln!("{k} {} longest {longest} area {}", fine.triangles.len(), fine.area());
    }
}
