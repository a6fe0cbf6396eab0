//! Solids of walls against closed forms; what folds or is torn is refused.

use super::thicken;
use crate::boolean::Exact;
use crate::math::Vec3;
use crate::mesh::{Solid, TriMesh};
use crate::remesh::SurfaceError;
use crate::shapes::{Detail, sphere};

fn thickened(mesh: &TriMesh, thickness: f64) -> Result<TriMesh, SurfaceError> {
    thicken(&mesh.vertices, &mesh.triangles, &vec![thickness; mesh.vertices.len()])
}

/// A strip of two squares side by side, folded at the edge between them by 90°.
fn angle_strip() -> TriMesh {
    let at = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let vertices = vec![
        at(0.0, 0.0, 0.0),
        at(1.0, 0.0, 0.0),
        at(1.0, 1.0, 0.0),
        at(0.0, 1.0, 0.0),
        at(1.0, 0.0, 1.0),
        at(1.0, 1.0, 1.0),
    ];
    TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]] }
}

#[test]
fn a_square_becomes_a_plate_and_an_angle_is_mitred() {
    let mut flat = angle_strip();
    flat.triangles.truncate(2);
    let flat = flat.submesh(&[0, 1]);
    let plate = thickened(&flat, 0.1).unwrap();
    assert!(plate.is_closed());
    assert!((plate.signed_volume() - 0.1).abs() < 1e-15);
    // Two legs, a square corner outside and a square notch inside.
    let angle = thickened(&angle_strip(), 0.1).unwrap();
    assert!(angle.is_closed());
    assert!((angle.signed_volume() - 0.2).abs() < 1e-12, "{}", angle.signed_volume());
    assert!(!Exact::new(&Solid::outer(angle)).unwrap().crosses_itself().unwrap());
}

#[test]
fn a_closed_surface_becomes_two_shells_whichever_way_it_faces() {
    let ball = sphere(1.0, Detail { segments: 60, edge: None }).unwrap();
    for surface in [ball.clone(), ball.flipped()] {
        let hollow = thickened(&surface, 0.1).unwrap();
        assert!(hollow.is_closed());
        assert_eq!(hollow.components().len(), 2);
        let shells = 4.0 / 3.0 * std::f64::consts::PI * (1.05_f64.powi(3) - 0.95_f64.powi(3));
        assert!((hollow.signed_volume() / shells - 1.0).abs() < 0.01);
        let volumes = hollow.components().into_iter().map(|c| hollow.submesh(&c).signed_volume());
        assert!(volumes.clone().any(|v| v > 4.5) && volumes.clone().any(|v| v < -3.2));
    }
}

#[test]
fn walls_that_cross_are_refused_with_their_place() {
    let ball = sphere(1.0, Detail { segments: 30, edge: None }).unwrap();
    assert!(thickened(&ball, 0.9).is_ok());
    let crossed = thickened(&ball, 1.2).unwrap_err();
    assert!(matches!(crossed, SurfaceError::Walls { bend, .. } if (0.55..0.7).contains(&bend)));
    assert!(crossed.to_string().contains("at most 0.5"), "{crossed}");
    let mut torn = angle_strip();
    torn.triangles[3].swap(0, 1);
    assert!(matches!(thickened(&torn, 0.1), Err(SurfaceError::Edge { .. })));
    let mut crowded = angle_strip();
    crowded.vertices.push(Vec3::new(1.5, 0.0, 0.0));
    crowded.triangles.push([1, 2, 6]);
    assert!(matches!(thickened(&crowded, 0.1), Err(SurfaceError::Edge { .. })));
}
