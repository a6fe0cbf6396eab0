//! Binary glTF: all triangles of the default scene, each node's place applied.

use super::raw::{Extra, Raw, finite, unit};
use super::{MAX_TRIANGLES, MeshFileError, hush};
use cullet_geometry::attributes::{SurfaceMaterial, SurfaceTexture, TextureMapping, TextureWrap};
use cullet_geometry::{Mat3, Vec3};
use gltf::mesh::Mode;
use gltf::texture::WrappingMode;
use std::collections::BTreeMap;

/// Deepest chain of nodes: deeper ones are cycles.
pub(super) const MAX_DEPTH: usize = 64;

/// Most nodes walked: a node may stand under many parents only in a broken file.
const MAX_NODES: usize = 100_000;

/// Most values of all accessors that have no bytes but for some of their values: they may name any
/// count.
const MAX_BARE: usize = 3 * MAX_TRIANGLES;

/// Bytes of the file's header and of those of its two chunks.
const HEADERS: u64 = 12 + 8 + 8;

type Affine = nalgebra::Matrix4<f64>;

/// The document and the binary chunk of a file that refers to nothing outside it.
pub(super) fn open(bytes: &[u8]) -> Result<gltf::Gltf, MeshFileError> {
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
    Ok(file)
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let file = open(bytes)?;
    let blob = file.blob.as_deref().unwrap_or(&[]);
    let materials = file.materials().len();
    let (names, raw) = (BTreeMap::new(), Raw::default());
    let mut walk = Walk { blob, nodes: 0, bare: 0, materials, names, raw };
    match file.default_scene().or_else(|| file.scenes().next()) {
        Some(scene) => {
            for node in scene.nodes() {
                walk.node(&node, &Affine::identity(), 0)?;
            }
        }
        None => {
            for mesh in file.meshes() {
                walk.object(mesh.name());
                walk.mesh(&mesh, &Affine::identity())?;
            }
        }
    }
    let mut raw = walk.raw;
    raw.materials = file.materials().map(|it| material(&it, bytes)).collect();
    let bare = raw.extras.iter().any(|extra| extra.slot as usize == materials);
    if bare && !raw.materials.is_empty() {
        raw.materials.push(SurfaceMaterial::named(""));
    }
    Ok(raw)
}

fn material(found: &gltf::Material<'_>, bytes: &[u8]) -> SurfaceMaterial {
    let look = found.pbr_metallic_roughness();
    let share = |value: f32| finite(value).clamp(0.0, 1.0);
    let texture = look.base_color_texture().map(|info| {
        let image = info.texture().source();
        let name = image.name().unwrap_or_default().to_owned();
        let found = match image.source() {
            gltf::image::Source::View { view, mime_type } => {
                SurfaceTexture { name, media_type: mime_type.to_owned(), ..range(&view, bytes) }
            }
            gltf::image::Source::Uri { uri, mime_type } => {
                let within = uri.starts_with("data:");
                let name = if within { name } else { uri.to_owned() };
                let media_type = mime_type.unwrap_or_default().to_owned();
                SurfaceTexture { name, media_type, ..SurfaceTexture::default() }
            }
        };
        SurfaceTexture { mapping: mapping(&info), ..found }
    });
    SurfaceMaterial {
        name: found.name().unwrap_or_default().to_owned(),
        base_colour: look.base_color_factor().map(share),
        metallic: share(look.metallic_factor()),
        roughness: share(look.roughness_factor()),
        texture,
    }
}

/// How the texture coordinates lead into a picture.
fn mapping(info: &gltf::texture::Info<'_>) -> TextureMapping {
    let sampler = info.texture().sampler();
    let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
        WrappingMode::ClampToEdge => TextureWrap::Clamp,
        WrappingMode::MirroredRepeat => TextureWrap::Mirror,
        WrappingMode::Repeat => TextureWrap::Repeat,
    });
    let Some(moved) = info.texture_transform() else {
        return TextureMapping { wrap, ..TextureMapping::default() };
    };
    let (offset, scale) = (moved.offset().map(finite), moved.scale().map(finite));
    TextureMapping { offset, rotation: finite(moved.rotation()), scale, wrap }
}

/// The set of texture coordinates that a picture is read with.
fn coordinates(info: &gltf::texture::Info<'_>) -> u32 {
    let moved = info.texture_transform().and_then(|moved| moved.tex_coord());
    moved.unwrap_or_else(|| info.tex_coord())
}

