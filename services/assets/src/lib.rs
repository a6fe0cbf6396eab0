//! Mesh files to triangles: OBJ, STL, PLY, glTF, and NURBS patches as JSON. Bytes in, a mesh or a
//! typed error out.
//!
//! A mesh read here is *what the file says*: equal corners are one vertex and faces without area by
//! index are gone, but nothing is closed, turned or moved. `geometry::door` judges it afterwards.
//! OBJ and GLB files also have texture coordinates, normals, materials and named objects:
//! [`read_surface`] reads them too.

mod error;
mod glb;
mod gltf_file;
mod hush;
mod motion;
mod nurbs;
mod obj;
mod ply;
mod raw;
mod stl;
mod text;

#[cfg(test)]
mod tests;

pub use error::MeshFileError;
pub use motion::{MAX_MOTION_KEYS, MotionFileError, NodeMotion, node_motion};
pub use raw::{Beside, MAX_COORDINATE, MAX_TRIANGLES};

use cullet_geometry::attributes::SurfaceAttributes;
use cullet_geometry::{TriMesh, Vec3};
use raw::{Extra, Raw};
use std::collections::BTreeMap;

/// The formats, by the end of the file's name.
pub const FORMATS: [&str; 6] = ["obj", "stl", "ply", "glb", "gltf", "json"];

/// The corners that a file lists, in its order, used or not.
pub struct Corners {
    /// Where \[file units\].
    pub points: Vec<Vec3>,
    /// Red, green and blue of each in [0, 1]; empty where the file has none.
    pub colours: Vec<[f64; 3]>,
}

/// Reads a mesh; the format is known by `name`'s end.
///
/// # Errors
/// Where and why the bytes are no mesh of that format.
pub fn read(name: &str, bytes: &[u8]) -> Result<TriMesh, MeshFileError> {
    read_surface(name, bytes, &mut |_| None).map(|file| file.surface.mesh)
}

/// A mesh file as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The mesh with what it has beside its shape.
    pub surface: SurfaceAttributes,
    /// What of the file is left out since it is no surface, with counts, in words.
    pub left_out: Option<String>,
}

/// Reads a mesh with what it has beside its shape; `beside` gives the material libraries of an OBJ
/// file and the buffers of a glTF file. What a library says is looked at, but nothing in it makes
/// the mesh an error: without it materials have their names.
///
/// # Errors
/// As [`read`].
pub fn read_surface(
    name: &str,
    bytes: &[u8],
    beside: &mut Beside<'_>,
) -> Result<MeshFile, MeshFileError> {
    let mut read = raw(name, bytes, beside)?;
    let left_out = std::mem::take(&mut read.left_out).tell();
    let surface = match tidy(read) {
        // The reader numbered the corners anew.
        Err(MeshFileError::BadCoordinate { value, limit, .. }) if extension(name) == "obj" => {
            let corners = obj::corners(bytes).map(|raw| raw.vertices).unwrap_or_default();
            let vertex = corners.iter().position(|p| p.iter().any(is_bad)).unwrap_or(0);
            Err(MeshFileError::BadCoordinate { vertex, value, limit })
        }
        surface => surface,
    }?;
    Ok(MeshFile { surface, left_out })
}

fn is_bad(coordinate: &f64) -> bool {
    coordinate.is_nan() || coordinate.abs() > MAX_COORDINATE
}

/// Reads the corners of a mesh, with their colours.
///
/// # Errors
/// As [`read`].
pub fn corners(name: &str, bytes: &[u8]) -> Result<Corners, MeshFileError> {
    let Raw { vertices, colours, .. } = match extension(name).as_str() {
        // The reader of triangles takes corners in the order of their use.
        "obj" => obj::corners(bytes)?,
        _ => raw(name, bytes, &mut |_| None)?,
    };
    Ok(Corners { points: vertices, colours })
}

/// The name of a file in its folder.
fn base(name: &str) -> &str {
    name.rsplit_once('/').map_or(name, |(_, base)| base)
}

