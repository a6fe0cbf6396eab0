//! What the readers of the formats have in common: the limits, and what a file says before it is
//! tidied.

use cullet_geometry::Vec3;
use cullet_geometry::attributes::SurfaceMaterial;
use std::sync::Arc;

/// Most triangles of one mesh: a solve needs some ten thousand; ten million would take minutes to
/// check.
pub const MAX_TRIANGLES: usize = 4_000_000;

/// Largest coordinate accepted \[file units\]: beyond it, differences of f32 files are coarser than
/// 1.
pub const MAX_COORDINATE: f64 = 1e7;

/// What a file says, before it is tidied: corners, and three indices a triangle.
#[derive(Default)]
pub(crate) struct Raw {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Red, green and blue of each corner in [0, 1]; empty where the file has none.
    pub(crate) colours: Vec<[f64; 3]>,
    /// Of each triangle; empty in formats that have no more than a shape.
    pub(crate) extras: Vec<Extra>,
    pub(crate) materials: Vec<SurfaceMaterial>,
    pub(crate) object_names: Vec<String>,
}

/// What a file says of a triangle beside its corners.
#[derive(Clone, Copy, Default)]
pub(crate) struct Extra {
    /// v upward.
    pub(crate) uv: Option<[[f32; 2]; 3]>,
    pub(crate) normals: Option<[[f32; 3]; 3]>,
    /// Place in `materials`.
    pub(crate) slot: u32,
    /// Place in `object_names`.
    pub(crate) object: u32,
}

/// Gives the bytes of a file that a mesh file names, if it may be had.
pub type Beside<'a> = dyn FnMut(&str) -> Option<Arc<Vec<u8>>> + 'a;

/// A number of a file, or zero for what is none: attributes decide nothing.
pub(crate) fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// A unit normal; nothing for a vector that has no direction.
pub(crate) fn unit(normal: [f64; 3]) -> Option<[f32; 3]> {
    let length = Vec3::from(normal).norm();
    let sound = length.is_finite() && length > 1e-12;
    sound.then(|| normal.map(|x| (x / length) as f32))
}

/// The triangles of a polygon, as a fan from its first corner.
pub(crate) fn fan(polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    for pair in polygon.windows(2).skip(1) {
        triangles.push([polygon[0], pair[0], pair[1]]);
    }
}
