//! Walls divided into quads: even, nearly regular, with their rims, and the same bits each time.

use super::{QuadError, QuadSurface};
use crate::divide::key;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::remesh::remesh;
use crate::shapes::{Detail, lathe_midline, torus};
use crate::wall_surface::WallSurface;
use std::f64::consts::TAU;

/// How even the quads of a surface are.
#[derive(Clone, Debug, Default)]
struct QuadQuality {
    /// Least, 1st percentile and greatest edge over the wanted \[1\].
    edges: [f64; 3],
    /// Least and greatest angle of a quad \[degrees\].
    angles: [f64; 2],
    /// Least and greatest number of quads at a vertex inside.
    inside: [usize; 2],
    /// Least and greatest number of quads at a vertex of a rim.
    rim: [usize; 2],
    /// Share of interior vertices without four quads \[1\].
    irregular: f64,
    /// Area \[m²\].
    area: f64,
    /// Vertices − edges + faces.
    euler: i64,
    /// Edges of one quad only.
    open: usize,
}

impl QuadQuality {
    fn of(surface: &QuadSurface, edge: f64) -> Self {
        let mut quality = Self { angles: [360.0, 0.0], ..Self::default() };
        let mut valence = vec![0; surface.vertices.len()];
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for quad in &surface.quads {
            let p = quad.map(|v| surface.vertices[v as usize]);
            let normal = (p[2] - p[0]).cross(&(p[3] - p[1]));
            quality.area += 0.5 * normal.norm();
            for k in 0..4 {
                valence[quad[k] as usize] += 1;
                edges.push(key(quad[k], quad[(k + 1) % 4]));
                let (e, f) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
                let sine = e.cross(&f).dot(&normal.normalize());
                let angle = libm::atan2(sine, e.dot(&f)).to_degrees().rem_euclid(360.0);
                let [low, high] = quality.angles;
                quality.angles = [low.min(angle), high.max(angle)];
            }
        }
        edges.sort_unstable();
        let mut is_rim = vec![false; valence.len()];
        let mut lengths: Vec<f64> = Vec::new();
        for uses in edges.chunk_by(|a, b| a == b) {
            assert!(uses.len() <= 2, "an edge of {} quads", uses.len());
            let [a, b] = uses[0].map(|v| v as usize);
            lengths.push((surface.vertices[a] - surface.vertices[b]).norm() / edge);
            if uses.len() == 1 {
                quality.open += 1;
                [is_rim[a], is_rim[b]] = [true, true];
            }
        }
        lengths.sort_by(f64::total_cmp);
        quality.edges = [0, lengths.len() / 100, lengths.len() - 1].map(|i| lengths[i]);
        let range = |rim: bool| {
            let all = || valence.iter().zip(&is_rim).filter(|v| *v.1 == rim).map(|v| *v.0);
            [all().min().unwrap_or(4), all().max().unwrap_or(4)]
        };
        [quality.inside, quality.rim] = [range(false), range(true)];
        let inner = || valence.iter().zip(&is_rim).filter(|v| !*v.1);
        let odd = inner().filter(|v| *v.0 != 4).count();
        quality.irregular = odd as f64 / inner().count() as f64;
        let [v, e, f] = [valence.len(), lengths.len(), surface.quads.len()];
        quality.euler = v as i64 - e as i64 + f as i64;
        quality
    }
}

/// Divides a wall twice and holds the quads against the bounds that all of them have to keep.
fn assert_even(wall: &WallSurface, edge: f64, irregular: f64) -> QuadQuality {
    let surface = QuadSurface::of_wall(wall, edge, 7).unwrap();
    assert_eq!(surface, QuadSurface::of_wall(wall, edge, 7).unwrap(), "not the same bits");
    let q = QuadQuality::of(&surface, edge);
    assert!(q.edges[0] >= 0.3 && q.edges[1] >= 0.6 && q.edges[2] <= 1.9, "{q:?}");
    assert!(q.angles[0] >= 30.0 && q.angles[1] <= 150.0, "{q:?}");
    assert!(q.inside[0] >= 3 && q.inside[1] <= 6 && q.rim[1] <= 4, "{q:?}");
    assert!(q.irregular <= irregular, "{q:?}");
    assert!((q.area / wall.area() - 1.0).abs() < 0.01, "{q:?}");
    let count = surface.quads.len() as f64 * edge * edge / wall.area();
    assert!((count - 1.0).abs() < 0.15, "{count}");
    let mesh = wall.mesh();
    let [v, e, f] = [mesh.vertices.len(), mesh.edges().len(), mesh.triangles.len()];
    assert_eq!(q.euler, v as i64 - e as i64 + f as i64);
    assert_rims(wall, &surface);
    q
}

/// As many rims as the wall has, the quads on the same side of them, and thickness everywhere.
fn assert_rims(wall: &WallSurface, surface: &QuadSurface) {
    let halves = surface.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let mesh = TriMesh { vertices: surface.vertices.clone(), triangles: halves.collect() };
    let split = WallSurface {
        thickness: surface.thickness.clone(),
        vertices: mesh.vertices.clone(),
        triangles: mesh.triangles.clone(),
    };
    crate::remesh::check_surface(&mesh, &split.thickness).unwrap();
    assert_eq!(split.boundary().len(), wall.boundary().len());
    let volume = |m: &TriMesh| m.mass_properties().volume;
    if wall.boundary().is_empty() {
        assert!(mesh.is_closed());
        assert!((volume(&mesh) / volume(&wall.mesh()) - 1.0).abs() < 0.02);
    }
    assert!((split.volume() / wall.volume() - 1.0).abs() < 0.01);
}

