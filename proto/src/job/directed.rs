//! How a body is to come apart: it travels around the job that breaks it, whose bytes it leaves as
//! they are.

use crate::bounds::{MAX_GUIDES, MAX_PIECES, MAX_WHOLE};
use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use cullet_model::{ArtDirection, BodyRegion};
use std::ops::Range;

fn check(direction: &ArtDirection) -> Result<(), WireError> {
    let ArtDirection { pieces, guides, whole } = direction;
    let pieces = u64::from(pieces.unwrap_or_default());
    codec::limit("the pieces asked for", pieces, u64::from(MAX_PIECES))?;
    codec::limit("a job's guide points", guides.len() as u64, MAX_GUIDES as u64)?;
    codec::limit("a job's whole regions", whole.len() as u64, MAX_WHOLE as u64)?;
    guides.iter().try_for_each(|guide| codec::finite("a job's guide points", guide.as_slice()))?;
    whole.iter().try_for_each(|region| {
        let (a, b) = match region {
            BodyRegion::Ball { centre, radius } => (centre.as_slice(), &[*radius][..]),
            BodyRegion::Box { low, high } => (low.as_slice(), high.as_slice()),
        };
        codec::finite("a job's whole regions", a)?;
        codec::finite("a job's whole regions", b)
    })
}

/// The bytes of a directed job, and where the slabs are in them, from those of the job itself.
pub(super) fn wrap(
    direction: &ArtDirection,
    inner: &[u8],
    slabs: [Range<usize>; 2],
) -> Result<(Vec<u8>, [Range<usize>; 2]), WireError> {
    check(direction)?;
    let bytes = envelope::seal(MessageKind::DirectedJob, direction, inner)?;
    let shift = bytes.len() - inner.len();
    Ok((bytes, slabs.map(|slab| slab.start + shift..slab.end + shift)))
}

/// The direction of a job, if it has one, and the bytes of the job itself.
pub(super) fn unwrap(bytes: &[u8]) -> Result<(Option<ArtDirection>, &[u8]), WireError> {
    if !envelope::is(MessageKind::DirectedJob, bytes) {
        return Ok((None, bytes));
    }
    let (direction, inner) = envelope::open::<ArtDirection>(MessageKind::DirectedJob, bytes)?;
    check(&direction)?;
    Ok((Some(direction), inner))
}
