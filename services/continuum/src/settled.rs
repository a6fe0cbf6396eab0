//! Pieces at rest as rigid bodies of their shape.

use crate::pieces::patience;
use crate::pieces::{GONE, PieceRecord};
use cullet_geometry::midsurface::thicken;
use cullet_geometry::{Solid, TriMesh, Vec3};
use cullet_model::{Refusal, SettledPiece};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Least volume of a rigid body over that of the box around it \[1\].
const LEAST_FILL: f64 = 1e-9;

/// Most pieces that a window offers as rigid bodies: others wait for the next.
pub const MOST_SETTLED: usize = 256;

/// Takes pieces out that have become rigid bodies.
///
/// # Errors
/// If one of them is unknown, or not at rest, or has become one before.
pub fn retire(
    pieces: &mut [PieceRecord],
    numbers: &[u32],
    world_step: f64,
    family: &'static str,
) -> Result<(), Refusal> {
    let patience = patience(world_step);
    for number in numbers {
        let rests = |piece: &&mut PieceRecord| {
            piece.number == *number && piece.still >= patience && !piece.is_gone()
        };
        let Some(piece) = pieces.iter_mut().find(rests) else {
            let lack = format!("piece {number} shall be a rigid body, but it is not one at rest");
            return Err(Refusal::Unfit { solver: family, lack });
        };
        piece.still = GONE;
    }
    Ok(())
}

/// The rigid body of a piece: its triangles between places \[m\] of which it may use some, the
/// thickness of its wall \[m\] (0 where the triangles close), and its mass \[kg\]. `None` where
/// they bound no volume, as where the walls of a crumpled sheet cross.
#[must_use]
pub fn settled(
    number: u32,
    triangles: &[[u32; 3]],
    places: &[Vec3],
    thickness: f64,
    mass: f64,
) -> Option<SettledPiece> {
    let mut renumbered = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut own = |v: u32| {
        *renumbered.entry(v).or_insert_with(|| {
            vertices.push(places[v as usize]);
            vertices.len() as u32 - 1
        })
    };
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut own)).collect();
    let mut mesh = match thickness > 0.0 {
        true => thicken(&vertices, &triangles, &vec![thickness; vertices.len()]).ok()?,
        false => TriMesh { vertices, triangles },
    };
    let properties = mesh.mass_properties();
    let first = mesh.vertices.first()?;
    let (low, high) = mesh.vertices.iter().fold((*first, *first), |b, x| (b.0.inf(x), b.1.sup(x)));
    let box_volume = (high - low).product();
    let filled = properties.volume > LEAST_FILL * box_volume && properties.volume > 0.0;
    if !filled || !mesh.open_edges().is_empty() {
        return None;
    }
    mesh.vertices.iter_mut().for_each(|v| *v -= properties.centroid);
    let solid = Arc::new(Solid::outer(mesh));
    Some(SettledPiece { number, solid, place: properties.centroid, mass })
}

#[cfg(test)]
mod tests {
    use super::{retire, settled};
    use crate::pieces::patience;
    use crate::pieces::{GONE, PieceRecord, gone_points};
    use cullet_geometry::Vec3;

    #[test]
    fn only_what_is_at_rest_becomes_a_rigid_body_and_only_once() {
        let rests = patience(1e-3);
        let piece = |number, still| PieceRecord { number, still, ..PieceRecord::default() };
        let mut pieces = vec![piece(0, rests), piece(3, rests - 1), piece(1, rests)];
        let refused = |pieces: &mut [PieceRecord], number| {
            retire(pieces, &[number], 1e-3, "family").unwrap_err().to_string()
        };
        assert!(refused(&mut pieces, 2).contains("piece 2"));
        assert!(refused(&mut pieces, 3).contains("not one at rest"));
        retire(&mut pieces, &[1], 1e-3, "family").unwrap();
        assert_eq!(pieces[2].still, GONE);
        assert!(refused(&mut pieces, 1).contains("not one at rest"));
        assert_eq!(gone_points(&[1, 0, 3, 1], &pieces), [true, false, false, true]);
    }

    #[test]
    fn a_sheet_at_rest_is_a_plate_about_its_centre() {
        let places = [
            Vec3::new(9.0, 9.0, 9.0),
            Vec3::new(1.0, 0.0, 2.0),
            Vec3::new(3.0, 0.0, 2.0),
            Vec3::new(3.0, 1.0, 2.0),
            Vec3::new(1.0, 1.0, 2.0),
        ];
        let piece = settled(7, &[[1, 2, 3], [1, 3, 4]], &places, 0.1, 0.5).unwrap();
        assert_eq!((piece.number, piece.mass), (7, 0.5));
        assert!((piece.place - Vec3::new(2.0, 0.5, 2.0)).norm() < 1e-12, "{}", piece.place);
        let properties = piece.solid.mesh.mass_properties();
        assert!((properties.volume - 0.2).abs() < 1e-12, "{}", properties.volume);
        assert!(properties.centroid.norm() < 1e-12);
        // What is open and has no thickness bounds nothing.
        assert!(settled(7, &[[1, 2, 3], [1, 3, 4]], &places, 0.0, 0.5).is_none());
    }
}
