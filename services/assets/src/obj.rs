//! Wavefront OBJ, and of its material libraries what a surface needs.
//!
//! What decides the shape are corners (`v`) and faces (`f`); texture coordinates, normals, colours
//! and names decide nothing, and nothing in them is an error. Elements that are no surface are left
//! out and counted. A face may name corners that are written below it.

use super::raw::{Extra, LeftOut, Raw, finite, triangles_of, unit};
use super::text::{decode, joined_lines, number};
use super::{Beside, MAX_TRIANGLES, MeshFileError, hush};
use cullet_geometry::Vec3;
use cullet_geometry::attributes::{SurfaceMaterial, SurfaceTexture};
use std::collections::BTreeMap;

/// What an object is called that has no name.
const UNNAMED: &str = "object";

/// The colour of a corner that has none where others have one.
const WHITE: [f64; 3] = [1.0; 3];

/// A corner of a face: places of its point, its texture coordinates and its normal, from 0 up;
/// what is none is out of range.
type FaceCorner = [i64; 3];

/// A face, whose corners are a part of all.
struct ObjFace {
    corners: std::ops::Range<usize>,
    slot: u32,
    object: u32,
}

/// What the lines say.
#[derive(Default)]
struct ObjFile {
    points: Vec<Vec3>,
    colours: Vec<Option<[f64; 3]>>,
    uv: Vec<[f32; 2]>,
    normals: Vec<Option<[f32; 3]>>,
    corners: Vec<FaceCorner>,
    faces: Vec<ObjFace>,
    triangles: usize,
    /// Names, and of each that is in use its place.
    objects: ObjNames,
    materials: ObjNames,
    libraries: Vec<String>,
    left_out: LeftOut,
}

/// Names in the order of their first use, and the one that is in use.
#[derive(Default)]
struct ObjNames {
    places: BTreeMap<String, u32>,
    names: Vec<String>,
    current: Option<u32>,
}

impl ObjNames {
    fn begin(&mut self, name: &str) {
        self.current = Some(*self.places.entry(name.to_owned()).or_insert_with(|| {
            self.names.push(name.to_owned());
            self.names.len() as u32 - 1
        }));
    }
}

pub(super) fn read(bytes: &[u8], beside: &mut Beside<'_>) -> Result<Raw, MeshFileError> {
    let mut file = ObjFile::default();
    for (line, text) in joined_lines(&decode(bytes)) {
        file.take(line, &text)?;
    }
    file.finish(beside)
}

/// The corners in the order of their lines: `v x y z`, or with `r g b` behind.
pub(super) fn corners(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let mut file = ObjFile::default();
    for (line, text) in joined_lines(&decode(bytes)) {
        let text = text.trim_start();
        if text.starts_with("v ") || text.starts_with("v\t") {
            file.take(line, text)?;
        }
    }
    Ok(file.bare())
}

impl ObjFile {
    fn take(&mut self, line: usize, text: &str) -> Result<(), MeshFileError> {
        let text = text.trim();
        let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let (rest, words) = (rest.trim(), rest.split('#').next().unwrap_or("").split_whitespace());
        match word {
            "v" => self.take_point(line, words)?,
            "f" | "fo" => self.take_face(line, words)?,
            "vt" => {
                let numbers = attributes(words);
                let at = |k: usize| finite(numbers.get(k).copied().unwrap_or(0.0) as f32);
                self.uv.push([at(0), at(1)]);
            }
            "vn" => self.normals.push(match attributes(words)[..] {
                [x, y, z, ..] => unit([x, y, z]),
                _ => None,
            }),
            "o" | "g" => self.objects.begin(if rest.is_empty() { UNNAMED } else { rest }),
            "usemtl" if rest.is_empty() => self.materials.current = None,
            "usemtl" => self.materials.begin(rest),
            "mtllib" if !rest.is_empty() => self.libraries.push(rest.to_owned()),
            "l" => self.left_out.add("line"),
            "p" => self.left_out.add("point"),
            "curv" | "curv2" => self.left_out.add("curve"),
            "surf" => self.left_out.add("free-form surface"),
            _ => {}
        }
        Ok(())
    }

    fn take_point<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshFileError> {
        let malformed = |reason: String| MeshFileError::Malformed { line: Some(line), reason };
        let words: Vec<&str> = words.collect();
        let [x, y, z, colour @ ..] = &words[..] else {
            let count = words.len();
            return Err(malformed(format!("a corner has three coordinates, and here are {count}")));
        };
        let read = |word: &str| number(word).map_err(malformed);
        self.points.push(Vec3::new(read(x)?, read(y)?, read(z)?));
        let colour = attributes(colour.iter().copied());
        self.colours.push(match colour[..] {
            [r, g, b, ..] => Some([r, g, b].map(|share| share.clamp(0.0, 1.0))),
            _ => None,
        });
        Ok(())
    }

