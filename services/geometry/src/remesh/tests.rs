//! Remeshed surfaces: even, on the surface, with their boundary and corners where they were.

use super::curved::CurvedMesh;
use super::passes::least_angle;
use super::{SurfaceError, remesh};
use crate::math::{Vec3, unit};
use crate::mesh::TriMesh;
use crate::shapes::{Detail, cylinder};
use std::f64::consts::PI;

/// How even the triangles of a surface are.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshQuality {
    /// Least and greatest edge over the spacing \[1\].
    pub(crate) edges: [f64; 2],
    /// Least angle of a triangle \[degrees\].
    pub(crate) angle: f64,
    /// Least and greatest valence inside.
    pub(crate) inside: [usize; 2],
    /// Least and greatest valence on the boundary.
    pub(crate) border: [usize; 2],
    /// Greatest sum of a triangle's interior valences.
    pub(crate) sum: usize,
    /// Share of interior vertices of valence 6 \[1\].
    pub(crate) regular: f64,
}

impl MeshQuality {
    pub(crate) fn of(mesh: &TriMesh, spacing: f64) -> Self {
        let mut valence = vec![0; mesh.vertices.len()];
        let mut is_border = vec![false; mesh.vertices.len()];
        let mut quality =
            Self { edges: [f64::MAX, 0.0], inside: [99, 0], border: [99, 0], ..Self::default() };
        for edge in mesh.edges() {
            let ends = [edge.from, edge.to].map(|v| v as usize);
            let length = (mesh.vertices[ends[0]] - mesh.vertices[ends[1]]).norm() / spacing;
            quality.edges = [quality.edges[0].min(length), quality.edges[1].max(length)];
            ends.iter().for_each(|&v| valence[v] += 1);
            if edge.forward + edge.backward == 1 {
                ends.iter().for_each(|&v| is_border[v] = true);
            }
        }
        let mut regular = [0, 0];
        for (v, &count) in valence.iter().enumerate() {
            let range = if is_border[v] { &mut quality.border } else { &mut quality.inside };
            *range = [range[0].min(count), range[1].max(count)];
            if !is_border[v] {
                regular = [regular[0] + usize::from(count == 6), regular[1] + 1];
            }
        }
        quality.regular = regular[0] as f64 / f64::from(regular[1].max(1) as u32);
        let angles = (0..mesh.triangles.len()).map(|t| least_angle(&mesh.corners(t)));
        quality.angle = angles.fold(f64::MAX, f64::min).to_degrees();
        let inner = mesh.triangles.iter().map(|t| t.map(|v| v as usize));
        let inner = inner.filter(|t| t.iter().all(|&v| !is_border[v]));
        quality.sum = inner.map(|t| t.iter().map(|&v| valence[v]).sum()).max().unwrap_or(0);
        quality
    }
}

/// A rectangle of nx × ny uneven quads in the plane z = 0, each moved by `place`.
fn patch(nx: u32, ny: u32, place: impl Fn(f64, f64) -> Vec3) -> TriMesh {
    let shifted = |i: u32, n: u32, key: u64| {
        let inner = i > 0 && i < n;
        let off = if inner { 0.5 * (unit(5, 0, key) - 0.5) } else { 0.0 };
        (f64::from(i) + off) / f64::from(n)
    };
    let mut mesh = TriMesh::default();
    for j in 0..=ny {
        for i in 0..=nx {
            let key = u64::from(j * (nx + 1) + i);
            mesh.vertices.push(place(shifted(i, nx, 2 * key), shifted(j, ny, 2 * key + 1)));
        }
    }
    for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
        let [a, b] = [j, j + 1].map(|j| j * (nx + 1) + i);
        mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
    }
    mesh
}

fn assert_even(mesh: &TriMesh, spacing: f64) {
    let q = MeshQuality::of(mesh, spacing);
    assert!(q.edges[0] > 0.6 && q.edges[1] < 1.5 && q.angle > 25.0, "{q:?}");
    assert!(q.inside[0] >= 5 && q.inside[1] <= 7 && q.sum <= 22, "{q:?}");
    assert!(q.border[0] >= 3 && q.border[1] <= 5, "{q:?}");
}

