//! How long it takes to find a crack in a cloud of particles, and to cut a body into pieces.
//!
//! `CULLET_MESHES` may name a folder with `rocker-arm.obj` and `spot.obj`; a noisy sphere of about
//! 20 000 triangles stands in for what is not there.

use cullet_fragment::cut::{CutSettings, DamageField, by_sites, extract};
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::{Solid, TriMesh, Vec3, shapes};
use cullet_model::CrackFaceDetail;

fn main() {
    divan::main();
}

/// 150 000 particles in a plate of 0.2 × 0.2 × 0.03 m with five wavy radial bands of damage.
#[divan::bench(sample_count = 5)]
fn extract_from_150k_particles(bencher: divan::Bencher<'_, '_>) {
    let size = Vec3::new(0.2, 0.2, 0.03);
    let h = 0.004;
    let n = [100u64, 100, 15];
    let positions: Vec<Vec3> = (0..n[0] * n[1] * n[2])
        .map(|i| {
            let node = [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
            let at = |k: usize| {
                let jitter = 0.5 * (unit(1, k as u64, i) - 0.5);
                (node[k] as f64 + 0.5 + jitter) / n[k] as f64 * size[k] - 0.5 * size[k]
            };
            Vec3::new(at(0), at(1), at(2))
        })
        .collect();
    let band = |p: &Vec3| {
        (0..5).any(|k| {
            let r = libm::hypot(p.x, p.y);
            let angle = 1.2566 * f64::from(k) + 0.15 * libm::sin(r / 0.015) + 4.0 * p.z;
            let (s, c) = libm::sincos(angle);
            c * p.x + s * p.y > 0.0 && (s * p.x - c * p.y).abs() < 0.9 * h
        })
    };
    let damage: Vec<f64> = positions.iter().map(|p| f64::from(u8::from(band(p)))).collect();
    let time: Vec<f64> =
        damage.iter().map(|&d| if d > 0.5 { 1e-5 } else { f64::INFINITY }).collect();
    let plate = Solid::outer(shapes::cuboid(size, Default::default()).expect("a plate"));
    let field = DamageField {
        spacing: h,
        positions: &positions,
        damage: &damage,
        damage_time: &time,
        time_step: 1e-9,
        top_speed: 3000.0,
        scale: Vec3::repeat(1.0),
        normals: None,
        pieces: None,
        scored: &[],
    };
    let settings = CutSettings {
        min_volume_ratio: 1e-4,
        max_fragments: 400,
        seed: 1,
        detail: CrackFaceDetail::NONE,
    };
    bencher.bench(|| {
        let parts = extract(&plate, &field, &settings).expect("a cut").parts.len();
        assert_eq!(parts, 5);
    });
}

/// A body cut by uniformly random cells.
fn cut(bencher: divan::Bencher<'_, '_>, mesh: &str, count: usize, detail: CrackFaceDetail) {
    let solid = Solid::outer(load(mesh).unwrap_or_else(noisy_sphere));
    let (low, high) = solid.mesh.bounds().expect("a body");
    let inside = Inside::new(&solid.mesh);
    let at = |i, k: usize| low[k] + unit(2, k as u64, i) * (high[k] - low[k]);
    let sites: Vec<Vec3> = (0u64..)
        .map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2)))
        .filter(|&p| inside.contains(p))
        .take(count)
        .collect();
    let labels: Vec<u32> = (0..count as u32).collect();
    let settings = CutSettings { min_volume_ratio: 1e-6, max_fragments: 5000, seed: 1, detail };
    let times = vec![0.0; count];
    bencher.bench(|| by_sites(&solid, &sites, &labels, &times, &settings).expect("a cut"));
}

#[divan::bench(sample_count = 3)]
fn rocker_arm_into_50(bencher: divan::Bencher<'_, '_>) {
    cut(bencher, "rocker-arm.obj", 50, CrackFaceDetail::NONE);
}

#[divan::bench(sample_count = 3)]
fn spot_into_1000(bencher: divan::Bencher<'_, '_>) {
    cut(bencher, "spot.obj", 1000, CrackFaceDetail::NONE);
}

/// Faces with noise, of the body and the number of cells at which other tools were timed.
#[divan::bench(sample_count = 3)]
fn rocker_arm_into_27_with_noisy_faces(bencher: divan::Bencher<'_, '_>) {
    let noise =
        CrackFaceDetail { edge: 0.5, grain: 0.15, grain_size: 2.0, ..CrackFaceDetail::NONE };
    cut(bencher, "rocker-arm.obj", 27, noise);
}

/// The triangles of an OBJ file in the folder that `CULLET_MESHES` names.
fn load(name: &str) -> Option<TriMesh> {
    let folder = std::env::var_os("CULLET_MESHES")?;
    let text = std::fs::read_to_string(std::path::Path::new(&folder).join(name)).ok()?;
    let mut mesh = TriMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
                mesh.vertices.push(Vec3::new(x[0], x[1], x[2]));
            }
            Some("f") => {
                let number = |word: &str| word.split('/').next().and_then(|n| n.parse().ok());
                let ids: Vec<u32> = words.filter_map(number).map(|n: u32| n - 1).collect();
                mesh.triangles.extend((2..ids.len()).map(|k| [ids[0], ids[k - 1], ids[k]]));
            }
            _ => {}
        }
    }
    Some(mesh)
}

fn noisy_sphere() -> TriMesh {
    let (rows, columns) = (72u32, 140u32);
    let place = |row: u32, column: u32| {
        let (s, c) = libm::sincos(std::f64::consts::PI * f64::from(row) / f64::from(rows));
        let (b, a) = libm::sincos(std::f64::consts::TAU * f64::from(column) / f64::from(columns));
        let noise = 1.0 + 0.1 * unit(3, u64::from(row), u64::from(column));
        Vec3::new(s * a, s * b, c) * noise
    };
    let mut mesh = TriMesh::default();
    mesh.vertices.push(Vec3::z());
    for row in 1..rows {
        mesh.vertices.extend((0..columns).map(|column| place(row, column)));
    }
    mesh.vertices.push(-Vec3::z());
    let id = |row: u32, column: u32| 1 + (row - 1) * columns + column % columns;
    let last = mesh.vertices.len() as u32 - 1;
    for column in 0..columns {
        mesh.triangles.push([0, id(1, column), id(1, column + 1)]);
        mesh.triangles.push([last, id(rows - 1, column + 1), id(rows - 1, column)]);
        for row in 1..rows - 1 {
            let [a, b] = [id(row, column), id(row, column + 1)];
            let [c, d] = [id(row + 1, column), id(row + 1, column + 1)];
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    mesh
}
