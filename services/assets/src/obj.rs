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
    let mut raw = Raw { vertices: Vec::new(), triangles: Vec::new(), colours: Vec::new() };
    for model in models {
        let base = raw.vertices.len() as u32;
        let points = model.mesh.positions.chunks_exact(3);
        raw.vertices.extend(points.map(|p| Vec3::new(p[0].into(), p[1].into(), p[2].into())));
        let corners = model.mesh.indices.chunks_exact(3);
        raw.triangles.extend(corners.map(|t| [base + t[0], base + t[1], base + t[2]]));
    }
    Ok(raw)
}

/// The corners in the order of their lines: `v x y z`, or with `r g b` behind.
pub(super) fn corners(bytes: &[u8]) -> Raw {
    let mut raw = Raw { vertices: Vec::new(), triangles: Vec::new(), colours: Vec::new() };
    for line in bytes.split(|&byte| byte == b'\n') {
        let words = String::from_utf8_lossy(line);
        let mut words = words.split_whitespace();
        if words.next() != Some("v") {
            continue;
        }
        let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
        if let [x, y, z, ..] = numbers[..] {
            raw.vertices.push(Vec3::new(x, y, z));
        }
        if let [.., r, g, b] = numbers[..]
            && numbers.len() >= 6
        {
            raw.colours.push([r, g, b].map(|value| value.clamp(0.0, 1.0)));
        }
    }
    raw
}
