//! Pieces that become one: which, and how.

use super::piece::DirectedPiece;
use crate::region::{agglomerate_apart, triangle_area};
use cullet_geometry::boolean::{Exact, MAX_TAG};
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::shapes::{self, Detail};
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use cullet_model::BodyRegion;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Faces of two pieces that lie closer than this share of the body's size are one crack \[1\]. Cuts
/// are exact to 1e-12 of it.
const TOGETHER: f64 = 1e-8;
/// What a union may gain or lose, and leave beside its main part, has this share of the body's
/// volume: rounding.
const REST: f64 = 1e-9;
/// The tag of a face that was there before any crack.
const OUTER: u32 = MAX_TAG;

/// What came of a union.
pub(super) struct United {
    /// The pieces as one; nothing if no two of them touch.
    pub(super) piece: Option<DirectedPiece>,
    /// Those that it is made of.
    pub(super) members: Vec<usize>,
    /// The others.
    pub(super) left: Vec<usize>,
}

/// Joins pieces of a body of that volume \[m³\] as far as they touch.
pub(super) fn unite(pieces: &[DirectedPiece], members: &[usize], volume: f64) -> United {
    let mut sorted = members.to_vec();
    sorted.sort_by(|&a, &b| DirectedPiece::order(&pieces[a], &pieces[b]));
    // A triangle's tag is its place in the list of all.
    let mut faces: Vec<([Vec3; 3], Surface)> = Vec::new();
    let mut exact = |k: usize| -> Option<Exact> {
        let solid = &pieces[k].fragment.solid;
        let tags: Vec<u32> = (0..solid.mesh.triangles.len())
            .map(|t| match solid.surface[t] {
                Surface::Outer => OUTER,
                crack => {
                    faces.push((solid.mesh.corners(t), crack));
                    faces.len() as u32 - 1
                }
            })
            .collect();
        Exact::tagged(&solid.mesh, &tags).ok()
    };
    let mut waiting: Vec<(usize, Option<Exact>)> = sorted.iter().map(|&k| (k, exact(k))).collect();
    let none = || United { piece: None, members: Vec::new(), left: members.to_vec() };
    if waiting.len() < 2 {
        return none();
    }
    let (first, Some(mut whole)) = waiting.remove(0) else { return none() };
    let (mut joined, mut sum) = (vec![first], pieces[first].properties.volume);
    loop {
        let before = waiting.len();
        waiting.retain(|(k, other)| {
            let both = sum + pieces[*k].properties.volume;
            let union = other.as_ref().and_then(|other| one(&whole, other, both, REST * volume));
            let Some(union) = union else { return true };
            (whole, sum) = (union, both);
            joined.push(*k);
            false
        });
        if waiting.is_empty() || waiting.len() == before {
            break;
        }
    }
    joined.sort_unstable();
    if joined.len() < 2 {
        return none();
    }
    let Ok((mesh, tags)) = whole.to_tagged() else { return none() };
    if (mesh.signed_volume() - sum).abs() > REST * volume {
        return none();
    }
    let surface = tags.iter().enumerate().map(|(t, &tag)| match faces.get(tag as usize) {
        Some((corners, crack)) => crack.within(*corners, mesh.corners(t)),
        None => Surface::Outer,
    });
    let solid = Solid { surface: surface.collect(), mesh };
    let of: Vec<&DirectedPiece> = joined.iter().map(|&k| &pieces[k]).collect();
    let piece = Some(DirectedPiece::joined(&of, solid));
    let left = waiting.into_iter().map(|(k, _)| k).collect();
    United { piece, members: joined, left }
}

/// Two bodies as one, if they touch along a face.
fn one(a: &Exact, b: &Exact, volume: f64, rest: f64) -> Option<Exact> {
    let mut parts = a.union(b).ok()?.components().ok()?.into_iter();
    let main = parts.next()?;
    let crumbs: f64 = parts.map(|part| part.volume()).sum();
    if crumbs > rest || (main.volume() - volume).abs() > rest {
        return None;
    }
    // What the kernel keeps of where faces come from doubles with each union: begin it anew.
    let (mesh, tags) = main.to_tagged().ok()?;
    let anew = Exact::tagged(&mesh, &tags).ok()?;
    // Seen once: what was thin was lost on the way in.
    Some(if (anew.volume() - volume).abs() <= rest { anew } else { main })
}

