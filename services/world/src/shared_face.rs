//! The face that two bodies share: where triangles of both lie against each other.

use crate::jointed::CarryingFace;
use cullet_geometry::mesh::bounds;
use cullet_geometry::{Mat3, Pose, TriMesh, Vec3};

/// A shared face, in the frame of the first body.
pub(crate) struct SharedFace {
    /// \[m\]
    pub(crate) middle: Vec3,
    pub(crate) face: CarryingFace,
}

/// Two faces lie against each other if the cosine between one and the back of the other is at
/// least this: 5°.
const FACING: f64 = 0.996;

/// What has been found, with moments about the frame's origin.
struct FaceSum {
    area: f64,
    normal: Vec3,
    first: Vec3,
    second: Mat3,
    corners: Vec<Vec3>,
}

/// The face that two bodies share, if they do: over all pairs of triangles that are nowhere in
/// their overlap farther apart than `gap` \[m\]. `place` leads from the frame of the second to that
/// of the first.
pub(crate) fn shared_face(
    one: &TriMesh,
    two: &TriMesh,
    place: &Pose,
    gap: f64,
) -> Option<SharedFace> {
    let ours: Vec<[Vec3; 3]> = (0..one.triangles.len()).map(|t| one.corners(t)).collect();
    let moved = |p: Vec3| (place * nalgebra::Point3::from(p)).coords;
    let theirs: Vec<[Vec3; 3]> =
        (0..two.triangles.len()).map(|t| two.corners(t).map(moved)).collect();
    let (ours, theirs) = (near(&ours, &theirs, gap), near(&theirs, &ours, gap));
    let zero = Vec3::zeros();
    let mut found = FaceSum {
        area: 0.0,
        normal: zero,
        first: zero,
        second: Mat3::zeros(),
        corners: Vec::new(),
    };
    for own in &ours {
        let twice = (own[1] - own[0]).cross(&(own[2] - own[0]));
        let Some(n) = twice.try_normalize(0.0) else { continue };
        for other in &theirs {
            let back = (other[1] - other[0]).cross(&(other[2] - other[0]));
            if -back.dot(&n) < FACING * back.norm() || !apart_at_most(own, other, gap) {
                continue;
            }
            found.add(&clipped(own, other, &n, gap), &n);
        }
    }
    found.face()
}

/// Those triangles that come near the box around the others.
fn near(own: &[[Vec3; 3]], others: &[[Vec3; 3]], gap: f64) -> Vec<[Vec3; 3]> {
    let corners: Vec<Vec3> = others.iter().flatten().copied().collect();
    let Some((low, high)) = bounds(&corners) else { return Vec::new() };
    let reaches = |triangle: &&[Vec3; 3]| {
        bounds(&triangle[..]).is_some_and(|(from, to)| {
            (0..3).all(|i| from[i] <= high[i] + gap && to[i] >= low[i] - gap)
        })
    };
    own.iter().filter(reaches).copied().collect()
}

fn apart_at_most(one: &[Vec3; 3], two: &[Vec3; 3], gap: f64) -> bool {
    match (bounds(&one[..]), bounds(&two[..])) {
        (Some((a, b)), Some((c, d))) => (0..3).all(|i| a[i] <= d[i] + gap && c[i] <= b[i] + gap),
        _ => false,
    }
}

/// The part of `other` that lies over `own`, brought onto the middle between the two planes; empty
/// where they are farther apart than `gap`.
fn clipped(own: &[Vec3; 3], other: &[Vec3; 3], n: &Vec3, gap: f64) -> Vec<Vec3> {
    let mut polygon = other.to_vec();
    for k in 0..3 {
        let (from, to) = (own[k], own[(k + 1) % 3]);
        let inward = n.cross(&(to - from));
        polygon = cut(&polygon, &|p| inward.dot(&(p - from)));
    }
    let height = |p: &Vec3| n.dot(&(p - own[0]));
    if polygon.len() < 3 || polygon.iter().any(|p| height(p).abs() > gap) {
        return Vec::new();
    }
    polygon.iter().map(|p| p - n * (height(p) / 2.0)).collect()
}

