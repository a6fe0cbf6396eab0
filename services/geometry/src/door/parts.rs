//! Parts of an assembly: shells that are closed each by itself, however they touch or cross others.

use super::error::DoorError;
use super::{shells, topology};
use crate::boolean::{BooleanError, Exact, rebuild};
use crate::math::Vec3;
use crate::mesh::{Solid, TriMesh};

/// Most triangles of a part that crosses itself and is rebuilt: it takes about a second per 10 000.
const MAX_REBUILD: usize = 300_000;

/// The patches that are connected across edges of two triangles that face the same way.
fn patches(mesh: &TriMesh) -> Vec<Vec<usize>> {
    let across = topology::neighbours(mesh);
    let mut seen = vec![false; mesh.triangles.len()];
    let mut patches = Vec::new();
    for seed in 0..mesh.triangles.len() {
        if seen[seed] {
            continue;
        }
        seen[seed] = true;
        let mut patch = vec![seed];
        let mut next = 0;
        while next < patch.len() {
            for &(other, agrees) in &across[patch[next]] {
                if agrees && !seen[other] {
                    seen[other] = true;
                    patch.push(other);
                }
            }
            next += 1;
        }
        patch.sort_unstable();
        patches.push(patch);
    }
    patches
}

/// The parts that are closed by themselves, and what is in none of them.
pub(super) fn divide(mesh: &TriMesh) -> (Vec<TriMesh>, TriMesh) {
    let (mut parts, mut rest) = (Vec::new(), Vec::new());
    for patch in patches(mesh) {
        let part = mesh.submesh(&patch);
        if topology::is_balanced(&part) {
            parts.push(part);
        } else {
            rest.extend(patch);
        }
    }
    rest.sort_unstable();
    (parts, mesh.submesh(&rest))
}

/// The union of a mesh's parts, each with its own cavities; those that cross themselves are rebuilt
/// first. Each part is swollen by `reach` \[m\] or up to twice as much, none by as much as another:
/// where parts meet but for rounding they then cross.
pub(super) fn joined(mesh: &TriMesh, reach: f64) -> Result<Exact, DoorError> {
    let (parts, rest) = divide(mesh);
    if !rest.triangles.is_empty() {
        return Err(DoorError::NoVolume);
    }
    let mut bodies = Vec::new();
    for (k, part) in shells::with_cavities(parts).iter().enumerate() {
        // Shares of the golden ratio keep apart however many there are.
        let by = reach * (1.0 + (0.618_033_988_749_895 * k as f64).fract());
        bodies.push(if reach > 0.0 { solid(&swollen(part, by))? } else { solid(part)? });
    }
    // Neighbours first, pair by pair: most of an assembly's parts touch only a few.
    let left = |body: &Exact| body.bounds().map_or(0.0, |(low, _)| low.x);
    bodies.sort_by(|a, b| left(a).total_cmp(&left(b)));
    while bodies.len() > 1 {
        let mut pairs = Vec::with_capacity(bodies.len().div_ceil(2));
        for pair in bodies.chunks(2) {
            pairs.push(match pair {
                [a, b] => a.union(b).map_err(DoorError::Unrepairable)?,
                _ => pair[0].clone(),
            });
        }
        bodies = pairs;
    }
    bodies.pop().ok_or(DoorError::NoVolume)
}

/// A surface whose corners are moved outward by `by` \[m\], along the mean of their triangles'
/// normals by their angles there.
fn swollen(mesh: &TriMesh, by: f64) -> TriMesh {
    let mut outward = vec![Vec3::zeros(); mesh.vertices.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let points = mesh.corners(t);
        let normal = (points[1] - points[0]).cross(&(points[2] - points[0]));
        let Some(normal) = normal.try_normalize(0.0) else { continue };
        for k in 0..3 {
            let [at, next, last] = [0, 1, 2].map(|i| points[(k + i) % 3]);
            outward[corners[k] as usize] += normal * (next - at).angle(&(last - at));
        }
    }
    let moved = mesh.vertices.iter().zip(outward);
    let vertices = moved.map(|(p, n)| p + n.try_normalize(0.0).unwrap_or_default() * by).collect();
    TriMesh { vertices, triangles: mesh.triangles.clone() }
}

/// One part as a solid that does not cross itself.
fn solid(part: &TriMesh) -> Result<Exact, DoorError> {
    let exact = import(part)?;
    if !exact.crosses_itself().map_err(DoorError::Unrepairable)? {
        return Ok(exact);
    }
    if part.triangles.len() > MAX_REBUILD {
        let (count, first) = super::crossing::count(part);
        return Err(DoorError::SelfIntersecting { count, first });
    }
    rebuild(part).map_err(DoorError::Unrepairable)
}

/// A shape for exact operations.
pub(super) fn import(mesh: &TriMesh) -> Result<Exact, DoorError> {
    Exact::new(&Solid::outer(mesh.clone())).map_err(|e| match e {
        BooleanError::NotSolid { .. } => DoorError::NoVolume,
        other => DoorError::Unrepairable(other),
    })
}
