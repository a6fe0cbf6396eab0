//! Meshes as little-endian slabs: vertices (3 × f64 \[m\]), triangles (3 × u32), and a u32 surface
//! tag for each triangle: all ones for the outer surface, else the bits of the crack's damage time
//! (f32 \[s\], finite, not negative). Then for each crack triangle in order: the bits of the
//! front's speed (f32 \[m/s\], likewise), and the number of the body that broke plus one (u32, 0:
//! not named).

use crate::codec::{self, WireError};
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};

/// Most vertices of one mesh. Ten times the largest scan that a solver here can take up.
pub const MAX_VERTICES: u64 = 4 << 20;
/// Most triangles of one mesh.
pub const MAX_TRIANGLES: u64 = 8 << 20;

const OUTER: u32 = u32::MAX;

/// Reads slabs off the front of some bytes.
#[derive(Clone, Copy, Debug)]
pub struct Slabs<'a>(&'a [u8]);

impl<'a> Slabs<'a> {
    /// Starts at the front.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// The next `count` items of `size` bytes each.
    ///
    /// # Errors
    /// [`WireError::Short`].
    pub fn take(
        &mut self,
        what: &'static str,
        count: usize,
        size: usize,
    ) -> Result<&'a [u8], WireError> {
        let have = self.0.len();
        let need = count.saturating_mul(size);
        let Some((front, rest)) = self.0.split_at_checked(need) else {
            return Err(WireError::Short { what, have, need });
        };
        self.0 = rest;
        Ok(front)
    }

    /// The next `count` unsigned numbers.
    ///
    /// # Errors
    /// [`WireError::Short`].
    pub fn u32s(&mut self, what: &'static str, count: usize) -> Result<Vec<u32>, WireError> {
        let bytes = self.take(what, count, 4)?;
        Ok(bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
    }

    /// The next `count` points.
    ///
    /// # Errors
    /// [`WireError::Short`], [`WireError::NotFinite`].
    pub fn points(&mut self, what: &'static str, count: usize) -> Result<Vec<Vec3>, WireError> {
        let bytes = self.take(what, count, 24)?;
        let numbers: Vec<f64> =
            bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        codec::finite(what, &numbers)?;
        Ok(numbers.as_chunks().0.iter().map(|&[x, y, z]| Vec3::new(x, y, z)).collect())
    }

    /// The next solid.
    ///
    /// # Errors
    /// What is wrong with it: too short, not finite, an index out of range, a tag that is none.
    pub fn solid(&mut self, vertices: u32, triangles: u32) -> Result<Solid, WireError> {
        codec::limit("a mesh's vertices", u64::from(vertices), MAX_VERTICES)?;
        codec::limit("a mesh's triangles", u64::from(triangles), MAX_TRIANGLES)?;
        let (nv, nt) = (vertices as usize, triangles as usize);
        let vertices = self.points("a mesh's vertices", nv)?;
        let flat = self.u32s("a mesh's triangles", 3 * nt)?;
        let triangles = flat.as_chunks::<3>().0.to_vec();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|i| **i as usize >= nv) {
                return Err(WireError::Index { triangle, index, vertices: nv });
            }
        }
        let tags = self.u32s("a mesh's surface tags", nt)?;
        let cracks = tags.iter().filter(|&&tag| tag != OUTER).count();
        let speeds = self.u32s("a mesh's front speeds", cracks)?;
        let parents = self.u32s("a mesh's crack parents", cracks)?;
        let mut more = speeds.into_iter().zip(parents);
        let mut surfaces = Vec::with_capacity(nt);
        for (triangle, tag) in tags.into_iter().enumerate() {
            let crack = if tag == OUTER { None } else { more.next() };
            surfaces.push(crack.map_or(Ok(Surface::Outer), |more| surface(triangle, tag, more))?);
        }
        let surface = surfaces;
        Ok(Solid { mesh: TriMesh { vertices, triangles }, surface })
    }

    /// Nothing may be left.
    ///
    /// # Errors
    /// [`WireError::Trailing`].
    pub fn end(self, what: &'static str) -> Result<(), WireError> {
        let extra = self.0.len();
        if extra == 0 { Ok(()) } else { Err(WireError::Trailing { what, extra }) }
    }
}

fn surface(triangle: usize, time: u32, (speed, parent): (u32, u32)) -> Result<Surface, WireError> {
    let number = |tag: u32| {
        let value = f32::from_bits(tag);
        let good = value.is_finite() && value.is_sign_positive();
        if good { Ok(value) } else { Err(WireError::Tag { triangle, tag }) }
    };
    Ok(Surface::Crack { damage_time: number(time)?, front_speed: number(speed)?, parent })
}

/// Appends numbers.
pub fn put_u32s(out: &mut Vec<u8>, numbers: impl IntoIterator<Item = u32>) {
    numbers.into_iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
}

/// Appends points.
pub fn put_points(out: &mut Vec<u8>, points: &[Vec3]) {
    out.reserve(24 * points.len());
    for point in points {
        point.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
    }
}

/// Appends a solid.
pub fn put_solid(out: &mut Vec<u8>, solid: &Solid) {
    put_points(out, &solid.mesh.vertices);
    put_u32s(out, solid.mesh.triangles.iter().flatten().copied());
    let tag = |surface: &Surface| match surface {
        Surface::Outer => OUTER,
        // Adding zero turns −0 into +0: one time, one encoding.
        Surface::Crack { damage_time, .. } => (damage_time + 0.0).to_bits(),
    };
    put_u32s(out, solid.surface.iter().map(tag));
    let more = |surface: &Surface| match *surface {
        Surface::Outer => None,
        Surface::Crack { front_speed, parent, .. } => Some(((front_speed + 0.0).to_bits(), parent)),
    };
    put_u32s(out, solid.surface.iter().filter_map(more).map(|more| more.0));
    put_u32s(out, solid.surface.iter().filter_map(more).map(|more| more.1));
}

/// A solid's counts, held to their limits, with one tag a triangle.
///
/// # Errors
/// [`WireError::Limit`], [`WireError::Short`].
pub fn counts(solid: &Solid) -> Result<(u32, u32), WireError> {
    let (nv, nt) = (solid.mesh.vertices.len(), solid.mesh.triangles.len());
    codec::limit("a mesh's vertices", nv as u64, MAX_VERTICES)?;
    codec::limit("a mesh's triangles", nt as u64, MAX_TRIANGLES)?;
    if solid.surface.len() != nt {
        let have = solid.surface.len();
        return Err(WireError::Short { what: "a mesh's surface tags", have, need: nt });
    }
    Ok((nv as u32, nt as u32))
}
