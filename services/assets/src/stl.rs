//! STL, text and binary.

use super::raw::Raw;
use super::{MAX_TRIANGLES, MeshFileError};
use cullet_geometry::Vec3;
use std::io::Cursor;

/// Bytes before the triangles of a binary file.
const HEADER: usize = 84;

/// Bytes of a triangle of a binary file.
const RECORD: u64 = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    if !is_text(bytes) {
        let Some(count) = bytes.get(80..HEADER).and_then(|count| count.try_into().ok()) else {
            let need = HEADER as u64;
            return Err(MeshFileError::Truncated { have: bytes.len() as u64, need });
        };
        let count = u32::from_le_bytes(count);
        let need = HEADER as u64 + u64::from(count) * RECORD;
        if (bytes.len() as u64) < need {
            return Err(MeshFileError::Truncated { have: bytes.len() as u64, need });
        }
    }
    let mut cursor = Cursor::new(bytes);
    let malformed = |error: std::io::Error| {
        let reason = match error.kind() {
            std::io::ErrorKind::UnexpectedEof => "the file ends early".to_owned(),
            _ => error.to_string(),
        };
        MeshFileError::Malformed { line: None, reason }
    };
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(malformed)?;
    let mut raw = Raw::default();
    for triangle in reader {
        let triangle = triangle.map_err(malformed)?;
        if raw.triangles.len() >= MAX_TRIANGLES {
            let count = raw.triangles.len() + 1;
            return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
        }
        let base = raw.vertices.len() as u32;
        raw.vertices.extend(
            triangle.vertices.iter().map(|v| Vec3::new(v[0].into(), v[1].into(), v[2].into())),
        );
        raw.triangles.push([base, base + 1, base + 2]);
    }
    Ok(raw)
}

/// Whether the reader will take the bytes as text: it goes by the first word.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(0);
    bytes[start..].get(..6).is_some_and(|word| word == b"solid ")
        || bytes[start..].starts_with(b"solid\n")
        || bytes[start..].starts_with(b"solid\r")
}
