//! Simple bodies as closed, outward-oriented meshes. **z is up**: axes of revolution lie along +z.
//!
//! A round body is a prism or polyhedron *inscribed* in the true surface; a body of revolution with
//! n segments has exactly sin(2π/n)/(2π/n) of the true volume.

mod detail;
mod lathe;
mod midline;
mod outline;
mod refine;

pub use detail::{Detail, MAX_SEGMENTS, MAX_TRIANGLES, MIN_SEGMENTS, SIZE_RANGE, ShapeError};
pub use lathe::{lathe_shell, lathe_solid};
pub use midline::lathe_midline;
pub use outline::{extrude, triangulate};
pub use refine::{refine, refine_solid};

use crate::math::Vec3;
use crate::mesh::TriMesh;
use detail::{check_count, check_edge, check_segments, check_size};
use lathe::{check_section, revolve};
use refine::finished;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A box of the given edge lengths \[m\], centred on the origin, with even grids on its faces.
///
/// # Errors
/// A length outside [`SIZE_RANGE`], or too many triangles.
pub fn cuboid(size: Vec3, detail: Detail) -> Result<TriMesh, ShapeError> {
    for length in size.iter() {
        check_size("box size", *length)?;
    }
    let edge = check_edge(detail)?;
    let cells = [size.x, size.y, size.z].map(|l| (l / edge).ceil().max(1.0));
    let [x, y, z] = cells;
    check_count((4.0 * (x * y + y * z + z * x)) as usize)?;
    let n = cells.map(|c| c as u32);
    let mut grid = BoxLattice { size, n, index: BTreeMap::new(), mesh: TriMesh::default() };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (i, j) in (0..n[u]).flat_map(|i| (0..n[v]).map(move |j| (i, j))) {
            for level in [0, n[axis]] {
                let mut quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
                    let mut key = [level; 3];
                    (key[u], key[v]) = (i + a, j + b);
                    grid.vertex(key)
                });
                if level == 0 {
                    quad.swap(1, 3);
                }
                let [a, b, c, d] = quad;
                grid.mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Ok(grid.mesh)
}

/// The lattice of points on the surface of a box.
struct BoxLattice {
    size: Vec3,
    n: [u32; 3],
    index: BTreeMap<[u32; 3], u32>,
    mesh: TriMesh,
}

impl BoxLattice {
    fn vertex(&mut self, key: [u32; 3]) -> u32 {
        let (size, n, vertices) = (self.size, self.n, &mut self.mesh.vertices);
        *self.index.entry(key).or_insert_with(|| {
            // Twice the index less the count is odd about the middle, so opposite faces mirror.
            let at = |i: usize| {
                0.5 * size[i] * (2.0 * f64::from(key[i]) - f64::from(n[i])) / f64::from(n[i])
            };
            vertices.push(Vec3::new(at(0), at(1), at(2)));
            vertices.len() as u32 - 1
        })
    }
}

/// A geodesic sphere of the given radius \[m\] about the origin, vertices on the sphere, with about
/// `detail.segments` edges on a great circle (or edges of about `detail.edge`, if that is finer).
///
/// # Errors
/// A value out of range, or too many triangles.
pub fn sphere(radius: f64, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_size("sphere radius", radius)?;
    check_segments(detail)?;
    let edge = check_edge(detail)?;
    // An icosahedron has five edges near a great circle; its edge is 1.0515 radii.
    let by_segments = (f64::from(detail.segments) / 5.0).round().max(1.0);
    let frequency = by_segments.max((1.0515 * radius / edge).ceil());
    check_count((20.0 * frequency * frequency) as usize)?;
    Ok(geodesic(radius, frequency as u32))
}

/// A cylinder along z, centred on the origin.
///
/// # Errors
/// A value out of range, or too many triangles.
pub fn cylinder(radius: f64, height: f64, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_size("cylinder radius", radius)?;
    check_size("cylinder height", height)?;
    turned(&[[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]], radius, height, detail)
}

/// A cone along z from `bottom` radius at −height/2 to `top` radius at +height/2 \[m\]. One of the
/// radii may be zero: a point.
///
/// # Errors
/// A value out of range, or too many triangles.
pub fn cone(bottom: f64, top: f64, height: f64, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_size("cone height", height)?;
    for (what, radius, other) in [("cone bottom", bottom, top), ("cone top", top, bottom)] {
        if radius != 0.0 || other == 0.0 {
            check_size(what, radius)?;
        }
    }
    turned(&[[0.0, -0.5], [bottom, -0.5], [top, 0.5], [0.0, 0.5]], 1.0, height, detail)
}

