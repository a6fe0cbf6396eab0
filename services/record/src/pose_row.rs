//! Where bodies are after a step.

use cullet_geometry::{Pose, Quat, Vec3};
use cullet_proto::recording::BodyPoses;

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

impl PoseRow {
    /// The rows of a recorded step, bit for bit as they were written.
    pub fn of(poses: &BodyPoses) -> impl Iterator<Item = Self> {
        let turns = poses.rotations.as_chunks::<4>().0;
        let [at, velocity, spin] = [&poses.positions, &poses.velocities, &poses.spins]
            .map(|column| column.as_chunks::<3>().0.iter().map(|&row| Vec3::from(row)));
        let rows = poses.ids.iter().zip(at.zip(turns)).zip(velocity.zip(spin));
        rows.map(|((&id, (at, &turn)), (velocity, spin))| {
            let pose = Pose::from_parts(at.into(), Quat::new_unchecked(turn.into()));
            Self { id, pose, velocity, spin }
        })
    }
}
