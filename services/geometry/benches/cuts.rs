//! Cutting a body by random Voronoi cells, one thread: 50 pieces of a 20k-triangle body, 1000 of a
//! 6k-triangle one. With `CULLET_MESHES` naming a folder that has them, the bodies are `rocker-arm`
//! and `spot`; else balls with bumps of the same sizes.

use cullet_geometry::boolean::Exact;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::math::unit;
use cullet_geometry::shapes::{Detail, sphere};
use cullet_geometry::voronoi::{Cells, Face, Key};
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use std::collections::BTreeMap;

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 5)]
fn rocker_arm_50(bencher: divan::Bencher<'_, '_>) {
    let (body, cells) = prepared("rocker-arm.obj", 160, 50);
    bencher.bench(|| cut(&body, &cells).len());
}

#[divan::bench(sample_count = 2)]
fn spot_1000(bencher: divan::Bencher<'_, '_>) {
    let (body, cells) = prepared("spot.obj", 85, 1000);
    bencher.bench(|| cut(&body, &cells).len());
}

/// Convex stand-ins of the 50 pieces.
#[divan::bench(sample_count = 5)]
fn convex_parts_of_50(bencher: divan::Bencher<'_, '_>) {
    let (body, cells) = prepared("rocker-arm.obj", 160, 50);
    let pieces = cut(&body, &cells);
    let settings = HullSettings::default();
    bencher.bench(|| pieces.iter().map(|p| convex_parts(p, settings).len()).sum::<usize>());
}

/// The body, and enough cells that `pieces` of them meet it.
fn prepared(name: &str, segments: u32, pieces: usize) -> (Exact, Vec<Exact>) {
    let mesh = body(name, segments);
    let whole = Solid::outer(mesh.clone());
    let (low, high) = mesh.bounds().unwrap();
    let margin = 0.01 * (high - low);
    let (low, high) = (low - margin, high + margin);
    let inside = cullet_geometry::inside::Inside::new(&mesh);
    let sites: Vec<Vec3> = (0..)
        .map(|i| {
            let at = |k: usize| low[k] + (high[k] - low[k]) * unit(1, k as u64, i);
            Vec3::new(at(0), at(1), at(2))
        })
        .filter(|&p| inside.contains(p))
        .take(pieces)
        .collect();
    let cells = Cells::new(sites, low, high).unwrap();
    let solids = (0..pieces as u32).map(|i| Exact::new(&solid_of(&cells, i)).unwrap());
    (Exact::new(&whole).unwrap(), solids.collect())
}

/// Every connected piece of every cell, as a solid; their volumes must sum to the body's.
fn cut(body: &Exact, cells: &[Exact]) -> Vec<Solid> {
    let mut pieces = Vec::new();
    for cell in cells {
        let part = body.intersect(cell).unwrap();
        for piece in part.components().unwrap() {
            pieces.push(piece.to_solid().unwrap());
        }
    }
    let sum: f64 = pieces.iter().map(Solid::volume).sum();
    assert!((sum / body.volume() - 1.0).abs() < 1e-9);
    pieces
}

fn solid_of(cells: &Cells, site: u32) -> Solid {
    let faces: Vec<Face> = cells.cell(site).unwrap();
    let mut index: BTreeMap<Key, u32> = BTreeMap::new();
    let mut mesh = TriMesh::default();
    for face in &faces {
        let mut corner = |key: &Key| {
            *index.entry(*key).or_insert_with(|| {
                mesh.vertices.push(cells.position(key));
                mesh.vertices.len() as u32 - 1
            })
        };
        let rim: Vec<u32> = face.corners.iter().map(&mut corner).collect();
        let fan = (1..rim.len() - 1).map(|i| [rim[0], rim[i], rim[i + 1]]);
        mesh.triangles.extend(fan);
    }
    let surface = vec![Surface::crack(0.0); mesh.triangles.len()];
    Solid { mesh, surface }
}

/// The named mesh, or a bumpy ball.
fn body(name: &str, segments: u32) -> TriMesh {
    let folder = std::env::var_os("CULLET_MESHES").map(std::path::PathBuf::from);
    if let Some(text) = folder.and_then(|f| std::fs::read_to_string(f.join(name)).ok()) {
        return read_obj(&text);
    }
    let mut ball = sphere(1.0, Detail { segments, edge: None }).unwrap();
    for p in &mut ball.vertices {
        let d = *p;
        *p *= 1.0 + 0.15 * libm::sin(5.0 * d.x + 2.0 * d.y) * libm::cos(4.0 * d.z);
    }
    ball
}

/// Vertices and polygons of a Wavefront OBJ text.
fn read_obj(text: &str) -> TriMesh {
    let mut mesh = TriMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                mesh.vertices.push(Vec3::new(c[0], c[1], c[2]));
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                let f: Vec<u32> = words.map(index).collect();
                mesh.triangles.extend((1..f.len() - 1).map(|i| [f[0], f[i], f[i + 1]]));
            }
            _ => {}
        }
    }
    mesh
}
