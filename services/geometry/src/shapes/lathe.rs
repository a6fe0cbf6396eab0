//! Bodies of revolution about z.

use super::detail::{
    self, Detail, ShapeError, check_count, check_edge, check_segments, check_size,
};
use super::outline::{
    check_coordinates, check_points, checked_loop, segments_meet, signed_area, turn,
};
use super::refine::finished;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use std::f64::consts::TAU;

/// How far a corner of the inner wall may run ahead of the wall's thickness; sharper corners are
/// cut.
const MITRE_LIMIT: f64 = 3.0;

/// A solid of revolution: a polyline of (radius, height) \[m\] turned about z, closed to the axis
/// by flat discs where its ends are not on it. A goblet is such a polyline too: foot, stem, bowl,
/// rim, and back down the inside of the bowl to the axis.
///
/// # Errors
/// A value out of range, a profile that crosses itself, touches the axis between its ends or
/// encloses nothing, or too many triangles.
pub fn lathe_solid(profile: &[[f64; 2]], detail: Detail) -> Result<TriMesh, ShapeError> {
    let points = checked_profile(profile, 2)?;
    make(closed_to_axis(points), true, detail)
}

/// A vessel: a wall of `thickness` \[m\] inside the profile (radius, height) \[m\], open where the
/// profile ends away from the axis. A profile from the axis out and up makes a pot; one that stays
/// off the axis at both ends makes a pipe. Where the wall leaves no room inside (a stem), the body
/// is solid.
///
/// # Errors
/// As [`lathe_solid`], and [`ShapeError::Wall`] where the wall does not fit.
pub fn lathe_shell(
    profile: &[[f64; 2]],
    thickness: f64,
    detail: Detail,
) -> Result<TriMesh, ShapeError> {
    check_size("wall thickness", thickness)?;
    let mut outer = checked_profile(profile, 2)?;
    if outer[0][0] > 0.0 && outer[outer.len() - 1][0] == 0.0 {
        outer.reverse();
    }
    if outer[outer.len() - 1][0] == 0.0 {
        // Both ends on the axis: there is no mouth, and a cavity is not a vessel.
        return Err(ShapeError::Wall { thickness });
    }
    let side = signed_area(&closed_to_axis(outer.clone())).signum();
    let mut inner = offset(&outer, side * thickness);
    inner.reverse();
    cut_loops(&mut inner);
    let from_axis = outer[0][0] == 0.0;
    if from_axis {
        end_on_axis(&mut inner, &outer, thickness)?;
    } else if inner.iter().any(|p| p[0] <= 0.0) {
        return Err(ShapeError::Wall { thickness });
    }
    let points: Vec<[f64; 2]> = outer.iter().chain(&inner).copied().collect();
    make(points, from_axis, detail).map_err(|e| match e {
        ShapeError::Crossing { .. } | ShapeError::Flat => ShapeError::Wall { thickness },
        other => other,
    })
}

/// Checks the section and turns it.
pub(super) fn make(
    points: Vec<[f64; 2]>,
    on_axis: bool,
    detail: Detail,
) -> Result<TriMesh, ShapeError> {
    check_segments(detail)?;
    let mut section = checked_loop(&points)?;
    if on_axis {
        // Turn the loop so that the edge along the axis closes it.
        let n = section.len();
        let axis_edge = |i: &usize| section[*i][0] == 0.0 && section[(i + 1) % n][0] == 0.0;
        let first = (0..n).find(axis_edge).ok_or(ShapeError::Flat)?;
        section.rotate_left((first + 1) % n);
    }
    let inner = if on_axis { 1..section.len() - 1 } else { 0..section.len() };
    if let Some(point) = inner.clone().find(|&i| section[i][0] <= 0.0) {
        return Err(ShapeError::Pinched { point });
    }
    check_section(&section, detail)?;
    finished(revolve(&section, on_axis, detail), detail)
}

