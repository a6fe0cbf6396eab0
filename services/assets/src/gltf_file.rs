//! glTF files, binary or as text, with the bytes of all their buffers.

use super::text::decode;
use super::{Beside, MAX_TRIANGLES, MeshFileError};
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::accessor::{DataType, Item, Iter};
use gltf::buffer::Source;
use std::borrow::Cow;
use std::sync::Arc;

/// Bytes of a binary file's header and of those of its two chunks.
const HEADERS: u64 = 12 + 8 + 8;

/// Extensions that a file may require, since they are read here, though not by the library.
const READ_HERE: [&str; 2] = ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"];

/// Extensions that pack the shape in a way that is not read here.
const PACKED: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Most values of all accessors that have no bytes but for some of their values.
const MAX_BARE: usize = 3 * MAX_TRIANGLES;

/// Base64 as data URIs have it, with or without its padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A document and the bytes of its buffers.
pub(super) struct GltfFile {
    pub(super) document: gltf::Document,
    buffers: Vec<Bytes>,
    /// Where the binary chunk lies in the file.
    pub(super) chunk: Option<u64>,
}

/// Bytes of a buffer.
enum Bytes {
    Own(Vec<u8>),
    Beside(Arc<Vec<u8>>),
}

impl GltfFile {
    /// Opens a file; `beside` gives buffers that lie in files of their own.
    pub(super) fn open(bytes: &[u8], beside: &mut Beside<'_>) -> Result<Self, MeshFileError> {
        let is_binary = bytes.starts_with(b"glTF");
        let (json, blob) = if is_binary { chunks(bytes)? } else { (decode_text(bytes)?, None) };
        let mut root: gltf::json::Root = gltf::json::deserialize::from_slice(&json)
            .map_err(|error| malformed(&format!("its JSON is not as glTF has it: {error}")))?;
        refuse_packed(&root)?;
        root.extensions_required.retain(|name| !READ_HERE.contains(&name.as_str()));
        let document = gltf::Document::from_json(root).map_err(|error| match error {
            gltf::Error::Validation(faults) => {
                let (place, fault) = faults.first().map_or_else(Default::default, |(at, fault)| {
                    (at.to_string(), fault.to_string())
                });
                malformed(&format!("{place}: {fault}"))
            }
            other => malformed(&other.to_string()),
        })?;
        refuse_bare(&document)?;
        let mut blob = blob;
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let bytes = match buffer.source() {
                Source::Bin => Bytes::Own(blob.take().unwrap_or_default()),
                Source::Uri(uri) => fetch(uri, beside)?,
            };
            let (have, need) = (bytes.get().len() as u64, buffer.length() as u64);
            if have < need {
                return Err(MeshFileError::Truncated { have, need });
            }
            buffers.push(bytes);
        }
        let text = HEADERS + json.len() as u64;
        Ok(Self { document, buffers, chunk: is_binary.then_some(text) })
    }

    /// The bytes of a buffer.
    pub(super) fn bytes(&self, buffer: &gltf::Buffer<'_>) -> Option<&[u8]> {
        self.buffers.get(buffer.index()).map(Bytes::get)
    }

    /// Vectors of an accessor, whatever numbers it holds them in; nothing where they cannot be had.
    pub(super) fn vectors<const N: usize>(
        &self,
        accessor: &gltf::Accessor<'_>,
    ) -> Option<Vec<[f64; N]>>
    where
        [i8; N]: Item,
        [u8; N]: Item,
        [i16; N]: Item,
        [u16; N]: Item,
        [f32; N]: Item,
    {
        if accessor.dimensions().multiplicity() != N {
            return None;
        }
        // glTF 2.0, 3.11: what is normalised is a share of the largest number of its type.
        let share = |full: f64| if accessor.normalized() { full } else { 1.0 };
        match accessor.data_type() {
            DataType::I8 => self.scaled::<i8, N>(accessor, share(127.0)),
            DataType::U8 => self.scaled::<u8, N>(accessor, share(255.0)),
            DataType::I16 => self.scaled::<i16, N>(accessor, share(32_767.0)),
            DataType::U16 => self.scaled::<u16, N>(accessor, share(65_535.0)),
            DataType::F32 => self.scaled::<f32, N>(accessor, 1.0),
            DataType::U32 => None,
        }
    }

    fn scaled<T: Into<f64>, const N: usize>(
        &self,
        accessor: &gltf::Accessor<'_>,
        full: f64,
    ) -> Option<Vec<[f64; N]>>
    where
        [T; N]: Item,
    {
        let values = Iter::<[T; N]>::new(accessor.clone(), |buffer| self.bytes(&buffer))?;
        let value = |value: T| -> f64 {
            let value: f64 = value.into();
            if full == 1.0 { value } else { (value / full).max(-1.0) }
        };
        Some(values.map(|values| values.map(value)).collect())
    }
}

