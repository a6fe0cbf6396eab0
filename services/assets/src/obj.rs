//! Wavefront OBJ, and of its material libraries what a surface needs.

use super::raw::{Extra, Raw, finite, unit};
use super::{Beside, MeshFileError, hush};
use cullet_geometry::Vec3;
use cullet_geometry::attributes::{SurfaceMaterial, SurfaceTexture};
use std::collections::BTreeMap;
use std::io::{BufRead, Read};
use std::path::Path;

/// Library that holds the name of every material in use: the reader keeps only those that it has
/// read a description of.
const LIBRARY: &str = "every name in use";

/// What the reader calls objects without a name.
const UNNAMED: &str = "unnamed_object";

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

pub(super) fn read(bytes: &[u8], beside: &mut Beside<'_>) -> Result<Raw, MeshFileError> {
    let names = named(bytes, "usemtl");
    // With materials the reader looks up corners earlier: faces may name only those above them.
    let (models, with) = match load(bytes, &names) {
        Ok(models) => (models, true),
        Err(_) => (load(bytes, &[])?, false),
    };
    let mut raw = Raw::default();
    let mut objects: BTreeMap<String, u32> = BTreeMap::new();
    for tobj::Model { mesh, name } in models {
        let base = raw.vertices.len() as u32;
        let points = mesh.positions.chunks_exact(3);
        raw.vertices.extend(points.map(|p| Vec3::new(p[0].into(), p[1].into(), p[2].into())));
        let corners = mesh.indices.chunks_exact(3);
        raw.triangles.extend(corners.map(|t| [base + t[0], base + t[1], base + t[2]]));
        let name = if name == UNNAMED { "object".to_owned() } else { name };
        let object = *objects.entry(name).or_insert_with_key(|name| {
            raw.object_names.push(name.clone());
            raw.object_names.len() as u32 - 1
        });
        // Faces without a material come before the first one that has any.
        let slot = mesh.material_id.map_or(names.len(), |slot| slot) as u32;
        let triangles = mesh.indices.len() / 3;
        raw.extras.extend((0..triangles).map(|t| extra(&mesh, t, (slot, object))));
    }
    if with && !names.is_empty() {
        raw.materials = materials(bytes, &names, beside);
        if raw.extras.iter().any(|extra| extra.slot as usize == names.len()) {
            raw.materials.push(SurfaceMaterial::named(""));
        }
    }
    Ok(raw)
}

/// The models of a file, whose materials are the places of their `names`.
fn load(bytes: &[u8], names: &[String]) -> Result<Vec<tobj::Model>, MeshFileError> {
    let described = |library: &Path| {
        if library != Path::new(LIBRARY) {
            return Ok(Default::default());
        }
        let material = |name: &String| tobj::Material { name: name.clone(), ..Default::default() };
        let places = names.iter().cloned().zip(0..).collect();
        Ok((names.iter().map(material).collect(), places))
    };
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let first = format!("mtllib {LIBRARY}\n");
    let mut lines = Lines { bytes, at: 0 };
    let mut text = first.as_bytes().chain(&mut lines);
    let loaded = tobj::load_obj_buf(&mut text, &options, described);
    let (models, _) = loaded.map_err(|error| {
        let taken = bytes[..lines.at].iter().filter(|&&byte| byte == b'\n').count();
        MeshFileError::Malformed { line: Some(taken.max(1)), reason: error.to_string() }
    })?;
    Ok(models)
}

/// What follows a word at the beginnings of lines, each once, in order.
fn named(bytes: &[u8], word: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for line in bytes.split(|&byte| byte == b'\n') {
        let Some(rest) = line.trim_ascii_start().strip_prefix(word.as_bytes()) else { continue };
        let name = String::from_utf8_lossy(rest).trim().to_owned();
        if rest.first() == Some(&b' ') && !name.is_empty() && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn extra(mesh: &tobj::Mesh, t: usize, (slot, object): (u32, u32)) -> Extra {
    let corner = |indices: &[u32], k: usize| indices.get(3 * t + k).map(|&i| i as usize);
    let uv = |k: usize| {
        let at = 2 * corner(&mesh.texcoord_indices, k)?;
        let pair = mesh.texcoords.get(at..at + 2)?;
        Some([finite(pair[0]), finite(pair[1])])
    };
    let normal = |k: usize| {
        let at = 3 * corner(&mesh.normal_indices, k)?;
        let of = mesh.normals.get(at..at + 3)?;
        unit([of[0].into(), of[1].into(), of[2].into()])
    };
    Extra { uv: all(uv), normals: all(normal), slot, object }
}

/// Of three corners, if each has it.
fn all<T>(of: impl Fn(usize) -> Option<T>) -> Option<[T; 3]> {
    Some([of(0)?, of(1)?, of(2)?])
}

/// The materials of these names, as the libraries of the file describe them.
fn materials(bytes: &[u8], names: &[String], beside: &mut Beside<'_>) -> Vec<SurfaceMaterial> {
    let mut described: BTreeMap<String, tobj::Material> = BTreeMap::new();
    for library in named(bytes, "mtllib") {
        let Some(text) = beside(&library) else { continue };
        let read = hush::hushed(|| tobj::load_mtl_buf(&mut text.as_slice()));
        let (found, _) = read.ok().and_then(Result::ok).unwrap_or_default();
        described.extend(found.into_iter().map(|material| (material.name.clone(), material)));
    }
    names.iter().map(|name| material(name, described.get(name))).collect()
}

fn material(name: &str, described: Option<&tobj::Material>) -> SurfaceMaterial {
    let mut material = SurfaceMaterial::named(name);
    let Some(found) = described else { return material };
    let [r, g, b] = found.diffuse.unwrap_or([1.0; 3]);
    material.base_colour = [r, g, b, found.dissolve.unwrap_or(1.0)].map(share);
    // The keys of the common extension for physically based materials.
    let own = |key: &str| found.unknown_param.get(key).and_then(|value| value.trim().parse().ok());
    material.metallic = own("Pm").map_or(material.metallic, share);
    material.roughness = own("Pr").map_or(material.roughness, share);
    let picture = found.diffuse_texture.clone();
    material.texture = picture.map(|name| SurfaceTexture { name, ..SurfaceTexture::default() });
    material
}

fn share(value: f32) -> f32 {
    finite(value).clamp(0.0, 1.0)
}

/// The corners in the order of their lines: `v x y z`, or with `r g b` behind.
pub(super) fn corners(bytes: &[u8]) -> Raw {
    let mut raw = Raw::default();
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