/// Refuses a section whose rings would be too many.
pub(super) fn check_section(section: &[[f64; 2]], detail: Detail) -> Result<(), ShapeError> {
    let edge = check_edge(detail)?;
    let n = section.len();
    let parts = (0..n).map(|i| {
        let ([r, z], [r1, z1]) = (section[i], section[(i + 1) % n]);
        (((r1 - r) * (r1 - r) + (z1 - z) * (z1 - z)).sqrt() / edge).ceil().max(1.0)
    });
    check_count((2.0 * parts.sum::<f64>() * f64::from(detail.segments)) as usize)
}

/// A point of a section and how many vertices its circle has.
type Circle = ([f64; 2], u32);

/// Turns a counter-clockwise section (radius to the right, height up) about z. With `on_axis`, the
/// first and last points lie on the axis and the edge between them is not part of the surface.
pub(super) fn revolve(section: &[[f64; 2]], on_axis: bool, detail: Detail) -> TriMesh {
    let circles = divided(section, on_axis, detail);
    let mut mesh = TriMesh::default();
    let mut rings: Vec<(u32, u32)> = Vec::with_capacity(circles.len());
    for &([r, z], count) in &circles {
        rings.push((mesh.vertices.len() as u32, count));
        for j in 0..count {
            let (sin, cos) = libm::sincos(TAU * f64::from(j) / f64::from(count));
            mesh.vertices.push(Vec3::new(r * cos, r * sin, z));
        }
    }
    let n = rings.len();
    for i in 0..if on_axis { n - 1 } else { n } {
        stitch(rings[i], rings[(i + 1) % n], &mut mesh.triangles);
    }
    mesh
}

/// Closes the strip between two rings (first vertex, count), going around both at one pace.
fn stitch((low, m): (u32, u32), (high, n): (u32, u32), out: &mut Vec<[u32; 3]>) {
    let (mut i, mut j) = (0, 0);
    // A ring of one is a pole: it never advances.
    let (low_steps, high_steps) = (if m == 1 { 0 } else { m }, if n == 1 { 0 } else { n });
    while i < low_steps || j < high_steps {
        let (a, b) = (low + i % m, high + j % n);
        let low_is_next = u64::from(i + 1) * u64::from(n) <= u64::from(j + 1) * u64::from(m);
        if j == high_steps || (i < low_steps && low_is_next) {
            out.push([a, low + (i + 1) % m, b]);
            i += 1;
        } else {
            out.push([a, high + (j + 1) % n, b]);
            j += 1;
        }
    }
}

/// Divides the edges of a section that are longer than `detail.edge`. Circles inside a flat disc
/// have only as many vertices as their length needs; all others have `detail.segments`, which keeps
/// the body's section the same polygon at every height.
fn divided(section: &[[f64; 2]], on_axis: bool, detail: Detail) -> Vec<Circle> {
    let n = section.len();
    let limit = detail.edge.unwrap_or(f64::INFINITY);
    let mut circles = Vec::with_capacity(n);
    for (i, &[r, z]) in section.iter().enumerate() {
        circles.push(([r, z], if r == 0.0 { 1 } else { detail.segments }));
        if on_axis && i + 1 == n {
            break;
        }
        let [r1, z1] = section[(i + 1) % n];
        let length = ((r1 - r) * (r1 - r) + (z1 - z) * (z1 - z)).sqrt();
        let parts = (length / limit).ceil().max(1.0) as u32;
        for k in 1..parts {
            let s = f64::from(k) / f64::from(parts);
            let radius = r + s * (r1 - r);
            let count = if z1 == z {
                ((TAU * radius / limit).ceil() as u32).clamp(6, detail.segments.max(6))
            } else {
                detail.segments
            };
            circles.push(([radius, z + s * (z1 - z)], count.min(detail.segments)));
        }
    }
    circles
}

