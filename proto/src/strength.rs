//! How a body's strength varies from place to place, as it travels with a job.

use crate::codec::{self, WireError};
use crate::mesh::{self, Slabs};
use cullet_geometry::Vec3;
use serde::{Deserialize, Serialize};

/// Most painted regions: they travel in the header.
pub const MAX_STROKES: usize = 256;

/// Alternating layers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layers {
    /// Unit normal, pattern frame.
    pub normal: [f64; 3],
    /// Thickness of one layer \[m\].
    pub thickness: f64,
    /// Strength of every second layer over σ_f \[1\].
    pub ratio: f64,
    /// Each boundary is moved by up to half this share of the thickness \[1\].
    pub jitter: f64,
}

/// Across planes of this normal the strength is a share of σ_f.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WeakPlane {
    /// Unit normal, pattern frame.
    pub normal: [f64; 3],
    /// The share \[1\].
    pub ratio: f64,
}

/// A part of space, pattern frame \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Region {
    /// Lowest and highest corner.
    Box([f64; 3], [f64; 3]),
    /// Centre and radius.
    Sphere([f64; 3], f64),
    /// A point of the plane, and its unit normal out of the half-space.
    HalfSpace([f64; 3], [f64; 3]),
    /// The middles of both ends, and the radius.
    Cylinder([f64; 3], [f64; 3], f64),
}

/// A region whose strength is multiplied.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stroke {
    /// Where.
    pub region: Region,
    /// Strength within over strength without \[1\].
    pub factor: f64,
    /// Width of the seam \[m\].
    pub edge: f64,
}

/// Factors at points of the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexPaint {
    /// Where, pattern frame \[m\].
    pub points: Vec<Vec3>,
    /// Strength over unpainted strength at each \[1\].
    pub factors: Vec<f64>,
    /// How deep the paint goes \[m\].
    pub reach: f64,
}

/// Weibull modulus from which on strength does not scatter at all \[1\]: the wire has no infinity.
pub const EVEN: f64 = 1e3;

/// The strength field of a body beside σ_f.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Of the original body.
    pub seed: u64,
    /// Weibull modulus \[1\].
    pub weibull: f64,
    /// Correlation length \[m\]; the solver chooses without it.
    pub correlation: Option<f64>,
    /// From a point of the body's frame to where it was in the original body's \[m\].
    pub offset: [f64; 3],
    /// A weak plane.
    pub weak_plane: Option<WeakPlane>,
    /// Layers.
    pub layers: Option<Layers>,
    /// Painted regions.
    pub strokes: Vec<Stroke>,
    /// Factors painted on the surface; they travel behind the header.
    #[serde(skip)]
    pub vertices: Option<VertexPaint>,
}

impl Default for Strength {
    /// No flaws that matter, nothing painted.
    fn default() -> Self {
        Self {
            seed: 0,
            weibull: EVEN,
            correlation: None,
            offset: [0.0; 3],
            weak_plane: None,
            layers: None,
            strokes: Vec::new(),
            vertices: None,
        }
    }
}

impl Strength {
    pub(crate) fn check(&self) -> Result<(), WireError> {
        codec::limit("a job's painted regions", self.strokes.len() as u64, MAX_STROKES as u64)?;
        let mut numbers = vec![self.weibull];
        numbers.extend(self.correlation);
        numbers.extend(self.offset);
        if let Some(weak) = &self.weak_plane {
            numbers.extend(weak.normal);
            numbers.push(weak.ratio);
        }
        if let Some(layers) = &self.layers {
            numbers.extend(layers.normal);
            numbers.extend([layers.thickness, layers.ratio, layers.jitter]);
        }
        for stroke in &self.strokes {
            numbers.extend([stroke.factor, stroke.edge]);
            match stroke.region {
                Region::Box(one, two) | Region::HalfSpace(one, two) => {
                    numbers.extend(one.into_iter().chain(two));
                }
                Region::Sphere(centre, radius) => {
                    numbers.extend(centre.into_iter().chain([radius]));
                }
                Region::Cylinder(from, to, radius) => {
                    numbers.extend(from.into_iter().chain(to).chain([radius]));
                }
            }
        }
        codec::finite("a job's strength", &numbers)
    }

    /// How many painted points there are, and how deep they reach, for the header.
    pub(crate) fn announced(&self) -> Result<Option<(u32, f64)>, WireError> {
        let Some(paint) = &self.vertices else { return Ok(None) };
        let (have, need) = (paint.factors.len(), paint.points.len());
        codec::limit("a job's painted points", need as u64, mesh::MAX_VERTICES)?;
        if have != need {
            return Err(WireError::Short { what: "a job's painted factors", have, need });
        }
        codec::finite("a job's paint", &[paint.reach])?;
        Ok(Some((need as u32, paint.reach)))
    }

    pub(crate) fn put(&self, out: &mut Vec<u8>) {
        if let Some(paint) = &self.vertices {
            mesh::put_points(out, &paint.points);
            paint.factors.iter().for_each(|f| out.extend_from_slice(&f.to_le_bytes()));
        }
    }

    pub(crate) fn take(
        &mut self,
        announced: Option<(u32, f64)>,
        slabs: &mut Slabs<'_>,
    ) -> Result<(), WireError> {
        let Some((count, reach)) = announced else { return Ok(()) };
        codec::limit("a job's painted points", u64::from(count), mesh::MAX_VERTICES)?;
        codec::finite("a job's paint", &[reach])?;
        let points = slabs.points("a job's painted points", count as usize)?;
        let bytes = slabs.take("a job's painted factors", count as usize, 8)?;
        let factors: Vec<f64> =
            bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        codec::finite("a job's painted factors", &factors)?;
        self.vertices = Some(VertexPaint { points, factors, reach });
        Ok(())
    }
}