fn extension(name: &str) -> String {
    base(name).rsplit_once('.').map_or("", |(_, end)| end).to_lowercase()
}

/// Whether a file is glTF, binary or as text, by the end of its name: there, y is up.
#[must_use]
pub fn is_gltf(name: &str) -> bool {
    matches!(extension(name).as_str(), "glb" | "gltf")
}

/// Whether a file's name ends as those that are read.
///
/// # Errors
/// It does not.
pub fn known(name: &str) -> Result<(), MeshFileError> {
    if FORMATS.contains(&extension(name).as_str()) {
        return Ok(());
    }
    Err(MeshFileError::UnknownFormat { name: base(name).to_owned() })
}

fn raw(name: &str, bytes: &[u8], beside: &mut Beside<'_>) -> Result<Raw, MeshFileError> {
    known(name)?;
    let extension = extension(name);
    let read = || match extension.as_str() {
        "obj" => obj::read(bytes, beside),
        "stl" => stl::read(bytes),
        "ply" => ply::read(bytes),
        "json" => nurbs::read(bytes),
        _ => glb::read(bytes, beside),
    };
    // The readers are others' code, and files are anybody's: a panic of theirs is an error of the
    // file.
    hush::hushed(read).unwrap_or_else(|_| {
        let reason = "the reader gave up on these bytes".to_owned();
        Err(MeshFileError::Malformed { line: None, reason })
    })
}

/// Checks coordinates and limits, makes equal corners one, and drops triangles with two equal
/// corners.
fn tidy(raw: Raw) -> Result<SurfaceAttributes, MeshFileError> {
    if raw.triangles.len() > MAX_TRIANGLES {
        let count = raw.triangles.len();
        return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
    }
    let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut mesh = TriMesh::default();
    let mut extras: Vec<Extra> = Vec::with_capacity(raw.extras.len());
    for (face, corners) in raw.triangles.iter().enumerate() {
        let mut triangle = [0; 3];
        for (slot, &index) in triangle.iter_mut().zip(corners) {
            let count = raw.vertices.len();
            let Some(point) = raw.vertices.get(index as usize) else {
                return Err(MeshFileError::IndexOutOfRange { face, index: index.into(), count });
            };
            if let Some(&value) = point.iter().find(|x| is_bad(x)) {
                let (vertex, limit) = (index as usize, MAX_COORDINATE);
                return Err(MeshFileError::BadCoordinate { vertex, value, limit });
            }
            // Adding zero makes -0 and 0 one corner.
            let key = [point.x + 0.0, point.y + 0.0, point.z + 0.0].map(f64::to_bits);
            *slot = *known.entry(key).or_insert_with(|| {
                mesh.vertices.push(*point);
                (mesh.vertices.len() - 1) as u32
            });
        }
        let [a, b, c] = triangle;
        if a != b && b != c && c != a {
            mesh.triangles.push(triangle);
            extras.extend(raw.extras.get(face).copied());
        }
    }
    if mesh.triangles.is_empty() {
        return Err(MeshFileError::Empty);
    }
    let mut surface = SurfaceAttributes { mesh, ..SurfaceAttributes::default() };
    if extras.iter().any(|extra| extra.uv.is_some()) {
        surface.uv = extras.iter().map(|extra| extra.uv.unwrap_or_default()).collect();
    }
    if extras.iter().any(|extra| extra.normals.is_some()) {
        let flat = |t: usize| {
            let [a, b, c] = surface.mesh.corners(t);
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::z);
            [[normal.x as f32, normal.y as f32, normal.z as f32]; 3]
        };
        let normals = extras.iter().enumerate();
        surface.normals = normals.map(|(t, e)| e.normals.unwrap_or_else(|| flat(t))).collect();
    }
    if !raw.materials.is_empty() {
        surface.slots = extras.iter().map(|extra| extra.slot).collect();
        surface.materials = raw.materials;
    }
    if !raw.object_names.is_empty() {
        surface.objects = extras.iter().map(|extra| extra.object).collect();
        surface.object_names = raw.object_names;
    }
    Ok(surface)
}
