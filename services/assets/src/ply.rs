//! PLY, text and binary.

use super::raw::{Raw, triangles_of, triangles_of_strip};
use super::{MAX_TRIANGLES, MeshFileError};
use cullet_geometry::Vec3;
use ply_rs_bw::parser::{ParseError, Parser};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::borrow::Cow;

/// Most corners of one polygon: a larger one is a broken length.
const MAX_CORNERS: usize = 1 << 16;

/// What is wanted of an element: a point, or the corners of a face.
#[derive(Default)]
struct Element {
    point: [Option<f64>; 3],
    colour: [Option<f64>; 3],
    corners: Option<Vec<i64>>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "x" => self.point[0] = number(&property),
            "y" => self.point[1] = number(&property),
            "z" => self.point[2] = number(&property),
            "red" => self.colour[0] = shade(&property),
            "green" => self.colour[1] = shade(&property),
            "blue" => self.colour[2] = shade(&property),
            "vertex_indices" | "vertex_index" => self.corners = indices(&property),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A colour: whole numbers are of their type's greatest.
fn shade(property: &Property) -> Option<f64> {
    let full = match property {
        Property::UChar(_) => f64::from(u8::MAX),
        Property::UShort(_) => f64::from(u16::MAX),
        _ => 1.0,
    };
    number(property).map(|value| (value / full).clamp(0.0, 1.0))
}

fn number(property: &Property) -> Option<f64> {
    match property {
        Property::Float(value) => Some(f64::from(*value)),
        Property::Double(value) => Some(*value),
        Property::Char(value) => Some(f64::from(*value)),
        Property::UChar(value) => Some(f64::from(*value)),
        Property::Short(value) => Some(f64::from(*value)),
        Property::UShort(value) => Some(f64::from(*value)),
        Property::Int(value) => Some(f64::from(*value)),
        Property::UInt(value) => Some(f64::from(*value)),
        _ => None,
    }
}

fn indices(property: &Property) -> Option<Vec<i64>> {
    fn wide<T: Copy + Into<i64>>(values: &[T]) -> Option<Vec<i64>> {
        Some(values.iter().map(|value| (*value).into()).collect())
    }
    match property {
        Property::ListChar(values) => wide(values),
        Property::ListUChar(values) => wide(values),
        Property::ListShort(values) => wide(values),
        Property::ListUShort(values) => wide(values),
        Property::ListInt(values) => wide(values),
        Property::ListUInt(values) => wide(values),
        _ => None,
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw, MeshFileError> {
    let mut raw = Raw::default();
    let bytes = known_header(bytes);
    let parser = Parser::<Element>::new();
    let header = parser.read_ply_header(&mut &bytes[..]).map_err(|error| malformed(&error))?;
    for (name, element) in &header.elements {
        // Each element takes at least a byte; a larger count is a lie that would cost memory.
        if element.count as u64 > bytes.len() as u64 {
            let reason = format!("{} {name}s in a file of {} bytes", element.count, bytes.len());
            return Err(MeshFileError::Malformed { line: None, reason });
        }
    }
    let file = parser.read_ply(&mut &bytes[..]).map_err(|error| malformed(&error))?;
    let all = |name: &str| file.payload.get(name).into_iter().flatten();
    for (vertex, element) in all("vertex").enumerate() {
        let [Some(x), Some(y), Some(z)] = element.point else {
            let reason = format!("corner {vertex} has no x, y, z");
            return Err(MeshFileError::Malformed { line: None, reason });
        };
        raw.vertices.push(Vec3::new(x, y, z));
        if let [Some(red), Some(green), Some(blue)] = element.colour {
            raw.colours.push([red, green, blue]);
        }
    }
    for (face, element) in all("face").enumerate() {
        let corners = element.corners.as_deref().unwrap_or(&[]);
        if corners.len() < 3 {
            raw.left_out.add("face of fewer than three corners");
            continue;
        }
        if corners.len() > MAX_CORNERS {
            let count = corners.len();
            let reason = format!("face {face} has {count} corners; at most {MAX_CORNERS} are read");
            return Err(MeshFileError::Malformed { line: None, reason });
        }
        let polygon = known_corners(corners, face, raw.vertices.len())?;
        for places in triangles_of(&raw.vertices, &polygon) {
            raw.triangles.push(places.map(|k| polygon[k as usize]));
        }
        bound(&raw)?;
    }
    for (strip, element) in all("tristrips").enumerate() {
        // One list may have several strips, with a negative number behind each.
        for run in element.corners.as_deref().unwrap_or(&[]).split(|&index| index < 0) {
            let run = known_corners(run, strip, raw.vertices.len())?;
            raw.triangles.extend(triangles_of_strip(&run));
            bound(&raw)?;
        }
    }
    raw.left_out.add_all("edge", all("edge").count());
    Ok(raw)
}

/// The bytes without lines of the header that are none: some programs forget the word `comment`.
fn known_header(bytes: &[u8]) -> Cow<'_, [u8]> {
    let words: [&[u8]; 7] =
        [b"ply", b"format", b"comment", b"obj_info", b"element", b"property", b"end_header"];
    let first = |line: &[u8]| {
        let line = line.trim_ascii();
        line.split(u8::is_ascii_whitespace).next().map(<[u8]>::to_ascii_lowercase)
    };
    let mut header = Vec::new();
    let (mut rest, mut is_known) = (bytes, true);
    while let Some(end) = rest.iter().position(|&byte| byte == b'\n') {
        let line;
        (line, rest) = rest.split_at(end + 1);
        let word = first(line).unwrap_or_default();
        if words.contains(&&word[..]) {
            header.extend_from_slice(line);
        } else {
            is_known = false;
        }
        if word == b"end_header" {
            break;
        }
    }
    if is_known {
        return Cow::Borrowed(bytes);
    }
    header.extend_from_slice(rest);
    Cow::Owned(header)
}

/// Corners that are there.
fn known_corners(corners: &[i64], face: usize, count: usize) -> Result<Vec<u32>, MeshFileError> {
    let known = |&index: &i64| match u32::try_from(index) {
        Ok(small) if (small as usize) < count => Ok(small),
        _ => Err(MeshFileError::IndexOutOfRange { face, index, count }),
    };
    corners.iter().map(known).collect()
}

fn bound(raw: &Raw) -> Result<(), MeshFileError> {
    let count = raw.triangles.len();
    if count > MAX_TRIANGLES {
        return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
    }
    Ok(())
}

fn malformed(error: &ParseError) -> MeshFileError {
    let reason = error.to_string();
    // It says the line itself.
    let said = reason.strip_prefix("Line ").and_then(|rest| rest.split_once(": "));
    let reason = said.map_or(reason.as_str(), |(_, rest)| rest).lines().next().unwrap_or_default();
    let reason = format!("this is no PLY file as the format has it: {reason}");
    MeshFileError::Malformed { line: error.line(), reason }
}
