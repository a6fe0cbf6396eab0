//! glTF, binary or as text: all triangles of the default scene, where it shows them: each node's
//! place, shape keys, bones and instances are applied as the file has them at rest.

use super::gltf_file::{GltfFile, malformed};
use super::raw::{Extra, Raw, finite, triangles_of_strip, unit};
use super::{Beside, MAX_TRIANGLES, MeshFileError, hush};
use cullet_geometry::attributes::{SurfaceMaterial, SurfaceTexture, TextureMapping, TextureWrap};
use cullet_geometry::{Mat3, Quat, Vec3};
use gltf::mesh::Mode;
use gltf::texture::WrappingMode;
use nalgebra::{Matrix4, Point3, Quaternion};
use std::collections::BTreeMap;

/// Deepest chain of nodes: deeper ones are cycles.
pub(super) const MAX_DEPTH: usize = 64;

/// Most nodes walked: a node may stand under many parents only in a broken file.
const MAX_NODES: usize = 100_000;

/// Most corners of all primitives, as often as they are placed.
const MAX_CORNERS: usize = 3 * MAX_TRIANGLES;

/// How instances of a node are placed.
const INSTANCES: &str = "EXT_mesh_gpu_instancing";

type Affine = Matrix4<f64>;

pub(super) fn read(bytes: &[u8], beside: &mut Beside<'_>) -> Result<Raw, MeshFileError> {
    let file = GltfFile::open(bytes, beside)?;
    let materials = file.document.materials().len();
    let places = NodePlaces::of(&file.document)?;
    let (names, raw) = (BTreeMap::new(), Raw::default());
    let mut walk = Walk { file: &file, places, nodes: 0, materials, names, raw };
    match file.document.default_scene().or_else(|| file.document.scenes().next()) {
        Some(scene) => {
            for node in scene.nodes() {
                walk.node(&node, 0)?;
            }
        }
        None => {
            for mesh in file.document.meshes() {
                walk.check_count(&mesh, 1)?;
                walk.object(mesh.name());
                walk.mesh(&mesh, &Placing { own: Affine::identity(), weights: None, bones: None })?;
            }
        }
    }
    let mut raw = walk.raw;
    raw.materials = file.document.materials().map(|it| material(&it, &file, bytes)).collect();
    let bare = raw.extras.iter().any(|extra| extra.slot as usize == materials);
    if bare && !raw.materials.is_empty() {
        raw.materials.push(SurfaceMaterial::named(""));
    }
    Ok(raw)
}

/// Where each node is in the scene, by its number.
struct NodePlaces(Vec<Affine>);

impl NodePlaces {
    fn of(document: &gltf::Document) -> Result<Self, MeshFileError> {
        let nodes: Vec<gltf::Node<'_>> = document.nodes().collect();
        let mut above: Vec<Option<usize>> = vec![None; nodes.len()];
        for node in &nodes {
            for child in node.children() {
                above[child.index()] = Some(node.index());
            }
        }
        let place = |node: &gltf::Node<'_>| {
            let mut place = local(node);
            let (mut at, mut depth) = (above[node.index()], 0);
            while let Some(parent) = at {
                depth += 1;
                if depth > MAX_DEPTH {
                    return Err(too_deep());
                }
                place = local(&nodes[parent]) * place;
                at = above[parent];
            }
            Ok(place)
        };
        nodes.iter().map(place).collect::<Result<_, _>>().map(Self)
    }
}

fn local(node: &gltf::Node<'_>) -> Affine {
    let matrix = node.transform().matrix();
    Affine::from_fn(|row, column| f64::from(matrix[column][row]))
}

fn too_deep() -> MeshFileError {
    malformed(&format!("the tree of nodes is deeper than {MAX_DEPTH}"))
}

/// How the mesh of a node comes into the scene.
struct Placing {
    /// The node's place; that of a mesh with bones is not used (glTF 2.0, 3.7.3.3).
    own: Affine,
    /// Of shape keys, where the node has its own.
    weights: Option<Vec<f64>>,
    /// For each joint, from the mesh as it is written into the scene.
    bones: Option<Vec<Affine>>,
}

/// What places each corner of a primitive in the scene.
enum CornerPlaces {
    One(Affine),
    Each(Vec<Affine>),
}

