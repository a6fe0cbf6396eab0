//! Crosses in the tangent plane and their arms.

use crate::math::Vec3;
use crate::remesh::curved::unit_or;

/// The unit vector of the tangent plane nearest to `way`.
pub(super) fn tangent(way: Vec3, normal: Vec3) -> Vec3 {
    let flat = way - normal * way.dot(&normal);
    let other = Vec3::ith(normal.iamin(), 1.0);
    unit_or(flat, unit_or(other - normal * other.dot(&normal), other))
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

/// The arm of a cross in the same plane as `way` that is nearest to it.
pub(super) fn nearest_arm(way: Vec3, arm: Vec3, normal: Vec3) -> Vec3 {
    let side = normal.cross(&arm);
    let (along, across) = (way.dot(&arm), way.dot(&side));
    let (cosine, arm) = if along.abs() >= across.abs() { (along, arm) } else { (across, side) };
    if cosine < 0.0 { -arm } else { arm }
}
