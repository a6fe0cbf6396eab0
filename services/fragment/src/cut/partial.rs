//! Cracks that end inside a part: nets from the damage, with times and speeds, clipped to it.

use super::ground::Ground;
use super::partition::{CutPart, OpenCrack};
use crate::field::DamageField;
use cullet_geometry::inside::Inside;
use cullet_geometry::shapes::refine;
use cullet_geometry::{Sheet, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Edges are divided down to this before they are clipped \[spacings\]: traces follow the surface.
const EDGE: f64 = 0.4;
/// A sheet of less area inside its part is dropped \[spacings²\].
const LEAST: f64 = 1.0;

/// Gives each part the cracks that end inside it. `labels`: those that each part comes from.
pub(super) fn attach(
    parts: &mut [CutPart],
    field: &DamageField<'_>,
    ground: &Ground,
    labels: &[Vec<u32>],
) {
    // Labels that ended in the same part, and only there, have one name.
    let mut homes: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (part, labels) in labels.iter().enumerate() {
        labels.iter().for_each(|&label| homes.entry(label).or_default().push(part));
    }
    let name = |label: u32| match homes.get(&label).map(Vec::as_slice) {
        Some(&[part]) => {
            labels[part].iter().copied().find(|l| homes[l].len() == 1).unwrap_or(label)
        }
        _ => label,
    };
    let nets = ground.nodes.partial(field, name);
    parts.par_iter_mut().zip(labels).for_each(|(part, labels)| {
        let own: Vec<&(u32, Sheet)> =
            nets.iter().filter(|(net, _)| labels.iter().any(|&l| name(l) == *net)).collect();
        if own.is_empty() {
            return;
        }
        let body = Inside::new(&part.solid.mesh);
        for (_, net) in own {
            for leaf in net.leaves() {
                let leaf = marked(leaf, ground);
                let inside = fine(&leaf, ground, field.spacing).clipped(&body);
                if inside.mesh.area() >= LEAST * field.spacing * field.spacing {
                    part.cracks.push(OpenCrack { inside, beyond: leaf });
                }
            }
        }
    });
}

/// The sheet with shorter edges.
fn fine(sheet: &Sheet, ground: &Ground, spacing: f64) -> Sheet {
    match refine(&sheet.mesh, EDGE * spacing) {
        Ok(mesh) => marked(Sheet { mesh, ..Sheet::default() }, ground),
        Err(_) => sheet.clone(),
    }
}

/// The sheet with times and speeds at its vertices.
fn marked(sheet: Sheet, ground: &Ground) -> Sheet {
    let mark = |&place: &Vec3| ground.mark(place, ground.nodes.time_at(place));
    let marks: Vec<[f32; 2]> = sheet.mesh.vertices.iter().map(mark).collect();
    Sheet {
        damage_time: marks.iter().map(|mark| mark[0]).collect(),
        front_speed: marks.iter().map(|mark| mark[1]).collect(),
        mesh: sheet.mesh,
    }
}
