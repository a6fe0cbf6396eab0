//! The closed solid around a midsurface.

use super::vertex_normals;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::remesh::curved::{area_vector, unit_or};
use crate::remesh::{SurfaceError, check_surface};

/// Greatest curvature times half the thickness \[1\] (F92).
const MOST_BEND: f64 = 0.5;

/// How far a corner of an offset wall may run ahead of half the thickness; sharper ones are cut.
const MITRE_LIMIT: f64 = 2.0;

/// The solid of a wall: the surface offset by half the `thickness` \[m\] at each vertex to both
/// sides along its normal, with corners mitred so that the faces come to lie that far off. A
/// boundary is closed by a strip across the wall. A closed surface gives an outer shell and an
/// inner one that bounds the hollow.
///
/// Walls of different parts of the surface that cross each other are not looked for:
/// [`crate::door`] does that.
///
/// # Errors
/// Arrays that are wrong, a surface that is not manifold or not consistently oriented, or walls
/// that cross inside the thickness (F92).
pub fn thicken(
    vertices: &[Vec3],
    triangles: &[[u32; 3]],
    thickness: &[f64],
) -> Result<TriMesh, SurfaceError> {
    let mesh = TriMesh { vertices: vertices.to_vec(), triangles: triangles.to_vec() };
    check_surface(&mesh, thickness)?;
    let offsets = offsets(&mesh, thickness);
    check_bend(&mesh, &offsets)?;
    let count = vertices.len() as u32;
    let front = vertices.iter().zip(&offsets).map(|(p, d)| p + d);
    let back = vertices.iter().zip(&offsets).map(|(p, d)| p - d);
    let mut solid = TriMesh { vertices: front.chain(back).collect(), triangles: vec![] };
    solid.triangles.extend(triangles);
    solid.triangles.extend(triangles.iter().map(|&[a, b, c]| [a + count, c + count, b + count]));
    for [a, b] in mesh.open_edges() {
        // The front runs through the edge from a to b, so the strip runs from b to a there.
        solid.triangles.extend([[b, a, a + count], [b, a + count, b + count]]);
    }
    Ok(solid)
}

/// From each vertex to the front wall \[m\].
fn offsets(mesh: &TriMesh, thickness: &[f64]) -> Vec<Vec3> {
    let normals = vertex_normals(mesh);
    let mut cosine = vec![[0.0; 2]; mesh.vertices.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let area = area_vector(mesh, t);
        let face = unit_or(area, Vec3::zeros());
        for v in corners.iter().map(|&v| v as usize) {
            cosine[v][0] += area.norm() * face.dot(&normals[v]);
            cosine[v][1] += area.norm();
        }
    }
    (0..normals.len())
        .map(|v| {
            let mean = cosine[v][0] / cosine[v][1].max(f64::MIN_POSITIVE);
            normals[v] * (0.5 * thickness[v] / mean.max(1.0 / MITRE_LIMIT))
        })
        .collect()
}

/// Refuses walls that cross: where an offset shortens or stretches an edge by over half, curvature
/// times half the thickness is over [`MOST_BEND`]; where it turns a triangle over, they have.
fn check_bend(mesh: &TriMesh, offsets: &[Vec3]) -> Result<(), SurfaceError> {
    let refuse = |vertex: u32, bend: f64| SurfaceError::Walls { vertex, bend, most: MOST_BEND };
    for edge in mesh.edges() {
        let (a, b) = (edge.from as usize, edge.to as usize);
        let way = mesh.vertices[b] - mesh.vertices[a];
        let bend = ((offsets[b] - offsets[a]).dot(&way) / way.norm_squared()).abs();
        if bend.is_nan() || bend > MOST_BEND {
            return Err(refuse(edge.from, bend));
        }
    }
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let area = area_vector(mesh, t);
        for side in [1.0, -1.0] {
            let moved = corners.map(|v| mesh.vertices[v as usize] + offsets[v as usize] * side);
            let [a, b, c] = moved;
            if (b - a).cross(&(c - a)).dot(&area) <= 0.0 {
                return Err(refuse(corners[0], 1.0));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
