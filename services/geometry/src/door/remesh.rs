//! A new surface from the distance to an old one that cannot be mended.

use crate::boolean::{BooleanError, Exact, level_set};
use crate::inside::{Inside, Nearest};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Grid edges along the diagonal of the box, in order of trial: a second or two of work, and a
/// surface within about one part in 160 of the old. No two fit the same planes.
pub(super) const GRIDS: [f64; 2] = [80.0, 71.3];

/// A surface made anew.
pub(super) struct NewSurface {
    pub(super) exact: Exact,
    /// The grid's edge \[m\].
    pub(super) edge: f64,
    /// The triangles of the old mesh that have empty space on a side: all but walls within.
    pub(super) exposed: Vec<usize>,
}

/// The surface at distance zero, signed by a vote of rays along the three axes, from a grid of
/// `edges` edges along the diagonal.
pub(super) fn from_distance(mesh: &TriMesh, edges: f64) -> Result<NewSurface, BooleanError> {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let edge = (high - low).norm() / edges;
    let turned = |by: usize, p: Vec3| Vec3::new(p[by % 3], p[(by + 1) % 3], p[(by + 2) % 3]);
    let votes = [0, 1, 2].map(|by| {
        let vertices = mesh.vertices.iter().map(|&p| turned(by, p)).collect();
        Inside::new(&TriMesh { vertices, triangles: mesh.triangles.clone() })
    });
    let inside = |p: Vec3| (0..3).filter(|&by| votes[by].contains(turned(by, p))).count() >= 2;
    // Walls within the body have it on both sides, fins outside it have it on none.
    let sides = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        let step = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default() * (0.1 * edge);
        let middle = (a + b + c) / 3.0;
        [inside(middle + step), inside(middle - step)]
    };
    let sides: Vec<[bool; 2]> = (0..mesh.triangles.len()).map(sides).collect();
    let of = |wanted: &dyn Fn([bool; 2]) -> bool| -> Vec<usize> {
        (0..sides.len()).filter(|&t| wanted(sides[t])).collect()
    };
    let surface = Nearest::new(&mesh.submesh(&of(&|[a, b]| a != b)));
    let field = |p: Vec3| {
        // Bounded, as there may be no skin at all.
        let distance = surface.distance(p).min(10.0 * edge);
        if inside(p) { distance } else { -distance }
    };
    let margin = Vec3::repeat(2.0 * edge);
    let exact = level_set(field, low - margin, high + margin, edge)?;
    Ok(NewSurface { exact, edge, exposed: of(&|[a, b]| !(a && b)) })
}
