//! The midsurface of thin-walled bodies: bottles, bulbs, bowls, eggs, curved panes.
//!
//! Faces are paired across the wall, one wall is moved to half way between the two, led to the rim
//! and remeshed to triangles of one size. A shell solver lays its subdivision surface on them.

mod middle;
mod not_wall;
mod pairing;
mod rim;
mod thicken;

pub use crate::wall_surface::WallSurface;
pub use not_wall::{
    LEAST_RADIUS, NotWall, PAIRED_SHARE, RAGGED, SHARP_SHARE, THICK_RATIO, THICKNESS_SPREAD,
    VOLUME_ERROR,
};
pub use thicken::thicken;

use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::{Solid, TriMesh};
use crate::remesh::curved::{CurvedMesh, area_vector, unit_or};
use crate::remesh::reference_surface::ReferenceSurface;
use crate::remesh::{self, MAX_SURFACE_TRIANGLES, REFERENCE_EDGE};
use crate::surface::Surface;
use middle::MiddleSurface;
use pairing::{WallFace, WallPairs, quantile};
use rim::CrackedRims;

/// How far from a wall a place on its rim may be, over the thickness.
const BESIDE: f64 = 2.0;

/// What a thin wall is like, before its midsurface is made.
#[derive(Clone, Debug)]
pub struct WallOutline {
    /// Median thickness \[m\].
    pub thickness: f64,
    /// Lesser of the square root of a wall's area and the middle extent of its box \[m\].
    pub width: f64,
    kind: Vec<WallFace>,
}

impl WallOutline {
    /// Of a closed mesh, from its triangles as they are: much less work than
    /// [`WallSurface::of_mesh`], which may still refuse what this takes.
    ///
    /// # Errors
    /// As [`WallSurface::of_mesh`], but for what only the midsurface shows.
    pub fn of_mesh(mesh: &TriMesh) -> Result<Self, NotWall> {
        Self::with_rims(mesh, &vec![false; mesh.triangles.len()])
    }

    /// Of a solid, whose crack faces are rims.
    ///
    /// # Errors
    /// As [`WallOutline::of_mesh`].
    pub fn of_solid(solid: &Solid) -> Result<Self, NotWall> {
        Self::with_rims(&solid.mesh, &crack_faces(solid))
    }

    fn with_rims(mesh: &TriMesh, rims: &[bool]) -> Result<Self, NotWall> {
        check_closed(mesh)?;
        let pairs = WallPairs::of_mesh(mesh, rims)?;
        let width = check_pairs(mesh, &pairs)?;
        Ok(Self { thickness: pairs.median, width, kind: pairs.kind })
    }

    /// How straight a direction goes through the wall of `mesh`, which this is the outline of, at
    /// a place on it \[m\]: |cos| of the angle to its normal; beside a rim, to that of the wall
    /// there.
    #[must_use]
    pub fn across(&self, mesh: &TriMesh, place: Vec3, direction: &Vec3) -> f64 {
        let is_wall = |t: usize| self.kind[t] != WallFace::Rim;
        let found = Nearest::new(mesh).closest_within(place, BESIDE * self.thickness, is_wall);
        let normal = |t: usize| unit_or(area_vector(mesh, t), Vec3::zeros());
        found.map_or(0.0, |(_, _, t)| normal(t).dot(direction).abs())
    }
}

fn crack_faces(solid: &Solid) -> Vec<bool> {
    solid.surface.iter().map(|surface| *surface != Surface::Outer).collect()
}

fn check_closed(mesh: &TriMesh) -> Result<(), NotWall> {
    if mesh.is_closed() {
        return Ok(());
    }
    let is_open = |e: &&crate::mesh::EdgeUse| (e.forward, e.backward) != (1, 1);
    Err(NotWall::Open { edges: mesh.edges().iter().filter(is_open).count() })
}

impl WallSurface {
    /// Finds the midsurface of a closed thin-walled mesh and divides it into triangles with edges
    /// of about `spacing` \[m\].
    ///
    /// Facets stand for a smooth surface: they are divided along arcs that fit the normals at
    /// their corners, except across edges of more than 40°. The thickness at a face is the diameter
    /// of the largest ball inside that touches it and a face turned the other way (n·n' < −0.8).
    /// Faces without such a ball, or with one of over 2.5 times the median thickness, have no
    /// partner. A connected region of those that touches both walls and is no larger than four
    /// times thickness times length is the rim: it counts neither for nor against the body. All
    /// other faces without partner, and those whose partner is on their own wall (ribs, solid
    /// handles), count against it.
    ///
    /// # Errors
    /// What keeps the body from being a thin wall, with the figure and the bound (F91, F95).
    pub fn of_mesh(mesh: &TriMesh, spacing: f64) -> Result<Self, NotWall> {
        Self::with_rims(mesh, &vec![false; mesh.triangles.len()], spacing)
    }

    /// The same of a solid, whose crack faces are rims: smoothed over some four edges, without the
    /// holes and narrow bays that are smaller than that.
    ///
    /// # Errors
    /// As [`WallSurface::of_mesh`]; too much filled or taken off.
    pub fn of_solid(solid: &Solid, spacing: f64) -> Result<Self, NotWall> {
        Self::with_rims(&solid.mesh, &crack_faces(solid), spacing)
    }

