//! Bodies of several shapes: their union as one closed surface.

use super::format::Shape;
use super::shape;
use cullet_geometry::boolean::{BooleanError, Exact};
use cullet_geometry::hull::{self, HullSettings};
use cullet_geometry::{Pose, Solid, TriMesh, Vec3};

/// Convex parts of a shape that is not convex, at least.
const LEAST_HULLS: u32 = 4;

/// Most triangles of all shapes of a body: those of an exact union take some kilobytes each.
const MOST_TRIANGLES: usize = 200_000;

/// A shape and where it stands in the frame of its body.
#[derive(Clone, Debug)]
pub struct PlacedShape {
    /// The shape.
    pub shape: Shape,
    /// Its own frame to that of the body \[m\].
    pub pose: Pose,
}

/// What shapes together come to, about the origin of their body.
pub(super) struct PartsMesh {
    /// Their union.
    pub(super) mesh: TriMesh,
    /// Convex parts of each shape, for collisions: a convex one is its own \[m\].
    pub(super) hulls: Vec<Vec<Vec3>>,
}

/// The union of shapes; `settings`: of the convex parts of all that are not convex.
///
/// # Errors
/// A shape that cannot be made, with its place in the list; one that does not overlap the others;
/// the boolean's refusal.
pub(super) fn mesh(parts: &[PlacedShape], settings: HullSettings) -> Result<PartsMesh, String> {
    let hollow = parts.iter().filter(|part| !shape::convex(&part.shape)).count() as u32;
    let max_parts = (settings.max_parts / hollow.max(1)).max(LEAST_HULLS);
    let settings = HullSettings { max_parts, ..settings };
    let (mut bodies, mut hulls) = (Vec::with_capacity(parts.len()), Vec::new());
    let mut triangles = 0;
    for (index, part) in parts.iter().enumerate() {
        let of_part = |why: String| format!("part {index}: {why}");
        let mut mesh = shape::mesh(&part.shape).map_err(of_part)?;
        let placed = |v: &Vec3| part.pose.rotation * v + part.pose.translation.vector;
        mesh.vertices.iter_mut().for_each(|v| *v = placed(v));
        triangles += mesh.triangles.len();
        if triangles > MOST_TRIANGLES {
            return Err(of_part(format!(
                "with it the body's parts have {triangles} triangles; at most {MOST_TRIANGLES} are \
                 taken"
            )));
        }
        let tags = vec![0; mesh.triangles.len()];
        bodies.push(Exact::tagged(&mesh, &tags).map_err(|error| of_part(error.to_string()))?);
        if shape::convex(&part.shape) {
            hulls.push(mesh.vertices);
        } else {
            hulls.extend(hull::convex_parts(&Solid::outer(mesh), settings));
        }
    }
    if let Some(index) = stray(&bodies).map_err(|error| error.to_string())? {
        return Err(format!(
            "part {index} does not overlap those that part 0 hangs together with: the parts of a \
             body are one piece"
        ));
    }
    let mut rest = bodies.into_iter();
    let first = rest.next().ok_or_else(|| "a body has at least one part".to_owned())?;
    let whole = rest.try_fold(first, |all, part| all.union(&part));
    let whole = whole.map_err(|error| error.to_string())?;
    let (mesh, _) = whole.to_tagged().map_err(|error| error.to_string())?;
    Ok(PartsMesh { mesh, hulls })
}

/// The first body that does not hang together with the first one by overlaps.
fn stray(bodies: &[Exact]) -> Result<Option<usize>, BooleanError> {
    let mut reached = vec![false; bodies.len()];
    let mut next = vec![0];
    while let Some(from) = next.pop().filter(|_| !bodies.is_empty()) {
        reached[from] = true;
        for to in 0..bodies.len() {
            if !reached[to] && !bodies[from].intersect(&bodies[to])?.is_empty() {
                reached[to] = true;
                next.push(to);
            }
        }
    }
    Ok(reached.iter().position(|reached| !reached))
}
