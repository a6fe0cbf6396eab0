//! Poses as slabs: place and turn, 7 × f64.

use crate::codec::{self, WireError};
use crate::mesh::Slabs;
use cullet_geometry::{Pose, Quat, Vec3};

/// Bytes of a pose.
const POSE: usize = 56;

/// Appends poses.
pub(super) fn put(out: &mut Vec<u8>, poses: &[Pose]) {
    let numbers = |pose: &Pose| {
        let (place, turn) = (pose.translation.vector, pose.rotation.coords);
        [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w]
    };
    poses.iter().flat_map(numbers).for_each(|x| out.extend(x.to_le_bytes()));
}

/// The next `count` poses.
pub(super) fn take(
    slabs: &mut Slabs<'_>,
    what: &'static str,
    count: usize,
) -> Result<Vec<Pose>, WireError> {
    slabs.take(what, count, POSE)?.as_chunks::<POSE>().0.iter().map(pose).collect()
}

fn pose(row: &[u8; POSE]) -> Result<Pose, WireError> {
    let number = |k: usize| f64::from_le_bytes(row.as_chunks::<8>().0[k]);
    let place = Vec3::new(number(0), number(1), number(2));
    let mut turn = Quat::identity();
    (0..4).for_each(|k| turn.as_mut_unchecked().coords[k] = number(3 + k));
    let pose = Pose::from_parts(place.into(), turn);
    check(&pose).map(|()| pose)
}

/// Holds a pose to finite numbers and a turn of length 1.
pub(super) fn check(pose: &Pose) -> Result<(), WireError> {
    codec::finite("a pose", pose.translation.vector.as_slice())?;
    codec::finite("a pose", pose.rotation.coords.as_slice())?;
    let off = (pose.rotation.coords.norm() - 1.0).abs();
    if off > 1e-6 {
        return Err(WireError::Header(format!("a turn is off length 1 by {off:.1e}")));
    }
    Ok(())
}
