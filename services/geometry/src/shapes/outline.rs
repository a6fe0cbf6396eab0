//! Plane outlines: checks, triangulation, extrusion.

use super::detail::{self, Detail, ShapeError, check_size};
use super::refine::finished;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use robust::{Coord, orient2d};

/// Most points of an outline: checking and triangulating it are quadratic, a second at this size.
pub(super) const MAX_POINTS: usize = 4096;

/// A prism along z over a simple polygon (either way round, convex or not) given in the xy plane
/// \[m\], from −height/2 to +height/2.
///
/// # Errors
/// A value out of range, an outline that crosses itself or encloses nothing, or too many triangles.
pub fn extrude(outline: &[[f64; 2]], height: f64, detail: Detail) -> Result<TriMesh, ShapeError> {
    check_size("extrusion height", height)?;
    let outline = checked_loop(outline)?;
    let n = outline.len() as u32;
    let level = |z: f64| outline.iter().map(move |p| Vec3::new(p[0], p[1], z));
    let vertices = level(-0.5 * height).chain(level(0.5 * height)).collect();
    let mut triangles = Vec::with_capacity(4 * n as usize);
    for [a, b, c] in triangulate(&outline) {
        triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    finished(TriMesh { vertices, triangles }, detail)
}

/// Triangles of a simple counter-clockwise polygon by ear clipping, with exact predicates; every
/// point is used, also those in the middle of a straight edge. A polygon that is not simple gives
/// fewer triangles than points less two.
#[must_use]
pub fn triangulate(outline: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let mut left: Vec<u32> = (0..outline.len() as u32).collect();
    let mut triangles = Vec::with_capacity(outline.len().saturating_sub(2));
    let mut at = 0;
    let mut misses = 0;
    while left.len() >= 3 && misses < left.len() {
        let n = left.len();
        let i = at % n;
        let ear = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        if is_ear(outline, &left, ear) {
            triangles.push(ear);
            left.remove(i);
            // Moving on by two spreads the ears around the polygon instead of fanning from one
            // point.
            at = i + 1;
            misses = 0;
        } else {
            at = i + 1;
            misses += 1;
        }
    }
    triangles
}

/// Whether the corner turns left and no other point lies in or on its triangle.
fn is_ear(outline: &[[f64; 2]], left: &[u32], ear: [u32; 3]) -> bool {
    let [a, b, c] = ear.map(|i| outline[i as usize]);
    turn(a, b, c) > 0.0
        && left.iter().filter(|i| !ear.contains(i)).all(|&i| {
            let p = outline[i as usize];
            let outside = (p[0] < a[0] && p[0] < b[0] && p[0] < c[0])
                || (p[0] > a[0] && p[0] > b[0] && p[0] > c[0])
                || (p[1] < a[1] && p[1] < b[1] && p[1] < c[1])
                || (p[1] > a[1] && p[1] > b[1] && p[1] > c[1]);
            outside || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
        })
}

/// The loop without equal neighbours, counter-clockwise, checked to be simple.
pub(super) fn checked_loop(points: &[[f64; 2]]) -> Result<Vec<[f64; 2]>, ShapeError> {
    check_coordinates(points)?;
    let mut outline = points.to_vec();
    outline.dedup();
    while outline.len() > 1 && outline.first() == outline.last() {
        outline.pop();
    }
    check_points(outline.len(), 3)?;
    let area = signed_area(&outline);
    if area == 0.0 {
        return Err(ShapeError::Flat);
    }
    if area < 0.0 {
        outline.reverse();
    }
    match first_crossing(&outline, true) {
        Some((first, second)) => Err(ShapeError::Crossing { first, second }),
        None => Ok(outline),
    }
}

pub(super) fn check_points(points: usize, low: usize) -> Result<(), ShapeError> {
    if (low..=MAX_POINTS).contains(&points) {
        Ok(())
    } else {
        Err(ShapeError::Points { points, low, high: MAX_POINTS })
    }
}

pub(super) fn check_coordinates(points: &[[f64; 2]]) -> Result<(), ShapeError> {
    let (low, high) = (-detail::SIZE_RANGE.1, detail::SIZE_RANGE.1);
    for &value in points.iter().flatten() {
        detail::check_range("outline coordinate", value, low, high)?;
    }
    Ok(())
}

/// Twice the area is Σ x_i y_{i+1} − x_{i+1} y_i, about the first point.
pub(super) fn signed_area(outline: &[[f64; 2]]) -> f64 {
    let [x, y] = outline[0];
    let cross = |p: [f64; 2], q: [f64; 2]| (p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y);
    let n = outline.len();
    0.5 * (0..n).map(|i| cross(outline[i], outline[(i + 1) % n])).sum::<f64>()
}

/// The first two edges that meet other than at a shared end.
pub(super) fn first_crossing(points: &[[f64; 2]], closed: bool) -> Option<(usize, usize)> {
    let n = points.len();
    let edges = if closed { n } else { n.saturating_sub(1) };
    let edge = |i: usize| (points[i], points[(i + 1) % n]);
    for i in 0..edges {
        for j in i + 1..edges {
            let ((a, b), (c, d)) = (edge(i), edge(j));
            let meet = if j == i + 1 {
                folds_back(a, b, d)
            } else if closed && i == 0 && j == edges - 1 {
                folds_back(c, d, b)
            } else {
                segments_meet(a, b, c, d)
            };
            if meet {
                return Some((i, j));
            }
        }
    }
    None
}

/// Whether b→c runs back over a→b.
fn folds_back(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    turn(a, b, c) == 0.0 && (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0.0
}

/// Whether two closed segments share a point.
pub(super) fn segments_meet(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> bool {
    for i in 0..2 {
        if a[i].max(b[i]) < c[i].min(d[i]) || c[i].max(d[i]) < a[i].min(b[i]) {
            return false;
        }
    }
    let apart = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    !apart(turn(a, b, c), turn(a, b, d)) && !apart(turn(c, d, a), turn(c, d, b))
}

/// Positive where a, b, c turn left; exact in sign.
pub(super) fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let at = |p: [f64; 2]| Coord { x: p[0], y: p[1] };
    orient2d(at(a), at(b), at(c))
}