/// The groups of pieces that leave no more than `wanted`: the smallest join the neighbour with
/// which they share the largest face, but no two of those that stay `apart`.
pub(super) fn neighbours(
    pieces: &[DirectedPiece],
    apart: Vec<bool>,
    wanted: usize,
) -> Vec<Vec<usize>> {
    let volumes: Vec<f64> = pieces.iter().map(|piece| piece.properties.volume).collect();
    let forced = vec![false; pieces.len()];
    let groups = agglomerate_apart(&volumes, &forced, apart, &shared(pieces), (0.0, wanted));
    let mut by_name: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (k, group) in groups.into_iter().enumerate() {
        by_name.entry(group).or_default().push(k);
    }
    by_name.into_values().filter(|members| members.len() > 1).collect()
}

/// Area of the cracks between pieces \[m²\].
fn shared(pieces: &[DirectedPiece]) -> BTreeMap<(u32, u32), f64> {
    let bounds: Vec<(Vec3, Vec3)> =
        pieces.iter().map(|piece| piece.fragment.solid.mesh.bounds().unwrap_or_default()).collect();
    let low = bounds.iter().fold(Vec3::repeat(f64::MAX), |low, b| low.inf(&b.0));
    let high = bounds.iter().fold(Vec3::repeat(f64::MIN), |high, b| high.sup(&b.1));
    let near = TOGETHER * (high - low).norm();
    let trees: Vec<Nearest> =
        pieces.par_iter().map(|piece| Nearest::new(&piece.fragment.solid.mesh)).collect();
    let beside = |(k, piece): (usize, &DirectedPiece)| -> Vec<((u32, u32), f64)> {
        let solid = &piece.fragment.solid;
        let mut found = Vec::new();
        for (t, surface) in solid.surface.iter().enumerate() {
            if !matches!(surface, Surface::Crack { parent: 0, .. }) {
                continue;
            }
            let middle = solid.mesh.corners(t).iter().sum::<Vec3>() / 3.0;
            let area = triangle_area(&solid.mesh.vertices, solid.mesh.triangles[t]);
            let touches = |&j: &usize| {
                let (low, high) = &bounds[j];
                let held = (0..3).all(|a| (low[a] - near..=high[a] + near).contains(&middle[a]));
                held && trees[j].closest_within(middle, near, |_| true).is_some()
            };
            let others = (0..pieces.len()).filter(|&j| j != k && !pieces[j].is_alone);
            found.extend(
                others.filter(touches).map(|j| ((k.min(j) as u32, k.max(j) as u32), 0.5 * area)),
            );
        }
        found
    };
    let found: Vec<_> = pieces.par_iter().enumerate().map(beside).collect();
    let mut shared = BTreeMap::new();
    for ((a, b), area) in found.into_iter().flatten() {
        if !pieces[a as usize].is_alone && !pieces[b as usize].is_alone {
            *shared.entry((a, b)).or_insert(0.0) += area;
        }
    }
    shared
}

/// The pieces that reach into a region, in rising order.
pub(super) fn overlapping(pieces: &[DirectedPiece], region: &BodyRegion) -> Vec<usize> {
    let reaches: Box<dyn Fn(&TriMesh) -> bool + Sync> = match *region {
        BodyRegion::Ball { centre, radius } => Box::new(move |mesh| {
            Nearest::new(mesh).distance(centre) < radius || Inside::new(mesh).contains(centre)
        }),
        BodyRegion::Box { low, high } => {
            let block = shapes::cuboid(high - low, Detail::default()).ok();
            let block = block.map(|mesh| mesh.translated(0.5 * (low + high)));
            let block = block.and_then(|mesh| Exact::new(&Solid::outer(mesh)).ok());
            let least = REST * (high - low).product();
            Box::new(move |mesh| {
                let tags = vec![OUTER; mesh.triangles.len()];
                let (Some(block), Ok(piece)) = (&block, Exact::tagged(mesh, &tags)) else {
                    return false;
                };
                block.intersect(&piece).is_ok_and(|common| common.volume() > least)
            })
        }
    };
    let (low, high) = match *region {
        BodyRegion::Ball { centre, radius } => {
            (centre.add_scalar(-radius), centre.add_scalar(radius))
        }
        BodyRegion::Box { low, high } => (low, high),
    };
    let near = |mesh: &TriMesh| {
        let (from, to) = mesh.bounds().unwrap_or_default();
        (0..3).all(|k| from[k] <= high[k] && low[k] <= to[k])
    };
    let within = |piece: &DirectedPiece| {
        let mesh = &piece.fragment.solid.mesh;
        near(mesh) && reaches(mesh)
    };
    let within: Vec<bool> = pieces.par_iter().map(within).collect();
    (0..pieces.len()).filter(|&k| within[k]).collect()
}
