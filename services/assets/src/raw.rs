//! What the readers of the formats have in common: the limits, and what a file says before it is
//! tidied.

use cullet_geometry::Vec3;
use cullet_geometry::attributes::SurfaceMaterial;
use cullet_geometry::polygon::triangulate_polygon;
use std::collections::BTreeMap;
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
    pub(crate) left_out: LeftOut,
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

/// The triangles of a polygon of these points, as places in it.
pub(crate) fn triangles_of(points: &[Vec3], polygon: &[u32]) -> Vec<[u32; 3]> {
    if polygon.len() == 3 {
        return vec![[0, 1, 2]];
    }
    let corners: Vec<Vec3> = polygon.iter().map(|&at| points[at as usize]).collect();
    triangulate_polygon(&corners)
}

/// The triangles of a strip: each corner with the two before it, every other one turned over.
pub(crate) fn triangles_of_strip(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let turned = |(k, of): (usize, &[u32])| {
        if k % 2 == 0 { [of[0], of[1], of[2]] } else { [of[0], of[2], of[1]] }
    };
    strip.windows(3).enumerate().map(turned)
}

/// How many elements of a file are left out, by kind: they are no surface.
#[derive(Default)]
pub(crate) struct LeftOut(BTreeMap<&'static str, usize>);

impl LeftOut {
    pub(crate) fn add(&mut self, kind: &'static str) {
        self.add_all(kind, 1);
    }

    pub(crate) fn add_all(&mut self, kind: &'static str, count: usize) {
        if count > 0 {
            *self.0.entry(kind).or_default() += count;
        }
    }

    /// What is left out, in words; nothing if nothing is.
    pub(crate) fn tell(&self) -> Option<String> {
        let counted = self.0.iter().map(|(kind, count)| {
            let (word, rest) =
                kind.split_once(' ').map_or((*kind, ""), |(word, rest)| (word, rest));
            let gap = if rest.is_empty() { "" } else { " " };
            format!("{count} {word}{}{gap}{rest}", if *count == 1 { "" } else { "s" })
        });
        let all: Vec<String> = counted.collect();
        let (last, others) = all.split_last()?;
        let list = match others {
            [] => last.clone(),
            _ => format!("{} and {last}", others.join(", ")),
        };
        Some(format!("{list} left out, which are no surface"))
    }
}