/// The part of a convex polygon where `inside` is not negative.
fn cut(polygon: &[Vec3], inside: &dyn Fn(&Vec3) -> f64) -> Vec<Vec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let q = &polygon[(k + 1) % polygon.len()];
        let (a, b) = (inside(p), inside(q));
        if a >= 0.0 {
            kept.push(*p);
        }
        if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
            kept.push(p + (q - p) * (a / (a - b)));
        }
    }
    kept
}

impl FaceSum {
    fn add(&mut self, polygon: &[Vec3], n: &Vec3) {
        let Some((first, rest)) = polygon.split_first() else { return };
        for pair in rest.windows(2) {
            let (b, c) = (pair[0], pair[1]);
            let area = 0.5 * (b - first).cross(&(c - first)).norm();
            let sum = first + b + c;
            self.area += area;
            self.normal += n * area;
            self.first += sum * (area / 3.0);
            // ∫ r rᵀ dA of a triangle [Eberly 2002].
            let corners = [*first, b, c];
            let squares: Mat3 = corners.iter().map(|p| p * p.transpose()).sum();
            self.second += (squares + sum * sum.transpose()) * (area / 12.0);
        }
        self.corners.extend(polygon);
    }

    fn face(self) -> Option<SharedFace> {
        let normal = self.normal.try_normalize(0.0)?;
        let middle = self.first / self.area;
        let tensor = self.second - middle * middle.transpose() * self.area;
        let corners = self.corners.iter().map(|p| p - middle).collect();
        let face = CarryingFace { normal: Some(normal), area: self.area, tensor, corners };
        Some(SharedFace { middle, face })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_geometry::shapes::{Detail, cuboid};

    fn slab(size: Vec3) -> TriMesh {
        cuboid(size, Detail::default()).unwrap()
    }

    #[test]
    fn bricks_share_the_overlap_of_their_faces() {
        let brick = slab(Vec3::new(0.4, 0.2, 0.1));
        let place = Pose::translation(0.3, 0.05, 0.1004);
        let found = shared_face(&brick, &brick, &place, 1e-3).unwrap();
        let (wide, deep) = (0.1, 0.15);
        assert!((found.face.area - wide * deep).abs() < 1e-12, "{}", found.face.area);
        assert!((found.middle - Vec3::new(0.15, 0.025, 0.0502)).norm() < 1e-12, "{}", found.middle);
        assert!((found.face.normal.unwrap() - Vec3::z()).norm() < 1e-12);
        let want = [deep * wide.powi(3) / 12.0, wide * deep.powi(3) / 12.0, 0.0];
        for (k, want) in want.into_iter().enumerate() {
            assert!((found.face.tensor[(k, k)] - want).abs() < 1e-12);
        }
        let far = found.face.corners.iter().map(Vec3::norm).fold(0.0, f64::max);
        assert!((far - (wide * wide + deep * deep).sqrt() / 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_wider_gap_an_edge_or_a_turn_shares_nothing() {
        let brick = slab(Vec3::new(0.4, 0.2, 0.1));
        let shares = |place: Pose| shared_face(&brick, &brick, &place, 1e-3);
        assert!(shares(Pose::translation(0.0, 0.0, 0.1011)).is_none());
        let edge = shares(Pose::translation(0.4, 0.0, 0.1)).map_or(0.0, |face| face.face.area);
        assert!(edge < 1e-12);
        let turned = Pose::new(Vec3::new(0.0, 0.0, 0.1), Vec3::new(0.0, 0.2, 0.0));
        assert!(shares(turned).is_none());
        // Upright beside it: another pair of sides.
        let upright = Pose::new(Vec3::new(0.25, 0.0, 0.0), Vec3::y() * std::f64::consts::FRAC_PI_2);
        let side = shares(upright).unwrap();
        assert!((side.face.area - 0.02).abs() < 1e-9, "{}", side.face.area);
        assert!((side.face.normal.unwrap() - Vec3::x()).norm() < 1e-12);
    }
}