fn arc(centre: [f64; 2], radius: f64, from: f64, to: f64, parts: usize) -> Vec<[f64; 2]> {
    let point = |k: usize| {
        let angle = (from + (to - from) * k as f64 / parts as f64).to_radians();
        let x = centre[0] + radius * libm::cos(angle);
        [if x.abs() < 1e-9 { 0.0 } else { x }, centre[1] + radius * libm::sin(angle)]
    };
    (0..=parts).map(point).collect()
}

fn lathed(profile: &[[f64; 2]], thickness: f64, edge: f64) -> WallSurface {
    let mesh = lathe_midline(profile, thickness, Detail { edge: None, segments: 64 }).unwrap();
    WallSurface::of_mesh(&mesh, edge).unwrap()
}

/// A grid of nx × ny quads cut in triangles, each vertex at its `place`.
fn grid(nx: u32, ny: u32, edge: f64, place: impl Fn(f64, f64) -> Vec3) -> WallSurface {
    let mut mesh = TriMesh::default();
    for (j, i) in (0..=ny).flat_map(|j| (0..=nx).map(move |i| (j, i))) {
        mesh.vertices.push(place(f64::from(i) / f64::from(nx), f64::from(j) / f64::from(ny)));
    }
    for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
        let [a, b] = [j, j + 1].map(|j| j * (nx + 1) + i);
        mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
    }
    remesh(&mesh, &vec![0.004; mesh.vertices.len()], edge).unwrap()
}

#[test]
fn a_bottle_is_divided_evenly() {
    let mut profile = vec![[0.0, 0.0], [0.010, 0.0], [0.020, 0.0]];
    profile.extend(arc([0.027, 0.010], 0.010, -90.0, 0.0, 6));
    profile.extend([[0.037, 0.06], [0.037, 0.12]]);
    profile.extend(arc([0.022, 0.15], 0.015, 0.0, 60.0, 6));
    profile.extend([[0.014, 0.20], [0.014, 0.25]]);
    let q = assert_even(&lathed(&profile, 0.003, 0.003), 0.003, 0.03);
    assert!(q.rim[0] >= 2, "{q:?}");
}

#[test]
fn a_bowl_is_divided_evenly_up_to_its_rim() {
    let wall = lathed(&arc([0.0, 0.08], 0.08, -90.0, 0.0, 24), 0.004, 0.004);
    let q = assert_even(&wall, 0.004, 0.03);
    assert!(q.rim[0] >= 2, "{q:?}");
    let surface = QuadSurface::of_wall(&wall, 0.004, 7).unwrap();
    assert!(surface.thickness.iter().all(|t| (t / 0.004 - 1.0).abs() < 0.05));
}

#[test]
fn an_egg_stays_closed() {
    let wall = lathed(&arc([0.0, 0.0], 0.022, -90.0, 90.0, 24), 0.0006, 0.0012);
    let q = assert_even(&wall, 0.0012, 0.03);
    assert_eq!((q.open, q.euler), (0, 2));
}

#[test]
fn a_torus_keeps_its_hole() {
    let mesh = torus(0.05, 0.02, Detail { edge: None, segments: 64 }).unwrap();
    let wall = remesh(&mesh, &vec![0.002; mesh.vertices.len()], 0.005).unwrap();
    assert_eq!(assert_even(&wall, 0.005, 0.04).euler, 0);
}

#[test]
fn a_flat_rectangle_is_nearly_a_grid_with_its_corners() {
    let wall = grid(10, 7, 0.004, |u, v| Vec3::new(0.2 * u, 0.14 * v, 0.0));
    let q = assert_even(&wall, 0.004, 0.005);
    assert_eq!(q.rim, [1, 2], "{q:?}");
    assert!((q.area / 0.028 - 1.0).abs() < 1e-9, "{q:?}");
    let surface = QuadSurface::of_wall(&wall, 0.004, 7).unwrap();
    for corner in [[0.0, 0.0], [0.2, 0.0], [0.2, 0.14], [0.0, 0.14]] {
        let corner = Vec3::new(corner[0], corner[1], 0.0);
        assert!(surface.vertices.iter().any(|p| (p - corner).norm() < 1e-12), "{corner}");
    }
}

#[test]
fn a_flat_disc_and_a_bent_panel_are_divided_evenly() {
    let place = |u: f64, r: f64| Vec3::new(libm::cos(TAU * u), libm::sin(TAU * u), 0.0) * r;
    let mut mesh = TriMesh { vertices: vec![Vec3::zeros()], triangles: Vec::new() };
    for k in 0..96 {
        mesh.vertices.push(place(f64::from(k) / 96.0, 0.1));
        mesh.triangles.push([0, 1 + k, 1 + (k + 1) % 96]);
    }
    let disc = remesh(&mesh, &[0.004; 97], 0.004).unwrap();
    let q = assert_even(&disc, 0.004, 0.04);
    assert!(q.rim[0] >= 2, "{q:?}");
    let panel = grid(40, 10, 0.02, |u, v| {
        let turn = 1.6 * (u - 0.5);
        let rise = 0.5 * v + 0.1 * turn * turn;
        Vec3::new(0.8 * libm::sin(turn), rise, 0.8 * libm::cos(turn))
    });
    assert_even(&panel, 0.02, 0.02);
}

#[test]
fn what_cannot_be_divided_is_refused() {
    let wall = grid(10, 7, 0.01, |u, v| Vec3::new(0.2 * u, 0.14 * v, 0.0));
    for edge in [0.2, 0.0, -1.0, f64::NAN] {
        let answer = QuadSurface::of_wall(&wall, edge, 1);
        assert!(matches!(answer, Err(QuadError::Edge { .. })), "{answer:?}");
    }
    let mut torn = wall.clone();
    torn.triangles[3].swap(0, 1);
    assert!(matches!(QuadSurface::of_wall(&torn, 0.01, 1), Err(QuadError::Surface(_))));
}
