//! What an artist's mesh has beside its shape: texture coordinates, normals, materials and names.
//!
//! They are kept beside the body that was made of the mesh, never on it: [`AttributeTransfer`]
//! finds them again by place, on whatever is left of its surface.

mod islands;
mod transfer;

#[cfg(test)]
mod tests;

pub use transfer::{AttributeTransfer, SkinTriangle};

use crate::math::Vec3;
use crate::mesh::{MeshError, TriMesh};
use std::collections::BTreeMap;

/// How a picture goes on where texture coordinates leave [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureWrap {
    /// It begins again.
    #[default]
    Repeat,
    /// It begins again, every other time as in a mirror.
    Mirror,
    /// Its last row or column goes on.
    Clamp,
}

/// How texture coordinates lead into a picture: scaled, then turned, then moved, as
/// KHR_texture_transform of glTF has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMapping {
    /// Where the coordinates' origin lies in the picture: u, and v downward.
    pub offset: [f32; 2],
    /// By how much the coordinates are turned, counter-clockwise as the picture is seen \[rad\].
    pub rotation: f32,
    /// Factors of u and v.
    pub scale: [f32; 2],
    /// How it goes on along u and v.
    pub wrap: [TextureWrap; 2],
}

impl Default for TextureMapping {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], wrap: Default::default() }
    }
}

impl TextureMapping {
    /// Whether it leaves coordinates as they are.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        Self { wrap: Default::default(), ..*self } == Self::default()
    }
}

/// A picture that a material names: in a file by range, or only by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceTexture {
    /// What the mesh file calls it, or the path that it gives.
    pub name: String,
    /// Media type, such as `image/png`; empty where it is not known.
    pub media_type: String,
    /// The picture's place in the mesh file: first byte and number of bytes. A length of 0: it lies
    /// elsewhere.
    pub offset: u64,
    /// See `offset`.
    pub length: u64,
    /// How the texture coordinates lead into it.
    pub mapping: TextureMapping,
}

/// How a surface is to look.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceMaterial {
    /// What the mesh file calls it.
    pub name: String,
    /// Linear red, green, blue and opacity, each in [0, 1].
    pub base_colour: [f32; 4],
    /// From 0, a dielectric, to 1, a metal.
    pub metallic: f32,
    /// From 0, a mirror, to 1, matt.
    pub roughness: f32,
    /// The picture that multiplies the base colour.
    pub texture: Option<SurfaceTexture>,
}

impl SurfaceMaterial {
    /// A material of which only the name is known: white and matt.
    #[must_use]
    pub fn named(name: impl Into<String>) -> Self {
        let (base_colour, metallic, roughness) = ([1.0; 4], 0.0, 1.0);
        Self { name: name.into(), base_colour, metallic, roughness, texture: None }
    }
}

/// The mesh of an artist with what it has beside its shape. Each of the lists has one entry a
/// triangle, or none where the file says nothing of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceAttributes {
    /// The mesh as it was before any repair \[m\].
    pub mesh: TriMesh,
    /// Texture coordinates (u, v) at the three corners; v grows upward, as in OBJ and USD.
    pub uv: Vec<[[f32; 2]; 3]>,
    /// Unit normals at the three corners.
    pub normals: Vec<[[f32; 3]; 3]>,
    /// The material, as its place in `materials`.
    pub slots: Vec<u32>,
    /// The materials.
    pub materials: Vec<SurfaceMaterial>,
    /// The object, as its place in `object_names`.
    pub objects: Vec<u32>,
    /// Names of the objects in the file, each once.
    pub object_names: Vec<String>,
}

/// What is wrong with the lists of [`SurfaceAttributes`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AttributeError {
    /// The mesh itself.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A list has neither one entry a triangle nor none.
    #[error("{list} has {length} entries for {triangles} triangles")]
    Length {
        /// Which list.
        list: &'static str,
        /// Its entries.
        length: usize,
        /// Triangles.
        triangles: usize,
    },
    /// A triangle names a material or object that is not there.
    #[error("triangle {triangle} names {list} {index} of {count}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// What it names.
        list: &'static str,
        /// Which.
        index: u32,
        /// How many there are.
        count: usize,
    },
}

impl SurfaceAttributes {
    /// Whether there is nothing beside the shape, and at most one object.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        let bare = self.uv.is_empty() && self.normals.is_empty() && self.materials.is_empty();
        bare && self.object_names.len() < 2
    }

    /// Checks that the lists fit the mesh and each other.
    ///
    /// # Errors
    /// The first list or entry that does not.
    pub fn validate(&self) -> Result<(), AttributeError> {
        self.mesh.validate()?;
        let triangles = self.mesh.triangles.len();
        let lengths = [
            ("uv", self.uv.len()),
            ("normals", self.normals.len()),
            ("slots", self.slots.len()),
            ("objects", self.objects.len()),
        ];
        if let Some(&(list, length)) =
            lengths.iter().find(|(_, length)| ![0, triangles].contains(length))
        {
            return Err(AttributeError::Length { list, length, triangles });
        }
        let named = [
            ("material", &self.slots, self.materials.len()),
            ("object", &self.objects, self.object_names.len()),
        ];
        for (list, indices, count) in named {
            let wrong = indices.iter().enumerate().find(|(_, index)| **index as usize >= count);
            if let Some((triangle, &index)) = wrong {
                return Err(AttributeError::Index { triangle, list, index, count });
            }
        }
        Ok(())
    }

    /// The triangles of one object, with their vertices in order of use.
    #[must_use]
    pub fn only(&self, object: u32) -> Self {
        let kept: Vec<usize> =
            (0..self.mesh.triangles.len()).filter(|&t| self.object_of(t) == object).collect();
        let mut mesh = TriMesh::default();
        let mut known: BTreeMap<u32, u32> = BTreeMap::new();
        for &t in &kept {
            let triangle = self.mesh.triangles[t].map(|old| {
                *known.entry(old).or_insert_with(|| {
                    mesh.vertices.push(self.mesh.vertices[old as usize]);
                    (mesh.vertices.len() - 1) as u32
                })
            });
            mesh.triangles.push(triangle);
        }
        let name = self.object_names.get(object as usize).cloned();
        Self {
            mesh,
            uv: pick(&self.uv, &kept),
            normals: pick(&self.normals, &kept),
            slots: pick(&self.slots, &kept),
            materials: self.materials.clone(),
            objects: name.iter().flat_map(|_| vec![0; kept.len()]).collect(),
            object_names: name.into_iter().collect(),
        }
    }

    /// Applies `turn`, a rotation, to the mesh and its normals.
    pub fn turn(&mut self, turn: impl Fn(&Vec3) -> Vec3) {
        self.mesh.vertices.iter_mut().for_each(|v| *v = turn(v));
        for normal in self.normals.iter_mut().flatten() {
            let turned = turn(&Vec3::from(normal.map(f64::from)));
            *normal = [turned.x as f32, turned.y as f32, turned.z as f32];
        }
    }

    /// The place of a triangle's material in `materials`; 0 where none has one.
    #[must_use]
    pub fn slot_of(&self, triangle: usize) -> u32 {
        self.slots.get(triangle).copied().unwrap_or(0)
    }

    /// The place of a triangle's object in `object_names`; 0 where there are none.
    #[must_use]
    pub fn object_of(&self, triangle: usize) -> u32 {
        self.objects.get(triangle).copied().unwrap_or(0)
    }
}

fn pick<T: Copy>(list: &[T], kept: &[usize]) -> Vec<T> {
    kept.iter().filter_map(|&t| list.get(t).copied()).collect()
}
