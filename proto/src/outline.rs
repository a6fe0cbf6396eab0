//! A job in parts: what is large in it (its mesh, what is painted on one) is named by its digest,
//! so that a worker that has it already need not be sent it again. A job's id stays the digest of
//! the whole.

use crate::chunks::MAX_BLOB;
use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::ids::{JobId, digest};
use crate::job::FractureJob;
use crate::specimen::SpecimenJob;
use crate::window::WindowJob;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Bytes from which on a part travels by its digest; what is smaller stays in the outline.
pub const LARGE: usize = 4_096;
/// Most parts of a job that travel by their digests.
pub const MAX_PARTS: usize = 8;

/// A part of a job that is not in its outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobPart {
    /// Its digest.
    pub digest: [u8; 32],
    /// Where it begins in the whole \[bytes\].
    pub at: u64,
    /// Its bytes.
    pub length: u64,
}

/// A job ready to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parted {
    /// The digest of the whole.
    pub id: JobId,
    /// Everything but the large parts, encoded.
    pub outline: Vec<u8>,
    /// The large parts, by digest.
    pub parts: Vec<([u8; 32], Arc<Vec<u8>>)>,
}

/// What an outline says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outline<'a> {
    /// What is not in it, in order.
    pub parts: Vec<JobPart>,
    rest: &'a [u8],
}

impl Parted {
    /// A job, taken apart.
    ///
    /// # Errors
    /// As [`FractureJob::encode`].
    pub fn of(job: &FractureJob) -> Result<Self, WireError> {
        let (bytes, slabs) = job.slabs()?;
        Self::cut(&bytes, &slabs)
    }

    /// A specimen, taken apart.
    ///
    /// # Errors
    /// As [`SpecimenJob::encode`].
    pub fn of_specimen(job: &SpecimenJob) -> Result<Self, WireError> {
        let bytes = job.encode()?;
        let (_, _, bulk) = envelope::split(&bytes)?;
        let slab = bytes.len() - bulk.len()..bytes.len();
        Self::cut(&bytes, &[slab])
    }

    /// A window, taken apart.
    ///
    /// # Errors
    /// As [`WindowJob::encode`].
    pub fn of_window(job: &WindowJob) -> Result<Self, WireError> {
        let (bytes, slabs) = job.slabs()?;
        Self::cut(&bytes, &slabs)
    }

    fn cut(bytes: &[u8], slabs: &[Range<usize>]) -> Result<Self, WireError> {
        let (mut rows, mut parts, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        let mut from = 0;
        for slab in slabs.iter().filter(|slab| slab.len() >= LARGE) {
            let part = bytes[slab.clone()].to_vec();
            let name = digest(&part);
            rest.extend_from_slice(&bytes[from..slab.start]);
            rows.push(JobPart { digest: name, at: slab.start as u64, length: part.len() as u64 });
            parts.push((name, Arc::new(part)));
            from = slab.end;
        }
        rest.extend_from_slice(&bytes[from..]);
        let outline = envelope::seal(MessageKind::Outline, &rows, &rest)?;
        Ok(Self { id: JobId::of(bytes), outline, parts })
    }
}

impl<'a> Outline<'a> {
    /// The outline in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn open(bytes: &'a [u8]) -> Result<Self, WireError> {
        let (parts, rest) = envelope::open::<Vec<JobPart>>(MessageKind::Outline, bytes)?;
        codec::limit("an outline's parts", parts.len() as u64, MAX_PARTS as u64)?;
        let mut whole = rest.len() as u64;
        let mut end = 0;
        for part in &parts {
            codec::limit("a part's length", part.length, MAX_BLOB)?;
            whole += part.length;
            codec::limit("where a part begins", end, part.at)?;
            end = part.at.saturating_add(part.length);
            codec::limit("where a part ends", end, whole)?;
        }
        codec::limit("a job's length", whole, MAX_BLOB)?;
        Ok(Self { parts, rest })
    }