/// Where a part of the binary chunk lies in the file; nothing where it does not.
fn range(view: &gltf::buffer::View<'_>, bytes: &[u8]) -> SurfaceTexture {
    let text = bytes.get(12..16).and_then(|length| length.try_into().ok()).map(u32::from_le_bytes);
    let chunk = HEADERS + u64::from(text.unwrap_or(0));
    let start = chunk.saturating_add(view.offset() as u64);
    let length = view.length() as u64;
    if start.saturating_add(length) > bytes.len() as u64 {
        return SurfaceTexture::default();
    }
    SurfaceTexture { offset: start, length, ..SurfaceTexture::default() }
}

struct Walk<'a> {
    blob: &'a [u8],
    nodes: usize,
    /// Values so far of accessors that have no bytes of their own.
    bare: usize,
    /// How many materials the file has; what has none is of the one after them.
    materials: usize,
    /// Names of objects, and the next number for one that is there.
    names: BTreeMap<String, u32>,
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
            self.object(node.name().or(mesh.name()));
            self.mesh(&mesh, &place)?;
        }
        for child in node.children() {
            self.node(&child, &place, depth + 1)?;
        }
        Ok(())
    }

    /// What follows is an object of that name, or of one with a number if that is taken.
    fn object(&mut self, name: Option<&str>) {
        let name = name.filter(|name| !name.trim().is_empty()).unwrap_or("object");
        let mut own = name.to_owned();
        while self.names.contains_key(&own) {
            let next = self.names.entry(name.to_owned()).or_insert(1);
            *next += 1;
            own = format!("{name}-{next}");
        }
        self.names.insert(own.clone(), 1);
        self.raw.object_names.push(own);
    }

    /// Whether what a primitive names is of a size that can be read.
    fn counted(&mut self, primitive: &gltf::Primitive<'_>) -> Result<(), MeshFileError> {
        let all = primitive.attributes().map(|(_, it)| it).chain(primitive.indices());
        for accessor in all.filter(|it| it.view().is_none() && it.sparse().is_some()) {
            self.bare = self.bare.saturating_add(accessor.count());
        }
        if self.bare > MAX_BARE {
            let count = self.bare;
            let what = format!("sparse accessors without a buffer name {count} values");
            return Err(malformed(&format!("{what}; at most {MAX_BARE} are read")));
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
            self.counted(&primitive)?;
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
            let before = self.raw.triangles.len();
            self.faces(&indices, base, count, mirrored)?;
            let triangles = &self.raw.triangles[before..];
            let slot = primitive.material().index().unwrap_or(self.materials) as u32;
            let object = (self.raw.object_names.len() as u32).saturating_sub(1);
            let plain = Extra { slot, object, ..Extra::default() };
            // What is wrong with an attribute does not make the shape wrong.
            let read = || self.extras(&primitive, place, (triangles, base), plain);
            let extras = hush::hushed(read).unwrap_or_else(|_| vec![plain; triangles.len()]);
            self.raw.extras.extend(extras);
        }
        Ok(())
    }

    /// What a primitive has beside these triangles, whose first corner is `base`.
    fn extras(
        &self,
        primitive: &gltf::Primitive<'_>,
        place: &Affine,
        (triangles, base): (&[[u32; 3]], u32),
        plain: Extra,
    ) -> Vec<Extra> {
        let reader = primitive.reader(|_| Some(self.blob));
        let material = primitive.material();
        let picture = material.pbr_metallic_roughness().base_color_texture();
        let set = picture.map_or(0, |info| coordinates(&info));
        let uv: Vec<[f32; 2]> = reader
            .read_tex_coords(set)
            .map(|pairs| pairs.into_f32().map(|[u, v]| [finite(u), 1.0 - finite(v)]).collect())
            .unwrap_or_default();
        let linear: Mat3 = place.fixed_view::<3, 3>(0, 0).into_owned();
        // Normals go by the inverse transpose; a place without volume has none.
        let turn = linear.try_inverse().map(|inverse| inverse.transpose());
        let normals: Vec<Option<[f32; 3]>> = match (turn, reader.read_normals()) {
            (Some(turn), Some(normals)) => {
                normals.map(|n| unit((turn * Vec3::from(n.map(f64::from))).into())).collect()
            }
            _ => Vec::new(),
        };
        let of = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|index| (index - base) as usize);
            let pair = |i: usize| uv.get(i).copied();
            let normal = |i: usize| normals.get(i).copied().flatten();
            let uv = pair(a).zip(pair(b)).zip(pair(c)).map(|((a, b), c)| [a, b, c]);
            let normals = normal(a).zip(normal(b)).zip(normal(c)).map(|((a, b), c)| [a, b, c]);
            Extra { uv, normals, ..plain }
        };
        triangles.iter().map(of).collect()
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

pub(super) fn malformed(reason: &str) -> MeshFileError {
    MeshFileError::Malformed { line: None, reason: reason.to_owned() }
}
