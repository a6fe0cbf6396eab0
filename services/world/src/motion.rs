//! How a body moves.

use cullet_geometry::{Pose, Vec3};

/// Where a body is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) pose: Pose,
    pub(crate) velocity: Vec3,
    pub(crate) spin: Vec3,
}

impl Motion {
    pub(crate) fn centre(&self) -> Vec3 {
        self.pose.translation.vector
    }

    /// A vector of the body's frame in the world's.
    pub(crate) fn to_world(self, v: &Vec3) -> Vec3 {
        self.pose.rotation * v
    }

    pub(crate) fn velocity_at(&self, point: &Vec3) -> Vec3 {
        self.velocity + self.spin.cross(&(point - self.centre()))
    }

    pub(crate) fn finite(&self) -> bool {
        let q = self.pose.rotation.coords;
        q.iter().chain(self.centre().iter()).all(|x| x.is_finite())
            && self.velocity.iter().chain(self.spin.iter()).all(|x| x.is_finite())
    }
}

/// The speed that counts for whether a body followed its velocity over a step \[m/s\]: the least of
/// those before the step, after it, and of the mean of both. A body that bounces, or is stopped or
/// hit within the step, does not count for it.
pub(crate) fn least_speed(before: &Motion, after: &Motion) -> f64 {
    let mean = (before.velocity + after.velocity) / 2.0;
    mean.norm().min(before.velocity.norm()).min(after.velocity.norm())
}
