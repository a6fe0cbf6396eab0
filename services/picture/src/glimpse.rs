//! What of a run is in view of a camera at a time.

use super::camera::Camera;
use super::moments::Glimpse;
use super::track::Track;
use cullet_geometry::Vec3;

/// What moves more slowly rests, in widths of the picture \[1/s\].
const LEAST_SPEED: f64 = 0.02;
/// Points of a sheet that are looked at.
const LOOKED_AT: usize = 400;

/// What is in view at a time, of bodies that can move; grains and lines do not count.
pub(super) fn take_glimpse(
    track: &Track,
    (camera, size): (&Camera, (usize, usize)),
    time: f64,
) -> Glimpse {
    let mut glimpse = Glimpse { time, in_view: 0.0, moves: false };
    for (_, actor, pose) in track.present(time) {
        if actor.fixed || actor.is_grain() {
            continue;
        }
        let corners = actor.corners(pose);
        let share = measure_covered_share(&corners, camera, size);
        let away = camera.local(corners.iter().sum::<Vec3>() / corners.len() as f64).z;
        let speed = actor.velocity(time).norm() * camera.focal / away / size.0 as f64;
        glimpse.in_view += share;
        glimpse.moves |= share > 0.0 && speed > LEAST_SPEED;
    }
    for (.., at) in track.sheets_at(time) {
        let stride = at.places().len().div_ceil(LOOKED_AT).max(1);
        let points: Vec<Vec3> = at.places().iter().copied().step_by(stride).collect();
        let share = measure_covered_share(&points, camera, size);
        glimpse.in_view += share;
        glimpse.moves |= share > 0.0;
    }
    glimpse
}

/// The share of the picture that the box about some points takes \[1\].
fn measure_covered_share(points: &[Vec3], camera: &Camera, (width, height): (usize, usize)) -> f64 {
    let (width, height) = (width as f64, height as f64);
    let before = points.iter().map(|&point| camera.local(point)).filter(|local| local.z > 1e-9);
    let [mut left, mut right] = [f64::INFINITY, f64::NEG_INFINITY];
    let [mut top, mut bottom] = [f64::INFINITY, f64::NEG_INFINITY];
    for local in before {
        let seen = camera.project(local);
        (left, right) = (left.min(seen.x), right.max(seen.x));
        (top, bottom) = (top.min(seen.y), bottom.max(seen.y));
    }
    let wide = right.min(width) - left.max(0.0);
    let tall = bottom.min(height) - top.max(0.0);
    if wide > 0.0 && tall > 0.0 { wide * tall / (width * height) } else { 0.0 }
}
