//! The cut of a body whose cells are no cubes: in a frame in which they are.

use super::once::{CutAttempt, extract_once};
use super::partition::{CutSettings, Partition};
use crate::error::CutError;
use crate::field::DamageField;
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};

/// One attempt at [`super::extract_stretched`], in the frame in which each axis is stretched by
/// `stretch` \[1\]. Parts come back in the body's frame: planes stay planes and volumes keep their
/// ratios.
pub(super) fn attempt(
    solid: &Solid,
    field: &DamageField<'_>,
    settings: &CutSettings,
    stretch: &Vec3,
    how: &CutAttempt,
) -> Result<Partition, CutError> {
    if *stretch == Vec3::repeat(1.0) {
        return extract_once(solid, field, settings, how);
    }
    let mut drawn = solid.clone();
    scale(&mut drawn.mesh, stretch);
    let positions: Vec<Vec3> = field.positions.iter().map(|x| x.component_mul(stretch)).collect();
    let back = stretch.map(|s| 1.0 / s);
    let across = |n: &Vec3| n.component_mul(&back).try_normalize(0.0).unwrap_or_default();
    let normals: Option<Vec<Vec3>> = field.normals.map(|all| all.iter().map(across).collect());
    let drawn_field = DamageField {
        positions: &positions,
        normals: normals.as_deref(),
        scale: field.scale.component_mul(&back),
        ..*field
    };
    let mut partition = extract_once(&drawn, &drawn_field, settings, how)?;
    let mut area = -crack_area(solid);
    for part in &mut partition.parts {
        scale(&mut part.solid.mesh, &back);
        for crack in &mut part.cracks {
            scale(&mut crack.inside.mesh, &back);
            scale(&mut crack.beyond.mesh, &back);
        }
        part.hulls.iter_mut().flatten().for_each(|x| x.component_mul_assign(&back));
        part.volume = part.solid.mesh.signed_volume();
        area += crack_area(&part.solid);
    }
    partition.crack_area = 0.5 * area;
    Ok(partition)
}

fn scale(mesh: &mut TriMesh, by: &Vec3) {
    mesh.vertices.iter_mut().for_each(|x| x.component_mul_assign(by));
}

/// Area of the faces that cracks made \[m²\].
fn crack_area(solid: &Solid) -> f64 {
    let faces = solid.mesh.triangles.iter().zip(&solid.surface);
    let cracks = faces.filter(|(_, surface)| !matches!(surface, Surface::Outer));
    cracks
        .map(|(corners, _)| {
            let [a, b, c] = corners.map(|v| solid.mesh.vertices[v as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        })
        .sum()
}
