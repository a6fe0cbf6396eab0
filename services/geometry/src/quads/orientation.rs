//! Which way the quads lie: a field of crosses, smooth over the surface and straight along rims.

use super::hierarchy::FieldLevel;
use crate::math::{Vec3, unit};
use crate::remesh::curved::unit_or;

/// Gauss–Seidel sweeps on each level.
const SWEEPS: usize = 12;
/// The stream of the seed's numbers that the first guess takes.
const STREAM: u64 = 0x0c05;

/// One arm of the cross at each vertex of each level, the finest first: a unit vector in the
/// tangent plane. The cross is smooth as seen in space, so it also follows bends \[Jakob et al.
/// 2015, section 4.1\].
pub(super) fn directions(levels: &[FieldLevel], seed: u64) -> Vec<Vec<Vec3>> {
    let mut field: Vec<Vec3> = Vec::new();
    for (l, level) in levels.iter().enumerate().rev() {
        field = if level.parents.is_empty() {
            (0..level.points.len()).map(|v| guess(level.normals[v], seed, v as u64)).collect()
        } else {
            let from = |v: usize| tangent(field[level.parents[v] as usize], level.normals[v]);
            (0..level.points.len()).map(from).collect()
        };
        let sweeps = if l == 0 { 2 * SWEEPS } else { SWEEPS };
        for _ in 0..sweeps {
            sweep(level, &mut field);
        }
    }
    let mut all = vec![field];
    for l in 1..levels.len() {
        let coarse = restricted(&levels[l - 1], &levels[l], &all[l - 1]);
        all.push(coarse);
    }
    all
}

fn guess(normal: Vec3, seed: u64, v: u64) -> Vec3 {
    let turn = std::f64::consts::TAU * unit(seed, STREAM, v);
    let x = tangent(Vec3::ith(normal.iamin(), 1.0), normal);
    x * libm::cos(turn) + normal.cross(&x) * libm::sin(turn)
}

/// The unit vector of the tangent plane nearest to `way`.
pub(super) fn tangent(way: Vec3, normal: Vec3) -> Vec3 {
    let flat = way - normal * way.dot(&normal);
    let other = Vec3::ith(normal.iamin(), 1.0);
    unit_or(flat, unit_or(other - normal * other.dot(&normal), other))
}

/// Replaces each cross by the mean of those around it.
fn sweep(level: &FieldLevel, field: &mut [Vec3]) {
    for v in 0..field.len() {
        let normal = level.normals[v];
        if let Some(hold) = level.holds[v] {
            field[v] = tangent(hold.along, normal);
            continue;
        }
        let (mut mean, mut whole) = (field[v], 0.0);
        for &(w, weight) in level.neighbours(v) {
            let (a, b) = nearest_arms(mean, normal, field[w as usize], level.normals[w as usize]);
            mean = tangent(a * whole + b * weight, normal);
            whole += weight;
        }
        field[v] = mean;
    }
}

/// The two arms, one of each cross, that are nearest to each other.
pub(super) fn nearest_arms(p: Vec3, m: Vec3, q: Vec3, n: Vec3) -> (Vec3, Vec3) {
    let (ours, theirs) = ([p, m.cross(&p)], [q, n.cross(&q)]);
    let mut best = (-1.0, p, q);
    for a in ours {
        for b in theirs {
            let cosine = a.dot(&b);
            if cosine.abs() > best.0 {
                best = (cosine.abs(), a, if cosine < 0.0 { -b } else { b });
            }
        }
    }
    (best.1, best.2)
}

/// The field on a coarser level: the mean of each vertex's crosses.
fn restricted(fine: &FieldLevel, coarse: &FieldLevel, field: &[Vec3]) -> Vec<Vec3> {
    let mut sums: Vec<Option<Vec3>> = vec![None; coarse.points.len()];
    for (v, &parent) in fine.parents.iter().enumerate() {
        let p = parent as usize;
        let own = tangent(field[v], coarse.normals[p]);
        sums[p] = Some(match sums[p] {
            None => own,
            Some(sum) => {
                let (a, b) = nearest_arms(sum, coarse.normals[p], own, coarse.normals[p]);
                tangent(a + b, coarse.normals[p])
            }
        });
    }
    let held = |p: usize| coarse.holds[p].map(|hold| tangent(hold.along, coarse.normals[p]));
    let own = |p: usize| held(p).or(sums[p]).unwrap_or_else(|| tangent(Vec3::x(), coarse.normals[p]));
    (0..sums.len()).map(own).collect()
}
