//! Admission of a surface that is the middle of a thin wall: it may be open.

use super::{DIAGONALS, DoorError, Repair, RepairReport, SEWING, topology};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Checks a surface, open or closed, and gives back one whose triangles meet edge on edge and face
/// the same way, with a report of what was done to it. Holes stay.
///
/// # Errors
/// With [`Repair::Refuse`], the first defect found; with the others, only what cannot be
/// repaired: wrong arrays, an impossible size, edges with more than two triangles or with a twist.
pub fn admit_open(mesh: &TriMesh, repair: Repair) -> Result<(TriMesh, RepairReport), DoorError> {
    super::check_count(mesh)?;
    let mut report = RepairReport::default();
    let (mut mesh, merged) = topology::weld(mesh);
    report.merged_vertices = merged;
    let diagonal = mesh.diagonal();
    if !(DIAGONALS.0..=DIAGONALS.1).contains(&diagonal) {
        return Err(DoorError::Size { diagonal });
    }
    if repair != Repair::Refuse {
        topology::drop_collapsed(&mut mesh, &mut report);
        topology::drop_flat(&mut mesh, &mut report);
        topology::sew(&mut mesh, SEWING * diagonal, &mut report);
        topology::drop_collapsed(&mut mesh, &mut report);
        topology::cancel_repeated(&mut mesh, &mut report);
        topology::orient(&mut mesh, &mut report);
        mesh = topology::compacted(&mesh);
    }
    super::check_faces(&mesh)?;
    super::check_edges(&mesh)?;
    report.triangles = mesh.triangles.len();
    Ok((mesh, report))
}

fn distance_to_edge(place: Vec3, a: Vec3, b: Vec3) -> f64 {
    let edge = b - a;
    let share = (edge.dot(&(place - a)) / edge.norm_squared()).clamp(0.0, 1.0);
    (a + edge * share - place).norm()
}

/// Where boundaries of a surface come closer than `reach` \[m\] to each other without being one: a
/// vertex, and how far from it the edge is \[m\]. Edges that share a vertex are not looked at.
#[must_use]
pub fn near_miss(mesh: &TriMesh, reach: f64) -> Option<(Vec3, f64)> {
    let at = |v: u32| mesh.vertices[v as usize];
    let mut edges = mesh.open_edges();
    let left = |&[a, b]: &[u32; 2]| at(a).x.min(at(b).x);
    edges.sort_by(|a, b| left(a).total_cmp(&left(b)).then(a.cmp(b)));
    let longest = edges.iter().map(|&[a, b]| (at(b) - at(a)).norm()).fold(0.0, f64::max);
    let found = edges.iter().filter_map(|&[v, next]| {
        let place = at(v);
        let first = edges.partition_point(|e| left(e) < place.x - reach - longest);
        let near = edges[first..].iter().take_while(|e| left(e) <= place.x + reach);
        let apart = near
            .filter(|&&[a, b]| a != v && b != v && a != next && b != next)
            .map(|&[a, b]| distance_to_edge(place, at(a), at(b)));
        let least = apart.fold(f64::INFINITY, f64::min);
        // What lies as near along its own boundary is not another one.
        (least < reach && least < 0.5 * (at(next) - place).norm()).then_some((place, least))
    });
    found.min_by(|a, b| a.1.total_cmp(&b.1))
}
