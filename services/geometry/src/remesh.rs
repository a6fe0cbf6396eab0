//! Isotropic remeshing of a surface with thickness: triangles of one size and nearly equal sides.
//!
//! Incremental: long edges split, short ones collapsed, edges flipped towards valence six, vertices
//! smoothed over the surface and projected back onto it \[Botsch & Kobbelt 2004, *A remeshing
//! approach to multiresolution modeling*\].

pub(crate) mod curved;
pub(crate) mod editable;
mod passes;
pub(crate) mod reference_surface;
mod repair;

use crate::math::Vec3;
use crate::mesh::{MeshError, TriMesh};
use crate::wall_surface::WallSurface;
use curved::{CurvedMesh, triangles_around};
use editable::{EditableMesh, VertexRole};
use passes::Remeshing;
use reference_surface::ReferenceSurface;
use thiserror::Error;

/// Most triangles that a surface may be divided into: a few seconds of work.
pub const MAX_SURFACE_TRIANGLES: usize = 1_000_000;

/// Longest edge of the surface that is projected onto, over the spacing; half of it where it is
/// bent, so that its facets are within 1 % of the spacing of an arc.
pub(crate) const REFERENCE_EDGE: f64 = 0.8;

/// Boundary vertices this near to a corner, over the spacing, are not corners too.
const CORNER_REACH: f64 = 0.5;

/// Passes of splitting, collapsing, flipping and smoothing; lengths settle in five or six.
const PASSES: usize = 10;

/// Why a surface cannot be remeshed or thickened.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SurfaceError {
    /// The arrays are wrong.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// There is not one thickness a vertex.
    #[error("{thicknesses} thicknesses for {vertices} vertices; there must be one a vertex")]
    ThicknessLength {
        /// Thicknesses given.
        thicknesses: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// A thickness is not a positive number.
    #[error("the thickness at vertex {vertex} is {value} m; it must be > 0")]
    Thickness {
        /// Which vertex.
        vertex: usize,
        /// Its thickness \[m\].
        value: f64,
    },
    /// An edge belongs to more than two triangles, or to two that face opposite ways.
    #[error(
        "{forward} triangles run through the edge {from}–{to} one way and {backward} the other; \
         at most one may each way"
    )]
    Edge {
        /// One end.
        from: u32,
        /// The other end.
        to: u32,
        /// Triangles that run from `from` to `to`.
        forward: u32,
        /// Triangles that run from `to` to `from`.
        backward: u32,
    },
    /// The triangles at a vertex are not one fan.
    #[error("parts of the surface touch at vertex {vertex} only")]
    Vertex {
        /// Which vertex.
        vertex: u32,
    },
    /// The surface is in pieces.
    #[error("the surface is in {pieces} pieces; it must be one")]
    Pieces {
        /// How many.
        pieces: usize,
    },
    /// The spacing is too small or too large for the surface.
    #[error("the spacing is {spacing:e} m; for this surface it must lie in [{low:e}, {high:e}]")]
    Spacing {
        /// Spacing asked for \[m\].
        spacing: f64,
        /// Least accepted \[m\].
        low: f64,
        /// Greatest accepted \[m\].
        high: f64,
    },
    /// Offset walls would cross inside the thickness (F92).
    #[error(
        "the walls cross at vertex {vertex}: curvature times half the thickness is {bend:.2}; \
         at most {most} is accepted"
    )]
    Walls {
        /// Which vertex.
        vertex: u32,
        /// |κ| t/2 \[1\].
        bend: f64,
        /// Greatest accepted \[1\].
        most: f64,
    },
}

/// Remeshes an open or closed surface with a thickness at each vertex \[m\] to triangles with
/// edges of about `spacing` \[m\]. The facets stand for a smooth surface, see
/// [`WallSurface::of_mesh`]; sharp turns of a boundary stay where they are.
///
/// # Errors
/// A surface that is in pieces, not manifold or not consistently oriented; a spacing out of range.
pub fn remesh(
    mesh: &TriMesh,
    thickness: &[f64],
    spacing: f64,
) -> Result<WallSurface, SurfaceError> {
    check_surface(mesh, thickness)?;
    check_spacing(mesh.area(), spacing)?;
    let curved = CurvedMesh::new(mesh).refined(REFERENCE_EDGE * spacing, MAX_SURFACE_TRIANGLES);
    let thickness = carried(mesh, thickness, &curved.mesh);
    let surface = ReferenceSurface::new(curved.mesh, thickness);
    Ok(remeshed(&surface, spacing))
}

