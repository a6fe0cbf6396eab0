//! The crack area that direction added, and that it closed.

use super::piece::DirectedPiece;
use crate::region::triangle_area;
use cullet_geometry::inside::Nearest;
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use cullet_model::Fragment;
use rayon::prelude::*;

/// A face is one that was found if its middle is nearer to one of those than this share of the
/// diagonal of the largest fragment \[1\].
const TOGETHER: f64 = 1e-7;

/// The area of cracks that the pieces have and the fragments that were found had not, and of those
/// that these had and the pieces have not \[m²\]. A crack that was cut and joined again is neither.
pub(super) fn crack_areas(found: &[Fragment], pieces: &[DirectedPiece]) -> (f64, f64) {
    let mut cracks = TriMesh::default();
    for solid in found.iter().map(|fragment| &fragment.solid) {
        for t in new_faces(solid) {
            let first = cracks.vertices.len() as u32;
            cracks.vertices.extend(solid.mesh.corners(t));
            cracks.triangles.push([first, first + 1, first + 2]);
        }
    }
    let sizes = found.iter().map(|fragment| fragment.solid.mesh.diagonal());
    let near = TOGETHER * sizes.fold(0.0, f64::max);
    let before = cracks.area();
    let surface = Nearest::new(&cracks);
    let of = |piece: &DirectedPiece| -> (f64, f64) {
        let solid = &piece.fragment.solid;
        let (mut fresh, mut kept) = (0.0, 0.0);
        for t in new_faces(solid) {
            let middle = solid.mesh.corners(t).iter().sum::<Vec3>() / 3.0;
            let area = triangle_area(&solid.mesh.vertices, solid.mesh.triangles[t]);
            match surface.closest_within(middle, near, |_| true) {
                Some(_) => kept += area,
                None => fresh += area,
            }
        }
        (fresh, kept)
    };
    let areas: Vec<(f64, f64)> = pieces.par_iter().map(of).collect();
    let (fresh, kept) = areas.iter().fold((0.0, 0.0), |sum, area| (sum.0 + area.0, sum.1 + area.1));
    // Every crack has two faces.
    (0.5 * fresh, (0.5 * (before - kept)).max(0.0))
}

/// The faces of the cracks of this break.
fn new_faces(solid: &Solid) -> impl Iterator<Item = usize> + '_ {
    let faces = solid.surface.iter().enumerate();
    faces.filter(|(_, s)| matches!(s, Surface::Crack { parent: 0, .. })).map(|(t, _)| t)
}
