//! Cracks that end inside a body, as open meshes of their own.

use crate::surface::{CrackMark, ExportFace, ExportMesh};
use cullet_geometry::{Sheet, Vec3};
use std::sync::Arc;

/// The cracks of a body that were recorded at one time.
#[derive(Clone, Debug)]
pub(crate) struct CrackSheet {
    /// A name that is an identifier and that nothing else has.
    pub(crate) name: String,
    /// When they appear \[s\].
    pub(crate) birth: f64,
    /// In the body's frame \[m\].
    pub(crate) mesh: ExportMesh,
}

/// A sheet as it is written. Which of its sides is seen means nothing: normals lie on one side, and
/// its materials show both.
pub(crate) fn sheet_mesh(sheet: &Sheet, body: u64) -> ExportMesh {
    let mut areas = vec![Vec3::zeros(); sheet.mesh.vertices.len()];
    for (t, corners) in sheet.mesh.triangles.iter().enumerate() {
        let [a, b, c] = sheet.mesh.corners(t);
        corners.iter().for_each(|&v| areas[v as usize] += (b - a).cross(&(c - a)));
    }
    let normal = |v: u32| areas[v as usize].try_normalize(1e-300).unwrap_or_else(Vec3::z);
    let parent = i64::try_from(body).unwrap_or(-1);
    let face = |&corners: &[u32; 3]| {
        let damage_time = corners.map(|v| sheet.damage_time[v as usize]);
        let front_speed = corners.map(|v| sheet.front_speed[v as usize]);
        let crack = Some(CrackMark { damage_time, front_speed, parent });
        ExportFace { corners, normals: corners.map(normal), uv: None, crack, slot: None }
    };
    ExportMesh {
        vertices: sheet.mesh.vertices.clone(),
        faces: sheet.mesh.triangles.iter().map(face).collect(),
        diagonal: sheet.mesh.diagonal(),
        materials: Arc::default(),
    }
}
