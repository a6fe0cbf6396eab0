//! Bodies that move as they deform: their surfaces, and where these are.
//!
//! They have a schema of their own, which names that of the other messages: a recording without
//! such bodies has the bytes that it had before there were any.

use super::messages;
use super::schema::{MessageDeclaration, PACKAGE, message};
use super::sheet_error::{SheetError, finite, length};
use super::vector::Vector3;
use super::windows;
use cullet_geometry::Vec3;
use cullet_model::{MovingSurface, SurfaceFrame};

message! {
    /// A surface whose points move, recorded once and named by the digest of its content.
    SheetSurface {
        /// BLAKE3 of the content, 32 bytes: equal surfaces have equal digests.
        "1" [bytes = "vec"] hash: Vec<u8>,
        /// Three points a triangle, counter-clockwise seen from the outside, or from above where
        /// the sheet lies at rest.
        "2" [uint32, repeated] triangles: Vec<u32>,
        /// x, y of each point at rest, in the plane of its sheet \[m\].
        "3" [float, repeated] reference: Vec<f32>,
        /// Thickness with which it is drawn \[m\]; 0 for a closed surface.
        "4" [float] thickness: f32,
    }
}

message! {
    /// Where the points of a sheet are after a step.
    SheetFrame {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// Number of the sheet, never reused in a run.
        "3" [uint32] sheet: u32,
        /// Its name.
        "4" [string] name: String,
        /// Name of its material.
        "5" [string] material: String,
        /// Digest of its [`SheetSurface`].
        "6" [bytes = "vec"] surface: Vec<u8>,
        /// What places are counted from \[m\].
        "7" [message, optional] origin: Option<Vector3>,
        /// x, y, z of each point from there \[m\].
        "8" [float, repeated] offsets: Vec<f32>,
        /// Of each point: the quantity that diffuses; empty where none does.
        "9" [float, repeated] quantity: Vec<f32>,
    }
}

pub(super) fn declarations() -> Vec<MessageDeclaration> {
    let mut all = vec![SheetSurface::declaration(), SheetFrame::declaration()];
    all.extend(windows::declarations());
    all
}

/// The schema of the messages of sheets: that of the others, and a file of their own beside it.
#[must_use]
pub fn sheet_schema_bytes() -> Vec<u8> {
    messages::declarations().to_bytes_with("cullet/sheets.proto", &declarations())
}

/// The schema that a message of ours is recorded with, by its full name.
#[must_use]
pub fn schema_of(name: &str) -> Vec<u8> {
    let own = name.strip_prefix(PACKAGE).and_then(|name| name.strip_prefix('.'));
    let of_sheets = declarations().iter().any(|it| Some(it.descriptor.name()) == own);
    if of_sheets { sheet_schema_bytes() } else { messages::schema_bytes() }
}

/// BLAKE3 over counts, indices, coordinate bits and thickness, little-endian.
#[must_use]
pub fn surface_hash(surface: &MovingSurface) -> [u8; 32] {
    let mut bytes = Vec::new();
    bytes.extend((surface.triangles.len() as u64).to_le_bytes());
    bytes.extend((surface.reference.len() as u64).to_le_bytes());
    surface.triangles.iter().flatten().for_each(|index| bytes.extend(index.to_le_bytes()));
    surface.reference.iter().flatten().for_each(|x| bytes.extend(x.to_bits().to_le_bytes()));
    bytes.extend(surface.thickness.to_bits().to_le_bytes());
    *blake3::hash(&bytes).as_bytes()
}

impl From<&MovingSurface> for SheetSurface {
    fn from(surface: &MovingSurface) -> Self {
        Self {
            hash: surface_hash(surface).to_vec(),
            triangles: surface.triangles.iter().flatten().copied().collect(),
            reference: surface.reference.iter().flatten().copied().collect(),
            thickness: surface.thickness,
        }
    }
}

impl TryFrom<&SheetSurface> for MovingSurface {
    type Error = SheetError;

    fn try_from(it: &SheetSurface) -> Result<Self, SheetError> {
        let (triangles, rest) = it.triangles.as_chunks::<3>();
        length("triangles", it.triangles.len(), it.triangles.len() - rest.len())?;
        let (reference, rest) = it.reference.as_chunks::<2>();
        length("reference", it.reference.len(), it.reference.len() - rest.len())?;
        let surface = Self {
            triangles: triangles.to_vec(),
            reference: reference.to_vec(),
            thickness: it.thickness,
        };
        check_surface(&surface)?;
        if it.hash == surface_hash(&surface) { Ok(surface) } else { Err(SheetError::Digest) }
    }
}

