//! Binary glTF: all triangles of the default scene, each node's place applied.

use super::{MAX_TRIANGLES, MeshFileError, Raw};
use cullet_geometry::Vec3;
use gltf::mesh::Mode;

/// Deepest chain of nodes: deeper ones are cycles.
const MAX_DEPTH: usize = 64;

/// Most nodes walked: a node may stand under many parents only in a broken file.
const MAX_NODES: usize = 100_000;

type Affine = nalgebra::Matrix4<f64>;

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    if let Some(need) = bytes.get(8..12).and_then(|length| length.try_into().ok()) {
        let need = u64::from(u32::from_le_bytes(need));
        if bytes.starts_with(b"glTF") && (bytes.len() as u64) < need {
            return Err(MeshFileError::Truncated { have: bytes.len() as u64, need });
        }
    }
    if !bytes.starts_with(b"glTF") {
        return Err(malformed("it does not begin with glTF"));
    }
    let file = gltf::Gltf::from_slice(bytes).map_err(|error| malformed(&error.to_string()))?;
    for buffer in file.buffers() {
        if let gltf::buffer::Source::Uri(_) = buffer.source() {
            let what = "a buffer outside the GLB file".to_owned();
            return Err(MeshFileError::Unsupported { what });
        }
        let have = file.blob.as_ref().map_or(0, Vec::len) as u64;
        if have < buffer.length() as u64 {
            return Err(MeshFileError::Truncated { have, need: buffer.length() as u64 });
        }
    }
    let blob = file.blob.as_deref().unwrap_or(&[]);
    let mut walk = Walk {
        blob,
        nodes: 0,
        raw: Raw { vertices: Vec::new(), triangles: Vec::new(), colours: Vec::new() },
    };
    match file.default_scene().or_else(|| file.scenes().next()) {
        Some(scene) => {
            for node in scene.nodes() {
                walk.node(&node, &Affine::identity(), 0)?;
            }
        }
        None => {
            for mesh in file.meshes() {
                walk.mesh(&mesh, &Affine::identity())?;
            }
        }
    }
    Ok(walk.raw)
}

struct Walk<'a> {
    blob: &'a [u8],
    nodes: usize,
    raw: Raw,
}

impl Walk<'_> {
    fn node(
        &mut self,
        node: &gltf::Node<'_>,
        parent: &Affine,
        depth: usize,
    ) -> Result<(), MeshFileError> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(malformed(&format!("the tree of nodes is deeper than {MAX_DEPTH}")));
        }
        let local = node.transform().matrix();
        let place = parent * Affine::from_fn(|row, column| f64::from(local[column][row]));
        if let Some(mesh) = node.mesh() {
            self.mesh(&mesh, &place)?;
        }
        for child in node.children() {
            self.node(&child, &place, depth + 1)?;
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, place: &Affine) -> Result<(), MeshFileError> {
        let mirrored = place.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        for primitive in mesh.primitives() {
            if !matches!(primitive.mode(), Mode::Triangles) {
                let what = format!("a primitive of {:?}", primitive.mode());
                return Err(MeshFileError::Unsupported { what });
            }
            let reader = primitive.reader(|buffer| match buffer.source() {
                gltf::buffer::Source::Bin => Some(self.blob),
                gltf::buffer::Source::Uri(_) => None,
            });
            let Some(positions) = reader.read_positions() else {
                return Err(malformed("a primitive has no positions that can be read"));
            };
            let base = self.raw.vertices.len() as u32;
            self.raw.vertices.extend(positions.map(|p| {
                let point = nalgebra::Point3::new(p[0].into(), p[1].into(), p[2].into());
                let moved: Vec3 = place.transform_point(&point).coords;
                moved
            }));
            let count = self.raw.vertices.len() as u32 - base;
            if let Some(colours) = reader.read_colors(0) {
                let wide = |c: [f32; 3]| c.map(|value| f64::from(value).clamp(0.0, 1.0));
                self.raw.colours.extend(colours.into_rgb_f32().map(wide));
            }
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None if primitive.indices().is_some() => {
                    return Err(malformed("a primitive has indices that cannot be read"));
                }
                None => (0..count).collect(),
            };
            self.faces(&indices, base, count, mirrored)?;
        }
        Ok(())
    }

    fn faces(
        &mut self,
        indices: &[u32],
        base: u32,
        count: u32,
        mirrored: bool,
    ) -> Result<(), MeshFileError> {
        for (face, corners) in indices.chunks_exact(3).enumerate() {
            if let Some(&index) = corners.iter().find(|index| **index >= count) {
                let (index, count) = (index.into(), count as usize);
                return Err(MeshFileError::IndexOutOfRange { face, index, count });
            }
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(|index| base + index);
            self.raw.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        if self.raw.triangles.len() > MAX_TRIANGLES {
            let count = self.raw.triangles.len();
            return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
        }
        Ok(())
    }
}

fn malformed(reason: &str) -> MeshFileError {
    MeshFileError::Malformed { line: None, reason: reason.to_owned() }
}
