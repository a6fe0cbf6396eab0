//! Materials of a GLB: skin, crack faces, and those of the artist with their pictures.

use super::GlbWriter;
use crate::looks::{ObjectLook, linear};
use crate::pictures::{ArtistMaterial, ExportPicture};
use crate::surface::FaceKind;
use crate::timeline::BodyTrack;
use cullet_geometry::attributes::{TextureMapping, TextureWrap};
use gltf::json;
use json::extensions::texture::{
    Info as InfoExtensions, TextureTransform, TextureTransformOffset, TextureTransformRotation,
    TextureTransformScale,
};
use json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use json::texture::{Info, Sampler, WrappingMode};
use json::validation::Checked;
use json::{Index, Material, Texture};

/// The extension of glTF that moves, turns and scales texture coordinates.
const TRANSFORM: &str = "KHR_texture_transform";

/// A material without pictures.
pub(super) fn plain(name: String, colour: [f32; 4], metallic: f32, roughness: f32) -> Material {
    Material {
        name: Some(name),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(colour),
            metallic_factor: StrengthFactor(metallic),
            roughness_factor: StrengthFactor(roughness),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}

impl<'a> GlbWriter<'a> {
    /// A material of one colour that is no metal.
    pub(super) fn plain(
        &mut self,
        name: String,
        colour: [f32; 4],
        roughness: f32,
    ) -> Index<Material> {
        self.root.push(plain(name, colour, 0.0, roughness))
    }

    /// The materials of an object: of its skin and its crack faces, and those that its file names.
    pub(super) fn materials(&mut self, track: &'a BodyTrack) {
        let body = &track.body;
        let named = &self.timeline.mesh(track).materials;
        if !self.materials.contains_key(&body.object[..]) {
            let ObjectLook { skin, crack, roughness: rough } =
                self.timeline.look(&body.material, &body.object, body.fixed);
            for (kind, part, rgb, roughness) in
                [(FaceKind::Skin, "skin", skin, 0.5), (FaceKind::Crack, "crack", crack, rough)]
            {
                let [r, g, b] = linear(rgb);
                let name = format!("{} {part}", body.object);
                let made = self.plain(name, [r, g, b, 1.0], roughness);
                self.materials.entry(&body.object).or_default().insert(kind, made);
            }
        }
        for (slot, of) in (0..).map(FaceKind::Slot).zip(named.iter()) {
            if self.materials[&body.object[..]].contains_key(&slot) {
                continue;
            }
            let ArtistMaterial { look, picture } = of;
            let name = format!("{} {}", body.object, look.name);
            let mut made = plain(name, look.base_colour, look.metallic, look.roughness);
            let texture = picture.as_ref().map(|picture| self.texture(picture, of.mapping()));
            made.pbr_metallic_roughness.base_color_texture = texture;
            let made = self.root.push(made);
            self.materials.entry(&body.object).or_default().insert(slot, made);
        }
    }

    /// A picture as a material reads it. Each picture is in the file once.
    fn texture(&mut self, picture: &'a ExportPicture, mapping: TextureMapping) -> Info {
        let source = match self.images.get(&picture.name[..]) {
            Some(&known) => known,
            None => {
                let made = self.buffer.picture(&mut self.root, picture);
                self.images.insert(&picture.name, made);
                made
            }
        };
        let [wrap_s, wrap_t] = mapping.wrap.map(|wrap| {
            Checked::Valid(match wrap {
                TextureWrap::Repeat => WrappingMode::Repeat,
                TextureWrap::Mirror => WrappingMode::MirroredRepeat,
                TextureWrap::Clamp => WrappingMode::ClampToEdge,
            })
        });
        let sampler = self.root.push(Sampler { wrap_s, wrap_t, ..Sampler::default() });
        let index: Index<Texture> = self.root.push(Texture {
            name: None,
            sampler: Some(sampler),
            source,
            extensions: None,
            extras: None,
        });
        Info { index, tex_coord: 0, extensions: self.transform(mapping), extras: None }
    }

    fn transform(&mut self, mapping: TextureMapping) -> Option<InfoExtensions> {
        if mapping.is_straight() {
            return None;
        }
        if !self.root.extensions_used.iter().any(|name| name == TRANSFORM) {
            self.root.extensions_used.push(TRANSFORM.to_owned());
        }
        let texture_transform = Some(TextureTransform {
            offset: TextureTransformOffset(mapping.offset),
            rotation: TextureTransformRotation(mapping.rotation),
            scale: TextureTransformScale(mapping.scale),
            // The writer would write `null` for none, which is no number.
            tex_coord: Some(0),
            extras: None,
        });
        Some(InfoExtensions { texture_transform, ..InfoExtensions::default() })
    }
}
