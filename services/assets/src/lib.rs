//! Mesh files to triangles: OBJ, STL, PLY, GLB. Bytes in, a mesh or a typed error out.
//!
//! A mesh read here is *what the file says*: equal corners are one vertex and faces without area by
//! index are gone, but nothing is closed, turned or moved. `geometry::door` judges it afterwards.

mod glb;
mod hush;
mod obj;
mod ply;
mod stl;

#[cfg(test)]
mod tests;

use cullet_geometry::{TriMesh, Vec3};
use std::collections::BTreeMap;

/// Most triangles of one mesh: a solve needs some ten thousand; ten million would take minutes to
/// check.
pub const MAX_TRIANGLES: usize = 4_000_000;

/// Largest coordinate accepted \[file units\]: beyond it, differences of f32 files are coarser than
/// 1.
pub const MAX_COORDINATE: f64 = 1e7;

/// The formats, by the end of the file's name.
pub const FORMATS: [&str; 4] = ["obj", "stl", "ply", "glb"];

/// Why bytes are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFileError {
    /// The name's end is no format that is read here.
    #[error("\"{name}\" is no mesh that is read here: those end in .obj, .stl, .ply, .glb")]
    UnknownFormat {
        /// The file's name.
        name: String,
    },
    /// The text or the bytes break the format.
    #[error("{}{reason}", .line.map(|line| format!("line {line}: ")).unwrap_or_default())]
    Malformed {
        /// Line of a text format, from 1.
        line: Option<usize>,
        /// What the reader said.
        reason: String,
    },
    /// The data ends before what its header promises.
    #[error("the file ends early: {have} of {need} bytes")]
    Truncated {
        /// Bytes there.
        have: u64,
        /// Bytes promised.
        need: u64,
    },
    /// A face names a corner that is not there.
    #[error("face {face} names corner {index}, but there are {count}")]
    IndexOutOfRange {
        /// Which face, from 0.
        face: usize,
        /// Which corner.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// A coordinate is not finite or too large.
    #[error("corner {vertex} has the coordinate {value}; it must be finite and within ±{limit:e}")]
    BadCoordinate {
        /// Which corner, from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
        /// The bound.
        limit: f64,
    },
    /// There is not one triangle.
    #[error("the file has no triangles")]
    Empty,
    /// More triangles than accepted.
    #[error("the file has {count} triangles; at most {limit} are read")]
    TooLarge {
        /// How many there are.
        count: usize,
        /// The bound.
        limit: usize,
    },
    /// Something of the format that is not read here.
    #[error("{what} is not read here")]
    Unsupported {
        /// What the value is.
        what: String,
    },
}

/// What a file says, before it is tidied: corners, and three indices a triangle.
pub(crate) struct Raw {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Red, green and blue of each corner in [0, 1]; empty where the file has none.
    colours: Vec<[f64; 3]>,
}

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
    let mesh = tidy(raw(name, bytes)?);
    match mesh {
        // The reader numbered the corners anew.
        Err(MeshFileError::BadCoordinate { value, limit, .. }) if extension(name) == "obj" => {
            let corners = obj::corners(bytes).vertices;
            let vertex = corners.iter().position(|p| p.iter().any(is_bad)).unwrap_or(0);
            Err(MeshFileError::BadCoordinate { vertex, value, limit })
        }
        mesh => mesh,
    }
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
        "obj" => obj::corners(bytes),
        _ => raw(name, bytes)?,
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

fn raw(name: &str, bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let extension = extension(name);
    let read: fn(&[u8]) -> Result<Raw, MeshFileError> = match extension.as_str() {
        "obj" => obj::read,
        "stl" => stl::read,
        "ply" => ply::read,
        "glb" => glb::read,
        _ => return Err(MeshFileError::UnknownFormat { name: base(name).to_owned() }),
    };
    // The readers are others' code, and files are anybody's: a panic of theirs is an error of the
    // file.
    hush::hushed(|| read(bytes)).unwrap_or_else(|_| {
        let reason = "the reader gave up on these bytes".to_owned();
        Err(MeshFileError::Malformed { line: None, reason })
    })
}

/// Checks coordinates and limits, makes equal corners one, and drops triangles with two equal
/// corners.
fn tidy(raw: Raw) -> Result<TriMesh, MeshFileError> {
    if raw.triangles.len() > MAX_TRIANGLES {
        let count = raw.triangles.len();
        return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
    }
    let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut mesh = TriMesh::default();
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
        }
    }
    if mesh.triangles.is_empty() {
        return Err(MeshFileError::Empty);
    }
    Ok(mesh)
}

/// The triangles of a polygon, as a fan from its first corner.
pub(crate) fn fan(polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    for pair in polygon.windows(2).skip(1) {
        triangles.push([polygon[0], pair[0], pair[1]]);
    }
}
