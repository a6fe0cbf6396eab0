//! Division of long edges without moving the surface.

use super::detail::{Detail, ShapeError, check_count, check_edge};
use crate::divide::{divide_triangle, key};
use crate::mesh::{Solid, TriMesh};
use std::collections::BTreeMap;

/// Passes after which division stops; each halves the longest edges, so this spans a factor of 2⁴⁰.
const MAX_PASSES: usize = 40;

/// Divides every edge longer than `edge` \[m\] at its middle, longest edges first, until none is
/// left. Neighbours share each middle, so a closed mesh stays closed; the surface does not move.
///
/// # Errors
/// [`ShapeError::TooFine`].
pub fn refine(mesh: &TriMesh, edge: f64) -> Result<TriMesh, ShapeError> {
    Ok(refine_solid(&Solid::outer(mesh.clone()), edge)?.mesh)
}

/// The same of a solid: a triangle leaves its mark to those that it is divided into.
///
/// # Errors
/// As [`refine`].
pub fn refine_solid(solid: &Solid, edge: f64) -> Result<Solid, ShapeError> {
    let Solid { mut mesh, mut surface } = solid.clone();
    for _ in 0..MAX_PASSES {
        let middles = divide_edges(&mut mesh, edge);
        if middles.is_empty() {
            break;
        }
        let mut triangles = Vec::with_capacity(2 * mesh.triangles.len());
        let mut marks = Vec::with_capacity(2 * mesh.triangles.len());
        for (&corners, mark) in mesh.triangles.iter().zip(surface) {
            let middle = |edge: [u32; 2]| middles.get(&edge).copied();
            divide_triangle(&mesh.vertices, corners, middle, &mut triangles);
            marks.resize(triangles.len(), mark);
        }
        (mesh.triangles, surface) = (triangles, marks);
        check_count(mesh.triangles.len())?;
    }
    Ok(Solid { mesh, surface })
}

/// Adds the middle of each edge that is too long and the longest of one of its triangles.
fn divide_edges(mesh: &mut TriMesh, edge: f64) -> BTreeMap<[u32; 2], u32> {
    let mut middles = BTreeMap::new();
    let limit = edge * edge;
    for t in 0..mesh.triangles.len() {
        let corners = mesh.triangles[t];
        let length = |i: usize| {
            let [a, b] = key(corners[i], corners[(i + 1) % 3]).map(|v| mesh.vertices[v as usize]);
            (b - a).norm_squared()
        };
        let lengths = [length(0), length(1), length(2)];
        let longest = (1..3).fold(0, |best, i| if lengths[i] > lengths[best] { i } else { best });
        if lengths[longest] > limit {
            let [a, b] = key(corners[longest], corners[(longest + 1) % 3]);
            let middle = 0.5 * (mesh.vertices[a as usize] + mesh.vertices[b as usize]);
            let next = mesh.vertices.len() as u32;
            if *middles.entry([a, b]).or_insert(next) == next {
                mesh.vertices.push(middle);
            }
        }
    }
    middles
}

/// Divides long edges where that was asked for.
pub(super) fn finished(mesh: TriMesh, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_count(mesh.triangles.len())?;
    match detail.edge {
        None => Ok(mesh),
        Some(_) => refine(&mesh, check_edge(detail)?),
    }
}
