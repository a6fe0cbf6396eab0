//! Which way the quads lie: a field of crosses, smooth over the surface and straight along rims.

use super::crosses::{nearest_arm, nearest_arms, tangent};
use super::hierarchy::FieldLevel;
use crate::math::{Vec3, unit};
use nalgebra::Complex;

/// Gauss–Seidel sweeps of the crosses as seen in space.
const SWEEPS: usize = 12;
/// Sweeps of the linear field on each level.
const LINEAR_SWEEPS: usize = 40;
/// The stream of the seed's numbers that the first guess takes.
const STREAM: u64 = 0x0c05;

/// One arm of the cross at each vertex of each level, the finest first: a unit vector in the
/// tangent plane. First the crosses are as smooth as can be within the surface, then as seen in
/// space, so that they also follow bends \[Jakob et al. 2015, section 4.1\].
pub(super) fn directions(levels: &[FieldLevel], seed: u64) -> Vec<Vec<Vec3>> {
    let mut field: Vec<Vec3> = Vec::new();
    for level in levels.iter().rev() {
        let from = |v: usize| match level.parents.get(v) {
            Some(&parent) => {
                let coarse = field[parent as usize];
                tangent(coarse, level.normals[v]) * coarse.norm()
            }
            None => guess(level.normals[v], seed, v as u64),
        };
        field = (0..level.points.len()).map(from).collect();
        relax(level, &mut field);
    }
    for _ in 0..SWEEPS {
        sweep(&levels[0], &mut field);
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

/// Replaces each cross by the mean of those around it, in sweeps. A cross counts by the length of
/// its vector and is added up as the fourth power of a complex number, so the mean is linear, and
/// where crosses disagree they fade instead of standing against each other \[Knöppel et al. 2013,
/// *Globally optimal direction fields*\].
fn relax(level: &FieldLevel, field: &mut [Vec3]) {
    let frame = |v: usize| {
        let normal = level.normals[v];
        let x = tangent(Vec3::ith(normal.iamin(), 1.0), normal);
        [x, normal.cross(&x)]
    };
    let frames: Vec<[Vec3; 2]> = (0..field.len()).map(frame).collect();
    let coded = |v: usize, way: Vec3| {
        let [x, y] = frames[v].map(|axis| axis.dot(&way));
        fourth(Complex::new(x, y))
    };
    let held =
        |v: usize| level.holds[v].map(|hold| coded(v, tangent(hold.along, level.normals[v])));
    let mut codes: Vec<Complex<f64>> =
        (0..field.len()).map(|v| held(v).unwrap_or_else(|| coded(v, field[v]))).collect();
    let turn =
        |v: usize, w: usize| coded(v, carried(frames[w][0], level.normals[w], level.normals[v]));
    let turns: Vec<Vec<Complex<f64>>> = (0..field.len())
        .map(|v| level.neighbours(v).iter().map(|&(w, _)| turn(v, w as usize)).collect())
        .collect();
    for _ in 0..LINEAR_SWEEPS {
        let (mut square, mut free) = (0.0, 0.0);
        for v in (0..codes.len()).filter(|&v| level.holds[v].is_none()) {
            let links = level.neighbours(v).iter().zip(&turns[v]);
            let mut sum = Complex::new(0.0, 0.0);
            let mut whole = 0.0;
            for (&(w, weight), turn) in links {
                sum += codes[w as usize] * turn * weight;
                whole += weight;
            }
            codes[v] = if whole > 0.0 { sum / whole } else { codes[v] };
            square += codes[v].norm_sqr();
            free += 1.0;
        }
        // Far from rims the crosses would fade away.
        let scale = if square > 0.0 { (free / square).sqrt() } else { 1.0 };
        for v in (0..codes.len()).filter(|&v| level.holds[v].is_none()) {
            codes[v] *= scale;
        }
    }
    for (v, code) in codes.into_iter().enumerate() {
        let turn = 0.25 * libm::atan2(code.im, code.re);
        let [x, y] = frames[v];
        field[v] = (x * libm::cos(turn) + y * libm::sin(turn)) * code.norm_sqr().sqrt();
    }
}

/// The fourth power of a number's direction, with its length.
fn fourth(z: Complex<f64>) -> Complex<f64> {
    let square = z * z;
    let length = z.norm_sqr().sqrt();
    if length > 0.0 { square * square / (length * length * length) } else { z }
}

/// A vector of the plane of one `normal` turned the shortest way into that of `other`.
fn carried(way: Vec3, normal: Vec3, other: Vec3) -> Vec3 {
    let sum = 1.0 + normal.dot(&other);
    if sum > 1e-6 { way - (normal + other) * (way.dot(&other) / sum) } else { tangent(way, other) }
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

/// The field on a coarser level: the mean of each vertex's crosses.
fn restricted(fine: &FieldLevel, coarse: &FieldLevel, field: &[Vec3]) -> Vec<Vec3> {
    let mut sums: Vec<Option<Vec3>> = vec![None; coarse.points.len()];
    for (v, &parent) in fine.parents.iter().enumerate() {
        let p = parent as usize;
        let own = tangent(field[v], coarse.normals[p]);
        sums[p] = Some(match sums[p] {
            None => own,
            Some(sum) => tangent(sum + nearest_arm(sum, own, coarse.normals[p]), coarse.normals[p]),
        });
    }
    let held = |p: usize| coarse.holds[p].map(|hold| tangent(hold.along, coarse.normals[p]));
    let own =
        |p: usize| held(p).or(sums[p]).unwrap_or_else(|| tangent(Vec3::x(), coarse.normals[p]));
    (0..sums.len()).map(own).collect()
}