#[test]
fn an_open_saddle_is_divided_evenly_with_its_thickness() {
    let place = |u: f64, v: f64| {
        let (x, y) = (0.6 * u - 0.3, 0.4 * v - 0.2);
        Vec3::new(x, y, 0.5 * (x * x - y * y))
    };
    let mesh = patch(25, 11, place);
    let thickness: Vec<f64> = mesh.vertices.iter().map(|p| 0.005 + 0.004 * p.x).collect();
    for spacing in [0.012, 0.03] {
        let surface = remesh(&mesh, &thickness, spacing).unwrap();
        assert_even(&surface.mesh(), spacing);
        for (p, t) in surface.vertices.iter().zip(&surface.thickness) {
            assert!((p.z - 0.5 * (p.x * p.x - p.y * p.y)).abs() < 3e-4, "{p}");
            assert!((t - 0.005 - 0.004 * p.x).abs() < 2e-5, "{t} at {p}");
        }
        for (x, y) in [(-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2)] {
            let corner = Vec3::new(x, y, 0.5 * (x * x - y * y));
            assert!(surface.vertices.contains(&corner), "the corner at {corner} moved");
        }
        assert!((surface.area() / mesh.area() - 1.0).abs() < 2e-3);
        assert_eq!(surface, remesh(&mesh, &thickness, spacing).unwrap());
    }
}

#[test]
fn facets_of_a_pipe_come_out_round() {
    let solid = cylinder(0.05, 0.2, Detail { segments: 24, edge: None }).unwrap();
    let is_wall = |t: &usize| solid.corners(*t).iter().any(|p| p.z != solid.corners(*t)[0].z);
    let wall: Vec<usize> = (0..solid.triangles.len()).filter(is_wall).collect();
    let pipe = solid.submesh(&wall);
    let fine = CurvedMesh::new(&pipe).refined(0.004, 1_000_000).mesh;
    // The chords of a 24-gon lie up to 0.43 mm within the circle.
    let off = fine.vertices.iter().map(|p| (p.xy().norm() - 0.05).abs()).fold(0.0, f64::max);
    assert!(off < 2e-5, "{off}");
    let surface = remesh(&pipe, &vec![0.002; pipe.vertices.len()], 0.008).unwrap();
    assert_even(&surface.mesh(), 0.008);
    assert_eq!(surface.boundary().len(), 2);
    assert!((surface.area() / (2.0 * PI * 0.05 * 0.2) - 1.0).abs() < 0.01);
    assert!(surface.vertices.iter().all(|p| (p.xy().norm() - 0.05).abs() < 1e-4));
}

#[test]
fn surfaces_that_cannot_be_divided_are_refused() {
    let mesh = patch(4, 4, |u, v| Vec3::new(u, v, 0.0));
    let t = vec![0.01; 25];
    assert!(matches!(remesh(&mesh, &t, 1e-5), Err(SurfaceError::Spacing { .. })));
    assert!(matches!(remesh(&mesh, &t, 0.9), Err(SurfaceError::Spacing { .. })));
    assert!(matches!(remesh(&mesh, &t[1..], 0.1), Err(SurfaceError::ThicknessLength { .. })));
    let mut thin = t.clone();
    thin[7] = 0.0;
    assert_eq!(remesh(&mesh, &thin, 0.1), Err(SurfaceError::Thickness { vertex: 7, value: 0.0 }));
    let mut turned = mesh.clone();
    turned.triangles[9].swap(0, 1);
    assert!(matches!(remesh(&turned, &t, 0.1), Err(SurfaceError::Edge { .. })));
    let mut pinched = mesh.clone();
    // Two quads are left, which touch at the vertex in the middle.
    pinched.triangles.retain(|c| [[6, 7, 12], [6, 12, 11], [12, 13, 18], [12, 18, 17]].contains(c));
    assert_eq!(remesh(&pinched, &t, 0.1), Err(SurfaceError::Vertex { vertex: 12 }));
    let mut two = mesh.clone();
    two.append(&mesh.translated(Vec3::z()));
    let t = vec![0.01; 50];
    assert_eq!(remesh(&two, &t, 0.1), Err(SurfaceError::Pieces { pieces: 2 }));
}
