//! Admission of a raw mesh: checked, and repaired or refused by name.

mod crossing;
mod error;
mod holes;
mod open;
mod remesh;
mod report;
mod shells;
mod topology;

pub use error::{DIAGONALS, DoorError, MAX_TRIANGLES};
pub use open::{admit_open, near_miss};
pub use report::RepairReport;

use crate::boolean::{BooleanError, Exact, rebuild};
use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::{MeshError, Solid, TriMesh};

/// Open edges whose ends are closer than this share of the diagonal are sewn together; about the
/// precision of coordinates in text files.
const SEWING: f64 = 1e-6;
/// Most triangles that the exact rebuild is tried on: it takes about a second per 10 000.
const MAX_REBUILD: usize = 300_000;

/// What to do with a mesh that is not a clean solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repair {
    /// Make it one, and report how.
    Auto,
    /// Refuse it by name.
    Refuse,
}

/// Checks a mesh and gives back a closed, outward-oriented one that does not cross itself and that
/// [`Exact::new`] accepts, with a report of what was done to it. Equal vertices are merged, unless
/// the mesh is closed without that.
///
/// # Errors
/// With [`Repair::Refuse`], the first defect found; with [`Repair::Auto`], only what cannot be
/// repaired: wrong arrays, an impossible size, no volume.
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
        Repair::Auto => mended(welded, &mut report)?,
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
    let exact = import(&mesh)?;
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

/// Repairs step by step, each step only where the one before left a defect.
fn mended(mut mesh: TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let original = mesh.clone();
    topology::drop_collapsed(&mut mesh, report);
    topology::cancel_repeated(&mut mesh, report);
    if !topology::is_balanced(&mesh) {
        topology::drop_flat(&mut mesh, report);
        topology::sew(&mut mesh, SEWING * original.diagonal(), report);
        topology::drop_collapsed(&mut mesh, report);
        topology::cancel_repeated(&mut mesh, report);
        holes::divide_at_junctions(&mut mesh, SEWING * original.diagonal(), report);
        topology::orient(&mut mesh, report);
        holes::fill(&mut mesh, report);
    }
    mesh = topology::compacted(&mesh);
    if mesh.triangles.is_empty() {
        return Err(DoorError::NoVolume);
    }
    if !topology::is_balanced(&mesh) {
        return remeshed(&original, report);
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

/// A balanced mesh as a closed one without crossings.
fn untangled(mesh: &TriMesh, report: &mut RepairReport) -> Result<TriMesh, DoorError> {
    let exact = import(mesh)?;
    if !exact.crosses_itself().map_err(DoorError::Unrepairable)? {
        if mesh.is_closed() {
            return Ok(mesh.clone());
        }
        return proven(&exact);
    }
    if mesh.triangles.len() > MAX_REBUILD {
        let (count, first) = crossing::count(mesh);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    let rebuilt = proven(&rebuild(mesh).map_err(DoorError::Unrepairable)?)?;
    report.merged_shells = true;
    Ok(rebuilt)
}

/// The mesh of an exact solid, if the kernel takes it back and finds nothing to complain of.
fn proven(exact: &Exact) -> Result<TriMesh, DoorError> {
    let mesh = exact.to_solid().map_err(DoorError::Unrepairable)?.mesh;
    let again = import(&mesh)?;
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
        let (exact, edge) =
            remesh::from_distance(original, edges).map_err(DoorError::Unrepairable)?;
        if exact.is_empty() {
            return Err(DoorError::NoVolume);
        }
        let unfolded = |e| rebuild(&exact.mesh()).map_err(|_| e).and_then(|r| proven(&r));
        match proven(&exact).or_else(unfolded) {
            Ok(mesh) => {
                let surface = Nearest::new(&mesh);
                let distances = original.vertices.iter().map(|&p| surface.distance(p));
                report.moved = distances.fold(0.0, f64::max);
                report.remeshed = edge;
                return Ok(mesh);
            }
            Err(e) => last = e,
        }
    }
    Err(last)
}

fn import(mesh: &TriMesh) -> Result<Exact, DoorError> {
    Exact::new(&Solid::outer(mesh.clone())).map_err(|e| match e {
        BooleanError::NotSolid { .. } => DoorError::NoVolume,
        other => DoorError::Unrepairable(other),
    })
}

#[cfg(test)]
mod tests;