/// Holds a surface to its numbers and indices.
///
/// # Errors
/// The first that does not hold.
pub fn check_surface(surface: &MovingSurface) -> Result<(), SheetError> {
    finite("thickness", &[surface.thickness])?;
    finite("reference", surface.reference.as_flattened())?;
    let points = surface.reference.len();
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        if let Some(&point) = corners.iter().find(|&&point| point as usize >= points) {
            return Err(SheetError::Index { triangle, point, points });
        }
    }
    Ok(())
}

impl SheetFrame {
    /// Where its points are \[m\], of so many as its surface has, checked.
    ///
    /// # Errors
    /// A column of another length, or a number that is none.
    pub fn places(&self, points: usize) -> Result<Vec<Vec3>, SheetError> {
        let origin = self.origin.ok_or(SheetError::Missing { part: "origin" })?;
        length("offsets", self.offsets.len(), 3 * points)?;
        if !self.quantity.is_empty() {
            length("quantity", self.quantity.len(), points)?;
        }
        finite("origin", &[origin.x, origin.y, origin.z])?;
        finite("offsets", &self.offsets)?;
        finite("quantity", &self.quantity)?;
        let origin = Vec3::new(origin.x, origin.y, origin.z);
        let offsets = self.offsets.as_chunks::<3>().0.iter();
        Ok(offsets.map(|offset| origin + Vec3::from(offset.map(f64::from))).collect())
    }

    /// Takes over what a frame says of its surface's points.
    #[must_use]
    pub fn with(self, frame: &SurfaceFrame) -> Self {
        Self {
            step: frame.step,
            origin: Some(Vector3 { x: frame.origin.x, y: frame.origin.y, z: frame.origin.z }),
            offsets: frame.offsets.as_flattened().to_vec(),
            quantity: frame.quantity.clone(),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recorded;

    /// Two triangles that share an edge.
    fn square() -> MovingSurface {
        MovingSurface {
            triangles: vec![[0, 1, 2], [1, 3, 2]],
            reference: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
            thickness: 1e-4,
        }
    }

    fn frame() -> SheetFrame {
        let offsets = vec![[0.0, 0.0, 0.5]; 4];
        let origin = Vec3::new(1.0, 2.0, 1e6);
        let quantity = vec![0.0, 1.0, 2.0, 3.0];
        let frame = SurfaceFrame { step: 7, surface: 0, origin, offsets, quantity };
        SheetFrame { surface: surface_hash(&square()).to_vec(), ..SheetFrame::default() }
            .with(&frame)
    }

    #[test]
    fn a_surface_comes_back_to_the_bit_and_damage_has_a_name() {
        let good = SheetSurface::from(&square());
        let bytes = good.to_bytes();
        let back = SheetSurface::from_bytes(&bytes).expect("decodes");
        assert_eq!(MovingSurface::try_from(&back), Ok(square()));
        let refused = |damage: fn(&mut SheetSurface)| {
            let mut bad = good.clone();
            damage(&mut bad);
            MovingSurface::try_from(&bad).expect_err("is damaged").to_string()
        };
        let text = refused(|it| it.triangles.truncate(5));
        assert_eq!(text, "triangles has 5 entries, 3 are needed");
        assert_eq!(refused(|it| it.triangles[4] = 9), "triangle 1 names point 9 of 4");
        let text = refused(|it| it.reference[3] = f32::NAN);
        assert_eq!(text, "entry 3 of reference is not finite");
        let text = refused(|it| it.reference[3] += 1.0);
        assert_eq!(text, "the content does not match its digest");
        let text = refused(|it| it.thickness *= 2.0);
        assert_eq!(text, "the content does not match its digest");
    }

    #[test]
    fn places_are_offsets_from_the_origin_or_an_error_with_its_place() {
        assert_eq!(frame().places(4).expect("places")[3], Vec3::new(1.0, 2.0, 1e6 + 0.5));
        let refused = |damage: fn(&mut SheetFrame)| {
            let mut bad = frame();
            damage(&mut bad);
            bad.places(4).expect_err("is damaged").to_string()
        };
        assert_eq!(refused(|it| it.origin = None), "it has no origin");
        assert_eq!(refused(|it| it.offsets.truncate(9)), "offsets has 9 entries, 12 are needed");
        assert_eq!(refused(|it| it.offsets[5] = f32::INFINITY), "entry 5 of offsets is not finite");
        assert_eq!(refused(|it| it.quantity.truncate(3)), "quantity has 3 entries, 4 are needed");
        let mut bare = frame();
        bare.quantity.clear();
        assert!(bare.places(4).is_ok());
    }
}
