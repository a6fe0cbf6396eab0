//! Convex polygons, cut by planes.

use cullet_geometry::Vec3;
use cullet_geometry::inside::{Inside, Nearest};

/// A half-space: all x with normal·x ≤ offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfPlane {
    pub(super) normal: Vec3,
    pub(super) offset: f64,
}

/// Planes that a polygon is cut by at most to lie in a body.
const PLANES: usize = 16;
/// How far out of it, in spacings, what is left may lie.
const SLACK: f64 = 0.02;
/// A direction that is so near to that of the nearest triangle counts as its normal.
const ALIKE: f64 = 0.5;

/// What of a convex polygon lies in a half-space.
pub(super) fn clipped(polygon: &[Vec3], half: &HalfPlane) -> Vec<Vec3> {
    let height = |x: &Vec3| half.normal.dot(x) - half.offset;
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, to) in polygon.iter().enumerate() {
        let from = &polygon[(k + polygon.len() - 1) % polygon.len()];
        let (a, b) = (height(from), height(to));
        if (a <= 0.0) != (b <= 0.0) {
            left.push(from + (to - from) * (a / (a - b)));
        }
        if b <= 0.0 {
            left.push(*to);
        }
    }
    if left.len() < 3 { Vec::new() } else { left }
}

/// A square about a place \[m\], with this normal and half a side of `size` \[m\].
pub(super) fn square(centre: Vec3, normal: Vec3, size: f64) -> Vec<Vec3> {
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let mut axis = Vec3::zeros();
    axis[least] = 1.0;
    let one = normal.cross(&axis).normalize() * size;
    let two = normal.cross(&one);
    vec![centre + one + two, centre - one + two, centre - one - two, centre + one - two]
}

/// Twice its area \[m²\] along its normal.
pub(super) fn area(polygon: &[Vec3]) -> Vec3 {
    let Some((first, rest)) = polygon.split_first() else { return Vec3::zeros() };
    rest.windows(2).map(|two| (two[0] - first).cross(&(two[1] - first))).sum()
}

/// A body that polygons are cut to.
pub(super) struct ClippingBody {
    pub(super) inside: Inside,
    pub(super) nearest: Nearest,
    /// Unit normals of its triangles.
    pub(super) normals: Vec<Vec3>,
    pub(super) spacing: f64,
}

impl ClippingBody {
    /// What of a polygon lies in the body: exact where its surface is flat or convex there.
    pub(super) fn clip(&self, mut polygon: Vec<Vec3>) -> Vec<Vec3> {
        for _ in 0..PLANES {
            let mut farthest: Option<(f64, HalfPlane)> = None;
            for x in &polygon {
                if self.inside.contains(*x) {
                    continue;
                }
                let Some((foot, far, triangle)) = self.nearest.closest(*x) else { continue };
                if far <= SLACK * self.spacing || farthest.as_ref().is_some_and(|it| it.0 >= far) {
                    continue;
                }
                let (way, flat) = ((x - foot) / far, self.normals[triangle]);
                let normal = if way.dot(&flat) > ALIKE { flat } else { way };
                farthest = Some((far, HalfPlane { normal, offset: normal.dot(&foot) }));
            }
            let Some((_, half)) = farthest else { break };
            polygon = clipped(&polygon, &half);
            if polygon.is_empty() {
                break;
            }
        }
        polygon
    }
}

#[cfg(test)]
mod tests {
    use super::{HalfPlane, area, clipped, square};
    use cullet_geometry::Vec3;

    #[test]
    fn a_square_is_cut_to_what_lies_below_a_plane() {
        let whole = square(Vec3::z(), Vec3::z(), 2.0);
        assert!((area(&whole) - 32.0 * Vec3::z()).norm() < 1e-12);
        let normal = Vec3::new(1.0, 1.0, 0.0).normalize();
        let half = clipped(&whole, &HalfPlane { normal, offset: 0.0 });
        assert!((area(&half) - 16.0 * Vec3::z()).norm() < 1e-12);
        assert!(clipped(&whole, &HalfPlane { normal, offset: -9.0 }).is_empty());
        assert_eq!(clipped(&whole, &HalfPlane { normal, offset: 9.0 }), whole);
    }
}
