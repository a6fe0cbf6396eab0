//! What of a flat piece of the surface lies in a part of space.

use crate::place::Where;
use cullet_geometry::Vec3;
use cullet_model::strength::Region;
use std::f64::consts::{PI, TAU};

/// Planes that stand for a round side. Their polygon has the circle's area.
const SIDES: u32 = 240;

/// Cuts off a piece, convex and in order around it, what lies outside of the part. What is no
/// farther outside than `slack` \[m\] stays.
pub(super) fn clip(piece: &mut Vec<Vec3>, part: &Where, slack: f64) {
    for region in part {
        let middle = piece.iter().sum::<Vec3>() / piece.len().max(1) as f64;
        let reach = piece.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        if piece.iter().all(|x| region.contains(x, slack)) {
            continue;
        }
        if region.contains(&middle, reach + slack) {
            cut_region(piece, region, slack);
        } else {
            piece.clear();
        }
    }
}

/// Middle, and normal times area \[m²\], of a convex piece in order around it.
pub(super) fn measure(piece: &[Vec3]) -> (Vec3, Vec3) {
    let Some(&first) = piece.first() else { return (Vec3::zeros(), Vec3::zeros()) };
    let (mut moment, mut area) = (Vec3::zeros(), Vec3::zeros());
    for side in piece[1..].windows(2) {
        let (u, v) = (side[0] - first, side[1] - first);
        let own = u.cross(&v) / 2.0;
        moment += (u + v) / 3.0 * own.norm();
        area += own;
    }
    let size = area.norm();
    if size > 0.0 { (first + moment / size, area) } else { (first, area) }
}

fn cut_region(piece: &mut Vec<Vec3>, region: &Region, slack: f64) {
    match *region {
        Region::HalfSpace { point, normal } => cut(piece, &point, &normal, slack),
        Region::Box { low, high } => {
            for axis in 0..3 {
                cut(piece, &low, &Vec3::ith(axis, -1.0), slack);
                cut(piece, &high, &Vec3::ith(axis, 1.0), slack);
            }
        }
        Region::Cylinder { from, to, radius } => {
            let axis = (to - from).normalize();
            cut(piece, &from, &-axis, slack);
            cut(piece, &to, &axis, slack);
            cut_round(piece, &from, &axis, radius, slack);
        }
        Region::Groove { from, to, inward, half_width } => {
            let (axis, down) = ((to - from).normalize(), inward.normalize());
            for (way, reach) in
                [(axis, (to - from).norm()), (down, inward.norm()), (axis.cross(&down), 0.0)]
            {
                let middle = 0.5 * (from + to + inward);
                let arm = way * (0.5 * reach + half_width);
                cut(piece, &(middle + arm), &way, slack);
                cut(piece, &(middle - arm), &-way, slack);
            }
        }
        Region::Sphere { centre, radius } => {
            let (first, area) = (piece.first().copied(), measure(piece).1);
            let (Some(first), Some(normal)) = (first, area.try_normalize(0.0)) else {
                return piece.clear();
            };
            let off = (first - centre).dot(&normal);
            let across = radius * radius - off * off;
            if across <= 0.0 {
                return piece.clear();
            }
            cut_round(piece, &(centre + normal * off), &normal, across.sqrt(), slack);
        }
    }
}

/// Cuts along a cylinder without ends.
fn cut_round(piece: &mut Vec<Vec3>, centre: &Vec3, axis: &Vec3, radius: f64, slack: f64) {
    let u = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize();
    let v = axis.cross(&u);
    let sides = f64::from(SIDES);
    let reach = radius * (PI / (sides * libm::tan(PI / sides))).sqrt();
    for side in 0..SIDES {
        let (sin, cos) = libm::sincos(TAU * f64::from(side) / sides);
        let normal = u * cos + v * sin;
        cut(piece, &(centre + normal * reach), &normal, slack);
    }
}

/// Cuts off what lies along the normal of a plane.
fn cut(piece: &mut Vec<Vec3>, point: &Vec3, normal: &Vec3, slack: f64) {
    let off: Vec<f64> = piece.iter().map(|x| (x - point).dot(normal)).collect();
    if off.iter().all(|&d| d <= slack) {
        return;
    }
    let whole = std::mem::take(piece);
    for (k, (x, &d)) in whole.iter().zip(&off).enumerate() {
        let next = (k + 1) % whole.len();
        if d <= 0.0 {
            piece.push(*x);
        }
        if (d <= 0.0) != (off[next] <= 0.0) {
            piece.push(x + (whole[next] - x) * (d / (d - off[next])));
        }
    }
}
