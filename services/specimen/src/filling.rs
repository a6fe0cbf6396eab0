//! Points that fill a body, for families whose points lie in it.

use crate::settings::{PointLayout, SpecimenSettings};
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;
use cullet_geometry::sample::{self, SampleError};
use cullet_model::Refusal;

/// Points of a body that are `apart` \[m\]: scattered, or in rows of which one lies `offset` from
/// zero along each axis, in their distance \[1\].
///
/// # Errors
/// The box around the body holds too many.
pub fn points(
    inside: &Inside,
    apart: f64,
    offset: Vec3,
    settings: &SpecimenSettings,
) -> Result<Vec<Vec3>, Refusal> {
    match settings.points.layout {
        PointLayout::Scattered => scattered(inside, apart, settings.seed),
        PointLayout::Rows => rows(inside.bounds(), apart, offset, |x| inside.contains(x)),
    }
}

fn scattered(inside: &Inside, apart: f64, seed: u64) -> Result<Vec<Vec3>, Refusal> {
    sample::poisson(inside, apart, seed).map_err(|error| {
        let value = match error {
            SampleError::TooMany { candidates, .. } => candidates,
            SampleError::Spacing { spacing } => spacing,
        };
        let limit = sample::MAX_CANDIDATES;
        Refusal::TooLarge { what: "the number of points in the body's box", value, limit }
    })
}

/// The places of rows in a box that are `inside`.
///
/// # Errors
/// The box holds too many.
pub fn rows(
    (low, high): (Vec3, Vec3),
    apart: f64,
    offset: Vec3,
    inside: impl Fn(Vec3) -> bool,
) -> Result<Vec<Vec3>, Refusal> {
    let first = low.map(|x| (x / apart).floor() as i64);
    let count = (high - low).map(|x| (x / apart).ceil() as i64 + 1);
    let all = count.map(|n| n as f64).product();
    if all > sample::MAX_CANDIDATES {
        let (what, limit) = ("the number of points in the body's box", sample::MAX_CANDIDATES);
        return Err(Refusal::TooLarge { what, value: all, limit });
    }
    let mut points = Vec::new();
    for (i, j) in (0..count.x).flat_map(|i| (0..count.y).map(move |j| (i, j))) {
        for k in 0..count.z {
            let place = Vec3::new((first.x + i) as f64, (first.y + j) as f64, (first.z + k) as f64);
            let x = (place + offset) * apart;
            if inside(x) {
                points.push(x);
            }
        }
    }
    Ok(points)
}
