//! Walls of revolution from their midline.

use super::detail::{Detail, ShapeError, check_size};
use super::lathe::{checked_profile, cut_loops, make, offset};
use super::outline::signed_area;
use crate::mesh::TriMesh;

/// A wall of `thickness` \[m\] turned about z, half of it on each side of the `profile` (radius,
/// height) \[m\]. The rim is square to the profile where that ends off the axis. A profile with
/// both ends on the axis gives a hollow body: an outer shell and an inner one that faces inward.
///
/// # Errors
/// As [`super::lathe_solid`], and [`ShapeError::Wall`] where the wall does not fit the profile.
pub fn lathe_midline(
    profile: &[[f64; 2]],
    thickness: f64,
    detail: Detail,
) -> Result<TriMesh, ShapeError> {
    check_size("wall thickness", thickness)?;
    let mut midline = checked_profile(profile, 2)?;
    if midline[midline.len() - 1][0] == 0.0 && midline[0][0] > 0.0 {
        midline.reverse();
    }
    let refuse = |e: ShapeError| match e {
        ShapeError::Crossing { .. } | ShapeError::Flat | ShapeError::Pinched { .. } => {
            ShapeError::Wall { thickness }
        }
        other => other,
    };
    let mut walls = [0.5, -0.5].map(|share| wall(&midline, share * thickness));
    if walls.iter().flatten().any(|p| p[0] < 0.0) {
        return Err(ShapeError::Wall { thickness });
    }
    let on_axis = [midline[0][0] == 0.0, midline[midline.len() - 1][0] == 0.0];
    if on_axis == [true, true] {
        if signed_area(&walls[0]).abs() < signed_area(&walls[1]).abs() {
            walls.swap(0, 1);
        }
        let [outer, inner] = walls.map(|wall| make(wall, true, detail).map_err(refuse));
        let mut hollow = outer?;
        hollow.append(&inner?.flipped());
        return Ok(hollow);
    }
    let [front, back] = &walls;
    let section = front.iter().chain(back.iter().rev()).copied().collect();
    make(section, on_axis[0], detail).map_err(refuse)
}

/// The profile moved to its left by `distance` \[m\], as if it went on beyond the axis.
fn wall(midline: &[[f64; 2]], distance: f64) -> Vec<[f64; 2]> {
    let n = midline.len();
    let beyond = |end: [f64; 2], next: [f64; 2]| (end[0] == 0.0).then_some([-next[0], next[1]]);
    let before = beyond(midline[0], midline[1]);
    let after = beyond(midline[n - 1], midline[n - 2]);
    let whole: Vec<[f64; 2]> =
        before.into_iter().chain(midline.iter().copied()).chain(after).collect();
    let moved = offset(&whole, distance);
    let first = usize::from(before.is_some());
    let mut wall = moved[first..first + n].to_vec();
    for (end, is_on_axis) in [(0, before.is_some()), (n - 1, after.is_some())] {
        if is_on_axis {
            wall[end][0] = 0.0;
        }
    }
    cut_loops(&mut wall);
    wall
}