    /// The whole job, from its parts; `None` if one is missing or has another length.
    #[must_use]
    pub fn whole<B: AsRef<[u8]>>(&self, parts: &[B]) -> Option<Vec<u8>> {
        let (mut bytes, mut rest) = (Vec::new(), self.rest);
        for (row, part) in self.parts.iter().zip(parts) {
            let before = (row.at as usize).checked_sub(bytes.len())?;
            let (first, last) = rest.split_at_checked(before)?;
            bytes.extend_from_slice(first);
            bytes.extend_from_slice(part.as_ref());
            rest = last;
            if part.as_ref().len() as u64 != row.length {
                return None;
            }
        }
        bytes.extend_from_slice(rest);
        (parts.len() == self.parts.len()).then_some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_geometry::{Solid, Vec3, shapes};
    use cullet_model::Law;
    use cullet_model::strength::VertexPaint;

    fn job(segments: u32) -> FractureJob {
        let mut job = FractureJob::smallest("brittle", 7);
        let detail = shapes::Detail { segments, ..shapes::Detail::default() };
        let solid = Solid::outer(shapes::cylinder(0.1, 0.1, detail).expect("a cylinder"));
        job.problem.body = solid.into();
        let Law::Brittle { strength, .. } = &mut job.problem.law else { panic!("another law") };
        strength.vertices = Some(Arc::new(VertexPaint {
            points: vec![Vec3::x(); 500],
            factors: vec![0.5; 500],
            reach: 0.1,
        }));
        job
    }

    #[test]
    fn a_job_comes_back_from_its_parts_with_the_id_of_the_whole() -> Result<(), WireError> {
        let mut job = job(200);
        let parted = Parted::of(&job)?;
        assert_eq!((parted.parts.len(), parted.id), (2, job.id()?));
        assert!(parted.outline.len() < 1_000, "{}", parted.outline.len());
        let outline = Outline::open(&parted.outline)?;
        let parts: Vec<_> = parted.parts.iter().map(|(_, part)| part.as_slice()).collect();
        assert_eq!(outline.whole(&parts), Some(job.encode()?));
        assert_eq!(outline.whole(&parts[..1]), None);
        assert_eq!(outline.whole(&[parts[1], parts[0]]), None);
        // Another hit of the same body has the same parts.
        job.problem.impacts[0].impulse *= 2.0;
        let other = Parted::of(&job)?;
        assert_eq!(other.parts, parted.parts);
        assert_ne!(other.id, parted.id);
        // What is small stays where it is.
        let small = Parted::of(&FractureJob::smallest("brittle", 7))?;
        assert!(small.parts.is_empty());
        let whole = Outline::open(&small.outline)?.whole::<&[u8]>(&[]);
        assert_eq!(whole.map(|bytes| JobId::of(&bytes)), Some(small.id));
        Ok(())
    }

    #[test]
    fn an_outline_that_cannot_be_is_refused() -> Result<(), WireError> {
        let part = |at, length| JobPart { digest: [0; 32], at, length };
        let open = |parts: Vec<JobPart>| -> Result<(), WireError> {
            Outline::open(&envelope::seal(MessageKind::Outline, &parts, b"rest")?).map(drop)
        };
        assert_eq!(open(vec![part(0, 5), part(5, 5)]), Ok(()));
        let bad = [
            vec![part(0, MAX_BLOB + 1)],
            vec![part(u64::MAX, 2)],
            vec![part(5, 5)],
            vec![part(0, 5), part(4, 5)],
            vec![part(0, MAX_BLOB), part(MAX_BLOB, MAX_BLOB)],
            vec![part(0, 0); MAX_PARTS + 1],
        ];
        for bad in bad {
            assert!(matches!(open(bad.clone()), Err(WireError::Limit { .. })), "{bad:?}");
        }
        Ok(())
    }
}