    fn with_rims(mesh: &TriMesh, rims: &[bool], spacing: f64) -> Result<Self, NotWall> {
        check_closed(mesh)?;
        // Both walls have to be divided.
        remesh::check_spacing(mesh.area(), spacing)?;
        let fine = CurvedMesh::new(mesh).refined(REFERENCE_EDGE * spacing, MAX_SURFACE_TRIANGLES);
        let rims: Vec<bool> = fine.origin.iter().map(|&t| rims[t as usize]).collect();
        let fine = fine.mesh;
        let pairs = WallPairs::of_mesh(&fine, &rims)?;
        check_pairs(&fine, &pairs)?;
        let middle = MiddleSurface::between(&fine, &pairs)
            .ok_or(NotWall::Unpaired { share: pairs.share })?;
        remesh::check_surface(&middle.mesh, &middle.thickness)?;
        let reference = ReferenceSurface::new(middle.mesh, middle.thickness);
        let surface = remesh::remeshed(&reference, spacing);
        surface.check(mesh.signed_volume())?;
        if !rims.contains(&true) {
            return Ok(surface);
        }
        let faces = Nearest::new(&fine);
        let is_rim = |t: usize| pairs.kind[t] == WallFace::Rim;
        let is_crack = |x: Vec3| {
            let found = faces.closest_within(x, BESIDE * pairs.median, is_rim);
            found.is_some_and(|(_, _, t)| rims[t])
        };
        let smooth = CrackedRims::new(surface, spacing, is_crack).smooth();
        let share = smooth.sharp_share();
        if share > SHARP_SHARE {
            return Err(NotWall::Sharp { share });
        }
        let share = smooth.volume() / mesh.signed_volume();
        let holds = (share - 1.0).abs() <= RAGGED;
        if holds { Ok(smooth) } else { Err(NotWall::Ragged { share }) }
    }

    /// Refuses a midsurface that bends too sharply or has not the volume of the body \[m³\].
    fn check(&self, volume: f64) -> Result<(), NotWall> {
        let share = self.sharp_share();
        if share > SHARP_SHARE {
            return Err(NotWall::Sharp { share });
        }
        let share = self.volume() / volume;
        if (share - 1.0).abs() <= VOLUME_ERROR { Ok(()) } else { Err(NotWall::Volume { share }) }
    }

    /// The share of the area with a radius of curvature under [`LEAST_RADIUS`] times its
    /// thickness: by the turn of the normal along the edges at each vertex.
    fn sharp_share(&self) -> f64 {
        let mesh = self.mesh();
        let curvature = greatest_curvatures(&mesh);
        let (mut sharp, mut whole) = (0.0, 0.0);
        for (t, corners) in self.triangles.iter().enumerate() {
            let third = self.triangle_area(t) / 3.0;
            for v in corners.iter().map(|&v| v as usize) {
                whole += third;
                if curvature[v] * self.thickness[v] * LEAST_RADIUS > 1.0 {
                    sharp += third;
                }
            }
        }
        sharp / whole
    }
}

/// At each vertex the greatest normal curvature along its edges \[1/m\].
fn greatest_curvatures(mesh: &TriMesh) -> Vec<f64> {
    let normals = vertex_normals(mesh);
    let mut greatest = vec![0.0_f64; mesh.vertices.len()];
    for edge in mesh.edges() {
        let (a, b) = (edge.from as usize, edge.to as usize);
        let way = mesh.vertices[b] - mesh.vertices[a];
        let curvature = ((normals[b] - normals[a]).dot(&way) / way.norm_squared()).abs();
        greatest[a] = greatest[a].max(curvature);
        greatest[b] = greatest[b].max(curvature);
    }
    greatest
}

/// Unit normals at the vertices, weighted by area.
#[must_use]
pub fn vertex_normals(mesh: &TriMesh) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); mesh.vertices.len()];
    for t in 0..mesh.triangles.len() {
        let area = area_vector(mesh, t);
        mesh.triangles[t].iter().for_each(|&v| sums[v as usize] += area);
    }
    sums.into_iter().map(|n| unit_or(n, Vec3::zeros())).collect()
}

/// Refuses a body that is thick, unpaired, or of very uneven thickness; its width \[m\].
fn check_pairs(mesh: &TriMesh, pairs: &WallPairs) -> Result<f64, NotWall> {
    let area = |t: usize| area_vector(mesh, t).norm();
    let side = || (0..pairs.kind.len()).filter(|&t| pairs.kind[t] == WallFace::Side);
    let mut extents = mesh.bounds().map_or([0.0; 3], |(low, high)| (high - low).into());
    extents.sort_by(f64::total_cmp);
    let width = side().map(area).sum::<f64>().sqrt().min(extents[1]);
    let ratio = pairs.median / width;
    if ratio > THICK_RATIO {
        return Err(NotWall::Thick { ratio });
    }
    if pairs.share < PAIRED_SHARE {
        return Err(NotWall::Unpaired { share: pairs.share });
    }
    let at = |share: f64| quantile(side().map(|t| (pairs.thickness[t], area(t))).collect(), share);
    let ratio = at(0.95).unwrap_or(0.0) / at(0.05).unwrap_or(0.0);
    if ratio > THICKNESS_SPREAD { Err(NotWall::Varies { ratio }) } else { Ok(width) }
}

#[cfg(test)]
pub(crate) mod tests;
