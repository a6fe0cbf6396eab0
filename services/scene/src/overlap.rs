//! Whether bodies stand in one another at the start.
//!
//! Judged by the convex parts that collide, because those are what would push bodies apart.

use super::geometry::bounds;
use cullet_geometry::{Pose, Vec3};
use cullet_world::hulls_overlap;

/// Parts are shrunk by this share about their middle first, so that touching is not overlapping
/// \[1\].
const SHRINK: f64 = 2e-3;

/// A body's convex parts in the world, shrunk. Their corners are made only for parts whose boxes
/// meet: thousands of bodies of one rich shape cost no more than the shape.
pub(super) struct Placed<'a> {
    low: Vec3,
    high: Vec3,
    pose: &'a Pose,
    parts: Vec<Part<'a>>,
}

struct Part<'a> {
    low: Vec3,
    high: Vec3,
    hull: &'a [Vec3],
}

/// Puts a body's convex parts into the world.
pub(super) fn place<'a>(hulls: &'a [Vec<Vec3>], pose: &'a Pose) -> Placed<'a> {
    let full = hulls.iter().filter(|hull| !hull.is_empty());
    let parts: Vec<Part<'a>> = full
        .map(|hull| {
            let (low, high) = bounds(&corners(hull, pose));
            Part { low, high, hull }
        })
        .collect();
    let boxes: Vec<Vec3> = parts.iter().flat_map(|part| [part.low, part.high]).collect();
    let (low, high) = bounds(&boxes);
    Placed { low, high, pose, parts }
}

fn corners(hull: &[Vec3], pose: &Pose) -> Vec<Vec3> {
    let middle: Vec3 = hull.iter().sum::<Vec3>() / hull.len() as f64;
    let placed = |v: &Vec3| {
        let shrunk = middle + (v - middle) * (1.0 - SHRINK);
        pose.rotation * shrunk + pose.translation.vector
    };
    hull.iter().map(placed).collect()
}

/// The first pairs of overlapping bodies, at most `most`; `skip` lets pairs stand in one another.
/// Once it is `stopped` no more are looked for.
pub(super) fn overlaps(
    placed: &[Placed<'_>],
    most: usize,
    stopped: impl Fn() -> bool,
    skip: impl Fn(usize, usize) -> bool,
) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..placed.len()).collect();
    order.sort_by(|&a, &b| placed[a].low.x.total_cmp(&placed[b].low.x).then(a.cmp(&b)));
    let mut found = Vec::new();
    for (rank, &a) in order.iter().enumerate().take_while(|_| !stopped()) {
        for &b in &order[rank + 1..] {
            if placed[b].low.x >= placed[a].high.x {
                break;
            }
            let (first, second) = (a.min(b), a.max(b));
            if !skip(first, second) && overlap(&placed[a], &placed[b]) {
                found.push((first, second));
                if found.len() >= most {
                    found.sort_unstable();
                    return found;
                }
            }
        }
    }
    found.sort_unstable();
    found
}

fn boxes_meet(a: (&Vec3, &Vec3), b: (&Vec3, &Vec3)) -> bool {
    (0..3).all(|i| a.0[i] < b.1[i] && b.0[i] < a.1[i])
}

fn overlap(a: &Placed<'_>, b: &Placed<'_>) -> bool {
    boxes_meet((&a.low, &a.high), (&b.low, &b.high))
        && a.parts.iter().any(|one| {
            b.parts.iter().any(|two| {
                boxes_meet((&one.low, &one.high), (&two.low, &two.high))
                    && hulls_overlap(&corners(one.hull, a.pose), &corners(two.hull, b.pose))
            })
        })
}

#[cfg(test)]
mod tests {
    use super::{overlaps, place};
    use cullet_geometry::{Pose, Quat, Vec3};

    fn cube(edge: f64) -> Vec<Vec<Vec3>> {
        let half = edge / 2.0;
        let corner = |i: usize| {
            let sign = |bit: usize| if i & bit == 0 { -half } else { half };
            Vec3::new(sign(1), sign(2), sign(4))
        };
        vec![(0..8).map(corner).collect()]
    }

    fn at(x: f64, y: f64, z: f64, turn: f64) -> Pose {
        let rotation = Quat::from_axis_angle(&Vec3::z_axis(), turn);
        Pose::from_parts(nalgebra::Translation3::new(x, y, z), rotation)
    }

    fn meet(first: Pose, second: Pose) -> bool {
        let shape = cube(1.0);
        let bodies = [place(&shape, &first), place(&shape, &second)];
        !overlaps(&bodies, 10, || false, |_, _| false).is_empty()
    }

    #[test]
    fn cubes_meet_when_they_do() {
        let eighth = std::f64::consts::FRAC_PI_4;
        let still = at(0.0, 0.0, 0.0, 0.0);
        assert!(meet(still, at(0.9, 0.9, 0.9, 0.0)));
        assert!(!meet(still, at(1.0, 0.0, 0.0, 0.0)), "touching is not overlapping");
        assert!(!meet(still, at(1.001, 0.3, 0.2, 0.0)));
        // Turned by 45° a corner reaches (1 + √2)/2 = 1.207 along x.
        assert!(meet(still, at(1.19, 0.0, 0.0, eighth)));
        assert!(!meet(still, at(1.21, 0.0, 0.0, eighth)));
        // The boxes around them meet here, they themselves do not: 1/√2 + 1/2 = 1.207 along the
        // diagonal.
        assert!(!meet(still, at(0.9, 0.9, 0.0, eighth)));
        assert!(meet(still, at(0.84, 0.84, 0.0, eighth)));
    }

    /// However deep, also where faces, edges or middles lie in one another's.
    #[test]
    fn a_body_that_sinks_into_a_floor_is_found_at_any_depth() {
        let (floor, small) = (cube(4.0), cube(0.1));
        for turn in [0.0, 0.3] {
            for step in 1..=210 {
                let depth = 0.01 * f64::from(step);
                let poses = [at(0.0, 0.0, -2.0, 0.0), at(0.0, 0.0, 0.05 - depth, turn)];
                let bodies = [place(&floor, &poses[0]), place(&small, &poses[1])];
                assert_eq!(overlaps(&bodies, 10, || false, |_, _| false), [(0, 1)], "{depth} deep");
            }
        }
    }

    #[test]
    fn a_small_body_inside_a_large_one_is_found() {
        let (large, small) = (cube(4.0), cube(0.1));
        let poses = [at(0.0, 0.0, 0.0, 0.3), at(1.0, 0.5, -0.7, 0.0)];
        let bodies = [place(&large, &poses[0]), place(&small, &poses[1])];
        assert_eq!(overlaps(&bodies, 10, || false, |_, _| false), [(0, 1)]);
        assert!(overlaps(&bodies, 10, || false, |_, _| true).is_empty());
        assert!(overlaps(&bodies, 10, || true, |_, _| false).is_empty());
    }
}
