//! The artist's materials, and the pictures that lie on them.

use crate::names::UniqueNames;
use cullet_geometry::attributes::{SurfaceAttributes, SurfaceMaterial, TextureMapping};
use cullet_proto::recording::{Appearance, AppearanceTexture};
use cullet_record::Recording;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A format of pictures that all programs read which read glTF or USD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureKind {
    Png,
    Jpeg,
}

impl PictureKind {
    /// By the first bytes: names and media types of mesh files are anybody's.
    fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            _ => None,
        }
    }

    pub(crate) fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
        }
    }
}

/// A picture as it is written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ExportPicture {
    /// An identifier that no other picture has.
    pub(crate) name: String,
    pub(crate) kind: PictureKind,
    pub(crate) bytes: Vec<u8>,
}

impl ExportPicture {
    /// The name of its file.
    pub(crate) fn file(&self) -> String {
        format!("{}.{}", self.name, self.kind.ending())
    }
}

/// A material of an artist's mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ArtistMaterial {
    pub(crate) look: SurfaceMaterial,
    /// The picture that multiplies the base colour.
    pub(crate) picture: Option<Arc<ExportPicture>>,
}

impl ArtistMaterial {
    /// How texture coordinates lead into its picture.
    pub(crate) fn mapping(&self) -> TextureMapping {
        self.look.texture.as_ref().map_or_else(Default::default, |texture| texture.mapping)
    }
}

/// Pictures of a recording, each once.
#[derive(Debug, Default)]
pub(crate) struct PictureShelf {
    names: UniqueNames,
    /// By mesh file, name and place in it.
    known: BTreeMap<(String, String, u64), Option<Arc<ExportPicture>>>,
    /// Those that cannot be written, and why.
    left_out: BTreeSet<String>,
}

impl PictureShelf {
    /// The materials of a surface with their pictures; none where its file names none.
    pub(crate) fn materials(
        &mut self,
        recording: &Recording,
        appearance: &Appearance,
        surface: &SurfaceAttributes,
    ) -> Vec<ArtistMaterial> {
        if surface.slots.is_empty() {
            return Vec::new();
        }
        let rows = surface.materials.iter().zip(&appearance.materials);
        let material = |(look, row): (&SurfaceMaterial, _)| {
            let texture: Option<&AppearanceTexture> = row;
            // Without texture coordinates nobody knows where it would lie.
            let texture = texture.filter(|_| !surface.uv.is_empty());
            let picture =
                texture.and_then(|of| self.picture(recording, appearance, of, &look.name));
            ArtistMaterial { look: look.clone(), picture }
        };
        rows.map(|(look, row)| (look, row.texture.as_ref())).map(material).collect()
    }

    fn picture(
        &mut self,
        recording: &Recording,
        of: &Appearance,
        texture: &AppearanceTexture,
        material: &str,
    ) -> Option<Arc<ExportPicture>> {
        let key = (of.file.clone(), texture.name.clone(), texture.offset);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let name = &texture.name;
        let refused =
            |why: &str| format!("the picture {name:?} of the material {material:?} {why}");
        let found = match recording.picture(of, texture) {
            None => Err(refused("is not in the recording")),
            Some(bytes) => match PictureKind::of(bytes) {
                None => Err(refused("is neither PNG nor JPEG")),
                Some(kind) => Ok(self.kept(bytes).unwrap_or_else(|| {
                    let stem = name.rsplit_once('.').map_or(&name[..], |(stem, _)| stem);
                    let stem = if stem.is_empty() { "picture" } else { stem };
                    let name = self.names.give(stem);
                    Arc::new(ExportPicture { name, kind, bytes: bytes.to_vec() })
                })),
            },
        };
        let picture = found.map_err(|text| self.left_out.insert(text)).ok();
        self.known.insert(key, picture.clone());
        picture
    }

    /// A picture of these bytes: mesh files may have copies of one.
    fn kept(&self, bytes: &[u8]) -> Option<Arc<ExportPicture>> {
        self.known.values().flatten().find(|it| it.bytes == bytes).cloned()
    }

    /// The pictures, and in words those that are not among them.
    pub(crate) fn finish(self) -> (Vec<Arc<ExportPicture>>, Vec<String>) {
        let pictures = self.known.into_values().flatten();
        let pictures: BTreeMap<String, _> = pictures.map(|it| (it.name.clone(), it)).collect();
        (pictures.into_values().collect(), self.left_out.into_iter().collect())
    }
}