impl CornerPlaces {
    fn at(&self, corner: usize) -> &Affine {
        match self {
            Self::One(place) => place,
            Self::Each(places) => &places[corner],
        }
    }

    /// How many corners are placed.
    fn count(&self) -> usize {
        match self {
            Self::One(_) => usize::MAX,
            Self::Each(places) => places.len(),
        }
    }
}

fn material(found: &gltf::Material<'_>, file: &GltfFile, bytes: &[u8]) -> SurfaceMaterial {
    let look = found.pbr_metallic_roughness();
    let share = |value: f32| finite(value).clamp(0.0, 1.0);
    let texture = look.base_color_texture().map(|info| {
        let image = info.texture().source();
        let name = image.name().unwrap_or_default().to_owned();
        let found = match image.source() {
            gltf::image::Source::View { view, mime_type } => SurfaceTexture {
                name,
                media_type: mime_type.to_owned(),
                ..range(&view, file, bytes)
            },
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
fn range(view: &gltf::buffer::View<'_>, file: &GltfFile, bytes: &[u8]) -> SurfaceTexture {
    let is_in_chunk = matches!(view.buffer().source(), gltf::buffer::Source::Bin);
    let Some(chunk) = file.chunk.filter(|_| is_in_chunk) else { return SurfaceTexture::default() };
    let start = chunk.saturating_add(view.offset() as u64);
    let length = view.length() as u64;
    if start.saturating_add(length) > bytes.len() as u64 {
        return SurfaceTexture::default();
    }
    SurfaceTexture { offset: start, length, ..SurfaceTexture::default() }
}

struct Walk<'a> {
    file: &'a GltfFile,
    places: NodePlaces,
    nodes: usize,
    /// How many materials the file has; what has none is of the one after them.
    materials: usize,
    /// Names of objects, and the next number for one that is there.
    names: BTreeMap<String, u32>,
    raw: Raw,
}

impl Walk<'_> {
    fn node(&mut self, node: &gltf::Node<'_>, depth: usize) -> Result<(), MeshFileError> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(too_deep());
        }
        if let Some(mesh) = node.mesh() {
            let weights = node.weights().map(|all| all.iter().map(|&w| w.into()).collect());
            let bones = node.skin().map(|skin| self.bones(&skin)).transpose()?;
            let mut placing = Placing { own: Affine::identity(), weights, bones };
            let instances = self.instances(node)?;
            self.check_count(&mesh, instances.len())?;
            for instance in instances {
                self.object(node.name().or(mesh.name()));
                placing.own = self.places.0[node.index()] * instance;
                self.mesh(&mesh, &placing)?;
            }
        }
        for child in node.children() {
            self.node(&child, depth + 1)?;
        }
        Ok(())
    }

    /// The joints of a skin: each leads from the mesh as it is written to where the joint is.
    fn bones(&self, skin: &gltf::Skin<'_>) -> Result<Vec<Affine>, MeshFileError> {
        let unread = || malformed("a skin has matrices that cannot be read");
        let inverse: Vec<Affine> = match skin.inverse_bind_matrices() {
            None => Vec::new(),
            Some(_) => {
                let reader = skin.reader(|buffer| self.file.bytes(&buffer));
                let read = reader.read_inverse_bind_matrices().ok_or_else(unread)?;
                let wide = |m: [[f32; 4]; 4]| Affine::from_fn(|row, column| m[column][row].into());
                read.map(wide).collect()
            }
        };
        let unmoved = Affine::identity();
        let joints = skin.joints().enumerate();
        let bone = |(k, joint): (usize, gltf::Node<'_>)| {
            self.places.0[joint.index()] * inverse.get(k).unwrap_or(&unmoved)
        };
        Ok(joints.map(bone).collect())
    }

    /// Where the instances of a node are in its own frame; one where it has no such extension.
    fn instances(&self, node: &gltf::Node<'_>) -> Result<Vec<Affine>, MeshFileError> {
        let Some(extension) = node.extension_value(INSTANCES) else {
            return Ok(vec![Affine::identity()]);
        };
        let unread = || malformed(&format!("the instances of a node ({INSTANCES}) cannot be read"));
        let accessor = |name: &str| {
            let number = extension.get("attributes")?.get(name)?.as_u64()?;
            self.file.document.accessors().nth(usize::try_from(number).ok()?)
        };
        let places =
            accessor("TRANSLATION").map(|it| self.file.vectors::<3>(&it).ok_or_else(unread));
        let turns = accessor("ROTATION").map(|it| self.file.vectors::<4>(&it).ok_or_else(unread));
        let scales = accessor("SCALE").map(|it| self.file.vectors::<3>(&it).ok_or_else(unread));
        let (places, turns, scales) =
            (places.transpose()?, turns.transpose()?, scales.transpose()?);
        let counts = [
            places.as_ref().map(Vec::len),
            turns.as_ref().map(Vec::len),
            scales.as_ref().map(Vec::len),
        ];
        let count = counts.into_iter().flatten().next().ok_or_else(unread)?;
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(unread());
        }
        let instance = |k: usize| {
            let place = places.as_ref().map_or([0.0; 3], |all| all[k]);
            let [x, y, z, w] = turns.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[k]);
            let scale = scales.as_ref().map_or([1.0; 3], |all| all[k]);
            let turn = Quat::new_normalize(Quaternion::new(w, x, y, z)).to_homogeneous();
            Affine::new_translation(&Vec3::from(place))
                * turn
                * Affine::new_nonuniform_scaling(&Vec3::from(scale))
        };
        Ok((0..count).map(instance).collect())
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

    /// Refuses more corners than can be held, before they are made.
    fn check_count(&self, mesh: &gltf::Mesh<'_>, times: usize) -> Result<(), MeshFileError> {
        let positions = mesh.primitives().filter_map(|it| it.get(&gltf::Semantic::Positions));
        let corners = positions.fold(0_usize, |sum, it| sum.saturating_add(it.count()));
        let all = corners.saturating_mul(times).saturating_add(self.raw.vertices.len());
        if all > MAX_CORNERS {
            return Err(malformed(&format!(
                "it has {all} corners; at most {MAX_CORNERS} are read"
            )));
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, placing: &Placing) -> Result<(), MeshFileError> {
        let keys: Vec<f64> = match &placing.weights {
            Some(weights) => weights.clone(),
            None => mesh.weights().unwrap_or_default().iter().map(|&w| w.into()).collect(),
        };
        for primitive in mesh.primitives() {
            let kind = match primitive.mode() {
                Mode::Points => Some("point cloud"),
                Mode::Lines | Mode::LineLoop | Mode::LineStrip => Some("set of lines"),
                Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => None,
            };
            if let Some(kind) = kind {
                self.raw.left_out.add(kind);
                continue;
            }
            let corners = self.corners(&primitive, &keys)?;
            let (base, count) = (self.raw.vertices.len() as u32, corners.len() as u32);
            let places = self.corner_places(&primitive, placing, corners.len())?;
            let placed = corners
                .iter()
                .enumerate()
                .map(|(k, corner)| places.at(k).transform_point(&Point3::from(*corner)).coords);
            self.raw.vertices.extend(placed);
            let reader = primitive.reader(|buffer| self.file.bytes(&buffer));
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
            self.faces(&indices_of_triangles(primitive.mode(), &indices), base, count, &places)?;
            let triangles = &self.raw.triangles[before..];
            let slot = primitive.material().index().unwrap_or(self.materials) as u32;
            let object = (self.raw.object_names.len() as u32).saturating_sub(1);
            let plain = Extra { slot, object, ..Extra::default() };
            // What is wrong with an attribute does not make the shape wrong.
            let read = || self.extras(&primitive, &places, (triangles, base), plain);
            let extras = hush::hushed(read).unwrap_or_else(|_| vec![plain; triangles.len()]);
            self.raw.extras.extend(extras);
        }
        Ok(())
    }

    /// The corners of a primitive as it is written, with its shape keys by their weights.
    fn corners(
        &self,
        primitive: &gltf::Primitive<'_>,
        keys: &[f64],
    ) -> Result<Vec<Vec3>, MeshFileError> {
        let unread = || malformed("a primitive has no positions that can be read");
        let positions = primitive.get(&gltf::Semantic::Positions).ok_or_else(unread)?;
        if positions.view().is_none() && positions.sparse().is_none() {
            return Err(unread());
        }
        let positions = self.file.vectors::<3>(&positions).ok_or_else(unread)?;
        let mut corners: Vec<Vec3> = positions.into_iter().map(Vec3::from).collect();
        for (target, &weight) in primitive.morph_targets().zip(keys) {
            let Some(moves) = target.positions().filter(|_| weight != 0.0) else { continue };
            let moves = self.file.vectors::<3>(&moves);
            let moves = moves
                .filter(|moves| moves.len() == corners.len())
                .ok_or_else(|| malformed("a shape key has no moves of corners that can be read"))?;
            corners.iter_mut().zip(moves).for_each(|(p, by)| *p += Vec3::from(by) * weight);
        }
        Ok(corners)
    }

    /// For each corner what places it in the scene: the node, or its bones by their weights.
    fn corner_places(
        &self,
        primitive: &gltf::Primitive<'_>,
        placing: &Placing,
        count: usize,
    ) -> Result<CornerPlaces, MeshFileError> {
        let Some(bones) = &placing.bones else { return Ok(CornerPlaces::One(placing.own)) };
        let reader = primitive.reader(|buffer| self.file.bytes(&buffer));
        let (mut places, mut sums) = (vec![Affine::zeros(); count], vec![0.0; count]);
        for set in 0.. {
            let (Some(joints), Some(weights)) = (reader.read_joints(set), reader.read_weights(set))
            else {
                break;
            };
            let both = joints.into_u16().zip(weights.into_f32());
            for (k, (joints, weights)) in both.enumerate().take(count) {
                for (joint, weight) in joints.into_iter().zip(weights) {
                    let weight = f64::from(weight);
                    if weight == 0.0 {
                        continue;
                    }
                    let bone = bones.get(usize::from(joint)).ok_or_else(|| {
                        malformed(&format!("a corner hangs on joint {joint} of {}", bones.len()))
                    })?;
                    places[k] += bone * weight;
                    sums[k] += weight;
                }
            }
        }
        for (place, sum) in places.iter_mut().zip(sums) {
            // A corner that hangs on nothing stays as it is written.
            *place = if sum > 0.0 { *place / sum } else { Affine::identity() };
        }
        Ok(CornerPlaces::Each(places))
    }

    /// What a primitive has beside these triangles, whose first corner is `base`.
    fn extras(
        &self,
        primitive: &gltf::Primitive<'_>,
        places: &CornerPlaces,
        (triangles, base): (&[[u32; 3]], u32),
        plain: Extra,
    ) -> Vec<Extra> {
        let reader = primitive.reader(|buffer| self.file.bytes(&buffer));
        let material = primitive.material();
        let picture = material.pbr_metallic_roughness().base_color_texture();
        let set = picture.map_or(0, |info| coordinates(&info));
        let uv: Vec<[f32; 2]> = reader
            .read_tex_coords(set)
            .map(|pairs| pairs.into_f32().map(|[u, v]| [finite(u), 1.0 - finite(v)]).collect())
            .unwrap_or_default();
        // Normals go by the inverse transpose; a place without volume has none.
        let turned = |(k, normal): (usize, [f32; 3])| {
            let linear: Mat3 = places.at(k).fixed_view::<3, 3>(0, 0).into_owned();
            let turn = linear.try_inverse()?.transpose();
            unit((turn * Vec3::from(normal.map(f64::from))).into())
        };
        let normals = reader.read_normals().into_iter().flatten().take(places.count());
        let normals: Vec<Option<[f32; 3]>> = normals.enumerate().map(turned).collect();
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
        triangles: &[[u32; 3]],
        base: u32,
        count: u32,
        places: &CornerPlaces,
    ) -> Result<(), MeshFileError> {
        for (face, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|index| **index >= count) {
                let (index, count) = (index.into(), count as usize);
                return Err(MeshFileError::IndexOutOfRange { face, index, count });
            }
            let mirrored =
                places.at(corners[0] as usize).fixed_view::<3, 3>(0, 0).determinant() < 0.0;
            let [a, b, c] = corners.map(|index| base + index);
            self.raw.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        if self.raw.triangles.len() > MAX_TRIANGLES {
            let count = self.raw.triangles.len();
            return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
        }
        Ok(())
    }
}

/// The triangles that indices make: each three of them, a strip, or a fan about the first.
fn indices_of_triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => triangles_of_strip(indices).collect(),
        Mode::TriangleFan => {
            indices.windows(2).skip(1).map(|pair| [indices[0], pair[0], pair[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect(),
    }
}
