//! Division of a surface with thickness into quads: edges along one smooth field of crosses and
//! along the rims, nearly all corners shared by four.
//!
//! After \[Jakob, Tarini, Panozzo & Sorkine-Hornung 2015, *Instant Field-Aligned Meshes*\]: a
//! direction and a square lattice at each vertex are made to agree with its neighbours'. Unlike
//! there, the quads are cut out of the triangles by merges of vertices that keep the topology, so
//! that holes and pinched vertices cannot arise.

mod crosses;
mod extract;
mod hierarchy;
mod net;
mod orientation;
mod phase;
mod position;
mod smooth;

use crate::math::{Vec3, scramble};
use crate::mesh::TriMesh;
use crate::remesh::editable::{EditableMesh, VertexRole};
use crate::remesh::reference_surface::{ReferenceSurface, boundary_loops};
use crate::remesh::{SurfaceError, check_surface};
use crate::shapes::{self, ShapeError};
use crate::wall_surface::WallSurface;
use crosses::{nearest_arm, tangent};
use hierarchy::RimHold;
use net::{QuadNet, SurfaceTopology};
use thiserror::Error;

/// Side of the lattice over the wanted edge: each of its squares is divided into four quads.
const COARSE: f64 = 2.0;
/// Longest edge of the triangles that carry the field, over the wanted edge.
const FIELD_EDGE: f64 = 0.8;
/// Rim vertices this near to a corner, over the wanted edge, are not corners too.
const CORNER_REACH: f64 = 1.0;
/// Seeds that are tried before a surface is given up.
const ATTEMPTS: u64 = 4;

/// Nets of which the one with the fewest irregular vertices is taken: two halve the odds of an
/// uneven one, and each takes half a second for 5000 quads.
const CANDIDATES: usize = 2;

/// Why a surface cannot be divided into quads.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum QuadError {
    /// The surface is not one manifold with a thickness at each vertex.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The surface would have to be divided too finely.
    #[error(transparent)]
    Fine(#[from] ShapeError),
    /// The edge is too long for the surface, or not a positive number.
    #[error("the edge is {edge:e} m; for this surface it must be > 0 and at most {most:e} m")]
    Edge {
        /// Edge asked for \[m\].
        edge: f64,
        /// Greatest accepted \[m\].
        most: f64,
    },
    /// No attempt gave a manifold with the rims and handles of the surface.
    #[error("{attempts} attempts gave no net of quads with the rims and handles of the surface")]
    Torn {
        /// Seeds tried.
        attempts: u64,
    },
}

/// A surface of quadrilaterals with a thickness: most vertices have four.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadSurface {
    /// Vertices \[m\].
    pub vertices: Vec<Vec3>,
    /// Four vertex indices each, counter-clockwise seen from the side that normals point to.
    pub quads: Vec<[u32; 4]>,
    /// Thickness at each vertex \[m\].
    pub thickness: Vec<f64>,
}

impl QuadSurface {
    /// Divides `wall` into quads with edges of about `edge` \[m\]. Sharp turns of a rim stay
    /// vertices. Equal input and `seed` give equal bits.
    ///
    /// # Errors
    /// A surface that is in pieces or not manifold; an edge too long for it; a surface for which
    /// no quads with its topology were found.
    pub fn of_wall(wall: &WallSurface, edge: f64, seed: u64) -> Result<Self, QuadError> {
        let mesh = wall.mesh();
        check_surface(&mesh, &wall.thickness)?;
        let most = mesh.area().sqrt() / 4.0;
        if !(edge > 0.0 && edge <= most) {
            return Err(QuadError::Edge { edge, most });
        }
        let wanted = SurfaceTopology::of_triangles(&mesh);
        let surface = ReferenceSurface::new(mesh, wall.thickness.clone());
        let fine = shapes::refine(&wall.mesh(), FIELD_EDGE * edge)?;
        let start = with_rims(&fine, &surface, edge);
        let levels = hierarchy::levels(&fine, holds(&fine, &start));
        let mut found: Vec<QuadNet> = Vec::new();
        for attempt in 0..ATTEMPTS {
            let seed = scramble(seed).wrapping_add(attempt);
            let directions = orientation::directions(&levels, seed);
            let mut lattice = start.clone();
            lattice.points = position::positions(&levels, &directions, COARSE * edge, seed);
            let net = quads_of(lattice, edge);
            if net.topology() == Some(wanted) {
                found.push(net);
            }
            if found.len() == CANDIDATES {
                break;
            }
        }
        let best = found.into_iter().min_by_key(QuadNet::irregular);
        let mut net = best.ok_or(QuadError::Torn { attempts: ATTEMPTS })?;
        smooth::smooth(&mut net, &surface, edge);
        smooth::polish(&mut net, &surface, edge);
        let thickness = net.points.iter().map(|&p| surface.thickness(p)).collect();
        Ok(Self { vertices: net.points, quads: net.quads, thickness })
    }
}

/// The quads of a mesh whose vertices stand on their lattice points.
fn quads_of(mut lattice: EditableMesh, edge: f64) -> QuadNet {
    extract::merge_lattice_points(&mut lattice, COARSE * edge);
    extract::divided(&lattice, &extract::faces(&lattice))
}

/// The mesh with its rims and their corners marked.
fn with_rims(mesh: &TriMesh, surface: &ReferenceSurface, edge: f64) -> EditableMesh {
    let mut marked = EditableMesh::new(mesh);
    for v in boundary_loops(mesh).into_iter().flatten() {
        marked.role[v as usize] = VertexRole::Border;
    }
    // The division kept the indices.
    for v in surface.corners(CORNER_REACH * edge) {
        marked.role[v as usize] = VertexRole::Corner;
    }
    marked
}

/// The holds of all rim vertices: the direction between the two edges of the rim, as one cross.
fn holds(mesh: &TriMesh, marked: &EditableMesh) -> Vec<Option<RimHold>> {
    let mut holds = vec![None; mesh.vertices.len()];
    for points in boundary_loops(mesh) {
        let n = points.len();
        let at = |i: usize| mesh.vertices[points[i % n] as usize];
        for (i, &v) in points.iter().enumerate() {
            let normal = marked.normal(v);
            let [into, out] =
                [at(i) - at(i + n - 1), at(i + 1) - at(i)].map(|w| tangent(w, normal));
            let is_corner = marked.role[v as usize] == VertexRole::Corner;
            let along = tangent(into + nearest_arm(into, out, normal), normal);
            holds[v as usize] = Some(RimHold { at: at(i), along, is_corner });
        }
    }
    holds
}

#[cfg(test)]
mod tests;