/// The polyline without equal neighbours; radii not negative.
pub(super) fn checked_profile(
    profile: &[[f64; 2]],
    least: usize,
) -> Result<Vec<[f64; 2]>, ShapeError> {
    check_coordinates(profile)?;
    for p in profile {
        detail::check_range("profile radius", p[0], 0.0, detail::SIZE_RANGE.1)?;
    }
    let mut points = profile.to_vec();
    points.dedup();
    check_points(points.len(), least)?;
    let n = points.len();
    match points[1..n - 1].iter().position(|p| p[0] == 0.0) {
        Some(before) => Err(ShapeError::Pinched { point: before + 1 }),
        None => Ok(points),
    }
}

fn closed_to_axis(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let (first, last) = (points[0], points[points.len() - 1]);
    if first[0] > 0.0 {
        points.insert(0, [0.0, first[1]]);
    }
    if last[0] > 0.0 {
        points.push([0.0, last[1]]);
    }
    points
}

/// The polyline moved to its left by `distance` \[m\], corners mitred.
pub(super) fn offset(points: &[[f64; 2]], distance: f64) -> Vec<[f64; 2]> {
    let normal = |i: usize| {
        let (a, b) = (points[i], points[i + 1]);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        let length = (x * x + y * y).sqrt();
        [-y / length, x / length]
    };
    let last = points.len() - 1;
    let mut moved = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        let (m, n) = (normal(i.max(1) - 1), normal(i.min(last - 1)));
        // The mitre runs along m + n, with length 1/cos(half the turn).
        let cosine = m[0] * n[0] + m[1] * n[1];
        let along = distance / (1.0 + cosine).max(2.0 / (MITRE_LIMIT * MITRE_LIMIT));
        moved.push([p[0] + along * (m[0] + n[0]), p[1] + along * (m[1] + n[1])]);
    }
    moved
}

/// Takes the loops out of a polyline that crosses itself, as an inward offset does in tight
/// corners.
pub(super) fn cut_loops(points: &mut Vec<[f64; 2]>) {
    let mut i = 0;
    while i + 3 < points.len() {
        let (a, b) = (points[i], points[i + 1]);
        let crossing = (i + 2..points.len() - 1)
            .rev()
            .find(|&j| segments_meet(a, b, points[j], points[j + 1]));
        if let Some(j) = crossing {
            let at = meeting_point(a, b, points[j], points[j + 1]);
            points.splice(i + 1..=j, [at]);
        }
        i += 1;
    }
}

fn meeting_point(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> [f64; 2] {
    let (p, q) = (turn(c, d, a), turn(c, d, b));
    let s = if p == q { 0.5 } else { (p / (p - q)).clamp(0.0, 1.0) };
    [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
}

/// Ends the inner wall, which runs from the rim down, where it first reaches the axis. If it does
/// not quite (the floor's offset ends off the axis where the floor is not level), it is led there.
fn end_on_axis(
    inner: &mut Vec<[f64; 2]>,
    outer: &[[f64; 2]],
    thickness: f64,
) -> Result<(), ShapeError> {
    if inner[0][0] <= 0.0 {
        return Err(ShapeError::Wall { thickness });
    }
    if let Some(i) = inner.iter().position(|p| p[0] <= 0.0) {
        let (above, below) = (inner[i - 1], inner[i]);
        let s = above[0] / (above[0] - below[0]);
        inner.truncate(i);
        inner.push([0.0, above[1] + s * (below[1] - above[1])]);
        return Ok(());
    }
    // Extend the last line to the axis; a vertical one ends at the floor's thickness instead.
    let n = inner.len();
    let (a, b) = (inner[n - 2], inner[n - 1]);
    let slope = (b[1] - a[1]) / (b[0] - a[0]);
    let z = b[1] - slope * b[0];
    let lands = slope.is_finite() && b[0] < a[0] && (z - outer[0][1]).abs() <= 4.0 * thickness;
    inner.push([0.0, if lands { z } else { b[1] }]);
    Ok(())
}
