//! The binary part of a GLB, and the accessors that lead into it.

use crate::pictures::ExportPicture;
use gltf::json;
use json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use json::buffer::{Buffer, Stride, Target, View};
use json::image::MimeType;
use json::validation::{Checked, USize64};
use json::{Image, Index, Root};
use serde_json::json;
use std::collections::BTreeMap;

/// For whom a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GlbUse {
    /// Programs that go on working with it: it has all there is.
    Work,
    /// A page that shows it: it has what is seen, as small as that is.
    Page,
}

/// Numbers of one kind lie together, in a view of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ViewKind {
    /// Places and normals.
    Vertices = 0,
    /// Texture coordinates.
    Textures = 1,
    /// Indices of two bytes.
    ShortIndices = 2,
    /// Indices of four bytes.
    LongIndices = 3,
    /// One number a vertex.
    Marks = 4,
    /// Keys of animations.
    Keys = 5,
    /// Normals of a byte a number.
    ByteNormals = 6,
}

const VIEWS: usize = 7;

/// Packs numbers; each kind becomes a buffer view at the end.
#[derive(Debug)]
pub(super) struct GlbBuffer {
    views: [Vec<u8>; VIEWS],
    /// Accessors of times that were written, by their bits: tracks of equal times share them.
    times: BTreeMap<Vec<u32>, Index<Accessor>>,
    /// Pictures as they are; each becomes a view of its own.
    pictures: Vec<(Index<Image>, Vec<u8>)>,
}

impl GlbBuffer {
    pub(super) fn new() -> Self {
        Self { views: Default::default(), times: BTreeMap::new(), pictures: Vec::new() }
    }

