//! Cracks that end inside a body, as open meshes of their own.

use crate::error::ExportError;
use crate::names::UniqueNames;
use crate::surface::{CrackMark, ExportFace, ExportMesh};
use crate::timeline::{BodyTrack, SAME};
use cullet_geometry::{Sheet, Vec3};
use cullet_record::{RecordError, Recording};
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

/// Adds to each body its cracks, until the last moment \[s\].
pub(crate) fn add(
    tracks: &mut [BodyTrack],
    recording: &Recording,
    last: f64,
    names: &mut UniqueNames,
) -> Result<(), ExportError> {
    for cracks in recording.cracks.iter().filter(|cracks| cracks.time <= last) {
        let there = |track: &&mut BodyTrack| {
            let BodyTrack { body, birth, death, .. } = &**track;
            body.id == cracks.body && *birth <= cracks.time + SAME && cracks.time < *death
        };
        // It broke or left at once, or in a part of the run that is not exported.
        let Some(track) = tracks.iter_mut().find(there) else { continue };
        let body = cracks.body;
        let sheet =
            Sheet::try_from(cracks).map_err(|source| RecordError::Cracks { body, source })?;
        let name = names.give(&format!("{}_open_crack", track.name));
        let birth = cracks.time.max(track.birth);
        track.sheets.push(CrackSheet { name, birth, mesh: mesh(&sheet, body) });
    }
    Ok(())
}

/// A sheet as it is written. Which of its sides is seen means nothing: normals lie on one side, and
/// its materials show both.
fn mesh(sheet: &Sheet, body: u64) -> ExportMesh {
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
