//! Admission of a raw mesh: checked, and repaired or refused by name.

mod crossing;
mod error;
mod holes;
mod open;
mod parts;
mod remesh;
mod report;
mod shells;
mod topology;

pub use error::{DIAGONALS, DoorError, MAX_TRIANGLES};
pub use open::{admit_open, near_miss};
pub use report::RepairReport;

use crate::boolean::{Exact, rebuild};
use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::{MeshError, TriMesh};

/// Open edges whose ends are closer than this share of the diagonal are sewn together; about the
/// precision of coordinates in text files.
const SEWING: f64 = 1e-6;

/// How far a repair that nobody asked for may move the surface, as a share of its box's diagonal.
pub const MOST_MOVED: f64 = 0.02;

/// What to do with a mesh that is not a clean solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repair {
    /// Make it one, and report how, but refuse to move its surface by more than [`MOST_MOVED`] of
    /// its size.
    Auto,
    /// Make it one, however far its surface moves.
    Remesh,
    /// Refuse it by name.
    Refuse,
}

/// Checks a mesh and gives back a closed, outward-oriented one that does not cross itself and that
/// [`Exact::new`] accepts, with a report of what was done to it. Equal vertices are merged, unless
/// the mesh is closed without that.
///
/// # Errors
/// With [`Repair::Refuse`], the first defect found; with the others, only what cannot be repaired:
/// wrong arrays, an impossible size, no volume; with [`Repair::Auto`], [`DoorError::Moved`] too.
pub fn admit(mesh: &TriMesh, repair: Repair) -> Result<(TriMesh, RepairReport), DoorError> {
    check_count(mesh)?;
    let mut report = RepairReport::default();
    let (welded, merged) = if mesh.is_closed() { (mesh.clone(), 0) } else { topology::weld(mesh) };
    let diagonal = welded.diagonal();
    if !(DIAGONALS.0..=DIAGONALS.1).contains(&diagonal) {
        return Err(DoorError::Size { diagonal });
    }
    report.merged_vertices = merged;
    let admitted = match repair {
        Repair::Refuse => checked(welded)?,
        Repair::Auto | Repair::Remesh => {
            let repaired = mended(welded, &mut report)?;
            if repair == Repair::Auto && report.moved > MOST_MOVED * diagonal {
                let (moved, at) = (report.moved, report.moved_most_at);
                return Err(DoorError::Moved { moved, share: moved / diagonal, at });
            }
            repaired
        }
    };
    report.triangles = admitted.triangles.len();
    report.volume = admitted.signed_volume();
    Ok((admitted, report))
}

/// Refuses wrong arrays, no triangles and too many.
fn check_count(mesh: &TriMesh) -> Result<(), DoorError> {
    mesh.validate()?;
    let triangles = mesh.triangles.len();
    if triangles == 0 {
        return Err(MeshError::Empty { vertices: mesh.vertices.len() }.into());
    }
    if triangles > MAX_TRIANGLES {
        return Err(DoorError::TooMany { triangles });
    }
    Ok(())
}

