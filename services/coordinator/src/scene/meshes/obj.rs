//! Wavefront OBJ.

use super::{MeshFileError, Raw};
use cullet_geometry::Vec3;
use std::io::{BufRead, Read};

/// Bytes that know how many lines were taken: the reader itself does not say where it failed.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Read for Lines<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = into.len().min(self.bytes.len() - self.at);
        into[..count].copy_from_slice(&self.bytes[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(&self.bytes[self.at..])
    }

    fn consume(&mut self, count: usize) {
        self.at = (self.at + count).min(self.bytes.len());
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let mut lines = Lines { bytes, at: 0 };
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let loaded = tobj::load_obj_buf(&mut lines, &options, |_| Ok(Default::default()));
    let (models, _) = loaded.map_err(|error| {
        let taken = bytes[..lines.at].iter().filter(|&&byte| byte == b'\n').count();
        MeshFileError::Malformed { line: Some(taken.max(1)), reason: error.to_string() }
    })?;
    let mut raw = Raw { vertices: Vec::new(), triangles: Vec::new() };
    for model in models {
        let base = raw.vertices.len() as u32;
        let points = model.mesh.positions.chunks_exact(3);
        raw.vertices.extend(points.map(|p| Vec3::new(p[0].into(), p[1].into(), p[2].into())));
        let corners = model.mesh.indices.chunks_exact(3);
        raw.triangles.extend(corners.map(|t| [base + t[0], base + t[1], base + t[2]]));
    }
    Ok(raw)
}