    fn put<const N: usize>(
        &mut self,
        root: &mut Root,
        kind: ViewKind,
        rows: &[[f32; N]],
    ) -> Index<Accessor> {
        let view = &mut self.views[kind as usize];
        let offset = view.len();
        rows.iter().flatten().for_each(|number| view.extend(number.to_le_bytes()));
        let of = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            3 => Type::Vec3,
            _ => Type::Vec4,
        };
        let (count, component) = (rows.len(), ComponentType::F32);
        root.push(accessor(kind, Extent { offset, count }, component, of))
    }

    /// Places \[m\], with their bounds, which glTF asks for.
    pub(super) fn places(&mut self, root: &mut Root, rows: &[[f32; 3]]) -> Index<Accessor> {
        let index = self.put(root, ViewKind::Vertices, rows);
        bound(root, index, rows);
        index
    }

    /// Unit normals. For a page they are of a byte a number, each at four bytes, as
    /// KHR_mesh_quantization allows.
    pub(super) fn normals(
        &mut self,
        root: &mut Root,
        purpose: GlbUse,
        rows: &[[f32; 3]],
    ) -> Index<Accessor> {
        if purpose == GlbUse::Work {
            return self.put(root, ViewKind::Vertices, rows);
        }
        let kind = ViewKind::ByteNormals;
        let view = &mut self.views[kind as usize];
        let extent = Extent { offset: view.len(), count: rows.len() };
        for row in rows {
            let [x, y, z] = row.map(|number| (127.0 * number).round() as i8 as u8);
            view.extend([x, y, z, 0]);
        }
        let made = accessor(kind, extent, ComponentType::I8, Type::Vec3);
        root.push(Accessor { normalized: true, ..made })
    }

    pub(super) fn textures(&mut self, root: &mut Root, rows: &[[f32; 2]]) -> Index<Accessor> {
        self.put(root, ViewKind::Textures, rows)
    }

    /// One number a vertex.
    pub(super) fn marks(&mut self, root: &mut Root, rows: &[[f32; 1]]) -> Index<Accessor> {
        self.put(root, ViewKind::Marks, rows)
    }

    pub(super) fn keys<const N: usize>(
        &mut self,
        root: &mut Root,
        rows: &[[f32; N]],
    ) -> Index<Accessor> {
        self.put(root, ViewKind::Keys, rows)
    }

    /// Times of keys \[s\].
    pub(super) fn times(&mut self, root: &mut Root, times: &[f32]) -> Index<Accessor> {
        let bits: Vec<u32> = times.iter().map(|time| time.to_bits()).collect();
        if let Some(&index) = self.times.get(&bits) {
            return index;
        }
        let rows: Vec<[f32; 1]> = times.iter().map(|&time| [time]).collect();
        let index = self.put(root, ViewKind::Keys, &rows);
        bound(root, index, &rows);
        self.times.insert(bits, index);
        index
    }

    pub(super) fn indices(&mut self, root: &mut Root, indices: &[u32]) -> Index<Accessor> {
        // The greatest number of a size is not for use.
        let short = indices.iter().all(|&index| index < u32::from(u16::MAX));
        let (kind, component) = match short {
            true => (ViewKind::ShortIndices, ComponentType::U16),
            false => (ViewKind::LongIndices, ComponentType::U32),
        };
        let view = &mut self.views[kind as usize];
        let offset = view.len();
        for &index in indices {
            match short {
                true => view.extend((index as u16).to_le_bytes()),
                false => view.extend(index.to_le_bytes()),
            }
        }
        let extent = Extent { offset, count: indices.len() };
        root.push(accessor(kind, extent, component, Type::Scalar))
    }

    /// A picture; its view is known at the end.
    pub(super) fn picture(&mut self, root: &mut Root, picture: &ExportPicture) -> Index<Image> {
        let index = root.push(Image {
            buffer_view: None,
            mime_type: Some(MimeType(picture.kind.media_type().to_owned())),
            name: Some(picture.name.clone()),
            uri: None,
            extensions: None,
            extras: None,
        });
        self.pictures.push((index, picture.bytes.clone()));
        index
    }

    /// The bytes, and their views in `root`.
    pub(super) fn finish(self, root: &mut Root) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.views.iter().map(Vec::len).sum());
        let mut place = [None; VIEWS];
        for (kind, view) in self.views.iter().enumerate().filter(|(_, view)| !view.is_empty()) {
            let (target, stride) = match kind {
                0 => (Some(Target::ArrayBuffer), Some(Stride(12))),
                1 => (Some(Target::ArrayBuffer), Some(Stride(8))),
                2 | 3 => (Some(Target::ElementArrayBuffer), None),
                4 | 6 => (Some(Target::ArrayBuffer), Some(Stride(4))),
                _ => (None, None),
            };
            place[kind] = Some(push_view(root, &mut bytes, view, stride, target));
        }
        for (image, picture) in &self.pictures {
            let view = push_view(root, &mut bytes, picture, None, None);
            root.images[image.value()].buffer_view = Some(view);
        }
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        for accessor in &mut root.accessors {
            let kind = accessor.buffer_view.map_or(0, |kind| kind.value());
            accessor.buffer_view = place[kind];
        }
        root.push(Buffer {
            byte_length: USize64::from(bytes.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        bytes
    }
}

/// Adds bytes as a view.
fn push_view(
    root: &mut Root,
    bytes: &mut Vec<u8>,
    view: &[u8],
    stride: Option<Stride>,
    target: Option<Target>,
) -> Index<View> {
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let start = bytes.len();
    bytes.extend(view);
    root.push(View {
        buffer: Index::new(0),
        byte_length: USize64::from(view.len()),
        byte_offset: Some(USize64::from(start)),
        byte_stride: stride,
        name: None,
        target: target.map(Checked::Valid),
        extensions: None,
        extras: None,
    })
}

/// Where numbers are in their view.
struct Extent {
    offset: usize,
    count: usize,
}

/// Its view is the number of its kind until the views are known.
fn accessor(kind: ViewKind, at: Extent, component: ComponentType, of: Type) -> Accessor {
    Accessor {
        buffer_view: Some(Index::new(kind as u32)),
        byte_offset: Some(USize64::from(at.offset)),
        count: USize64::from(at.count),
        component_type: Checked::Valid(GenericComponentType(component)),
        type_: Checked::Valid(of),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
        extensions: None,
        extras: None,
    }
}

fn bound<const N: usize>(root: &mut Root, index: Index<Accessor>, rows: &[[f32; N]]) {
    let least = |k: usize| rows.iter().map(|row| row[k]).fold(f32::INFINITY, f32::min);
    let most = |k: usize| rows.iter().map(|row| row[k]).fold(f32::NEG_INFINITY, f32::max);
    let accessor = &mut root.accessors[index.value()];
    accessor.min = Some(json!(std::array::from_fn::<f32, N, _>(least).to_vec()));
    accessor.max = Some(json!(std::array::from_fn::<f32, N, _>(most).to_vec()));
}