/// Looks for every defect in turn.
fn checked(mesh: TriMesh) -> Result<TriMesh, DoorError> {
    check_faces(&mesh)?;
    let open = mesh.edges();
    let mut open = open.iter().filter(|e| e.forward + e.backward == 1);
    if let Some(first) = open.next() {
        return Err(DoorError::OpenEdges { count: 1 + open.count(), first: middle(&mesh, first) });
    }
    check_edges(&mesh)?;
    shells::check(&mesh)?;
    let exact = parts::import(&mesh)?;
    if exact.crosses_itself().map_err(DoorError::Unrepairable)? {
        let (count, first) = crossing::count(&mesh);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    Ok(mesh)
}

/// Refuses triangles without area, and such as are there twice.
fn check_faces(mesh: &TriMesh) -> Result<(), DoorError> {
    let listed = |found: &[usize]| found.first().map(|&first| (found.len(), first));
    if let Some((count, first)) = listed(&topology::flat(mesh)) {
        return Err(DoorError::Degenerate { count, first });
    }
    if let Some((count, first)) = listed(&topology::repeated(mesh)) {
        return Err(DoorError::Duplicate { count, first });
    }
    Ok(())
}

/// Refuses edges with more than two triangles, or with two that face opposite ways.
fn check_edges(mesh: &TriMesh) -> Result<(), DoorError> {
    let edges = mesh.edges();
    let bad = |test: &dyn Fn(u32, u32) -> bool| {
        let mut found = edges.iter().filter(|e| test(e.forward, e.backward));
        found.next().map(|first| (1 + found.count(), middle(mesh, first)))
    };
    if let Some((count, first)) = bad(&|f, b| f + b > 2) {
        return Err(DoorError::NonManifold { count, first });
    }
    if let Some((count, first)) = bad(&|f, b| f + b == 2 && f != b) {
        return Err(DoorError::NotOriented { count, first });
    }
    Ok(())
}

fn middle(mesh: &TriMesh, edge: &crate::mesh::EdgeUse) -> Vec3 {
    0.5 * (mesh.vertices[edge.from as usize] + mesh.vertices[edge.to as usize])
}

/// Repairs step by step, each step only where the one before left a defect, and of an assembly only
/// what is not closed by itself.
fn mended(mut mesh: TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let original = mesh.clone();
    topology::drop_collapsed(&mut mesh, report);
    topology::cancel_repeated(&mut mesh, report);
    if !topology::is_balanced(&mesh) {
        let (parts, rest) = parts::divide(&mesh);
        let closed = closed_up(rest, SEWING * original.diagonal(), report);
        let closed = match closed {
            // What encloses nothing beside what does.
            Err(DoorError::NoVolume) if !parts.is_empty() => {
                report.dropped_shells += 1;
                TriMesh::default()
            }
            closed => closed?,
        };
        mesh = TriMesh::default();
        parts.iter().chain([&closed]).for_each(|part| mesh.append(part));
    }
    mesh = topology::compacted(&mesh);
    if mesh.triangles.is_empty() {
        return Err(DoorError::NoVolume);
    }
    let (volume, least) = (mesh.signed_volume().abs(), shells::least_volume(&mesh));
    mesh = shells::ordered(&mesh, report);
    if mesh.triangles.is_empty() {
        let none = volume == 0.0;
        return Err(if none { DoorError::NoVolume } else { DoorError::Thin { volume, least } });
    }
    report.crowded_edges = mesh.non_manifold_edges().len();
    match untangled(&mesh, report) {
        Ok(clean) => Ok(clean),
        Err(_) => remeshed(&original, report),
    }
}

/// An open mesh as one whose edges are used as often one way as the other: sewn within `reach`
/// \[m\], with its holes filled, or made anew.
fn closed_up(
    mut mesh: TriMesh,
    reach: f64,
    report: &mut RepairReport,
) -> Result<TriMesh, DoorError> {
    let original = mesh.clone();
    topology::drop_flat(&mut mesh, report);
    topology::sew(&mut mesh, reach, report);
    topology::drop_collapsed(&mut mesh, report);
    topology::cancel_repeated(&mut mesh, report);
    holes::divide_at_junctions(&mut mesh, reach, report);
    topology::orient(&mut mesh, report);
    holes::fill(&mut mesh, report);
    if topology::is_balanced(&mesh) { Ok(mesh) } else { remeshed(&original, report) }
}

/// A balanced mesh as a closed one without crossings.
fn untangled(mesh: &TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let exact = parts::import(mesh)?;
    if !exact.crosses_itself().map_err(DoorError::Unrepairable)? {
        if mesh.is_closed() {
            return Ok(mesh.clone());
        }
        return proven(&exact);
    }
    report.merged_shells = true;
    for reach in [0.0, SEWING * mesh.diagonal()] {
        if let Ok(joined) = parts::joined(mesh, reach).and_then(|exact| proven(&exact)) {
            report.moved = report.moved.max(2.0 * reach);
            return Ok(joined);
        }
    }
    report.merged_shells = false;
    let (count, first) = crossing::count(mesh);
    Err(DoorError::SelfIntersecting { count, first })
}

/// The mesh of an exact solid, if the kernel takes it back and finds nothing to complain of.
fn proven(exact: &Exact) -> Result<TriMesh, DoorError> {
    let mesh = exact.to_solid().map_err(DoorError::Unrepairable)?.mesh;
    let again = parts::import(&mesh)?;
    if again.crosses_itself().map_err(DoorError::Unrepairable)? {
        let (count, first) = crossing::count(&mesh);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    Ok(mesh)
}

/// The last resort: a new surface from the distance to the old one. A grid that happens to fit
/// the surface's own planes can fold it by a rounding error; then the next is tried.
fn remeshed(original: &TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let mut last = DoorError::NoVolume;
    for edges in remesh::GRIDS {
        let new = remesh::from_distance(original, edges).map_err(DoorError::Unrepairable)?;
        if new.exact.is_empty() {
            return Err(DoorError::NoVolume);
        }
        let unfolded = |e| rebuild(&new.exact.mesh()).map_err(|_| e).and_then(|r| proven(&r));
        match proven(&new.exact).or_else(unfolded) {
            Ok(mesh) => {
                let surface = Nearest::new(&mesh);
                for p in original.submesh(&new.exposed).vertices {
                    let moved = surface.distance(p);
                    if moved > report.moved {
                        (report.moved, report.moved_most_at) = (moved, p);
                    }
                }
                report.remeshed = new.edge;
                return Ok(mesh);
            }
            Err(e) => last = e,
        }
    }
    Err(last)
}

#[cfg(test)]
mod tests;
