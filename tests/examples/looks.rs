//! Eight looks of one broken cube: `cargo run --release -p cullet-tests --example looks [PNG]`.

use cullet_fragment::cut::{CutSettings, DamageField, Partition, extract};
use cullet_geometry::math::unit;
use cullet_geometry::{Pose, Quat, Solid, Vec3, shapes};
use cullet_model::CrackFaceDetail;
use cullet_picture::{contact_sheet, exhibit};
use cullet_scene::surface_detail::Look;
use std::path::PathBuf;

/// Side of the cube \[m\].
const SIDE: f64 = 0.2;
/// Spacing of the damage field \[m\].
const H: f64 = 0.0085;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file =
        std::env::args_os().nth(1).map_or_else(|| PathBuf::from("docs/looks.png"), PathBuf::from);
    let mut pictures = Vec::new();
    for (name, look) in Look::ALL {
        let detail = detail_of(look.detail());
        let start = std::time::Instant::now();
        let parts = broken(detail)?;
        let faces: usize = parts.parts.iter().map(|p| p.solid.mesh.triangles.len()).sum();
        println!("{name}: {} parts, {faces} faces, {:.0?}", parts.parts.len(), start.elapsed());
        let pieces: Vec<(Solid, Pose)> =
            parts.parts.iter().map(|part| (part.solid.clone(), place(&part.solid))).collect();
        let forward = Vec3::new(-0.85, 1.0, -0.75);
        pictures.push(exhibit(&pieces, material(name), forward, (600, 500), name));
    }
    contact_sheet(&pictures).save(&file)?;
    Ok(())
}

fn detail_of(d: cullet_model::CrackFaceDetail) -> CrackFaceDetail {
    CrackFaceDetail {
        edge: d.edge,
        length: d.length,
        influence: d.influence,
        grid: d.grid,
        height: d.height,
        share: d.share,
        ribs: d.ribs,
        rib_spacing: d.rib_spacing,
        grain: d.grain,
        grain_size: d.grain_size,
    }
}

/// Whose colours go with a look.
fn material(look: &str) -> &str {
    match look {
        "stone" => "granite",
        "clay" => "stoneware",
        same => same,
    }
}

/// The part at the eye's corner is laid down before the rest, its crack faces upward.
fn place(solid: &Solid) -> Pose {
    let out = solid.mesh.mass_properties().centroid;
    if out.x > 0.0 && out.y < 0.0 && out.z > 0.0 {
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), 2.3)
            * Quat::from_axis_angle(&Vec3::x_axis(), 0.5);
        let to = Vec3::new(0.17, -0.15, -0.045);
        return Pose::from_parts((to - turn * out).into(), turn);
    }
    Pose::from_parts((out * 0.04).into(), Quat::identity())
}

/// The cube, broken by three curved cracks that start near one corner.
fn broken(detail: CrackFaceDetail) -> Result<Partition, Box<dyn std::error::Error>> {
    let cube = Solid::outer(shapes::cuboid(Vec3::repeat(SIDE), Default::default())?);
    let n = (2.0 * SIDE / H).round() as u64;
    let step = SIDE / n as f64;
    let source = Vec3::new(-0.1, -0.1, 0.1);
    let at = |i: u64, k: u64, node: u64| {
        step * (node as f64 + 0.5 + 0.7 * (unit(1, k, i) - 0.5)) - 0.5 * SIDE
    };
    let positions: Vec<Vec3> = (0..n * n * n)
        .map(|i| Vec3::new(at(i, 0, i % n), at(i, 1, i / n % n), at(i, 2, i / (n * n))))
        .collect();
    let curved = |p: &Vec3| {
        let q = p / SIDE;
        let bend = |a: f64, b: f64| 0.06 * libm::sin(5.0 * a + 1.0) + 0.05 * libm::cos(4.0 * b);
        [q.x + 0.25 * q.y - bend(q.y, q.z), q.y - 0.3 * q.z - bend(q.x, q.z), q.z - bend(q.x, q.y)]
            .iter()
            .any(|d| d.abs() * SIDE < 0.8 * H)
    };
    let damage: Vec<f64> = positions.iter().map(|p| f64::from(u8::from(curved(p)))).collect();
    let damage_time: Vec<f64> = positions.iter().map(|p| (p - source).norm() / 1500.0).collect();
    let field = DamageField {
        spacing: H,
        positions: &positions,
        damage: &damage,
        damage_time: &damage_time,
        normals: None,
        pieces: None,
        scored: &[],
        time_step: 1e-8,
        top_speed: 3000.0,
        scale: Vec3::repeat(1.0),
    };
    let settings = CutSettings { min_volume_ratio: 1e-3, max_fragments: 50, seed: 3, detail };
    Ok(extract(&cube, &field, &settings)?)
}
