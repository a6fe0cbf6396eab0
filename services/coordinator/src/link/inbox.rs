//! Blobs that come in pieces from workers and clients.

use cullet_proto::chunks::Assembly;
use cullet_proto::ids::digest;
use cullet_proto::pool::{Chunk, ChunkAnswer, MAX_MISSING};
use cullet_proto::{WireError, chunks};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Bytes of unfinished blobs held, beyond which senders are told to wait. A piece makes room for
/// all that comes before it in its blob: so there may be one blob more than this.
const MAX_HELD: usize = 1 << 30;
/// An unfinished blob that nobody adds to is forgotten after this.
const STALE: Duration = Duration::from_secs(120);

/// What there is of a blob.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Blob {
    /// All of it, and it matches its digest.
    Whole(Vec<u8>),
    /// Not these pieces (perhaps more).
    Missing(Vec<u32>),
    /// All of it, but it does not match: thrown away.
    Damaged,
}

#[derive(Debug)]
pub(super) struct Inbox {
    bound: usize,
    blobs: BTreeMap<[u8; 32], (Assembly, Instant)>,
    pub(super) damaged: u64,
}

impl Default for Inbox {
    fn default() -> Self {
        Self { bound: MAX_HELD, blobs: BTreeMap::new(), damaged: 0 }
    }
}

impl Inbox {
    /// Takes a piece.
    pub(super) fn put(&mut self, chunk: &Chunk, bytes: &[u8]) -> Result<ChunkAnswer, WireError> {
        let held: usize = self.blobs.values().map(|(blob, _)| blob.held()).sum();
        if held + bytes.len() > self.bound {
            return Ok(ChunkAnswer::Busy);
        }
        let fresh = Assembly::new(chunk.length)?;
        let now = Instant::now();
        let (blob, touched) = self.blobs.entry(chunk.digest).or_insert((fresh, now));
        if blob.length() != chunk.length {
            let (value, limit) = (chunk.length, blob.length());
            return Err(WireError::Limit { what: "a blob's length", value, limit });
        }
        *touched = now;
        match blob.put(chunk.index, chunk.sum, bytes) {
            Ok(()) => Ok(ChunkAnswer::Have),
            Err(WireError::Checksum { .. }) => {
                self.damaged += 1;
                Ok(ChunkAnswer::Damaged)
            }
            Err(error) => Err(error),
        }
    }

    /// Takes a blob out if it is whole and sound.
    pub(super) fn take(&mut self, name: &[u8; 32], length: u64) -> Result<Blob, WireError> {
        let Some((blob, _)) = self.blobs.get(name) else {
            // Held to the limit here, so that an absurd length is refused and not sent.
            Assembly::new(length)?;
            let all = 0..chunks::count(length);
            return Ok(Blob::Missing(all.take(MAX_MISSING).collect()));
        };
        let Some(bytes) = blob.whole() else {
            return Ok(Blob::Missing(blob.missing(MAX_MISSING)));
        };
        let sound = digest(bytes) == *name;
        let bytes = if sound { bytes.to_vec() } else { Vec::new() };
        self.blobs.remove(name);
        if sound {
            Ok(Blob::Whole(bytes))
        } else {
            self.damaged += 1;
            Ok(Blob::Damaged)
        }
    }

    /// Forgets a blob that is not needed any more.
    pub(super) fn forget(&mut self, name: &[u8; 32]) {
        self.blobs.remove(name);
    }

    /// Forgets blobs that nobody adds to.
    pub(super) fn sweep(&mut self) {
        self.blobs.retain(|_, (_, touched)| touched.elapsed() < STALE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(bytes: &[u8], name: [u8; 32]) -> Chunk {
        Chunk { digest: name, length: bytes.len() as u64, index: 0, sum: chunks::sum(bytes) }
    }

    #[test]
    fn a_blob_counts_only_if_its_digest_is_right() -> Result<(), WireError> {
        let mut inbox = Inbox::default();
        let (good, name) = (b"fragments", digest(b"fragments"));
        assert_eq!(inbox.take(&name, 9)?, Blob::Missing(vec![0]));
        // Each piece has the right checksum, and yet the whole is not what was promised.
        inbox.put(&chunk(b"fragmenta", name), b"fragmenta")?;
        assert_eq!(inbox.take(&name, 9)?, Blob::Damaged);
        assert_eq!(inbox.put(&chunk(good, name), good)?, ChunkAnswer::Have);
        assert_eq!(inbox.take(&name, 9)?, Blob::Whole(good.to_vec()));
        assert_eq!(inbox.take(&name, 9)?, Blob::Missing(vec![0]));
        Ok(())
    }

    #[test]
    fn unfinished_blobs_hold_no_more_than_the_bound_and_one_of_them() -> Result<(), WireError> {
        assert_eq!(Inbox::default().bound, 1 << 30);
        let (piece, length) = (vec![1; chunks::CHUNK], 3 * chunks::CHUNK);
        let mut inbox = Inbox { bound: 2 * length, ..Inbox::default() };
        let held = |inbox: &Inbox| inbox.blobs.values().map(|(blob, _)| blob.held()).sum::<usize>();
        let last = |inbox: &mut Inbox, name: u8| {
            let (digest, length, sum) = ([name; 32], length as u64, chunks::sum(&piece));
            inbox.put(&Chunk { digest, length, index: 2, sum }, &piece)
        };
        // The last pieces first: each makes its blob as large as it can be.
        let said: Vec<_> = (0..200).map(|name| last(&mut inbox, name)).collect::<Result<_, _>>()?;
        let taken = said.iter().filter(|said| **said == ChunkAnswer::Have).count();
        assert_eq!((taken, said[taken..].contains(&ChunkAnswer::Have)), (2, false));
        assert!(held(&inbox) <= inbox.bound + length, "{} bytes", held(&inbox));
        // There is room again when somebody is done, or has not been heard of for long.
        inbox.forget(&[0; 32]);
        assert_eq!(last(&mut inbox, 7)?, ChunkAnswer::Have);
        assert_eq!(last(&mut inbox, 8)?, ChunkAnswer::Busy);
        for (_, touched) in inbox.blobs.values_mut() {
            *touched = touched.checked_sub(STALE).unwrap_or(*touched);
        }
        inbox.sweep();
        assert_eq!((held(&inbox), last(&mut inbox, 8)?), (0, ChunkAnswer::Have));
        Ok(())
    }

    #[test]
    fn a_damaged_piece_is_asked_for_again() -> Result<(), WireError> {
        let mut inbox = Inbox::default();
        let (good, name) = (b"fragments", digest(b"fragments"));
        assert_eq!(inbox.put(&chunk(good, name), b"fragmentx")?, ChunkAnswer::Damaged);
        assert_eq!(inbox.take(&name, 9)?, Blob::Missing(vec![0]));
        assert_eq!(inbox.damaged, 1);
        assert!(inbox.take(&[0; 32], u64::MAX).is_err());
        Ok(())
    }
}
