//! Where bodies are after a step.

use cullet_geometry::{Pose, Vec3};

/// Where one body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRow {
    /// The body.
    pub id: u64,
    /// Body frame to world; the origin of the body frame is the centre of mass.
    pub pose: Pose,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity \[rad/s\].
    pub spin: Vec3,
}
