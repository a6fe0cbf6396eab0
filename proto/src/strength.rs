//! A body's strength field on its way with a job: what is painted on a mesh travels behind the
//! header.

use crate::codec::{self, WireError};
use crate::mesh::{self, Slabs};
use cullet_model::StrengthField;
use cullet_model::strength::{Region, VertexPaint};
use std::sync::Arc;

/// Most painted regions: they travel in the header.
pub const MAX_STROKES: usize = 256;

/// Checks its numbers against the limits of the wire; the two texts name them in errors.
pub(crate) fn check(
    field: &StrengthField,
    (what_regions, what_numbers): (&'static str, &'static str),
) -> Result<(), WireError> {
    codec::limit(what_regions, field.strokes.len() as u64, MAX_STROKES as u64)?;
    let mut numbers = vec![field.weibull];
    numbers.extend(field.correlation);
    numbers.extend(field.offset.iter());
    if let Some(weak) = &field.weak_plane {
        numbers.extend(weak.normal.iter());
        numbers.push(weak.ratio);
    }
    if let Some(layers) = &field.layers {
        numbers.extend(layers.normal.iter());
        numbers.extend([layers.thickness, layers.ratio, layers.jitter]);
    }
    for stroke in &field.strokes {
        numbers.extend([stroke.factor, stroke.edge]);
        match stroke.region {
            Region::Box { low: one, high: two } | Region::HalfSpace { point: one, normal: two } => {
                numbers.extend(one.iter().chain(two.iter()));
            }
            Region::Sphere { centre, radius } => {
                numbers.extend(centre.iter().chain([&radius]));
            }
            Region::Groove { from, to, inward, half_width } => {
                let places = [from, to, inward];
                numbers.extend(places.iter().flat_map(|place| place.iter()).chain([&half_width]));
            }
            Region::Cylinder { from, to, radius } => {
                numbers.extend(from.iter().chain(to.iter()).chain([&radius]));
            }
        }
    }
    codec::finite(what_numbers, &numbers)
}

/// How many painted points there are, and how deep they reach, for the header.
pub(crate) fn announced(field: &StrengthField) -> Result<Option<(u32, f64)>, WireError> {
    let Some(paint) = &field.vertices else { return Ok(None) };
    let (have, need) = (paint.factors.len(), paint.points.len());
    codec::limit("a job's painted points", need as u64, mesh::MAX_VERTICES)?;
    if have != need {
        return Err(WireError::Short { what: "a job's painted factors", have, need });
    }
    codec::finite("a job's paint", &[paint.reach])?;
    Ok(Some((need as u32, paint.reach)))
}

/// Writes what is painted on a mesh.
pub(crate) fn put(field: &StrengthField, out: &mut Vec<u8>) {
    if let Some(paint) = &field.vertices {
        mesh::put_points(out, &paint.points);
        paint.factors.iter().for_each(|f| out.extend_from_slice(&f.to_le_bytes()));
    }
}

/// Reads what is painted on a mesh.
pub(crate) fn take(
    field: &mut StrengthField,
    announced: Option<(u32, f64)>,
    slabs: &mut Slabs<'_>,
) -> Result<(), WireError> {
    let Some((count, reach)) = announced else { return Ok(()) };
    codec::limit("a job's painted points", u64::from(count), mesh::MAX_VERTICES)?;
    codec::finite("a job's paint", &[reach])?;
    let points = slabs.points("a job's painted points", count as usize)?;
    let bytes = slabs.take("a job's painted factors", count as usize, 8)?;
    let factors: Vec<f64> = bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    codec::finite("a job's painted factors", &factors)?;
    field.vertices = Some(Arc::new(VertexPaint { points, factors, reach }));
    Ok(())
}
