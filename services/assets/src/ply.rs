//! PLY, text and binary.

use super::raw::{Raw, fan};
use super::{MAX_TRIANGLES, MeshFileError};
use cullet_geometry::Vec3;
use ply_rs_bw::parser::{ParseError, Parser};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// Most corners of one polygon: a larger one is a broken length.
const MAX_CORNERS: usize = 1024;

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
    let mut raw = Raw::default();
    for (vertex, element) in file.payload.get("vertex").into_iter().flatten().enumerate() {
        let [Some(x), Some(y), Some(z)] = element.point else {
            let reason = format!("corner {vertex} has no x, y, z");
            return Err(MeshFileError::Malformed { line: None, reason });
        };
        raw.vertices.push(Vec3::new(x, y, z));
        if let [Some(red), Some(green), Some(blue)] = element.colour {
            raw.colours.push([red, green, blue]);
        }
    }
    for (face, element) in file.payload.get("face").into_iter().flatten().enumerate() {
        let corners = element.corners.as_deref().unwrap_or(&[]);
        if !(3..=MAX_CORNERS).contains(&corners.len()) {
            let reason = format!("face {face} has {} corners", corners.len());
            return Err(MeshFileError::Malformed { line: None, reason });
        }
        let count = raw.vertices.len();
        let mut polygon = Vec::with_capacity(corners.len());
        for &index in corners {
            match u32::try_from(index) {
                Ok(small) if (small as usize) < count => polygon.push(small),
                _ => return Err(MeshFileError::IndexOutOfRange { face, index, count }),
            }
        }
        fan(&polygon, &mut raw.triangles);
        if raw.triangles.len() > MAX_TRIANGLES {
            let count = raw.triangles.len();
            return Err(MeshFileError::TooLarge { count, limit: MAX_TRIANGLES });
        }
    }
    Ok(raw)
}

fn malformed(error: &ParseError) -> MeshFileError {
    MeshFileError::Malformed { line: error.line(), reason: error.to_string() }
}
