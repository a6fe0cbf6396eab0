//! Shapes by their measures, as closed meshes.

use super::format::Shape;
use cullet_geometry::shapes::{self, Detail};
use cullet_geometry::{TriMesh, Vec3};

/// The mesh of a shape about its own origin.
pub fn mesh(shape: &Shape) -> Result<TriMesh, String> {
    let detail = |segments: u32| Detail { segments, edge: None };
    let made = match shape {
        Shape::Box { size } => shapes::cuboid(Vec3::from(*size), Detail::default()),
        Shape::Sphere { radius, segments } => shapes::sphere(*radius, detail(*segments)),
        Shape::Cylinder { radius, height, segments } => {
            shapes::cylinder(*radius, *height, detail(*segments))
        }
        Shape::Cone { radius, top_radius, height, segments } => {
            shapes::cone(*radius, *top_radius, *height, detail(*segments))
        }
        Shape::Torus { ring_radius, tube_radius, segments } => {
            shapes::torus(*ring_radius, *tube_radius, detail(*segments))
        }
        Shape::Capsule { radius, length, segments } => {
            shapes::capsule(*radius, *length, detail(*segments))
        }
        Shape::Extrusion { polygon, height } => {
            shapes::extrude(polygon, *height, Detail::default())
        }
        Shape::Lathe { profile, wall: None, segments } => {
            shapes::lathe_solid(profile, detail(*segments))
        }
        Shape::Lathe { profile, wall: Some(wall), segments } => {
            shapes::lathe_shell(profile, *wall, detail(*segments))
        }
        Shape::Sheet { outline, thickness } => {
            shapes::extrude(outline, *thickness, Detail::default())
        }
        Shape::Shell { profile, thickness, segments } => {
            shapes::lathe_midline(profile, *thickness, detail(*segments))
        }
    };
    made.map_err(|error| error.to_string())
}

/// Whether a shape is convex by its kind: its corners are its one convex part.
pub(super) fn convex(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Box { .. }
            | Shape::Sphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Cone { .. }
            | Shape::Capsule { .. }
    )
}