    fn take_face<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'a str>,
    ) -> Result<(), MeshFileError> {
        let first = self.corners.len();
        let counts = [self.points.len(), self.uv.len(), self.normals.len()];
        for word in words {
            let corner = face_corner(word, counts).ok_or_else(|| {
                let reason = format!("\"{word}\" is no corner of a face");
                MeshFileError::Malformed { line: Some(line), reason }
            })?;
            self.corners.push(corner);
        }
        let corners = first..self.corners.len();
        if corners.len() < 3 {
            self.corners.truncate(first);
            self.left_out.add("face of fewer than three corners");
            return Ok(());
        }
        self.triangles += corners.len() - 2;
        if self.triangles > MAX_TRIANGLES {
            return Err(MeshFileError::TooLarge { count: self.triangles, limit: MAX_TRIANGLES });
        }
        if self.objects.current.is_none() {
            self.objects.begin(UNNAMED);
        }
        let (slot, object) = (self.materials.current, self.objects.current.unwrap_or(0));
        self.faces.push(ObjFace { corners, slot: slot.unwrap_or(u32::MAX), object });
        Ok(())
    }

    /// Points and colours.
    fn bare(self) -> Raw {
        let coloured = self.colours.iter().any(Option::is_some);
        let colours = self.colours.iter().map(|colour| colour.unwrap_or(WHITE));
        Raw {
            colours: if coloured { colours.collect() } else { Vec::new() },
            vertices: self.points,
            left_out: self.left_out,
            ..Raw::default()
        }
    }

    fn finish(mut self, beside: &mut Beside<'_>) -> Result<Raw, MeshFileError> {
        let mut triangles = Vec::with_capacity(self.triangles);
        let mut extras = Vec::with_capacity(self.triangles);
        let none = self.materials.names.len() as u32;
        let mut polygon = Vec::new();
        for (face, of) in self.faces.iter().enumerate() {
            let corners = &self.corners[of.corners.clone()];
            polygon.clear();
            for &[point, ..] in corners {
                let found = usize::try_from(point).ok().filter(|&at| at < self.points.len());
                let Some(at) = found else {
                    let (index, count) = (point.saturating_add(1), self.points.len());
                    return Err(MeshFileError::IndexOutOfRange { face, index, count });
                };
                polygon.push(at as u32);
            }
            let (slot, object) = (of.slot.min(none), of.object);
            for places in triangles_of(&self.points, &polygon) {
                triangles.push(places.map(|k| polygon[k as usize]));
                extras.push(self.extra(places.map(|k| corners[k as usize]), slot, object));
            }
        }
        let mut materials = Vec::new();
        if none > 0 {
            materials = describe(&self.materials.names, &self.libraries, beside);
            if extras.iter().any(|extra| extra.slot == none) {
                materials.push(SurfaceMaterial::named(""));
            }
        }
        let object_names = std::mem::take(&mut self.objects.names);
        Ok(Raw { triangles, extras, materials, object_names, ..self.bare() })
    }

    fn extra(&self, corners: [FaceCorner; 3], slot: u32, object: u32) -> Extra {
        let uv = |corner: FaceCorner| self.uv.get(usize::try_from(corner[1]).ok()?).copied();
        let normal =
            |corner: FaceCorner| self.normals.get(usize::try_from(corner[2]).ok()?).copied()?;
        Extra { uv: all(corners, uv), normals: all(corners, normal), slot, object }
    }
}

/// Of three corners, if each has it.
fn all<T>(corners: [FaceCorner; 3], of: impl Fn(FaceCorner) -> Option<T>) -> Option<[T; 3]> {
    let [a, b, c] = corners;
    Some([of(a)?, of(b)?, of(c)?])
}

/// Numbers of an attribute, as far as they are numbers.
fn attributes<'a>(words: impl Iterator<Item = &'a str>) -> Vec<f64> {
    words.map_while(|word| word.parse().ok()).collect()
}

/// `point`, `point/uv`, `point//normal` or `point/uv/normal`, where the counts are those of the
/// lines above: a negative number counts back from there.
fn face_corner(word: &str, counts: [usize; 3]) -> Option<FaceCorner> {
    let mut corner = [i64::MIN; 3];
    let mut parts = word.split('/');
    for (k, (place, count)) in corner.iter_mut().zip(counts).enumerate() {
        let Some(part) = parts.next().filter(|part| !part.is_empty()) else { continue };
        // Only the point decides the shape.
        *place = match part.parse::<i64>() {
            Ok(back) if back < 0 => back.saturating_add(count as i64),
            Ok(number) => number - 1,
            Err(_) if k == 0 => return None,
            Err(_) => i64::MIN,
        };
    }
    (corner[0] != i64::MIN).then_some(corner)
}

/// The materials of these names, as the libraries of the file describe them.
fn describe(
    names: &[String],
    libraries: &[String],
    beside: &mut Beside<'_>,
) -> Vec<SurfaceMaterial> {
    let mut described: BTreeMap<String, tobj::Material> = BTreeMap::new();
    for library in libraries {
        let Some(bytes) = beside(library) else { continue };
        let text = decode(&bytes).replace('\r', "\n");
        let read = hush::hushed(|| tobj::load_mtl_buf(&mut text.as_bytes()));
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