/// A torus around z, centred on the origin: a tube of radius `minor` about a circle of radius
/// `major` \[m\].
///
/// # Errors
/// A value out of range (`minor` must be less than `major`), or too many triangles.
pub fn torus(major: f64, minor: f64, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_size("torus major radius", major)?;
    check_size("torus minor radius", minor)?;
    if minor >= major {
        let (low, high) = (SIZE_RANGE.0, major);
        return Err(ShapeError::OutOfRange { what: "torus minor radius", value: minor, low, high });
    }
    check_segments(detail)?;
    let around = (f64::from(detail.segments) * minor / major).ceil().max(8.0) as u32;
    check_count(2 * around as usize * detail.segments as usize)?;
    let loop_of = |i: u32| {
        let a = TAU * f64::from(i) / f64::from(around);
        [major + minor * libm::cos(a), minor * libm::sin(a)]
    };
    let profile: Vec<[f64; 2]> = (0..around).map(loop_of).collect();
    spun(&profile, false, detail)
}

/// A capsule along z, centred on the origin: a cylinder of length `height` between its two half
/// spheres of `radius` \[m\]; the whole is `height + 2 radius` long.
///
/// # Errors
/// A value out of range, or too many triangles.
pub fn capsule(radius: f64, height: f64, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_size("capsule radius", radius)?;
    check_size("capsule height", height)?;
    check_segments(detail)?;
    let quarter = detail.segments.div_ceil(4).max(2);
    check_count(4 * (quarter as usize + 1) * detail.segments as usize)?;
    let arc = |i: u32, side: f64| {
        let a = FRAC_PI_2 * f64::from(i) / f64::from(quarter);
        let r = if i == quarter { 0.0 } else { radius * libm::cos(a) };
        [r, side * (0.5 * height + radius * libm::sin(a))]
    };
    let lower = (0..=quarter).rev().map(|i| arc(i, -1.0));
    let profile: Vec<[f64; 2]> = lower.chain((0..=quarter).map(|i| arc(i, 1.0))).collect();
    spun(&profile, true, detail)
}

/// A body of revolution from a short profile in units of (radius, height).
fn turned(
    profile: &[[f64; 2]],
    radius: f64,
    height: f64,
    detail: Detail,
) -> Result<TriMesh, ShapeError> {
    check_segments(detail)?;
    let mut points: Vec<[f64; 2]> =
        profile.iter().map(|&[r, z]| [r * radius, z * height]).collect();
    points.dedup();
    spun(&points, true, detail)
}

/// A section turned about z.
fn spun(section: &[[f64; 2]], on_axis: bool, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_section(section, detail)?;
    finished(revolve(section, on_axis, detail), detail)
}

/// The icosahedron, each face divided into `frequency`² triangles, pushed out to the sphere.
fn geodesic(radius: f64, frequency: u32) -> TriMesh {
    let (corners, faces) = icosahedron();
    let mut index: BTreeMap<[(u32, u32); 3], u32> = BTreeMap::new();
    let mut mesh = TriMesh::default();
    for face in faces {
        // A point is the weights of its face's corners, in order of corner: equal on both sides of
        // an edge, bit for bit.
        let mut vertex = |i: u32, j: u32| {
            let mut key = [(face[0], frequency - i - j), (face[1], i), (face[2], j)];
            for part in &mut key {
                if part.1 == 0 {
                    *part = (u32::MAX, 0);
                }
            }
            key.sort_unstable();
            *index.entry(key).or_insert_with(|| {
                let used = key.iter().filter(|(_, weight)| *weight > 0);
                let p: Vec3 = used.map(|&(c, w)| corners[c as usize] * f64::from(w)).sum();
                mesh.vertices.push(p.normalize() * radius);
                mesh.vertices.len() as u32 - 1
            })
        };
        for (i, j) in (0..frequency).flat_map(|i| (0..frequency - i).map(move |j| (i, j))) {
            let [a, b, c] = [vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)];
            mesh.triangles.push([a, b, c]);
            if i + j + 2 <= frequency {
                let d = vertex(i + 1, j + 1);
                mesh.triangles.push([b, d, c]);
            }
        }
    }
    mesh
}

/// Corners (cyclic permutations of (0, ±1, ±φ)) and faces of the icosahedron.
fn icosahedron() -> ([Vec3; 12], Vec<[u32; 3]>) {
    let phi = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = [Vec3::zeros(); 12];
    for (i, corner) in corners.iter_mut().enumerate() {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let axis = i / 4;
        corner[(axis + 1) % 3] = sign(0);
        corner[(axis + 2) % 3] = sign(1) * phi;
    }
    let near = |a: usize, b: usize| (corners[a] - corners[b]).norm() < 2.1;
    let mut faces = Vec::with_capacity(20);
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let normal = (corners[b] - corners[a]).cross(&(corners[c] - corners[a]));
                    let [b, c] = if normal.dot(&corners[a]) > 0.0 { [b, c] } else { [c, b] };
                    faces.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    (corners, faces)
}

#[cfg(test)]
mod tests;
