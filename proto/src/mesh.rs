//! Meshes as little-endian slabs: vertices (3 × f64 \[m\]), triangles (3 × u32), and a u32 surface
//! tag for each triangle: all ones for the outer surface, else the number of the body that broke
//! plus one (0: not named). Then for each crack triangle in order, at its three corners: the damage
//! times (3 × f32 \[s\]), and after those of all of them the front speeds (3 × f32 \[m/s\]), finite
//! and not negative. A sheet is vertices and triangles, then the damage time of each vertex, then
//! its front speed.

use crate::codec::{self, WireError};
use cullet_geometry::{Sheet, Solid, Surface, TriMesh, Vec3};

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
        let mesh = self.mesh(vertices, triangles)?;
        let tags = self.u32s("a mesh's surface tags", mesh.triangles.len())?;
        let cracks = tags.iter().filter(|&&tag| tag != OUTER).count();
        let times = self.marks("a mesh's damage times", 3 * cracks)?;
        let speeds = self.marks("a mesh's front speeds", 3 * cracks)?;
        let mut marks = times.as_chunks().0.iter().zip(speeds.as_chunks().0);
        let surface = |parent: u32| {
            let marks = if parent == OUTER { None } else { marks.next() };
            marks.map_or(Surface::Outer, |(&damage_time, &front_speed)| Surface::Crack {
                damage_time,
                front_speed,
                parent,
            })
        };
        let surface = tags.into_iter().map(surface).collect();
        Ok(Solid { mesh, surface })
    }

    /// The next sheet.
    ///
    /// # Errors
    /// As [`Slabs::solid`].
    pub fn sheet(&mut self, vertices: u32, triangles: u32) -> Result<Sheet, WireError> {
        let mesh = self.mesh(vertices, triangles)?;
        let count = mesh.vertices.len();
        let damage_time = self.marks("a sheet's damage times", count)?;
        let front_speed = self.marks("a sheet's front speeds", count)?;
        Ok(Sheet { mesh, damage_time, front_speed })
    }

    fn mesh(&mut self, vertices: u32, triangles: u32) -> Result<TriMesh, WireError> {
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
        Ok(TriMesh { vertices, triangles })
    }

    /// The next `count` times or speeds: finite, not negative, and no negative zero.
    ///
    /// # Errors
    /// [`WireError::Short`], [`WireError::Mark`].
    pub fn marks(&mut self, what: &'static str, count: usize) -> Result<Vec<f32>, WireError> {
        let marks: Vec<f32> = self.u32s(what, count)?.into_iter().map(f32::from_bits).collect();
        match marks.iter().position(|x| !(x.is_finite() && x.is_sign_positive())) {
            Some(index) => Err(WireError::Mark { what, index, value: marks[index] }),
            None => Ok(marks),
        }
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
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

fn put_mesh(out: &mut Vec<u8>, mesh: &TriMesh) {
    put_points(out, &mesh.vertices);
    put_u32s(out, mesh.triangles.iter().flatten().copied());
}

/// Appends a sheet.
pub fn put_sheet(out: &mut Vec<u8>, sheet: &Sheet) {
    put_mesh(out, &sheet.mesh);
    put_marks(out, &sheet.damage_time);
    put_marks(out, &sheet.front_speed);
}

/// Appends a solid.
pub fn put_solid(out: &mut Vec<u8>, solid: &Solid) {
    put_mesh(out, &solid.mesh);
    let tag = |surface: &Surface| match *surface {
        Surface::Outer => OUTER,
        // The last name is never given: it would take more bodies than there are numbers.
        Surface::Crack { parent, .. } => parent.min(OUTER - 1),
    };
    put_u32s(out, solid.surface.iter().map(tag));
    let cracks = solid.surface.iter().filter_map(|surface| match *surface {
        Surface::Outer => None,
        Surface::Crack { damage_time, front_speed, .. } => Some([damage_time, front_speed]),
    });
    for which in [0, 1] {
        cracks.clone().for_each(|marks| put_marks(out, &marks[which]));
    }
}

/// Appends times or speeds.
pub fn put_marks(out: &mut Vec<u8>, marks: &[f32]) {
    // Adding zero turns −0 into +0: one time, one encoding.
    put_u32s(out, marks.iter().map(|mark| (mark + 0.0).to_bits()));
}

/// A solid's counts, held to their limits, with one tag a triangle.
///
/// # Errors
/// [`WireError::Limit`], [`WireError::Short`].
pub fn counts(solid: &Solid) -> Result<(u32, u32), WireError> {
    let counts = mesh_counts(&solid.mesh)?;
    short("a mesh's surface tags", solid.surface.len(), solid.mesh.triangles.len())?;
    Ok(counts)
}

/// A sheet's counts, held to their limits, with one time and one speed a vertex.
///
/// # Errors
/// [`WireError::Limit`], [`WireError::Short`].
pub fn sheet_counts(sheet: &Sheet) -> Result<(u32, u32), WireError> {
    let counts = mesh_counts(&sheet.mesh)?;
    short("a sheet's damage times", sheet.damage_time.len(), sheet.mesh.vertices.len())?;
    short("a sheet's front speeds", sheet.front_speed.len(), sheet.mesh.vertices.len())?;
    Ok(counts)
}

fn mesh_counts(mesh: &TriMesh) -> Result<(u32, u32), WireError> {
    let (nv, nt) = (mesh.vertices.len(), mesh.triangles.len());
    codec::limit("a mesh's vertices", nv as u64, MAX_VERTICES)?;
    codec::limit("a mesh's triangles", nt as u64, MAX_TRIANGLES)?;
    Ok((nv as u32, nt as u32))
}

fn short(what: &'static str, have: usize, need: usize) -> Result<(), WireError> {
    if have == need { Ok(()) } else { Err(WireError::Short { what, have, need }) }
}