/// Refuses a spacing that would give too many triangles, or fewer than a few dozen.
pub(crate) fn check_spacing(area: f64, spacing: f64) -> Result<(), SurfaceError> {
    // A triangle of side l has the area 0.43 l²; the reference has about eight for each.
    let low = (8.0 * area / (0.433 * MAX_SURFACE_TRIANGLES as f64)).sqrt();
    let high = area.sqrt() / 4.0;
    let within = spacing >= low && spacing <= high;
    if within { Ok(()) } else { Err(SurfaceError::Spacing { spacing, low, high }) }
}

/// Refuses what is not one manifold, consistently oriented surface with a thickness a vertex.
pub(crate) fn check_surface(mesh: &TriMesh, thickness: &[f64]) -> Result<(), SurfaceError> {
    mesh.validate()?;
    let vertices = mesh.vertices.len();
    if mesh.triangles.is_empty() {
        return Err(MeshError::Empty { vertices }.into());
    }
    if thickness.len() != vertices {
        return Err(SurfaceError::ThicknessLength { thicknesses: thickness.len(), vertices });
    }
    if let Some(vertex) = thickness.iter().position(|t| !(t.is_finite() && *t > 0.0)) {
        return Err(SurfaceError::Thickness { vertex, value: thickness[vertex] });
    }
    if let Some(e) = mesh.edges().iter().find(|e| e.forward > 1 || e.backward > 1) {
        let (from, to, forward, backward) = (e.from, e.to, e.forward, e.backward);
        return Err(SurfaceError::Edge { from, to, forward, backward });
    }
    if let Some(vertex) = pinched_vertex(mesh) {
        return Err(SurfaceError::Vertex { vertex });
    }
    let pieces = mesh.components().len();
    if pieces == 1 { Ok(()) } else { Err(SurfaceError::Pieces { pieces }) }
}

/// The first vertex at which the triangles are more than one fan.
fn pinched_vertex(mesh: &TriMesh) -> Option<u32> {
    let around = triangles_around(mesh);
    (0u32..).zip(&around).find(|(v, fan)| fans(mesh, *v, fan).len() > 1).map(|(v, _)| v)
}

/// The triangles at a vertex grouped by shared edges.
pub(crate) fn fans(mesh: &TriMesh, v: u32, around: &[u32]) -> Vec<Vec<u32>> {
    let others = |t: u32| mesh.triangles[t as usize].into_iter().filter(move |&w| w != v);
    let mut left = around.to_vec();
    let mut fans = Vec::new();
    while !left.is_empty() {
        let mut fan = vec![left.remove(0)];
        let mut next = 0;
        while next < fan.len() {
            let t = fan[next];
            next += 1;
            left.retain(|&s| {
                let joins = others(s).any(|w| others(t).any(|u| u == w));
                if joins {
                    fan.push(s);
                }
                !joins
            });
        }
        fans.push(fan);
    }
    fans
}

/// Thickness at the vertices of a division of `mesh`: the first are those of `mesh`, the others are
/// interpolated.
fn carried(mesh: &TriMesh, thickness: &[f64], fine: &TriMesh) -> Vec<f64> {
    let coarse = ReferenceSurface::new(mesh.clone(), thickness.to_vec());
    let new = fine.vertices[thickness.len()..].iter().map(|&p| coarse.thickness(p));
    thickness.iter().copied().chain(new).collect()
}

/// Remeshes a surface that is already finely divided.
pub(crate) fn remeshed(surface: &ReferenceSurface, spacing: f64) -> WallSurface {
    let mut mesh = EditableMesh::new(&surface.mesh);
    for &v in surface.loops.iter().flatten() {
        mesh.role[v as usize] = VertexRole::Border;
        mesh.target[v as usize] = 4;
    }
    for v in surface.corners(CORNER_REACH * spacing) {
        mesh.role[v as usize] = VertexRole::Corner;
        let sixths = surface.angle_at(v) / std::f64::consts::FRAC_PI_3;
        mesh.target[v as usize] = (sixths.round() as usize + 1).clamp(3, 5);
    }
    let mut work = Remeshing { mesh, surface, spacing };
    for _ in 0..PASSES {
        work.split_long();
        work.collapse_short();
        work.flip_to_valence(false);
        work.relax();
        work.relax();
    }
    work.repair_valences();
    for _ in 0..5 {
        work.relax();
    }
    work.polish();
    let mesh = work.mesh.compacted();
    let thickness = mesh.vertices.iter().map(|&p: &Vec3| surface.thickness(p)).collect();
    WallSurface { vertices: mesh.vertices, triangles: mesh.triangles, thickness }
}

#[cfg(test)]
pub(crate) mod tests;