impl Bytes {
    fn get(&self) -> &[u8] {
        match self {
            Self::Own(bytes) => bytes,
            Self::Beside(bytes) => bytes,
        }
    }
}

/// The two chunks of a binary file: its JSON, and its bytes if it has any.
fn chunks(bytes: &[u8]) -> Result<(Vec<u8>, Option<Vec<u8>>), MeshFileError> {
    if let Some(need) = bytes.get(8..12).and_then(|length| length.try_into().ok()) {
        let need = u64::from(u32::from_le_bytes(need));
        if (bytes.len() as u64) < need {
            return Err(MeshFileError::Truncated { have: bytes.len() as u64, need });
        }
    }
    let glb = gltf::Glb::from_slice(bytes).map_err(|error| malformed(&error.to_string()))?;
    Ok((glb.json.into_owned(), glb.bin.map(Cow::into_owned)))
}

fn decode_text(bytes: &[u8]) -> Result<Vec<u8>, MeshFileError> {
    let text = decode(bytes);
    if !text.trim_start().starts_with('{') {
        return Err(malformed(
            "it begins neither with glTF, as a binary file, nor with {, as text",
        ));
    }
    Ok(text.into_owned().into_bytes())
}

/// Refuses what nothing here can unpack.
fn refuse_packed(root: &gltf::json::Root) -> Result<(), MeshFileError> {
    let packs = |name: &&String| PACKED.contains(&name.as_str());
    let Some(name) = root.extensions_required.iter().find(packs) else { return Ok(()) };
    let what = format!(
        "a shape that is packed with {name}: export it without compression, or unpack it, as \
         `npx @gltf-transform/cli copy packed.glb plain.glb` does; it"
    );
    Err(MeshFileError::Unsupported { what })
}

/// Refuses a file whose accessors without bytes name more values than can be held: they may name
/// any count.
fn refuse_bare(document: &gltf::Document) -> Result<(), MeshFileError> {
    let bare = document.accessors().filter(|accessor| accessor.view().is_none());
    let count = bare.fold(0_usize, |sum, accessor| sum.saturating_add(accessor.count()));
    if count <= MAX_BARE {
        return Ok(());
    }
    let what = format!("sparse accessors without a buffer name {count} values");
    Err(malformed(&format!("{what}; at most {MAX_BARE} are read")))
}

/// The bytes of a buffer that is not in the binary chunk.
fn fetch(uri: &str, beside: &mut Beside<'_>) -> Result<Bytes, MeshFileError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, coded)) = data.split_once(";base64,") else {
            let what = "a buffer in a data URI without base64".to_owned();
            return Err(MeshFileError::Unsupported { what });
        };
        let bytes = BASE64.decode(coded.trim_ascii());
        return bytes.map(Bytes::Own).map_err(|error| malformed(&format!("a buffer: {error}")));
    }
    let name = decode_percent(uri);
    match beside(&name) {
        Some(bytes) => Ok(Bytes::Beside(bytes)),
        None => Err(MeshFileError::Beside { name }),
    }
}

/// A name as URIs write it: `%20` for a space.
fn decode_percent(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let coded = tail.get(..2).filter(|_| first == b'%');
        let coded = coded.and_then(|two| std::str::from_utf8(two).ok());
        match coded.and_then(|two| u8::from_str_radix(two, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

pub(super) fn malformed(reason: &str) -> MeshFileError {
    MeshFileError::Malformed { line: None, reason: reason.to_owned() }
}
